"""The whole mission as one continuous-time Markov chain whose states are listed.

The model is that of :mod:`mcpn.answers.causes.risk`. Neither composition nor the solution of linear systems
has a part in it: a state is a stable state of the mission, an edge an event with its rate. Where a state is
left in no time, its edges have probabilities. So other tools may judge the numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from mcpn._kernel import incoming, spread
from mcpn.answers.causes.chain import EdgeRates, ListedChain, Number
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import refuse_unknown
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError
from mcpn.events import What
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.markings.graph import Ints, Mask

MOST_STATES = 1_000_000
"""Stable states of a mission whose chain is listed, unless another limit is asked for."""


@dataclass(frozen=True, eq=False)
class WholeChain:
    """The states that a mission comes to with some probability, and its edges of a positive rate.

    Args:
        mission_net: The mission's net.
        markings: By state, the marked places.
        sources: By edge, the state before it, ascending; 0 is the first state.
        targets: By edge, the state after it.
        rates: By edge, how often per hour it is taken in the state before it; of a vanishing state its
            probability.
        hasty: Vanishing states, left in no time.
        ends: By ``success``, ``failure`` and, of a mission that can abort, ``abort`` the states at that end.
        running: By objective, the states in which it runs.
        failing: By edge, the number of the hardware that fails by itself; -1 for other edges.
        hardware: The hardware that can fail.
    """

    mission_net: MissionNet
    markings: Callable[[int], tuple[int, ...]]
    sources: Ints
    targets: Ints
    rates: npt.NDArray[Any]
    hasty: Mask
    ends: Mapping[str, Mask]
    running: Mapping[str, Mask]
    failing: Ints
    hardware: tuple[str, ...]

    @property
    def states(self) -> int:
        """Number of states."""
        return len(self.hasty)

    @cached_property
    def ended(self) -> Mask:
        """States at some end."""
        return np.asarray(np.logical_or.reduce([*self.ends.values()]), np.bool_)


def whole_chain(prospects: Prospects[Any], number: Callable[[float], Number] = float) -> WholeChain:
    """The chain of a mission whose file gives rates and durations.

    Args:
        prospects: The mission on its alternatives graph, whose states are listed: :data:`MOST_STATES` at
            most, unless it says another limit.
        number: What rates are: ``float``, or :func:`mcpn.answers.causes.chain.decimal` for fractions
            that are exactly what the file says.

    Raises:
        InputError: An objective that may run has no duration.
        LimitError: There are too many states to be listed.
    """
    refuse_unknown(prospects)
    prospects = _listed(prospects, MOST_STATES if prospects.max_states is None else prospects.max_states)
    net, hardware = prospects.mission_net, prospects.hardware
    known = {h.name: h for h in net.core.hardware}
    demands = [number(known[name].demand_probability or 0.0) for name in hardware]
    listed = ListedChain(
        prospects,
        [("hardware", name) for name in hardware],
        demanded=[i for i, demand in enumerate(demands) if demand],
    )
    each = ((known[name].failure_rate or 0.0, known[name].repair_rate or 0.0) for name in hardware)
    ending = [
        (1 / number(o.duration) if o.duration else number(0.0), *map(number, o.shares))
        for o in prospects.sections.values()
    ]
    found = EdgeRates(listed, [(number(a), number(b)) for a, b in each], ending, demands, number)
    graph = listed.graph
    begin = 0  # with what fails on demand as the mission starts, else without
    if listed.split is None:
        (start,) = np.flatnonzero(listed.carrying(What.START) & (graph.sources == 0)).tolist()
        begin = int(graph.targets[start])
    reached = graph.reached(found.moving, begin)
    states = np.flatnonzero(reached)
    states = np.concatenate([[begin], states[states != begin]])
    number_of = np.zeros(graph.states, np.int64)
    number_of[states] = np.arange(len(states))
    edges = np.flatnonzero(found.moving & reached[graph.sources])
    edges = edges[np.argsort(number_of[graph.sources[edges]], kind="stable")]
    sources, hasty = number_of[graph.sources[edges]], found.hasty[states]
    rates, weights = found.rates[edges], np.full(len(states), number(0.0))
    np.add.at(weights, sources, rates)
    rates = np.where(hasty[sources], rates / weights[sources], rates)
    ends = {"success": net.success, "failure": net.failure}
    ends |= {} if net.abort is None else {"abort": net.abort}
    ended = np.asarray(listed.ended[states], np.bool_)
    return WholeChain(
        mission_net=net,
        markings=lambda state: graph.marking(int(states[state])),
        sources=sources,
        targets=number_of[graph.targets[edges]],
        rates=rates,
        hasty=hasty,
        ends={name: np.asarray(graph.marked(place)[states], np.bool_) for name, place in ends.items()},
        running={name: goal.running.mask[states] & ~ended for name, goal in prospects.objectives.items()},
        failing=np.asarray(listed.failing[edges], np.int64),
        hardware=hardware,
    )


def _listed(prospects: Prospects[Any], limit: int) -> Prospects[Any]:
    """A mission whose stable states are listed."""
    net, states = prospects.mission_net, prospects.space.everything.count()
    if states > limit:
        raise LimitError(f"the chain of the whole mission has {states} states, the limit is {limit}")
    if isinstance(prospects.space, ArraySpace):
        return prospects
    return Prospects(net, spaces_of(net).unproved(limit))


def leading(chain: WholeChain, goal: Mask) -> Mask:
    """States from which some run leads to some states, these included."""
    offsets = np.searchsorted(chain.sources, np.arange(chain.states + 1))
    return np.asarray(spread(*incoming(offsets, chain.targets.astype(np.uint32)), goal), np.bool_)
