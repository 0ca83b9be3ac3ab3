"""Behaviour trees against the missions that are made of them."""
