"""The explicit engine: how markings fire, and the graph of the markings that are reached."""
