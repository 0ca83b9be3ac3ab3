"""A controller without its robot: fake drivers in virtual time, and sequences of events to test with."""
