"""Behaviour trees of BehaviorTree.CPP and Nav2, read and translated into missions with a ledger."""
