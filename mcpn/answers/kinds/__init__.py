"""Kinds of claims, each with its formula, sentences and evidence; what makes claims stands elsewhere."""
