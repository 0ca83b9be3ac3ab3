"""Runs of a controller in virtual time, and sequences of events to test with."""

AGAINST = ("c", "python", "scxml")
"""The targets whose code is run beside the runtime."""
