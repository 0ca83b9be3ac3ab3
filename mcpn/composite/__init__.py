"""Composition: each type of sections explored on its own, glued at the states of their hardware."""
