"""Numbers of risk that need the chain of the whole mission: by a time, by small changes, for other tools."""
