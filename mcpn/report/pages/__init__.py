"""The parts of a report's page: its first screen, its tables, and what runs in the browser."""
