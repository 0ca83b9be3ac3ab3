"""Reductions of a net for one question, and the runs of the smaller net lifted back."""
