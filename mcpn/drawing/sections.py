"""Sections of an objectives graph as nets of their own, and which of them are of one type.

A section is an elementary objective or a parallel block whole. Its local net is drawn with the facts of the
whole mission, so that each of its places is the one that the net of the mission has. Two sections are of one
type where renaming objectives, activities, alternatives and resources makes one of the other: their local
nets then differ in names only, place by place and transition by transition.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from operator import itemgetter
from typing import Any, NamedTuple

from mcpn.drawing.status import Element, Flag, Status, kind_by_kind, statuses, told_as_facts
from mcpn.errors import LimitError, Problem
from mcpn.mission.core.objectives_graph import (
    ElementarySection,
    ObjectivesGraph,
    ParallelSection,
    Section,
    failed_for,
)
from mcpn.mission.core.routes import Interrupted, exits_by_facts, exits_on
from mcpn.mission.fact_cases import FactCase
from mcpn.mission.fact_usage import touched_by
from mcpn.mission.model import ABORT, FAIL, SUCCEED, TIMED_OUT
from mcpn.mission.robot import Activity, Crash, Fact, Hardware, Software
from mcpn.mission.static.resource_use import Usage
from mcpn.records import record

MOST_BRANCHES = 30
"""Branches that may run at the same time in one section whose states are to be put on a diagram."""

MOST_HARDWARE = 120
"""Hardware resources that may fail in one such section."""

MOST_OF_BOTH_APART = 900
"""The product of the two, where no failure of hardware concerns two branches."""

MOST_OF_BOTH = 600
"""The same, where some failure does."""

MOST_OF_BOTH_WIDE = 200
"""The same, where the section has more than :data:`MOST_AT_ONCE` branches as well."""

MOST_AT_ONCE = 12
"""Such branches that one failure of hardware concerns: each more doubles at least what may come of it."""

MOST_ALTERNATIVES = 60
"""Alternatives of one activity in such a section."""


class Parts(NamedTuple):
    """What a net is made of: elements of a mission in the order in which they are drawn.

    Args:
        graph: The mission's objectives graph, or sections of it with routes of their own.
        hardware: Hardware resources.
        software: Software resources, those of each activity among them.
        activities: Activities, with all those that they reach through resources.
        facts: Facts that any of them, or the sections, change or read.
    """

    graph: ObjectivesGraph
    hardware: tuple[Hardware, ...]
    software: tuple[Software, ...]
    activities: tuple[Activity, ...]
    facts: tuple[Fact, ...] = ()


class Used:
    """The resources and activities that some activities use, with what templates look at of them.

    Args:
        usage: The static analysis of the whole mission.
        activities: The activities that objectives run, in the order in which the objectives stand.

    Attributes:
        hardware: Hardware, in the order in which the activities come upon it.
        software: The same.
        activities: The activities, with those that produce what they consume.
        number: The position of each resource among those of its kind.
        task: The position of each activity.
    """

    def __init__(self, usage: Usage, activities: Sequence[str]) -> None:
        self.usage = usage
        hardware, software = dict[str, Hardware](), dict[str, Software]()
        closure = dict[str, Activity]()
        declared = {s.name: s for s in usage.core.software}
        stack = [*activities][::-1]
        while stack:
            name = stack.pop()
            if name in closure:
                continue
            activity = closure[name] = usage.activities[name]
            for s in activity.produces:
                software.setdefault(s, declared[s])
            consumed = [k for alternative in activity.alternatives for k in alternative.consumes]
            for k in (*consumed, *activity.detects):
                if k in usage.hardware:
                    hardware.setdefault(k, usage.hardware[k])
            stack.extend(usage.producer[k] for k in reversed(consumed) if k in usage.producer)
        self.hardware = tuple(hardware.values())
        self.software = tuple(software.values())
        self.activities = tuple(closure.values())
        self.number = {e.name: i for kind in (self.hardware, self.software) for i, e in enumerate(kind)}
        self.task = {activity.name: i for i, activity in enumerate(self.activities)}

    @cached_property
    def faulty(self) -> tuple[str, ...]:
        """Hardware that can fail, in the order of :attr:`hardware`."""
        return tuple(h.name for h in self.hardware if h.faulty)

    @cached_property
    def statuses(self) -> tuple[Status, ...]:
        """The status of hardware that can fail, one for all sections with these activities."""
        return tuple(statuses((h for h in self.hardware if h.faulty), (), ()))

    @cached_property
    def flags(self) -> tuple[Flag, ...]:
        """What may be true of it, while none dies."""
        return kind_by_kind(self.statuses)

    @cached_property
    def late(self) -> tuple[str, ...]:
        """Hardware whose loss is detected late, in the order of :attr:`hardware`."""
        return tuple(h.name for h in self.hardware if h.detected == "late")

    @cached_property
    def type(self) -> Hashable:
        """Equal for what differs in names only: what templates look at, names replaced by numbers."""
        usage, number, task = self.usage, self.number, self.task
        activities = tuple(
            (
                tuple(number[s] for s in activity.produces),
                tuple(
                    (
                        tuple((k in usage.hardware, number[k]) for k in alternative.consumes),
                        usage.waits_for_release(activity.name, i),
                        usage.waits_for_answer(activity.name, i),
                    )
                    for i, alternative in enumerate(activity.alternatives)
                ),
                activity.name in usage.handover.with_idle,
                usage.may_wait(activity.name),
                usage.sharing.serves(activity.name),
                usage.switching.switches_back(activity.name),
                tuple(number[k] for k in activity.detects),
            )
            for activity in self.activities
        )
        # The ends of objectives read what is detected late in document order.
        late = tuple(number[h.name] for h in usage.core.late if h.name in {*self.late})

        def shared(resource: str) -> tuple[int, ...] | None:
            if resource not in usage.sharing.consumers:
                return None
            return tuple(task[a] for a in usage.sharing.consumers[resource] if a in task)

        return (
            tuple(
                (
                    h.faulty,
                    h.repairable,
                    shared(h.name),
                    h.name in usage.switching.watched,
                    isinstance(h, Crash),
                )
                for h in self.hardware
            ),
            tuple(shared(s.name) for s in self.software),
            activities,
            late,
        )


@record(frozen=True)
class LocalPart:
    """Some sections of a mission, glued by routes of their own, with all that they use.

    Args:
        used: What they use.
        graph: The sections; a route that leaves them is ``succeed``, ``fail`` or ``abort``.
    """

    used: Used
    graph: ObjectivesGraph

    @property
    def usage(self) -> Usage:
        """The static analysis of the whole mission."""
        return self.used.usage

    @property
    def parts(self) -> Parts:
        """What the sections use, in the order in which they come upon it."""
        used = self.used
        return Parts(self.graph, used.hardware, used.software, used.activities, self.facts)

    @property
    def faulty(self) -> tuple[str, ...]:
        """Hardware of the sections that can fail, in the order of :attr:`parts`."""
        return self.used.faulty

    @cached_property
    def once(self) -> tuple[str, ...]:
        """Handlers of the sections that happen once, in the order in which they stand."""
        return tuple(self.graph.once())

    def once_on(self, events: Collection[str]) -> tuple[str, ...]:
        """Those handlers of :attr:`once` that some events trigger."""
        on = {i.once: i.event for section in self.graph.all_sections() for i in section.every_interruption}
        return tuple(handler for handler in self.once if on[handler] in events)

    @cached_property
    def facts(self) -> tuple[Fact, ...]:
        """Facts that the sections, or what they use, touch, with those that events change with them."""
        world = self.usage.world
        if not world.facts:
            return ()
        required = (fact for activity in self.used.activities for fact in world.read_by(activity.name))
        return world.closed((*required, *touched_by(self.graph)))

    @cached_property
    def statuses(self) -> tuple[Status, ...]:
        """What has a status that the sections are entered with, may change, and hand on."""
        beside = tuple(statuses((), self.once, self.facts))
        return (*self.used.statuses, *beside) if beside else self.used.statuses

    @cached_property
    def flags(self) -> tuple[Flag, ...]:
        """What may be true of these, while no hardware dies, kind by kind."""
        alone = self.statuses is self.used.statuses
        return self.used.flags if alone else kind_by_kind(self.statuses)

    @property
    def entry_flags(self) -> tuple[str, ...]:
        """What may be true at its entry that controllers tell beside hardware and handlers."""
        return tuple(flag.text for flag in told_as_facts(self.statuses))

    @cached_property
    def carried(self) -> tuple[Element, ...]:
        """Its flags by kind and name."""
        return tuple(flag.element for flag in self.flags)

    @cached_property
    def type(self) -> Hashable:
        """Equal for sections of one type: what the paper's templates look at, names replaced by numbers."""
        return (
            self.used.type,
            self._shape(self.graph, self.used.number, self.used.task),
            self._world if self.facts else None,
        )

    @property
    def _world(self) -> Hashable:
        """What templates look at of facts, names replaced by numbers."""
        world, number = self.usage.world, {fact.name: i for i, fact in enumerate(self.facts)}
        value = {(fact.name, v): i for fact in self.facts for i, v in enumerate(fact.values)}
        changing = tuple(
            (event, *((number[fact], *(value[fact, v] for v in to.values())) for fact, to in changes.items()))
            for event, changes in world.changing.items()
            if not number.keys().isdisjoint(changes)
        )
        required = tuple(
            tuple(
                tuple((number[fact], value[fact, v]) for fact, v in world.requires(activity.name, i))
                for i in range(len(activity.alternatives))
            )
            for activity in self.used.activities
        )
        sets = tuple(
            tuple((number[s.fact], value[s.fact, s.value], s.on) for s in objective.sets)
            for objective in self.graph.walk()
        )
        cases = tuple(
            tuple((number[fact], value[fact, v]) for fact, v in case.when)
            for section in self.graph.all_sections()
            for case in section.all_cases
        )
        facts = tuple((len(fact.values), fact.values.index(fact.start)) for fact in self.facts)
        watched = tuple((number[fact], value[fact, v]) for fact, v in sorted(world.watched) if fact in number)
        return facts, changing, required, sets, cases, watched

    def _shape(self, graph: ObjectivesGraph, number: dict[str, int], task: dict[str, int]) -> Hashable:
        positions = {section.name: i for i, section in enumerate(graph.sections)}
        shapes = []
        for section in graph.sections:
            inside: Hashable
            gated = section.name in self.usage.handover.gated
            if isinstance(section, ElementarySection):
                inside = tuple(task[a] for a in section.activities)
                if section.reasons:  # names of events, which the nets of one type share
                    inside = inside, tuple(reason for reason, _ in section.reasons)
                if section.becomes:
                    inside = inside, len(section.becomes), section.timed_out is not None
            else:
                branches = tuple((b.mandatory, self._shape(b.graph, number, task)) for b in section.branches)
                pause_graphs = tuple(
                    (self._shape(pause_graph.graph, number, task), self._events(pause_graph, {}))
                    for pause_graph in section.pause_graphs
                )
                inside = (branches, section.needed, section.hasty, section.failing, pause_graphs)
                inside = inside if section.timed_out is None else (inside, TIMED_OUT)
                inside = (inside, len(section.becomes)) if section.becomes else inside
            outcomes = (section.led(outcome) for outcome, _ in section.outcomes)
            routes = (tuple(positions.get(route, route) for route in led) for led in outcomes)
            events = self._events(section, positions)
            shapes.append((isinstance(section, ParallelSection), gated, inside, events, *routes))
        return positions[graph.entry], tuple(shapes)

    def _events(self, interrupted: Interrupted, positions: Mapping[str, int]) -> Hashable:
        """What interrupts a section, names replaced by numbers."""
        return tuple(
            (
                i.event,
                tuple(positions.get(route, route) for route in i.routes),
                i.once and self.once.index(i.once),
                i.pauses,
            )
            for i in interrupted.interruptions
        )


