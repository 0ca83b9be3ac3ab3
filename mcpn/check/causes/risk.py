"""Numbers of risk: the alternatives graph as a continuous-time Markov chain.

The model, all durations exponential and independent, hours the unit of time:

- the mission starts at time 0 with all hardware in service;
- hardware in service fails at its ``failure_rate``, hardware out of service is repaired at its
  ``repair_rate``; one that is not given is 0;
- an objective of mean duration ``d`` ends at rate ``1/d`` while its success is possible: with its
  ``failure_probability`` in failure, else in success;
- an objective that cannot succeed any more fails at once (the activity's error to the controller, paper 6.2);
  one that only waits for a resource waits. Of several that fail at once, each is as likely to be the first.

What ends first decides the next state, so that probabilities and expected numbers are those of the chain of
jumps and solve sparse linear systems (Kemeny, Snell, *Finite Markov Chains*, 1960, chapter 3).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.sparse import csc_array, csr_array, identity
from scipy.sparse.linalg import spsolve

from mcpn.check.causes.prospects import Prospects
from mcpn.errors import InputError, Problem
from mcpn.net.events import What
from mcpn.space.arrays import ArraySet, ArraySpace
from mcpn.space.graph import Ints, Mask

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Risk:
    """Numbers of one mission.

    Args:
        success: Probability of mission success.
        failure: Probability of mission failure; with the former less than 1 where the mission need not end.
        degraded_modes: Expected number of times that the robot comes into a degraded functioning mode: one in
            which some activity runs in another alternative than its first.
        importance: Birnbaum importance by hardware: how much more probable success is if the resource never
            fails than if it is out of service from the start and never repaired.
    """

    success: float
    failure: float
    degraded_modes: float
    importance: Mapping[str, float]


def risk(prospects: Prospects[ArraySet]) -> Risk:
    """The numbers of a mission whose file gives rates and durations.

    Args:
        prospects: The mission on its alternatives graph in arrays: a probability is one number for each
            state, so that the states must be listed.

    Returns:
        Success, failure, degraded modes and importance.

    Raises:
        InputError: An objective that may run has no duration.
    """
    _refuse_unknown(prospects)
    hardware = {h.name: h for h in prospects.mission_net.mission.hardware}
    failing = np.array([hardware[name].failure_rate or 0.0 for name in prospects.hardware])
    repaired = np.array([hardware[name].repair_rate or 0.0 for name in prospects.hardware])
    chain = Chain(prospects, failing, repaired)
    importance = {}
    for number, name in enumerate(prospects.hardware):
        other_failing, other_repaired = failing.copy(), repaired.copy()
        other_failing[number] = other_repaired[number] = 0.0
        other = Chain(prospects, other_failing, other_repaired)
        lost = np.flatnonzero((chain.graph.sources == 0) & (chain.failing == number))
        dead = int(chain.graph.targets[lost[0]])
        importance[name] = float(other.success[0] - other.success[dead])
    return Risk(float(chain.success[0]), float(chain.failure[0]), chain.degraded_modes, importance)


def _refuse_unknown(prospects: Prospects[ArraySet]) -> None:
    needed = "which numbers of risk need: its mean in hours"
    problems = [
        Problem(section.source, f"objective {section.name} has no duration, {needed}")
        for section in prospects.mission_net.graph.walk()
        if section.duration is None and prospects.objectives[section.name].running
    ]
    if problems:
        raise InputError(problems)


class Chain:
    """The chain of jumps under given rates.

    Args:
        prospects: The mission on its alternatives graph in arrays.
        failing: Failures per hour, shape (hardware,).
        repaired: Repairs per hour, shape (hardware,).
    """

    def __init__(self, prospects: Prospects[ArraySet], failing: Floats, repaired: Floats) -> None:
        assert isinstance(prospects.space, ArraySpace), "numbers are of listed states"
        self.prospects = prospects
        self.graph = prospects.space.graph
        self.failing = self._hardware_of(What.OUT_OF_SERVICE)
        self.repaired = self._hardware_of(What.REPAIRED)
        self.rates = self._hardware_rates(failing, repaired)
        self.hasty = np.zeros(self.graph.states, np.bool_)
        """States that are left at once."""
        self._at_once(self.fired(prospects.carrying(What.START)))
        self._objectives()
        self.ended = self.graph.marked(prospects.mission_net.success)
        self.ended |= self.graph.marked(prospects.mission_net.failure)

    def _hardware_of(self, what: What) -> Ints:
        """The number of the resource that fails, or is repaired, at each edge; -1 for other edges."""
        number = np.full(len(self.graph.net.transitions), -1, np.int64)
        for i, name in enumerate(self.prospects.hardware):
            number[list(self.prospects.carrying(what, name))] = i
        return number[self.graph.labels]

    def fired(self, transitions: Collection[int]) -> Mask:
        """Edges of some transitions."""
        return np.isin(self.graph.labels, list(transitions))

    def _hardware_rates(self, failing: Floats, repaired: Floats) -> Floats:
        fails, back = self.failing, self.repaired
        rates = np.zeros(self.graph.edges)
        rates[fails >= 0] = failing[fails[fails >= 0]]
        rates[back >= 0] = repaired[back[back >= 0]]
        return rates

    def _at_once(self, edges: Mask) -> None:
        """Leaves the states before some edges at once, along those edges alone."""
        states = np.zeros(self.graph.states, np.bool_)
        states[self.graph.sources[edges]] = True
        self.rates[(states & ~self.hasty)[self.graph.sources]] = 0.0
        self.rates[edges] = 1.0
        self.hasty |= states

    def _objectives(self) -> None:
        prospects, graph = self.prospects, self.graph
        possible = self.rates > 0
        hardware = (self.failing >= 0) | (self.repaired >= 0)
        failed = np.zeros(graph.edges, np.bool_)
        for section in prospects.mission_net.graph.walk():
            goal = prospects.objectives[section.name]
            well = self.fired(prospects.carrying(What.SUCCESS, section.name))
            badly = self.fired(prospects.carrying(What.FAILURE, section.name))
            if not goal.running:
                continue
            assert section.duration is not None
            rate, probability = 1.0 / section.duration, section.failure_probability
            self.rates[well] = rate * (1.0 - probability)
            self.rates[badly & goal.won.mask[graph.sources]] = rate * probability
            running = goal.running.mask
            inside = running[graph.sources] & running[graph.targets] & ~well & ~badly
            lost = running & ~graph.reaching(goal.won.mask, inside & (~hardware | possible))
            failed |= badly & lost[graph.sources]
        self._at_once(failed)

    @cached_property
    def jumps(self) -> csr_array:
        """Probabilities of the next state, shape (states, states); ended states have none."""
        graph = self.graph
        rates = np.where(self.ended[graph.sources], 0.0, self.rates)
        total = np.bincount(graph.sources, weights=rates, minlength=graph.states)
        moving = rates > 0
        sources, targets = graph.sources[moving], graph.targets[moving]
        return csr_array(
            (rates[moving] / total[sources], (sources, targets)), shape=(graph.states, graph.states)
        )

    @cached_property
    def ending(self) -> Mask:
        """States from which the mission ends with some probability."""
        return self.graph.reaching(self.ended, (self.rates > 0) & ~self.ended[self.graph.sources])

    def absorbed(self, goal: Mask) -> Floats:
        """The probability of ending in a set of ended states, by state."""
        inner = np.flatnonzero(self.ending & ~self.ended)
        found = goal.astype(np.float64)
        if len(inner):
            step = self.jumps[inner]
            system = csc_array(identity(len(inner), format="csc") - step[:, inner])
            found[inner] = spsolve(system, step @ goal.astype(np.float64))
        return found

    @cached_property
    def success(self) -> Floats:
        """The probability of mission success, by state."""
        return self.absorbed(self.graph.marked(self.prospects.mission_net.success))

    @cached_property
    def failure(self) -> Floats:
        """The probability of mission failure, by state."""
        return self.absorbed(self.graph.marked(self.prospects.mission_net.failure))

    @cached_property
    def degraded_modes(self) -> float:
        """The expected number of jumps into another, degraded mode; infinite where they need not end."""
        graph = self.graph
        moving = (self.rates > 0) & ~self.ended[graph.sources]
        counted = moving & self._into_degraded
        met = graph.reached(moving)
        inner = np.flatnonzero(self.ending & ~self.ended & met)
        if (counted & (met & ~self.ending)[graph.sources]).any():
            return math.inf
        if not len(inner):
            return 0.0
        first = np.zeros(len(inner))
        first[inner == 0] = 1.0
        step = self.jumps[inner][:, inner]
        visits = np.zeros(graph.states)
        visits[inner] = spsolve(csc_array(identity(len(inner), format="csc") - step.T), first)
        total = np.bincount(graph.sources, weights=np.where(moving, self.rates, 0.0), minlength=graph.states)
        sources = graph.sources[counted]
        return float((visits[sources] * self.rates[counted] / total[sources]).sum())

    @cached_property
    def _into_degraded(self) -> Mask:
        graph, found = self.graph, self.prospects.mission_net
        first = {f"{a.name}.{a.alternatives[0].name}" for a in found.mission.activities}
        active, objectives = found.saying("active"), found.saying("objective")
        degraded = np.zeros(graph.states, np.bool_)
        changed = np.zeros(graph.edges, np.bool_)
        for place in (*active, *objectives):
            marked = graph.marked(place)
            changed |= marked[graph.sources] != marked[graph.targets]
            if place in active and active[place] not in first:
                degraded |= marked
        return changed & (degraded & ~self.hasty & ~self.ended)[graph.targets]
