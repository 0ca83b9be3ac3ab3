"""Bounds on the ends of a mission whose rates are known as intervals.

Each rate may lie anywhere in its interval. Here it may even change from moment to moment and depend on all
that has happened: what holds then holds of every constant choice, so that the bounds are true, though they
need not be the least. The largest probability of an end is the least solution of ``x = max T x``, where in
each state an edge has its highest rate if it leads to where the end is more probable, else its lowest.
Policies are improved until none is better (Howard).

Floats do not prove that. So the solution is enlarged a little, until one sees state by state, with what
floats may lose, that no choice leads above it; then by induction none ever does. The same is done for the
lowest. There the mission must leave its states in the end whatever the rates are; it does, for an interval
begins above 0, so that the edges are always the same.

Sources: Howard, *Dynamic programming and Markov processes*, 1960; Givan, Leach, Dean, *Bounded-parameter
Markov decision processes*, Artificial Intelligence 122, 2000; Hartmanns, Kaminski, *Optimistic value
iteration*, CAV 2020, for the proof by enlargement.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mcpn.answers.causes.linear_systems import LayeredSystem
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.sparse import Floats, SparseMatrix
from mcpn.answers.causes.whole_chain import WholeChain, leading, whole_chain
from mcpn.errors import LimitError
from mcpn.spaces.markings.graph import Mask

MOST_ROUNDS = 100
"""Improvements of a policy; a few are usual."""

ENLARGED = 10.0 ** np.arange(-13, -4)
"""How much, relative to itself, a solution is enlarged to prove it: the first that is enough."""
ABSOLUTE = 10.0 ** np.arange(-15, -6, 0.5)
"""How much it is enlarged by each step, where it is rounded afterwards."""


def bounds(prospects: Prospects[Any]) -> Mapping[str, tuple[float, float]]:
    """Bounds on the probability of each end that hold for every choice of rates in their intervals.

    Args:
        prospects: The mission on its alternatives graph, whose states are listed.

    Raises:
        InputError: An objective that may run has no duration.
        LimitError: There are too many states, or no bounds could be proved.
    """
    low = whole_chain(prospects, lambda rate: getattr(rate, "low", rate))
    high = whole_chain(prospects, lambda rate: getattr(rate, "high", rate))
    found = dict[str, tuple[float, float]]()
    for end, goal in low.ends.items():
        least, most = (float(proved_values(low, high, goal, up=up)[0]) for up in (False, True))
        found[end] = max(0.0, least), min(1.0, most)
    return found


def proved_values(low: WholeChain, high: WholeChain, goal: Mask, *, up: bool, parts: int = 0) -> Floats:
    """Bounds on the probability of some states, from each state, such that no step leads beyond them.

    Args:
        low: The chain with the least rates.
        high: The chain with the largest.
        goal: The states.
        up: Whether the bounds are above, else below.
        parts: Where given, the bounds may be rounded away to so many parts of 1, and are still some.

    Raises:
        LimitError: Floats prove none.
    """
    states, sources, targets = low.states, low.sources, low.targets
    # From elsewhere the probability is 0 whatever the rates are.
    inner = np.flatnonzero(leading(low, goal) & ~low.ended)
    if not len(inner) or inner[0] != 0:
        return goal.astype(np.float64)
    number = np.full(states, -1, np.int64)
    number[inner] = np.arange(len(inner))

    def best(values: Floats) -> Floats:
        """The rates that make the values larger, or smaller, in one step."""
        better = values[targets] > values[sources]
        return np.where(better == up, high.rates, low.rates).astype(np.float64)

    def after(rates: Floats, values: Floats) -> Floats:
        """The values after one step at some rates."""
        leaving = np.bincount(sources, rates, states)
        gained = np.bincount(sources, rates * values[targets], states)
        return np.asarray(gained[inner] / leaving[inner])

    def solved(rates: Floats) -> tuple[Floats, Floats]:
        """The probabilities at some rates; and their sum, or how many there are, of all further steps."""
        share = rates / np.bincount(sources, rates, states)[sources]
        begins, ends = number[sources], number[targets]
        among, apart = (begins >= 0) & (ends >= 0), (begins >= 0) & (ends < 0)
        step = SparseMatrix(share[among], begins[among], ends[among], (len(inner),) * 2)
        leaving = np.bincount(begins[apart], share[apart], len(inner)).astype(np.float64)
        solve = LayeredSystem(step, leaving).solved
        values, total = goal.astype(np.float64), np.zeros(states)
        values[inner] = solve(after(rates, goal.astype(np.float64)))
        total[inner] = solve(np.ones(len(inner)) if parts else values[inner])
        return values, total

    rates = np.sqrt(low.rates * high.rates)
    for _ in range(MOST_ROUNDS):
        values, total = solved(rates)
        now, rates = rates, best(values)
        change = after(rates, values) - after(now, values)
        if np.all(np.abs(change) <= 1e-14 * values[inner]):
            break
    most = int(np.bincount(sources).max())
    for enlarged in ABSOLUTE if parts else ENLARGED:
        tried = values + enlarged * total if up else values - enlarged * total
        # What is compared is off by sums over as many edges as a state has, and by rates that are rounded.
        lost = (2 * most + 16) * 2.0**-53 * np.abs(tried[inner]) + (2 / parts if parts else 0.0)
        beyond = after(best(tried), tried) - tried[inner]
        fine = (beyond if up else -beyond) <= -lost
        if parts and not up:
            tried, fine = np.maximum(tried, 0.0), fine | (tried[inner] <= 0)
        if np.all(fine) and np.all(tried >= 0):
            return np.asarray(tried, np.float64)
    raise LimitError(f"no bounds could be proved: rates of {states} states differ too much for floats")
