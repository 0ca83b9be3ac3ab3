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

from mcpn.answers.causes.linear_systems import Floats, csc_array, csr_array, splu
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.whole_chain import WholeChain, leading, whole_chain
from mcpn.errors import LimitError
from mcpn.spaces.markings.graph import Mask

MOST_ROUNDS = 100
"""Improvements of a policy; a few are usual."""

ENLARGED = 10.0 ** np.arange(-13, -4)
"""How much, relative to itself, a solution is enlarged to prove it: the first that is enough."""


def bounds(prospects: Prospects[Any], max_states: int | None = None) -> Mapping[str, tuple[float, float]]:
    """Bounds on the probability of each end that hold for every choice of rates in their intervals.

    Args:
        prospects: The mission on its alternatives graph.
        max_states: Limit on its stable states, which are listed.

    Raises:
        InputError: An objective that may run has no duration.
        LimitError: There are too many states, or no bounds could be proved.
    """
    low = whole_chain(prospects, max_states, lambda rate: getattr(rate, "low", rate))
    high = whole_chain(prospects, max_states, lambda rate: getattr(rate, "high", rate))
    found = dict[str, tuple[float, float]]()
    for end, goal in low.ends.items():
        least, most = (_proved(low, high, goal, up=up) for up in (False, True))
        found[end] = max(0.0, least), min(1.0, most)
    return found


def _proved(low: WholeChain, high: WholeChain, goal: Mask, *, up: bool) -> float:
    """A bound on the probability of some states, from the first state."""
    states, sources, targets = low.states, low.sources, low.targets
    # From elsewhere the probability is 0 whatever the rates are.
    inner = np.flatnonzero(leading(low, goal) & ~low.ended)
    if not len(inner) or inner[0] != 0:
        return float(goal[0])
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
        """The probabilities at some rates; and their sum over all further steps."""
        share = rates / np.bincount(sources, rates, states)[sources]
        among = (number[sources] >= 0) & (number[targets] >= 0)
        ways = number[sources[among]], number[targets[among]]
        step = csr_array((share[among], ways), shape=(len(inner),) * 2)
        identity = csr_array((np.ones(len(inner)), (range(len(inner)),) * 2), shape=step.shape)
        solve = splu(csc_array(identity - step)).solve
        values, total = goal.astype(np.float64), np.zeros(states)
        values[inner] = solve(after(rates, goal.astype(np.float64)))
        total[inner] = solve(values[inner])
        return values, total

    rates = np.sqrt(low.rates * high.rates)
    for _ in range(MOST_ROUNDS):
        values, total = solved(rates)
        now, rates = rates, best(values)
        change = after(rates, values) - after(now, values)
        if np.all(np.abs(change) <= 1e-14 * values[inner]):
            break
    most = int(np.bincount(sources).max())
    for enlarged in ENLARGED:
        tried = values + enlarged * total if up else values - enlarged * total
        # What is compared is off by sums over as many edges as a state has, and by rates that are rounded.
        lost = (2 * most + 16) * 2.0**-53 * np.abs(tried[inner])
        beyond = after(best(tried), tried) - tried[inner]
        if np.all((beyond if up else -beyond) <= -lost) and np.all(tried >= 0):
            return float(tried[0])
    raise LimitError(f"no bounds could be proved: rates of {states} states differ too much for floats")
