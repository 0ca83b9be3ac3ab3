"""What holds of a state space: verdicts, their witnesses, functioning modes."""
