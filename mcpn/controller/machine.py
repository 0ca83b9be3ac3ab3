"""The mission controller as a state machine (paper, 7.3), and the order of the actions of an event.

"The mission controller receives the events and reads in the graph of the alternatives the actions he must
perform (alternative change, activation / deactivation of activity)." A state is a stable marking; the actions
of an edge are what the net's run to completion does to activities
(:mod:`mcpn.controller.run_to_completion`), in a safe order:

Consumers are stopped before what they consume, and started after it. Hardware is released after the last stop
and before anything new is asked for. An alternative is selected before its activity starts. The timers of
objectives and blocks that end are disarmed first, those of what begins armed last.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, reduce
from operator import or_
from typing import Any, Literal

import numpy as np

from mcpn.answers.verdicts.modes import Situation, said_as, said_by
from mcpn.controller.run_to_completion import Runner, Stopped
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.sections import section_part
from mcpn.events import Event
from mcpn.mission.core.objectives_graph import ObjectivesGraph, Section, names_in
from mcpn.mission.static.resource_use import Usage
from mcpn.nets.petri import PetriNet
from mcpn.spaces.markings.graph import Ints
from mcpn.spaces.markings.masked import bits_of
from mcpn.spaces.stable.alternatives import AlternativesGraph

Verb = Literal["disarm", "stop", "release", "select", "start", "arm"]
VERBS: tuple[Verb, ...] = ("disarm", "stop", "release", "select", "start", "arm")
"""In the order in which they are given on one event."""


@dataclass(frozen=True, slots=True)
class PlannedAction:
    """One order of the controller to the robot.

    Args:
        verb: ``stop`` or ``start`` an activity, ``select`` one of its alternatives, ``release`` hardware,
            ``arm`` or ``disarm`` the timer of an objective, or of a block.
        activity: The activity, of the first three.
        alternative: The alternative, for ``select``.
        hardware: The hardware resource, for ``release``.
        objective: The running objective that names the activity, for ``select`` and ``start``; ``None`` for
            an activity that is started by a request for what it produces. Of a timer, the objective or block.
    """

    verb: Verb
    activity: str | None = None
    alternative: str | None = None
    hardware: str | None = None
    objective: str | None = None


class Ordering:
    """The order of actions, in the net of a mission or of one section of it.

    Args:
        usage: The static analysis of the mission.
        graph: The objectives graph: the mission's, or that of a section alone.

    Attributes:
        timed: Objectives with a timeout.
        held: By block with a timeout, the objectives in it.
        named: By objective, its activities.
        hardware: By activity and alternative, what it takes, as it is declared.
    """

    def __init__(self, usage: Usage, graph: ObjectivesGraph) -> None:
        self.usage = usage
        self._home = {name: section.name for section in graph.sections for name in names_in(section)}
        self._stops = {section.name: _consumers_first(usage, section) for section in graph.sections}
        self.timed = {section.name for section in graph.timed}
        self.held = {block.name: set(block.held) for block in graph.timed_blocks()}
        self.named = {section.name: section.activities for section in graph.walk()}
        # What stands for a fault or a crash is nothing that the robot takes or releases.
        stands = (*usage.core.common_causes, *usage.core.crashes)
        taken = usage.hardware.keys() - {each.name for each in stands}
        self._declared = {k: number for number, k in enumerate(usage.hardware)}
        self.hardware = {
            (activity.name, alternative.name): self.as_declared(taken.intersection(alternative.consumes))
            for activity in usage.activities.values()
            for alternative in activity.alternatives
        }

    @property
    def order(self) -> Sequence[str] | None:
        """The activities, consumers before what they consume; ``None`` where there are several sections."""
        return next(iter(self._stops.values())) if len(self._stops) == 1 else None

    def as_declared(self, hardware: Iterable[str]) -> list[str]:
        """Hardware in the order of its declarations, in which an activity releases it."""
        return sorted(hardware, key=self._declared.__getitem__)

    def actions(self, before: Situation, after: Situation, passage: Stopped) -> Iterator[PlannedAction]:
        """The actions of one event.

        Args:
            before: What the robot does before it.
            after: What it does afterwards.
            passage: How the net came from the one to the other.
        """
        changed = {
            a
            for a, alternative in before.mode.items()
            if after.mode.get(a) != alternative or a in passage.activities
        }
        stopped = {a for a in before.mode if a not in after.mode or a in passage.idled}
        first = self._order(before, before.mode)
        was, now = self._in_time(before), self._in_time(after)
        yield from (PlannedAction("disarm", objective=o) for o in was if o in passage.ended)
        yield from (PlannedAction("stop", a) for a in first if a in stopped)
        released = [k for a in first if a in changed for k in self.hardware[a, before.mode[a]]]
        yield from (PlannedAction("release", hardware=k) for k in dict.fromkeys(released))
        begun = [
            a for a in self._order(after, after.mode)[::-1] if a not in before.mode or a in changed | stopped
        ]
        objective = {a: name for name in after.objectives for a in self.named[name]}
        for a in begun:
            yield PlannedAction("select", a, after.mode[a], objective=objective.get(a))
        for a in begun:
            if a not in before.mode or a in stopped:
                yield PlannedAction("start", a, objective=objective.get(a))
        for name in now:
            if name not in was or name in passage.ended:
                yield PlannedAction("arm", objective=name)

    def _in_time(self, situation: Situation) -> list[str]:
        """The objectives and blocks whose time runs; something in a block runs or is about to begin."""
        found = [name for name in situation.objectives if name in self.timed]
        if self.held:
            here = {*situation.objectives, *situation.pending}
            found += [name for name, held in self.held.items() if not here.isdisjoint(held)]
        return found

    def _order(self, situation: Situation, activities: Mapping[str, str]) -> Sequence[str]:
        """Activities of a situation, consumers before what they consume, in the order of its section."""
        names = (*situation.objectives, *situation.pending, *situation.done)
        home = next((self._home[name] for name in names if name in self._home), None)
        known = self._stops[home] if home is not None else []
        rest = [a for a in activities if a not in known]
        return [a for a in known if a in activities] + rest


def _consumers_first(usage: Usage, section: Section) -> list[str]:
    """The activities of a section, each before those that produce what it consumes.

    The order depends on the shape of the section alone, so that sections of one type have the same.
    """
    found = [activity.name for activity in section_part(usage, section).parts.activities]
    members = set(found)
    waiting = dict.fromkeys(found, 0)
    below = {}
    for name in found:
        alternatives = range(len(usage.activities[name].alternatives))
        below[name] = dict.fromkeys(p for i in alternatives for p in usage.suppliers(name, i) if p in members)
        for supplier in below[name]:
            waiting[supplier] += 1
    ready, order = [name for name in found if not waiting[name]], list[str]()
    for name in ready:  # grows while it is walked
        order.append(name)
        for supplier in below[name]:
            waiting[supplier] -= 1
            if not waiting[supplier]:
                ready.append(supplier)
    return order


@dataclass(frozen=True, slots=True)
class MachineEdge:
    """What the controller does on an event.

    Args:
        source: Number of the state that it is in.
        event: The event received.
        transition: The net's transition of it.
        target: Number of the state that it goes to.
        actions: In order: stops, releases, selections, starts.
    """

    source: int
    event: Event
    transition: int
    target: int
    actions: tuple[PlannedAction, ...]


@dataclass(frozen=True, eq=False)
class Machine:
    """A mission controller with a state for each stable marking, its edges in arrays.

    Args:
        mission: The mission's name.
        states: What each state is, by number.
        graph: The alternatives graph, whose edges they are: sorted by source, then in the net's order; at
            most one for each state and event, but in a net that forgets (:mod:`mcpn.drawing.permanent_loss`).
        orders: By edge, the number of its list of actions.
        lists: By number, actions in order: stops, releases, selections, starts.
        waiting: Numbers of the states before the mission's start.
        initial: Number of the initial state.
    """

    mission: str
    states: tuple[Situation, ...]
    graph: AlternativesGraph
    orders: Ints
    lists: Sequence[tuple[PlannedAction, ...]]
    waiting: frozenset[int]
    initial: int = 0

    @cached_property
    def edges(self) -> tuple[MachineEdge, ...]:
        """What the controller does, one by one."""
        graph = self.graph
        columns = (graph.sources, graph.labels, graph.targets, self.orders)
        return tuple(
            MachineEdge(source, event_at(graph.net, label), label, target, self.lists[order])
            for source, label, target, order in zip(*(c.tolist() for c in columns), strict=True)
        )

    @property
    def events(self) -> tuple[Event, ...]:
        """Every event that the controller reacts to, sorted."""
        labels = np.flatnonzero(np.bincount(self.graph.labels)).tolist()
        return tuple(sorted({event_at(self.graph.net, label) for label in labels}))


def controller(mission_net: MissionNet, alternatives: AlternativesGraph) -> Machine:
    """Generates the controller of a mission, or of a section of one.

    Args:
        mission_net: The net of the mission, or of the section alone.
        alternatives: Its alternatives graph.

    Returns:
        One state for each stable marking, one edge for each event that it allows.
    """
    packed = [int.from_bytes(row.tobytes(), "little") for row in alternatives.markings]
    states = situations(mission_net, packed)
    ordered = Ordered(mission_net, states)
    passed, passages = Runner(mission_net).passages(alternatives)
    alike = np.array(ordered.alike, np.int64)
    kinds = np.stack((alike[alternatives.sources], alike[alternatives.targets], passed))
    first, orders = distinct(kinds)
    lists = [
        ordered.actions(source, target, passages[number])
        for source, target, number in zip(
            alternatives.sources[first].tolist(),
            alternatives.targets[first].tolist(),
            passed[first].tolist(),
            strict=True,
        )
    ]
    beginning = 1 << mission_net.beginning
    waiting = frozenset(n for n, marking in enumerate(packed) if marking & beginning)
    return Machine(mission_net.core.name, states, alternatives, orders, lists, waiting)


def distinct(columns: Ints) -> tuple[Ints, Ints]:
    """The distinct ones of some columns of numbers that are not negative.

    Returns:
        By number of a distinct column, where it stands first, and by column its number.
    """
    found = np.zeros(columns.shape[1], np.int64)
    first = np.zeros(min(columns.shape[1], 1), np.int64)
    for row in columns:  # pairs of what was found and the next row fit 64 bits
        pairs = found * (row.max(initial=0) + 1) + row
        order = np.argsort(pairs, kind="stable")
        new = np.diff(pairs[order], prepend=-1) != 0
        first, found[order] = order[new], np.cumsum(new) - 1
    return first, found


def event_at(net: PetriNet, label: int) -> Event:
    """The event of a transition that an alternatives graph is labelled with."""
    event = net.transitions[label].event
    assert event is not None, "only event transitions label the alternatives graph"
    return event


def situations(mission_net: MissionNet, packed: Sequence[int]) -> tuple[Situation, ...]:
    """The situations of markings, which are integers with a bit for each place; equal ones are one object.

    Each field is said by few of the places, which many markings mark alike: it is found once for these.
    """
    masks = dict[str, int]()
    """By field, the places that say it."""
    for place, (role, _) in mission_net.roles.items():
        if (field := _OTHERS.get(role) or said_as(role)) is not None:
            masks[field] = masks.get(field, 0) | 1 << place
    mask = reduce(or_, masks.values(), 0)
    known = [
        (places, (first, *_WITH.get(first, ())), dict[int, list[Any]]()) for first, places in masks.items()
    ]
    names = [name for _, fields, _ in known for name in fields]

    @cache
    def said(marked: int) -> Situation:
        values = list[Any]()
        for places, fields, of in known:
            if (here := marked & places) not in of:
                part = said_by(mission_net, bits_of(here))
                of[here] = [getattr(part, field) for field in fields]
            values += of[here]
        return Situation(**dict(zip(names, values, strict=True)))

    return tuple(said(marking & mask) for marking in packed)


_OTHERS = dict.fromkeys(("success", "failure", "abort", "exit"), "outcome") | {"known": "out_of_service"}
"""By role that says no field alone, the field that it says with others."""
_WITH = {"out_of_service": ("unnoticed",)}
"""By field, those that the same places say."""


class Ordered:
    """The actions of events, in order; computed once for all edges that determine the same actions.

    Args:
        mission_net: The net.
        states: What each state is.
    """

    def __init__(self, mission_net: MissionNet, states: Sequence[Situation]) -> None:
        self._ordering = Ordering(mission_net.usage, mission_net.graph)
        self._states = states
        numbers: dict[object, int] = {}
        self.alike = [
            numbers.setdefault((s.objectives, s.pending, s.done, tuple(s.mode.items())), len(numbers))
            for s in states
        ]
        """By state, the number of all that actions depend on."""
        self._known: dict[object, tuple[PlannedAction, ...]] = {}

    def actions(self, source: int, target: int, passage: Stopped) -> tuple[PlannedAction, ...]:
        """The actions of an event between two states."""
        key = self.alike[source], self.alike[target], passage.activities, passage.idled, passage.ended
        if key not in self._known:
            before, after = self._states[source], self._states[target]
            self._known[key] = tuple(self._ordering.actions(before, after, passage))
        return self._known[key]
