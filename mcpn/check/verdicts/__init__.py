"""Verdicts on a mission, each with the run that shows it: one check for every engine."""
