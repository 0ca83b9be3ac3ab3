"""One reader and one writer per net format."""
