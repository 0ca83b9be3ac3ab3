"""A small mission in three files to start from."""
