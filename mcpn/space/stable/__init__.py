"""Stable markings: what follows an event, whether it is always the same, and what clashes where it is not."""
