"""Commands around a running controller: a bench, sequences of events."""