class SectionParts:
    """Makes parts of one section, or of two at their junction; parts of the same activities share their use.

    Args:
        usage: The static analysis of the whole mission.
    """

    def __init__(self, usage: Usage) -> None:
        self.usage = usage
        self._known: dict[tuple[str, ...], Used] = {}
        self._alone: dict[str, LocalPart] = {}
        self._kinds: dict[Hashable, int] = {}

    def alone(self, section: Section) -> LocalPart:
        """A section alone; one for all who ask."""
        if section.name not in self._alone:
            self._alone[section.name] = self._part([_routed(section, set())])
        return self._alone[section.name]

    def alike(self, section: Section) -> Hashable:
        """Equal for sections of one type that use the same, and say the same of facts and of handlers."""
        part = self.alone(section)
        kind = part.type, part.used, part.once, tuple(fact.name for fact in part.facts)
        return self._kinds.setdefault(kind, len(self._kinds))  # which is hashed once

    def junction(self, first: Section, second: Section) -> LocalPart:
        """Two sections of which the first leads to the second; or one that leads to itself."""
        if first.name == second.name:
            return self._part([_routed(first, {first.name})])
        return self._part([_routed(first, {second.name}), _routed(second, set())])

    def _part(self, sections: Sequence[Section]) -> LocalPart:
        graph = ObjectivesGraph(tuple(sections), sections[0].name)
        activities = tuple(a for section in graph.walk() for a in section.activities)
        if activities not in self._known:
            self._known[activities] = Used(self.usage, activities)
        return LocalPart(self._known[activities], graph)


