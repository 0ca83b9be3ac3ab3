"""Runs of a controller in virtual time, and sequences of events to test with."""
