"""Transitions that may fire on a cycle of markings: those that no ranking function excludes.

The numbers of firings on a cycle are a T-semiflow: together they change no marking. Take some transitions,
and weights of places such that none of these transitions raises the weighted sum of tokens. One that lowers
the sum fires on no cycle of them, for the sum would never come back. A linear program finds weights that
exclude as many transitions as can be (Farkas' lemma: weights exclude each transition that is in no
T-semiflow of the set).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import inf

from mcpn.nets.petri import PetriNet
from mcpn.nets.programs import minimise
from mcpn.nets.structure import Sparse, incidence

LARGEST = 10_000
"""Larger weights of arcs are not given to the solver."""
SCALES = (1, 2, 6, 12, 60, 420)
"""The solver's weights are rounded to whole numbers after they are multiplied by one of these."""


def repeatable(net: PetriNet, transitions: Collection[int]) -> frozenset[int]:
    """Those of some transitions that may fire on a cycle on which nothing but these transitions fires.

    Weights are checked in whole numbers, so that no rounding in the solver excludes a transition wrongly.

    Args:
        net: The net.
        transitions: By index.

    Returns:
        Those that no weights exclude. It takes about 10 ms for 300 transitions.
    """
    changes: dict[int, Sparse] = {t: {} for t in transitions}
    for place, row in enumerate(incidence(net)):
        for t, change in row.items():
            if t in changes:
                changes[t][place] = change
    moving = [t for t in sorted(changes) if changes[t]]
    most = max((abs(change) for t in moving for change in changes[t].values()), default=0)
    if not moving or most > LARGEST:
        return frozenset(transitions)
    weights = _weights([changes[t] for t in moving], len(net.places))
    for scale in SCALES:
        whole = [round(weight * scale) for weight in weights]
        sums = {t: sum(whole[place] * change for place, change in changes[t].items()) for t in moving}
        if max(sums.values()) <= 0:
            return frozenset(t for t in transitions if sums.get(t, 0) == 0)
    return frozenset(transitions)


def _weights(changes: Sequence[Sparse], places: int) -> list[float]:
    """Weights of places that no change raises and as many as may be lower by 1; zeros where none is found."""
    # Variables: the weights, and by how much each change lowers the sum.
    solution = minimise(
        [0.0] * places + [-1.0] * len(changes),
        [({**change, places + row: 1.0}, -inf, 0.0) for row, change in enumerate(changes)],
        [-inf] * places + [0.0] * len(changes),
        [inf] * places + [1.0] * len(changes),
    )
    return list(solution.values[:places]) if solution.kind == "solved" else [0.0] * places
