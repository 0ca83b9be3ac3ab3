"""Temporal logic: the language of formulas, their evaluation over a space of states, witnesses, answers."""
