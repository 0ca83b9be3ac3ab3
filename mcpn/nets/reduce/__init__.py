"""Structural reductions: smaller nets with the same answer to a question, whose runs are lifted back."""
