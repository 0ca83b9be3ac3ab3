"""Deadlocks, unsafe firings and reachable markings without the space: walks, search, the state equation."""

HOME = "HOME_MARKING"
"""The technique of what a home marking tells; here since answers name it before they load a search."""
