"""State spaces: markings graphs and alternatives graphs."""
