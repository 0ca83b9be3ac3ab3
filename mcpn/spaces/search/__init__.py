"""Deadlocks, unsafe firings and reachable markings without the space: walks, search, the state equation."""

# The techniques, in words of the Model Checking Contest: answers name them before they load a search.

INITIAL_STATE, RANDOM_WALK, STUBBORN_SETS = "INITIAL_STATE", "RANDOM_WALK", "STUBBORN_SETS"
EXPLICIT, REDUCTION, STRUCTURE = "EXPLICIT", "STRUCTURAL_REDUCTION", "STRUCTURAL"
STATE_EQUATION, TRAPS = "STATE_EQUATION", "TRAPS"
HEURISTIC = "HEURISTIC_SEARCH"
"""Greedy best first, by the additive heuristic of planning."""
HOME = "HOME_MARKING"
"""What a home marking tells."""