def section_part(usage: Usage, section: Section) -> LocalPart:
    """A section alone."""
    return SectionParts(usage).alone(section)


def refuse_wide(parts: Iterable[LocalPart]) -> None:
    """Counts what makes the diagram of a section large, before work on it begins.

    A diagram grows faster than with the square of what may happen at the same time, and with each branch that
    one event concerns by a factor, so that a little beyond the limits it takes minutes and gigabytes.

    Args:
        parts: Each of one section alone.

    Raises:
        LimitError: A section has more than :data:`MOST_BRANCHES` branches, uses more than
            :data:`MOST_HARDWARE` hardware resources that may fail, has too much of both, one failure
            concerns more than :data:`MOST_AT_ONCE` branches, or an activity has more than
            :data:`MOST_ALTERNATIVES` alternatives; with its line.
    """
    for part in parts:
        (section,) = part.graph.sections
        branches, hardware = _width(part.graph), len(part.faulty)
        same, may_fail = "branches that may run at the same time", "hardware resources that may fail"
        listed = 1 < branches <= MOST_BRANCHES and hardware <= MOST_HARDWARE
        most, concerned = _most_concerned(part) if listed else ("", 0)
        of_both = MOST_OF_BOTH_WIDE if branches > MOST_AT_ONCE else MOST_OF_BOTH
        if concerned <= 1:
            of_both = MOST_OF_BOTH_APART
        ways, widest = max(((len(a.alternatives), a.name) for a in part.used.activities), default=(0, ""))
        for found, limit, what in (
            (branches, MOST_BRANCHES, same),
            (hardware, MOST_HARDWARE, may_fail),
            (branches * hardware, of_both, f"({branches} {same}) x ({hardware} {may_fail})"),
            (concerned, MOST_AT_ONCE, f"{same} and that the loss of {most} concerns"),
            (ways, MOST_ALTERNATIVES, f"alternatives of activity {widest}"),
        ):
            if found > limit:
                message = (
                    f"{section.name} has {found} {what}, the limit for composition and diagrams is {limit}"
                )
                raise LimitError(str(Problem(section.source, message)))


