"""Missions and nets played at a prompt or from a file of events."""
