"""Numbers of risk: the alternatives graph as a continuous-time Markov chain.

The model, all durations exponential and independent, hours the unit of time:

- the mission starts at time 0 with all hardware in service;
- hardware in service fails at its ``failure_rate``, hardware out of service is repaired at its
  ``repair_rate``; one that is not given is 0;
- an objective of mean duration ``d`` ends at rate ``1/d`` while its success is possible: with its
  ``failure_probability`` in failure, else in success;
- an objective that cannot succeed any more fails at once (the activity's error to the controller, paper 6.2);
  one that only waits for a resource waits. Of several that fail at once, each is as likely to be the first.

Where states can be listed, the whole mission is one chain (:mod:`mcpn.check.causes.chain`); by composition
each type of section is one, and they are put together at the status of the hardware
(:mod:`mcpn.check.causes.section_chains`). Both give the same numbers but for rounding.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcpn.check.causes.chain import Chain, Listed, Rates
from mcpn.check.causes.prospects import Prospects
from mcpn.check.causes.section_chains import SectionChains
from mcpn.errors import InputError
from mcpn.mission.facts.warnings import of_objectives
from mcpn.space.arrays import ArraySet, ArraySpace
from mcpn.space.local.composite import CompositeSpace
from mcpn.space.markings.explicit import DEFAULT_MAX_STATES
from mcpn.space.stable.listing import written_out


@dataclass(frozen=True)
class Risk:
    """Numbers of one mission.

    Args:
        success: Probability of mission success.
        failure: Probability of mission failure; with the former less than 1 where the mission need not end.
        degraded_modes: Expected number of times that the robot comes into a degraded functioning mode: one in
            which some activity runs in another alternative than its first. Infinite where it may go on so for
            ever.
        importance: Birnbaum importance by hardware: how much more probable success is if the resource never
            fails than if it is out of service from the start and never repaired.
    """

    success: float
    failure: float
    degraded_modes: float
    importance: Mapping[str, float]


def risk(prospects: Prospects[Any], max_states: int | None = None) -> Risk:
    """The numbers of a mission whose file gives rates and durations.

    Args:
        prospects: The mission on its alternatives graph. A probability is one number for each state: of a
            decision diagram the states are listed, of a composite those of each type of section.
        max_states: Limit on states that are listed one by one.

    Returns:
        Success, failure, degraded modes and importance.

    Raises:
        InputError: An objective that may run has no duration.
        LimitError: There are too many states to be listed, or too much hardware to be remembered.
    """
    _refuse_unknown(prospects)
    limit = DEFAULT_MAX_STATES if max_states is None else max_states
    model: SectionChains | _Whole
    if isinstance(prospects.space, CompositeSpace):
        model = SectionChains(prospects, limit)
    else:
        model = _Whole(_listed(prospects, limit))
    hardware = {h.name: h for h in prospects.mission_net.mission.hardware}
    failing = {name: hardware[name].failure_rate or 0.0 for name in prospects.hardware}
    repaired = {name: hardware[name].repair_rate or 0.0 for name in prospects.hardware}
    expected = model.outlook(failing, repaired)
    importance = {}
    for name in prospects.hardware:
        frozen = model.outlook({**failing, name: 0.0}, {**repaired, name: 0.0})
        importance[name] = frozen.ends()[0] - frozen.ends(name)[0]
    return Risk(*expected.ends(), expected.degraded_modes(), importance)


def _refuse_unknown(prospects: Prospects[Any]) -> None:
    needed = "no duration, which numbers of risk need: its mean in hours"
    unknown = (
        section
        for section in prospects.mission_net.graph.walk()
        if section.duration is None and prospects.objectives[section.name].running
    )
    problems = list(of_objectives(unknown, f"has {needed}", f"have {needed}"))
    if problems:
        raise InputError(problems)


def _listed(prospects: Prospects[Any], max_states: int) -> Prospects[ArraySet]:
    if isinstance(prospects.space, ArraySpace):
        return prospects
    graph = written_out(prospects.space, "risk", max_states)
    return Prospects(prospects.mission_net, ArraySpace(graph))


class _Whole:
    """The whole mission as one chain, asked as :class:`mcpn.check.causes.section_chains.SectionChains` is."""

    def __init__(self, prospects: Prospects[ArraySet]) -> None:
        self.sections = list(prospects.mission_net.graph.walk())
        self.listed = Listed(prospects, prospects.hardware)

    def outlook(self, failing: Mapping[str, float], repaired: Mapping[str, float]) -> _WholeOutlook:
        names = self.listed.hardware
        rates = Rates.of(self.sections, [failing[n] for n in names], [repaired[n] for n in names])
        return _WholeOutlook(Chain(self.listed, rates))


class _WholeOutlook:
    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        listed = chain.listed
        self.values = [
            chain.expected(np.asarray(listed.exit_of == number, np.float64))
            for number in (listed.exits["success"], listed.exits["failure"])
        ]

    def ends(self, lost: str | None = None) -> tuple[float, float]:
        names = self.chain.listed.hardware
        status = 0 if lost is None else 1 << (len(names) - 1 - names.index(lost))
        entry = self.chain.listed.entries[status]
        success, failure = (float(values[entry]) for values in self.values)
        return success, failure

    def degraded_modes(self) -> float:
        numbers, infinite = self.chain.modes_at_entries()
        return math.inf if infinite[0] else float(numbers[0] + self.chain.into_degraded[0])
