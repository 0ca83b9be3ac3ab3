"""Numbers of risk by dense linear algebra on the stable states of a mission, and missions drawn with rates.

The model is that of ``papers/causes.md``, written down once more: nothing of ``mcpn/answers/causes`` is used.
Which event ends the present run of an objective is read from the net: it takes the token of the objective's
place, be it that another comes before all is stable.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import networkx as nx
import numpy as np
import numpy.typing as npt
from hypothesis import strategies as st

from mcpn.drawing.compose import MissionNet, compose
from mcpn.events import START, Event, What
from mcpn.mission.model import Block, Handler, Holder, Mission, Objective, Parallel
from mcpn.mission.robot import Activity, Alternative, Crash, DeclaredEvent, Hardware
from mcpn.spaces.stable.alternatives import AlternativesGraph, direct
from mcpn.testing import Shape, missions
from tests.logic.oracle import Play
from tests.small import activity, hw, robot

Rates = Mapping[str, tuple[float, float]]
Demands = Mapping[str, float]
Crashing = TypeVar("Crashing", Activity, Alternative)
Start = tuple[tuple[int, ...], str, str]
"""An alternative that starts and hardware that it consumes, with their rank among others."""


@dataclass(frozen=True)
class Numbers:
    """What the model says of one mission, as :class:`mcpn.answers.causes.risk.Risk` does."""

    success: float
    failure: float
    degraded_modes: float
    importance: Mapping[str, float]
    abort: float | None
    safety_importance: Mapping[str, float] | None


@dataclass(frozen=True)
class Edge:
    """One event between two stable states.

    Args:
        source: The state before it.
        target: The state after it.
        event: What happens.
        ended: Objectives whose present run it ends.
        started: Alternatives that it starts, each with hardware that it consumes and may fail on demand, in
            the order in which they are asked.
    """

    source: int
    target: int
    event: Event
    ended: frozenset[str]
    started: tuple[Start, ...] = ()


class Dense:
    """A mission's stable states and the events between them, as the net has them.

    Args:
        found: The mission's net.
        graph: Its alternatives graph.
    """

    def __init__(self, found: MissionNet, graph: AlternativesGraph) -> None:
        self.play = Play(found)
        self.found, self.states = found, graph.states
        self.objectives = {o.name: o for o in found.graph.walk()}
        self.hardware = {h.name: h for h in found.core.hardware if h.faulty}
        self.events = {e.name: e.rate or 0.0 for e in found.mission.events}
        self.finding = {k: a.detection_rate or 0.0 for a in found.core.activities for k in a.detects}
        markings = [graph.marking(s) for s in range(graph.states)]
        role = found.roles
        self.runs = [
            {role[p][1] for p, n in enumerate(m) if n and p in role and role[p][0] == "objective"}
            for m in markings
        ]
        self.active = [
            {role[p][1] for p, n in enumerate(m) if n and p in role and role[p][0] == "active"}
            for m in markings
        ]
        self.gone = [
            {role[p][1] for p, n in enumerate(m) if n and p in role and role[p][0] == "oos"} for m in markings
        ]
        self.succeeded = {s for s, m in enumerate(markings) if m[found.success]}
        self.failed = {s for s, m in enumerate(markings) if m[found.failure]}
        self.aborted = {s for s, m in enumerate(markings) if found.abort is not None and m[found.abort]}
        self.ends = self.succeeded | self.failed | self.aborted
        self.edges: list[Edge] = []
        self.begin: dict[int, Edge] = {}
        self.lost: dict[tuple[int, str], Edge] = {}
        # Before the start, by hardware: what it is when that one is otherwise.
        self.other: dict[str, int] = {}
        for source in range(graph.states):
            for label, target in graph.successors(source):
                event = graph.net.transitions[label].event
                assert event is not None
                started = self.started(markings[source], label, target)
                if event == START:
                    self.begin[source] = Edge(source, target, event, frozenset(), started)
                elif event.what is What.OUT_OF_SERVICE:
                    self.lost[source, event.element] = Edge(source, target, event, frozenset(), started)
                if source == 0 and event.what in (What.OUT_OF_SERVICE, What.REPAIRED):
                    self.other[event.element] = target
                if event != START and source not in self.ends and self.runs[source]:
                    ended = frozenset(self.runs[source] - self.runs[target])
                    if event.what in (What.SUCCESS, What.FAILURE, What.TIMEOUT):
                        ended |= {event.element}
                    if self.runs[source] & self.runs[target]:
                        ended |= self.ended(markings[source], label, self.runs[source])
                    self.edges.append(Edge(source, target, event, ended, started))

        self.may_succeed = {(e.source, e.event.element) for e in self.edges if e.event.what is What.SUCCESS}
        # All that the objective needs runs, and yet it cannot succeed: somebody uses what is lost unnoticed.
        self.misused = {
            (state, name)
            for state, running in enumerate(self.runs)
            for name in running
            if {*self.objectives[name].activities} <= {said.partition(".")[0] for said in self.active[state]}
        } - self.may_succeed

    def ended(self, marking: tuple[int, ...], label: int, running: Collection[str]) -> frozenset[str]:
        """Objectives that run whose token an event takes, or what follows the event at once."""
        net, taken = self.found.net, set[int]()
        after = net.fire(marking, label)
        self.play.settle(after, taken)
        taken |= {p for p, _ in net.transitions[label].consume}
        return frozenset(name for name in running if self.play.place[f"OBJ_{name}"] in taken)

    def started(self, marking: tuple[int, ...], label: int, target: int) -> tuple[Start, ...]:
        """What an event starts of what may fail on demand, in the order in which a section comes upon it."""
        asked = {n for n, h in self.hardware.items() if h.demand_probability is not None}
        sections = (s for s in self.found.graph.sections if self.runs[target] & {o.name for o in s.walk()})
        if not asked or (section := next(sections, None)) is None:
            return ()
        taken: set[int] = set()
        self.play.settle(self.found.net.fire(marking, label), taken)
        taken |= {p for p, _ in self.found.net.transitions[label].consume}
        known = {a.name: a for a in self.found.core.activities}
        makers = {k: a for a in self.found.core.activities for k in a.produces}
        order: dict[str, None] = {}
        hardware: dict[str, None] = {}

        def visit(name: str) -> None:
            if name not in order:
                order[name] = None
                consumed = [k for way in known[name].alternatives for k in way.consumes]
                hardware.update(dict.fromkeys(k for k in consumed if k not in makers))
                for k in consumed:
                    if k in makers:
                        visit(makers[k].name)

        for objective in section.walk():
            for name in objective.activities:
                visit(name)
        found = list[Start]()
        for place in range(len(marking)):
            kind, said = self.found.roles.get(place, ("", ""))
            if kind == "active" and said in self.active[target] and (place in taken or not marking[place]):
                activity, _, alternative = said.partition(".")
                ways = [way.name for way in known[activity].alternatives]
                number = ways.index(alternative)
                for k in known[activity].alternatives[number].consumes:
                    if k in asked and k not in self.gone[target]:
                        rank = [*hardware].index(k), [*order].index(activity), number
                        found.append((rank, said, k))
        return tuple(sorted(found))

    def leads(self, target: int, started: tuple[Start, ...], demands: Demands) -> Iterator[tuple[float, int]]:
        """Where an event leads when what it starts is asked, and how probable each is."""
        if not started:
            yield 1.0, target
            return
        (_, _, name), *rest = started
        for share, end in self.leads(target, tuple(rest), demands):
            yield share * (1 - demands[name]), end
        lost = self.lost[target, name]
        still = {start for start in rest if start[2] != name and start[1] in self.active[lost.target]}
        for share, end in self.leads(lost.target, tuple(sorted(still.union(lost.started))), demands):
            yield share * demands[name], end

    def numbers(self) -> Numbers:
        """All numbers of the mission."""
        rates = {n: (h.failure_rate or 0.0, h.repair_rate or 0.0) for n, h in self.hardware.items()}
        demands = {n: h.demand_probability or 0.0 for n, h in self.hardware.items()}
        start, aborts = self.begin[0], self.found.abort is not None
        jumps = Jumps(self, rates, demands)
        success, failure, abort = (
            jumps.likely(end, start) for end in (self.succeeded, self.failed, self.aborted)
        )
        importance, safely = dict[str, float](), dict[str, float]()
        for name in rates:
            frozen = Jumps(self, {**rates, name: (0.0, 0.0)}, {**demands, name: 0.0})
            well, lost = start, self.begin[self.other[name]] if name in self.other else start
            if self.hardware[name].initial == "oos":
                well, lost = lost, well
            if isinstance(self.hardware[name], Crash):
                barred = self.barred(name, rates, demands)
                importance[name] = frozen.likely(self.succeeded, start) - barred[0]
                safely[name] = frozen.likely(self.succeeded | self.aborted, start) - barred[1]
                continue
            for found, ends in ((importance, self.succeeded), (safely, self.succeeded | self.aborted)):
                found[name] = frozen.likely(ends, well) - frozen.likely(ends, lost)
        firsts = self.leads(start.target, start.started, demands)
        modes = sum(share * jumps.degraded_modes(first) for share, first in firsts if share)
        if not aborts:
            return Numbers(success, failure, modes, importance, None, None)
        return Numbers(success, failure, modes, importance, abort, safely)

    def barred(self, crash: str, rates: Rates, demands: Demands) -> tuple[float, float]:
        """Success, and a safe end, where what may crash needs something that is never there."""

        def without(activity: Activity) -> Activity:
            ways = tuple(
                replace(way, consumes=(*way.consumes, "barred"))
                if crash in (activity.name, f"{activity.name}.{way.name}")
                else way
                for way in activity.alternatives
            )
            return replace(activity, alternatives=ways)

        mission = self.found.mission
        never = Hardware(name="barred", initial="oos")
        robots = [replace(r, activities=tuple(map(without, r.activities))) for r in mission.robots]
        robots[0] = replace(robots[0], hardware=(*robots[0].hardware, never))
        found = compose(replace(mission, robots=tuple(robots)))
        other = Dense(found, direct(found.net, proof=False))
        none = {**rates, crash: (0.0, 0.0), "barred": (0.0, 0.0)}
        jumps, start = Jumps(other, none, {**demands, "barred": 0.0}), other.begin[0]
        safe = other.succeeded | other.aborted
        return jumps.likely(other.succeeded, start), jumps.likely(safe, start)


class Jumps:
    """The chain of jumps under given rates of hardware."""

    def __init__(self, of: Dense, rates: Rates, demands: Demands) -> None:
        self.of, self.demands = of, demands
        possible = {name: self.possible(name, rates) for name in of.objectives}
        hasty = {s for s in range(of.states) for name in of.runs[s] if s not in possible[name]}
        self.hasty = hasty - of.ends
        self.weights = [
            (replace(edge, target=end), w * share)
            for edge in of.edges
            if (w := self.weight(edge, rates, possible)) > 0
            for share, end in of.leads(edge.target, edge.started, demands)
            if share
        ]

    @cached_property
    def total(self) -> npt.NDArray[np.float64]:
        """The rate at which each state is left."""
        total = np.zeros(self.of.states)
        for edge, w in self.weights:
            total[edge.source] += w
        return total

    @cached_property
    def matrix(self) -> npt.NDArray[np.float64]:
        """The probability of a jump from one state to another."""
        matrix = np.zeros((self.of.states, self.of.states))
        for edge, w in self.weights:
            matrix[edge.source, edge.target] += w / self.total[edge.source]
        return matrix

    @cached_property
    def gained(self) -> npt.NDArray[np.float64]:
        """The expected number of jumps into another, degraded mode, by state."""
        gained = np.zeros(self.of.states)
        for edge, w in self.weights:
            into = self.mode(edge.source) != self.mode(edge.target) and self.counts(edge.target)
            gained[edge.source] += w / self.total[edge.source] * into
        return gained

    def own_rate(self, event: Event, rates: Rates) -> float:
        """How often hardware changes, or a declared event happens, per hour."""
        if event.what is What.OUT_OF_SERVICE:
            return rates[event.element][0]
        if event.what is What.REPAIRED:
            return rates[event.element][1]
        if event.what is What.DETECTED:
            return self.of.finding[event.element]
        return 0.0 if event.what is What.TIMEOUT else self.of.events[event.element]

    def possible(self, name: str, rates: Rates) -> set[int]:
        """States in which an objective runs whose present run may still succeed, for all the robot knows."""
        before: dict[int, list[int]] = {}
        stack = [state for state, misusing in self.of.misused if misusing == name]
        for edge in self.of.edges:
            if edge.event == Event(What.SUCCESS, name):
                stack.append(edge.source)
            ends = edge.event.what in (What.SUCCESS, What.FAILURE)
            going_on = name in self.of.runs[edge.source] and name not in edge.ended
            if going_on and (ends or self.own_rate(edge.event, rates) > 0):
                for share, end in self.of.leads(edge.target, edge.started, self.demands):
                    if share:
                        before.setdefault(end, []).append(edge.source)
        found = set(stack)
        while stack:
            for state in before.get(stack.pop(), ()):
                if state not in found:
                    found.add(state)
                    stack.append(state)
        return found

    def weight(self, edge: Edge, rates: Rates, possible: Mapping[str, set[int]]) -> float:
        """The rate of an edge; in states that are left at once a share."""
        what, name = edge.event.what, edge.event.element
        if edge.source in self.hasty:
            alone = what is What.FAILURE and not edge.event.reason
            return float(alone and edge.source not in possible[name])
        if what not in (What.SUCCESS, What.FAILURE):
            return self.own_rate(edge.event, rates)
        objective = self.of.objectives[name]
        assert objective.duration is not None
        failing = objective.failure_probability
        if what is What.SUCCESS:
            return (1 - failing) / objective.duration
        if (edge.source, name) in self.of.misused:
            return float(not edge.event.reason) / objective.duration
        named = dict(zip((reason for reason, _ in objective.reasons), objective.shares[1:], strict=True))
        failing = named[edge.event.reason] if edge.event.reason else failing - sum(named.values())
        return failing / objective.duration if (edge.source, name) in self.of.may_succeed else 0.0

    def mode(self, state: int) -> tuple[frozenset[str], frozenset[str]]:
        return frozenset(self.of.runs[state]), frozenset(self.of.active[state])

    def counts(self, state: int) -> bool:
        """Whether a state is a degraded mode that lasts."""
        first = {f"{a.name}.{a.alternatives[0].name}" for a in self.of.found.core.activities}
        return bool(self.of.active[state] - first) and state not in self.hasty | self.of.ends

    def solved(self, states: Collection[int], gained: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """What is expected to be gained before some states are left."""
        at = sorted(states)
        found = np.zeros(self.of.states)
        if at:
            found[at] = np.linalg.solve(np.eye(len(at)) - self.matrix[np.ix_(at, at)], gained[at])
        return found

    def graph(self) -> nx.DiGraph[int]:
        graph: nx.DiGraph[int] = nx.DiGraph()
        graph.add_nodes_from(range(self.of.states))
        graph.add_edges_from((edge.source, edge.target) for edge, _ in self.weights)
        return graph

    def likely(self, goal: Collection[int], begin: Edge) -> float:
        """That it comes to a goal from the beginning."""
        firsts = self.of.leads(begin.target, begin.started, self.demands)
        return sum(share * self.probability(goal, first) for share, first in firsts if share)

    def probability(self, goal: Collection[int], start: int) -> float:
        """That it comes to a goal."""
        if start in goal:
            return 1.0
        graph = self.graph()
        coming = set[int]().union(*(nx.ancestors(graph, s) for s in goal)) - set(goal)
        gained = self.matrix[:, sorted(goal)].sum(axis=1)
        return float(self.solved(coming, gained)[start])

    def degraded_modes(self, start: int) -> float:
        graph = self.graph()
        graph = graph.subgraph({start, *nx.descendants(graph, start)})
        condensed = nx.condensation(graph)
        for component in condensed:
            members = condensed.nodes[component]["members"]
            if not condensed.out_degree(component) and any(self.gained[s] > 0 for s in members):
                return math.inf
        gaining = {s for s in graph if self.gained[s] > 0}
        coming = gaining.union(*(nx.ancestors(graph, s) for s in gaining))
        return float(self.solved(coming, self.gained)[start] + self.counts(start))


@st.composite
def with_numbers(draw: st.DrawFn, mission: Mission, *, demands: bool = False) -> Mission:
    """Rates and durations near one another, so that everything happens now and then.

    Args:
        draw: Given by hypothesis.
        mission: A mission of any kind.
        demands: Whether hardware may fail on demand, too.
    """

    def timed(block: Block) -> Block:
        if isinstance(block, Holder):
            return replace(block, blocks=tuple(timed(b) for b in block.blocks))
        if not isinstance(block, Objective):
            return block
        values = draw(st.tuples(st.sampled_from([0.5, 1.0, 4.0]), st.sampled_from([0.0, 0.25])))
        shares = [draw(st.sampled_from([None, 0.0, 0.0625, 0.125])) for _ in block.failures]
        said = zip(block.failures, shares, strict=True)
        named = tuple(text if share is None else f"{text}={share}" for text, share in said)
        failing = None if any(shares) and draw(st.booleans()) else max(values[1], sum(filter(None, shares)))
        return replace(block, duration=values[0], failure_probability=failing, failures=named)

    def often(event: DeclaredEvent) -> DeclaredEvent:
        return replace(event, rate=draw(st.sampled_from([None, 0.0, 0.2, 1.0])))

    def crashing(activity: Activity) -> Activity:
        ways = tuple(rated(way) for way in activity.alternatives)
        return replace(rated(activity), alternatives=ways)

    def finding(of: Activity) -> Activity:
        return replace(of, detection_rate=draw(st.sampled_from([None, 0.5, 2.0]))) if of.detects else of

    def rated(of: Crashing) -> Crashing:
        if not of.faulty:
            return of
        values = draw(st.tuples(st.sampled_from([0.2, 1.0]), st.sampled_from([0.0, 0.5])))
        return replace(of, failure_rate=values[0], repair_rate=values[1] if of.recovers else None)

    robots = []
    for of in mission.robots:
        parts = []
        for h in of.hardware:
            values = draw(st.tuples(st.sampled_from([0.2, 1.0]), st.sampled_from([0.0, 0.5])))
            back = values[1] if h.repairable else None
            asked = draw(st.sampled_from([None, 0.25, 1.0])) if demands else None
            known = replace(h, failure_rate=values[0], repair_rate=back, demand_probability=asked)
            parts.append(known if h.faulty else h)
        faults = []
        for fault in of.faults:
            values = draw(st.tuples(st.sampled_from([0.2, 1.0]), st.sampled_from([0.0, 0.5])))
            back = values[1] if fault.repairable else None
            faults.append(replace(fault, failure_rate=values[0], repair_rate=back))
        activities = tuple(finding(crashing(activity)) for activity in of.activities)
        events = tuple(map(often, of.events))
        robots.append(
            replace(of, hardware=tuple(parts), faults=tuple(faults), events=events, activities=activities)
        )
    protocols = tuple(replace(p, blocks=tuple(map(timed, p.blocks))) for p in mission.protocols)
    return replace(
        mission, robots=tuple(robots), blocks=tuple(map(timed, mission.blocks)), protocols=protocols
    )


@st.composite
def interrupted_missions(draw: st.DrawFn) -> Mission:
    """Objectives in a row or side by side that events lead back into, or on, or out of.

    Args:
        draw: Given by hypothesis.

    Returns:
        A strategy of missions with rates; their hardware is shared, so that nothing contends.
    """
    resources = tuple(replace(h, shared=True) for h in hw("h", "g")[: draw(st.integers(1, 2))])
    ways = st.lists(st.sampled_from([(h.name,) for h in resources]), min_size=1, max_size=2, unique=True)
    activities = (activity("free", ()), *(activity(f"a{i}", *draw(ways)) for i in range(2)))
    events = ("e", "f")[: draw(st.integers(1, 2))]
    numbers = iter(range(100))

    def handlers(targets: list[str]) -> tuple[Handler, ...]:
        return tuple(
            Handler(event=e, goto=draw(st.sampled_from(targets)), once=draw(st.integers(0, 3)) == 0)
            for e in events
            if draw(st.booleans())
        )

    def objective() -> Objective:
        return Objective(name=f"o{next(numbers)}", activities=(draw(st.sampled_from(activities)).name,))

    def block() -> Block:
        if draw(st.integers(0, 2)):
            return replace(objective(), retries=draw(st.sampled_from([0, 0, 0, 1])))
        # Branches that start the same activity might ask for it at the same moment.
        chosen = draw(st.permutations(activities))[: draw(st.integers(1, 2))]
        names = [(f"o{next(numbers)}", a.name) for a in chosen]
        branches = (
            Objective(name=n, activities=(a,), handlers=handlers(["succeed", "fail", "abort"]))
            for n, a in names
        )
        return Parallel(name=f"p{next(numbers)}", blocks=tuple(branches))

    row = [block() for _ in range(draw(st.integers(1, 3)))]
    siblings = [b.name for b in row]
    routes = st.sampled_from([None, *siblings, "succeed", "abort"])
    blocks = tuple(
        replace(b, failure=draw(routes), handlers=handlers(["succeed", "fail", "abort", *siblings, b.name]))
        for b in row
    )
    of = robot(resources, *activities, events=events)
    around = handlers(["succeed", "fail", *siblings, siblings[0]])
    return draw(with_numbers(Mission(name="m", robots=(of,), blocks=blocks, handlers=around)))


@st.composite
def spared_missions(draw: st.DrawFn) -> Mission:
    """A row of objectives that fail only when all that they could use is lost, mostly beside another one.

    Args:
        draw: Given by hypothesis.
    """
    rates, durations = st.sampled_from([0.1, 0.3]), st.sampled_from([0.5, 1.0, 4.0])
    names = [f"h{i}" for i in range(draw(st.integers(2, 3)))]
    hardware = tuple(
        Hardware(name=name, failure_rate=draw(rates), repair_rate=draw(st.sampled_from([None, None, 0.2])))
        for name in names
    )
    used = [draw(st.lists(st.sampled_from(names), unique=True, max_size=3)) for _ in range(3)]
    ways: list[list[tuple[str, ...]]] = [[(name,) for name in some] or [()] for some in used]
    of = robot(hardware, *(activity(f"a{i}", *each) for i, each in enumerate(ways)))
    blocks = tuple(
        Objective(name=f"o{i}", activities=(f"a{draw(st.integers(0, 2))}",), duration=draw(durations))
        for i in range(draw(st.integers(2, 4)))
    )
    return Mission(name="m", robots=(of,), blocks=blocks)


@st.composite
def any_missions(draw: st.DrawFn) -> Mission:
    """Missions of any shape, small, with rates.

    Args:
        draw: Given by hypothesis.
    """
    small = Shape(hardware=2, producers=1, alternatives=2, events=2, sections=5)
    aborting = replace(small, aborts=3)
    chosen = draw(
        st.one_of(
            missions(small, sections=4),
            missions(small, own_hardware=True, shared_activities=False),
            missions(small, disjoint_branches=True),
            missions(aborting),
            missions(small, faults=1, sections=4),
            missions(small, lasting=True, sections=4),
            missions(small, late=True, sections=4),
            missions(small, late=True, lasting=True, aborts=1, own_hardware=True, shared_activities=False),
            missions(small, hardware=1, crashes=True, sections=4),
            missions(aborting, hardware=1, crashes=True, sections=4, own_hardware=True),
            missions(small, sections=4, own_hardware=True, alternatives=3, shared_activities=False),
            missions(small, pauses=8, sections=4, own_hardware=True, shared_activities=False),
            missions(aborting, lasting=True, own_hardware=True, shared_activities=False),
            missions(aborting, own_hardware=True, shared_activities=False),
            missions(small, facts=2, sections=4),
            missions(aborting, facts=2, own_hardware=True, shared_activities=False),
            missions(small, facts=1, becoming=7, sections=4),
            missions(small, facts=1, becoming=7, early=2, own_hardware=True, shared_activities=False),
            missions(small, reasons=7, recovers=2, sections=4),
            missions(aborting, reasons=7, own_hardware=True, shared_activities=False),
        )
    )
    return draw(with_numbers(chosen, demands=draw(st.booleans())))
