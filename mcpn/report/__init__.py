"""What people and programs read: text, tables, pages, pictures, JSON."""
