"""Monitors of requirements: their states, what they say after each event, and their files."""
