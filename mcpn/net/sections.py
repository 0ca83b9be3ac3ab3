"""Sections of an objectives graph as nets of their own, and which of them are of one type.

A section is an elementary objective or a parallel block whole. Its local net is drawn with the facts of the
whole mission, so that each of its places is the one that the net of the mission has. Two sections are of one
type where renaming objectives, activities, alternatives and resources makes one of the other: their local
nets then differ in names only, place by place and transition by transition.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from mcpn.errors import InputError
from mcpn.mission.flatten import ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.model import FAIL, SUCCEED, Activity, Hardware, Software
from mcpn.mission.usage import Usage
from mcpn.net.compose import MissionNet, Parts, compose_parts
from mcpn.net.templates import TemplateSet

MOST_NAMED = 12
"""Sections that an error lists at most."""


@dataclass(frozen=True)
class LocalPart:
    """Some sections of a mission, glued by routes of their own, with all that they use.

    Args:
        usage: Static facts of the whole mission.
        graph: The sections; a route that leaves them is ``succeed`` or ``fail``.
    """

    usage: Usage
    graph: ObjectivesGraph

    @cached_property
    def parts(self) -> Parts:
        """What the sections use, in the order in which they come upon it."""
        hardware, software = dict[str, Hardware](), dict[str, Software]()
        activities = dict[str, Activity]()
        declared = {s.name: s for s in self.usage.mission.software}
        stack = [a for section in self.graph.walk() for a in section.activities][::-1]
        while stack:
            name = stack.pop()
            if name in activities:
                continue
            activity = activities[name] = self.usage.activities[name]
            for s in activity.produces:
                software.setdefault(s, declared[s])
            consumed = [k for alternative in activity.alternatives for k in alternative.consumes]
            for k in consumed:
                if k in self.usage.hardware:
                    hardware.setdefault(k, self.usage.hardware[k])
            stack.extend(self.usage.producer[k] for k in reversed(consumed) if k in self.usage.producer)
        in_order = tuple(tuple(found.values()) for found in (hardware, software, activities))
        return Parts(self.graph, *in_order)  # type: ignore[arg-type]

    @property
    def faulty(self) -> tuple[str, ...]:
        """Hardware of the sections that can fail, in the order of :attr:`parts`."""
        return tuple(h.name for h in self.parts.hardware if h.faulty)

    def net(self, templates: TemplateSet | None = None) -> MissionNet:
        """The local net."""
        return compose_parts(self.usage, self.parts, templates)

    @cached_property
    def type(self) -> Hashable:
        """Equal for sections of one type: what the paper's templates look at, names replaced by numbers."""
        usage, parts = self.usage, self.parts
        number = {e.name: i for kind in (parts.hardware, parts.software) for i, e in enumerate(kind)}
        task = {activity.name: i for i, activity in enumerate(parts.activities)}
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
                usage.sharing.order_matters(activity.name),
                usage.switching.switches_back(activity.name),
            )
            for activity in parts.activities
        )

        def shared(resource: str) -> tuple[int, ...] | None:
            if resource not in usage.sharing.consumers:
                return None
            return tuple(task[a] for a in usage.sharing.consumers[resource] if a in task)

        software = tuple((usage.released_unasked(s.name), shared(s.name)) for s in parts.software)
        return (
            tuple((h.faulty, shared(h.name), h.name in usage.switching.watched) for h in parts.hardware),
            software,
            activities,
            self._shape(self.graph, number, task),
        )

    def _shape(self, graph: ObjectivesGraph, number: dict[str, int], task: dict[str, int]) -> Hashable:
        places = {section.name: i for i, section in enumerate(graph.sections)}
        shapes = []
        for section in graph.sections:
            inside: Hashable
            awaited = self.usage.handover.awaited.get(section.name)
            waits = None
            if awaited is not None:  # what is not of the part is idle while the part runs
                waits = (
                    tuple(task[a] for a in awaited.activities if a in task),
                    tuple(
                        (number[s], None if owner is None else task[owner])
                        for s, owner in awaited.interfaces
                        if s in number and (owner is None or owner in task)
                    ),
                )
            if isinstance(section, ElementarySection):
                inside = tuple(task[a] for a in section.activities)
            else:
                inside = tuple((b.mandatory, self._shape(b.graph, number, task)) for b in section.branches)
            routes = (places.get(r, r) for r in (section.success, section.failure))
            events = tuple((i.event, places.get(i.target, i.target)) for i in section.interruptions)
            shapes.append((isinstance(section, ParallelSection), waits, inside, events, *routes))
        return places[graph.entry], tuple(shapes)


