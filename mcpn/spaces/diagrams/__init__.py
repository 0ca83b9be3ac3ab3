"""The symbolic engine: nets on decision diagrams, orders of places and their race, spaces of states."""
