"""One writer per language that controllers are generated in."""