def exit_on(event: str) -> str:
    """What the exit of a part is called that an event leads to; no section can be called so."""
    return f"on {event}"


def section_part(usage: Usage, section: Section) -> LocalPart:
    """A section alone."""
    alone = _routed(section, set())
    return LocalPart(usage, ObjectivesGraph((alone,), section.name))


def part_of(mission_net: MissionNet, name: str) -> LocalPart:
    """A section of a mission, by its name, alone.

    Raises:
        InputError: There is no such section.
    """
    sections = {section.name: section for section in mission_net.graph.sections}
    if name not in sections:
        some = ", ".join([*sections][:MOST_NAMED]) + (", …" if len(sections) > MOST_NAMED else "")
        raise InputError.at(None, f"found the section {name!r}, expected one of {some}")
    return section_part(mission_net.usage, sections[name])


def junction_part(usage: Usage, first: Section, second: Section) -> LocalPart:
    """Two sections of which the first leads to the second; or one that leads to itself."""
    if first.name == second.name:
        sections: Sequence[Section] = (_routed(first, {first.name}),)
    else:
        sections = (_routed(first, {second.name}), _routed(second, set()))
    return LocalPart(usage, ObjectivesGraph(tuple(sections), first.name))


def _routed(section: Section, kept: set[str]) -> Section:
    success = section.success if section.success in kept else SUCCEED
    failure = section.failure if section.failure in kept else FAIL
    interruptions = tuple(
        i if i.target in kept else replace(i, target=exit_on(i.event)) for i in section.interruptions
    )
    return replace(section, success=success, failure=failure, interruptions=interruptions)


class Renaming:
    """From the names in one section to those in another of the same type.

    Args:
        old: The section that the names are of.
        new: The other section.

    Attributes:
        objectives: By name in the old section.
        activities: The same.
        alternatives: As ``activity.alternative``.
        hardware: By name.
        elements: By the kind and the name that provenances in the old section have, the name in the new one.
    """

    def __init__(self, old: LocalPart, new: LocalPart) -> None:
        both = list(zip(old.parts.activities, new.parts.activities, strict=True))
        walks = zip(old.graph.walk(), new.graph.walk(), strict=True)
        self.objectives = {theirs.name: mine.name for theirs, mine in walks}
        self.activities = {theirs.name: mine.name for theirs, mine in both}
        self.alternatives = {
            f"{theirs.name}.{a.name}": f"{mine.name}.{b.name}"
            for theirs, mine in both
            for a, b in zip(theirs.alternatives, mine.alternatives, strict=True)
        }
        resources = zip(old.parts.hardware, new.parts.hardware, strict=True)
        self.hardware = {theirs.name: mine.name for theirs, mine in resources}
        software = zip(old.parts.software, new.parts.software, strict=True)
        sections = zip(old.graph.all_sections(), new.graph.all_sections(), strict=True)
        self.elements = {
            **{("hardware", name): mine for name, mine in self.hardware.items()},
            **{("software", theirs.name): mine.name for theirs, mine in software},
            **{("activity", name): mine for name, mine in self.activities.items()},
            **{("alternative", name): mine for name, mine in self.alternatives.items()},
            **{(kind_of(theirs), theirs.name): mine.name for theirs, mine in sections},
        }


def kind_of(section: Section) -> str:
    """What the provenances of a section's places call it."""
    return "objective" if isinstance(section, ElementarySection) else "parallel"
