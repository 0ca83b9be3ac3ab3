"""Petri nets: the model and its firing, formats, structure, reductions."""
