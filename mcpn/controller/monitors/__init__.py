"""Monitors: machines that watch, event by event, whether a robot does what its mission requires."""
