"""Behaviour trees, read by the versions of their libraries and translated into missions with a ledger."""
