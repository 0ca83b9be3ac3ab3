"""How much success changes with the failure rate of each resource: the derivative of its probability.

Birnbaum importance compares a resource that never fails with one that is lost from the start. The
derivative asks what a little more or less reliability changes, where repairs and the time of use count.
From one state to the next the probability of what remains changes by the difference of the two; the
derivative is the sum of these differences over the failures of the resource, each times the hours that the
mission is expected to spend in the state before it. Both come from one system of linear equations and its
transpose.

Source: Birnbaum, *On the importance of different components in a multicomponent system*, 1969; Cao, Chen,
*Perturbation realization, potentials, and sensitivity analysis of Markov processes*, 1997.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mcpn.answers.causes.linear_systems import LayeredSystem
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.sparse import Floats, SparseMatrix
from mcpn.answers.causes.whole_chain import WholeChain, leading, whole_chain
from mcpn.spaces.markings.graph import Mask

MOST_STATES_OF_SLOPES = 100_000
"""Stable states of a mission whose derivatives are computed beside its numbers of risk."""


def slopes_of(prospects: Prospects[Any]) -> Mapping[str, float] | None:
    """The derivatives of a mission (:func:`slopes`); ``None`` of one with too many states for them.

    Args:
        prospects: The mission on its alternatives graph; it may have no more stable states than it says, and
            never more than :data:`MOST_STATES_OF_SLOPES`.
    """
    said, most = prospects.max_states, MOST_STATES_OF_SLOPES
    limit = most if said is None else min(said, most)
    if prospects.space.everything.count() > limit:
        return None
    return slopes(whole_chain(prospects.within(limit)))


def slopes(chain: WholeChain) -> Mapping[str, float]:
    """The derivative of the probability of success by the failure rate of each resource that has one.

    Args:
        chain: The mission's chain, its rates floats.

    Returns:
        By hardware, for one more failure per hour.
    """
    ends = chain.ended
    inner = np.flatnonzero(leading(chain, ends) & ~ends)
    leaving = np.bincount(chain.sources, chain.rates, chain.states)
    step = chain.rates / leaving[chain.sources]
    every, apart = np.arange(chain.states), np.ones(chain.states)
    apart[inner] = 0.0
    jumps = SparseMatrix(step, chain.sources, chain.targets, (chain.states,) * 2).within(inner, every)
    among = jumps.within(np.arange(len(inner)), inner)
    system = LayeredSystem(among, jumps @ apart) if len(inner) else None

    def reaching(goal: Mask) -> Floats:
        """How probable some ends are, by state."""
        found = goal.astype(np.float64)
        if system is not None:
            found[inner] = system.solved(jumps @ found)
        return found

    hours = np.zeros(chain.states)
    if system is not None and inner[0] == 0:
        visits = system.solved(np.eye(1, len(inner))[0], forward=True)
        hours[inner] = np.where(chain.hasty[inner], 0.0, visits / leaving[inner])
    # Where the mission is sure to end, success is lost by the other ends, which keep the digits when rare.
    sure = len(inner) + np.count_nonzero(ends) == chain.states
    gained = -reaching(ends & ~chain.ends["success"]) if sure else reaching(chain.ends["success"])
    found = dict[str, float]()
    rates = {h.name: h.failure_rate for h in chain.mission_net.core.hardware}
    for number, name in enumerate(chain.hardware):
        if rate := rates[name]:
            own = chain.failing == number
            sources, targets = chain.sources[own], chain.targets[own]
            share = hours[sources] * chain.rates[own] / rate
            found[name] = float(share @ (gained[targets] - gained[sources]))
    return found
