"""Patterns of requirements: as formulas, and as sentences."""
