"""Linear temporal logic: what single paths satisfy, by automata that run beside a space."""
