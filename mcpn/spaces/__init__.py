"""State spaces of nets: markings and alternatives graphs, listed, as diagrams; searches without a space."""