def _most_concerned(part: LocalPart) -> tuple[str, int]:
    """The hardware whose loss concerns the most branches that run at the same time, and their number."""
    consumed = {
        activity.name: {k for alternative in activity.alternatives for k in alternative.consumes}
        for activity in part.used.activities
    }
    needed = {
        name: frozenset[str]().union(*(consumed[supplier] for supplier in part.usage.closure(name)))
        for name in {a for section in part.graph.walk() for a in section.activities}
    }

    def concerned(lost: str) -> int:
        return _width(part.graph, lambda objective: any(lost in needed[a] for a in objective.activities))

    return max(((name, concerned(name)) for name in part.faulty), key=itemgetter(1), default=("", 0))


def _width(
    graph: ObjectivesGraph, counts: Callable[[ElementarySection], bool] = lambda _objective: True
) -> int:
    """How many objectives of a graph, of those that count, may run at the same time."""
    return max(
        sum(_width(branch.graph, counts) for branch in section.branches)
        if isinstance(section, ParallelSection)
        else int(counts(section))
        for section in graph.sections
    )


def junction_part(usage: Usage, first: Section, second: Section) -> LocalPart:
    """Two sections of which the first leads to the second; or one that leads to itself."""
    return SectionParts(usage).junction(first, second)


def _routed(section: Section, kept: set[str]) -> Section:
    """The section, each of its routes to a section that is not ``kept`` replaced by an exit of its own."""
    success = section.success if section.success in kept else SUCCEED
    failure = section.failure if section.failure in kept else FAIL

    def cased(exit_: str, cases: Sequence[FactCase]) -> tuple[FactCase, ...]:
        return tuple(
            c if c.target in kept else c._replace(target=to) for to, c in exits_by_facts(exit_, cases)
        )

    interruptions = tuple(
        replace(i, target=i.target if i.target in kept else exit_, cases=cased(exit_, i.cases))
        for exit_, i in exits_on(section)
    )
    cases = tuple(
        (outcome, case)
        for outcome, _ in section.outcomes
        for case in cased(outcome, section.cases_of(outcome))
    )
    becomes = (
        each if each.target in kept else replace(each, target=outcome) for outcome, each in section.becoming
    )
    routed: dict[str, Any] = {
        "success": success,
        "failure": failure,
        "interruptions": interruptions,
        "cases": cases,
        "becomes": tuple(becomes),
    }
    if section.timed_out is not None and section.timed_out not in kept:
        routed["timed_out"] = TIMED_OUT
    if isinstance(section, ElementarySection):
        named = ((why, to if to in kept else failed_for(why)) for why, to in section.reasons)
        return replace(section, **routed, reasons=tuple(named))
    abort = section.abort if section.abort is None or section.abort in kept else ABORT
    pause_exits = tuple(
        (outcome, target if target in kept else outcome) for outcome, target in section.pause_exits
    )
    return replace(section, **routed, abort=abort, pause_exits=pause_exits)
