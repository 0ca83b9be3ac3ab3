"""State spaces of nets: markings graphs and alternatives graphs, listed, as diagrams; searches without a space."""
