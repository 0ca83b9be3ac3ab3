"""Small probabilities with fifty digits, by taking out states of the chain of jumps one by one.

The states and rates are those of :mod:`tests.answers.dense`. No linear system is written down, and nothing is
subtracted either.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from decimal import Decimal, localcontext
from typing import TypeAlias

import networkx as nx

from mcpn.mission.model import Mission
from mcpn.mission.robot import Activity
from tests.answers.dense import Dense, Jumps

DIGITS = 50

Value: TypeAlias = list[Decimal]
"""By end of the mission."""


def values(rates: Mapping[int, Mapping[int, Decimal]], known: Mapping[int, Value]) -> dict[int, Value]:
    """The expected value at the end by state: states that lead to each other together, last ones first."""
    graph: nx.DiGraph[int] = nx.DiGraph()
    graph.add_nodes_from(rates)
    graph.add_edges_from((s, t) for s, each in rates.items() for t in each)
    found = dict(known)
    for component in nx.strongly_connected_components(graph):  # in reverse topological order
        of = _Component(rates, component - known.keys(), found)
        found |= of.values()
    return found


class _Component:
    """States that lead to each other: the rates between them, and what each gains by leaving them."""

    def __init__(self, rates: Mapping[int, Mapping[int, Decimal]], own: set[int], found: Mapping[int, Value]):
        self.inner = {s: {t: w for t, w in rates[s].items() if t in own and t != s} for s in own}
        self.gain = {s: [Decimal(0)] * 3 for s in own}
        self.out = dict.fromkeys(own, Decimal(0))
        self.before: dict[int, set[int]] = {s: set() for s in own}
        for s in own:
            for t in self.inner[s]:
                self.before[t].add(s)
            for t, w in rates[s].items():
                if t not in own:
                    self.out[s] += w
                    self.gain[s] = [g + w * v for g, v in zip(self.gain[s], found[t], strict=True)]

    def take_out(self, state: int) -> None:
        """Leads what led to a state to where it leads."""
        total = self.out[state] + sum(self.inner[state].values())
        for source in self.before[state]:
            share = self.inner[source].pop(state) / total
            self.out[source] += share * self.out[state]
            gains = zip(self.gain[source], self.gain[state], strict=True)
            self.gain[source] = [g + share * v for g, v in gains]
            for t, w in self.inner[state].items():
                if t != source:
                    self.inner[source][t] = self.inner[source].get(t, Decimal(0)) + share * w
                    self.before[t].add(source)
        for t in self.inner[state]:
            self.before[t].discard(state)

    def values(self) -> dict[int, Value]:
        """What is expected at the end, by state; 0 where there is no end."""
        found, left, order = dict[int, Value](), set(self.inner), list[int]()
        if not any(self.out.values()):
            return {s: [Decimal(0)] * 3 for s in left}
        while left:
            state = min(left, key=lambda s: len(self.inner[s]) * len(self.before[s]))
            left.discard(state)
            order.append(state)
            self.take_out(state)
        for state in reversed(order):
            total, value = self.out[state] + sum(self.inner[state].values()), self.gain[state]
            for t, w in self.inner[state].items():
                value = [v + w * x for v, x in zip(value, found[t], strict=True)]
            found[state] = [v / total for v in value]
        return found


def exact_ends(of: Dense) -> tuple[Decimal, Decimal, Decimal]:
    """The probabilities of success, failure and abort."""
    rates = {n: (h.failure_rate or 0.0, h.repair_rate or 0.0) for n, h in of.hardware.items()}
    demands = {n: h.demand_probability or 0.0 for n, h in of.hardware.items()}
    with localcontext() as context:
        context.prec = DIGITS
        context.Emin = -999_999
        steps: dict[int, dict[int, Decimal]] = {s: {} for s in range(-1, of.states)}
        for edge, weight in Jumps(of, rates, demands).weights:
            row = steps[edge.source]
            row[edge.target] = row.get(edge.target, Decimal(0)) + Decimal(weight)
        begin = of.begin[0]
        for share, first in of.leads(begin.target, begin.started, demands):
            if share:
                steps[-1][first] = steps[-1].get(first, Decimal(0)) + Decimal(share)
        ends = (of.succeeded, of.failed, of.aborted)
        known = {s: [Decimal(int(s in end)) for end in ends] for s in of.ends}
        success, failure, abort = values(steps, known)[-1]
    return success, failure, abort


def scaled(mission: Mission, factor: float) -> Mission:
    """A mission whose hardware and software fail so many times as often."""

    def rare(rate: float | None) -> float | None:
        return None if rate is None else rate * factor

    def rarely(of: Activity) -> Activity:
        ways = tuple(replace(way, failure_rate=rare(way.failure_rate)) for way in of.alternatives)
        return replace(of, failure_rate=rare(of.failure_rate), alternatives=ways)

    robots = tuple(
        replace(
            of,
            hardware=tuple(replace(h, failure_rate=rare(h.failure_rate)) for h in of.hardware),
            faults=tuple(replace(f, failure_rate=rare(f.failure_rate)) for f in of.faults),
            activities=tuple(map(rarely, of.activities)),
        )
        for of in mission.robots
    )
    return replace(mission, robots=robots)
