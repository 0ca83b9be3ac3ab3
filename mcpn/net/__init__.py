"""Petri nets: model, templates, composition."""
