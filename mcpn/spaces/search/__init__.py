"""Deadlocks, unsafe firings and reachable markings without the space: walks, search, the state equation."""
