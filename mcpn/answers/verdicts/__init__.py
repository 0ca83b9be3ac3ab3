"""Verdicts on a mission and on any net, each with the run that shows it: one check for every engine."""
