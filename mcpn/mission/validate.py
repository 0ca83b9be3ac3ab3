"""Whether a mission is valid: all that the schema cannot say is checked from here, resources in this file.

What is wrong with blocks and their routes is found by :mod:`mcpn.mission.block_errors`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from mcpn.did_you_mean import Hints
from mcpn.errors import InputError, Problem
from mcpn.mission.block_errors import BlockErrors, undeclared
from mcpn.mission.crash_errors import crash_errors, standing_errors
from mcpn.mission.fact_errors import fact_errors
from mcpn.mission.field_types import wrong_types
from mcpn.mission.hardware_errors import detected_twice, detection_errors, failure_errors
from mcpn.mission.language.datatypes import CORE_NAME, NAME, Interval
from mcpn.mission.language.forms import form_of
from mcpn.mission.language.references import cycles, duplicates, repeats, unseen
from mcpn.mission.model import (
    Block,
    BlockElement,
    Mission,
    Use,
    walk,
)
from mcpn.mission.requirement import Requirement
from mcpn.mission.robot import Activity, Crash, Described, Element, Fact, Parameter

MAX_CONSUMED = 1_000
"""Resources of one alternative: the net has arcs from the loss of each to all the others."""


def find_errors(mission: Mission, *, read: bool = False, before: Mission | None = None) -> list[Problem]:
    """What makes a mission invalid, what the schema says of files included.

    Args:
        mission: Any mission, read or built in Python.
        read: Whether it was read of files that fit the schema, so that its values are of the right types.
        before: The mission before an edit, valid; attributes of elements kept from it are not checked again.

    Returns:
        Every problem, with its line; empty for a valid mission, which is not checked again. Where values
        are of wrong types nothing else is checked. Nearly linear in the mission's size.
    """
    if mission.checked:
        return []
    problems = [] if read else list(wrong_types(mission))
    problems = problems or list(_Checks(mission, before).errors())
    if not problems:
        object.__setattr__(mission, "checked", True)
    return problems


def valid(mission: Mission) -> Mission:
    """Returns the mission if it is valid.

    Raises:
        InputError: It is no mission, or it is not valid, with every problem.
    """
    if not isinstance(mission, Mission):
        raise InputError.at(None, f"expected a mission, found {type(mission).__name__}")
    if problems := find_errors(mission):
        raise InputError(problems)
    return mission


class _Checks:
    def __init__(self, mission: Mission, before: Mission | None = None) -> None:
        self.mission = mission
        self.before = before
        self.activities: Mapping[str, Activity] = {a.name: a for a in mission.activities}
        self.hardware = {h.name: h for h in mission.hardware}
        self.software = {s.name: s for s in mission.software}
        self.resources: Mapping[str, Element] = {**self.hardware, **self.software}
        self.standing = {each.name for each in (*mission.common_causes, *mission.crashes)}
        self.named = {*self.resources, *(fault.name for fault in mission.faults)}
        self.hints = Hints()
        self.of_blocks = BlockErrors(mission, self.hints)
        self.producers: dict[str, list[Activity]] = {}
        for activity in mission.activities:
            for resource in dict.fromkeys(activity.produces):
                self.producers.setdefault(resource, []).append(activity)
        self.scopes: list[tuple[Element, tuple[Block, ...]]] = [
            (mission, mission.blocks),
            *((protocol, protocol.blocks) for protocol in mission.protocols),
        ]

    def errors(self) -> Iterator[Problem]:
        mission = self.mission
        for element in unseen(mission, self.before):
            yield from self.attributes(element)
        yield from duplicates("robot", mission.robots)
        resources = (*mission.hardware, *mission.faults, *mission.software)
        yield from duplicates("resource", resources)
        yield from duplicates("activity", mission.activities)
        yield from duplicates("fact", mission.every_fact)
        yield from duplicates("event", mission.events)
        yield from duplicates("protocol", mission.protocols)
        for requirements in (mission.requirements, *(p.requirements for p in mission.protocols)):
            yield from duplicates("requirement", requirements)
        for requirement in mission.all_requirements:
            yield from self.requirement(requirement)
        yield from failure_errors(mission.robots, self.hints)
        for crash in mission.crashes:
            yield from standing_errors(crash, self.activities)
        yield from detected_twice(mission.activities)
        yield from self.products()
        yield from fact_errors(mission, self.hints)
        for robot in mission.robots:
            for activity in robot.activities:
                yield from self.activity(activity)
                yield from crash_errors(activity, self.named)
                yield from self.of_blocks.reasons.activity(activity)
                yield from detection_errors(activity, self.hardware, self.named, self.hints)
        yield from cycles(
            "activities need each other's resources",
            self.activities,
            lambda name: [
                p.name for k in _consumed(self.activities[name]) for p in self.producers.get(k, ())
            ],
        )
        for owner, blocks in self.scopes:
            yield from self.of_blocks.text(owner, blocks)
        yield from cycles(
            "protocols use each other",
            protocols := self.of_blocks.protocols,
            lambda name: [b.protocol for b in walk(protocols[name].blocks) if isinstance(b, Use)],
        )

    def attributes(self, element: Element) -> Iterator[Problem]:
        """What one element says, by itself."""
        datatype = (
            CORE_NAME if self.mission.core and isinstance(element, BlockElement | Crash | Fact) else NAME
        )
        if not datatype.matches(element.name):
            found = f"the name {element.name!r} is not allowed"
            yield Problem(element.source, f"{found}, expected {datatype.expected}")
        yield from self.of_core(element)
        yield from self.values(element, element.name)
        for content in form_of(type(element)).contents:
            if content.classes == (Parameter,):
                yield from duplicates("parameter", getattr(element, content.name))

    def of_core(self, element: Element) -> Iterator[Problem]:
        """What is wrong with what an element says as core missions do, a block of itself as a copy."""
        core = form_of(type(element)).core
        said = [field.tag for field in core if getattr(element, field.name) != field.default]
        if said and not self.mission.core:
            message = f"{element.name} has {said[0]}, though the mission is no core mission"
            yield Problem(element.source, message)
        elif not isinstance(element, BlockElement) or not element.copy:
            return
        elif not element.own.endswith("".join(f"_{suffix}" for suffix in element.copy)):
            message = f"the copy {' '.join(element.copy)} of {element.name} is not what its name ends in"
            yield Problem(element.source, message)

    def values(self, element: Described, name: str) -> Iterator[Problem]:
        """Values of its attributes that are not allowed."""
        for attribute in form_of(type(element)).attributes:
            value, datatype = getattr(element, attribute.name), attribute.datatype
            if value is attribute.default:
                continue
            if attribute.several:
                yield from repeats(element.source, f"{attribute.tag} of {name}", value)
            elif value is not None and not datatype.allows(value):
                whole = isinstance(value, float) and not isinstance(value, Interval)
                shown = f"{value:g}" if whole else value
                message = f"{attribute.tag} of {name} is {shown}, expected {datatype.allowed}"
                yield Problem(element.source, message)

    def requirement(self, requirement: Requirement) -> Iterator[Problem]:
        """Checks a requirement by itself; its formulas are parsed later, when the mission has its net."""
        if requirement.misuse:
            yield Problem(requirement.source, f"requirement {requirement.name} has {requirement.misuse}")
        for pattern in requirement.patterns:
            said = f"<{pattern.TAG}> of requirement {requirement.name}"
            yield from self.values(pattern, said)
            if pattern.misuse:
                yield Problem(pattern.source, f"{said} has {pattern.misuse}")

    def products(self) -> Iterator[Problem]:
        for software in self.mission.software:
            producers = self.producers.get(software.name, [])
            if len(producers) != 1:
                names = ", ".join(a.name for a in producers) or "none"
                wanted = f'produces="{software.name}"'
                remedy = f"give {wanted} to the one that makes it"
                if producers:
                    remedy = f"leave {wanted} on one of them"
                needed = f"software {software.name} needs exactly one activity that produces it"
                yield Problem(software.source, f"{needed}, found {names}: {remedy}")

    def activity(self, activity: Activity) -> Iterator[Problem]:
        yield from duplicates("alternative", activity.alternatives)
        if not activity.alternatives:
            yield Problem(activity.source, f"activity {activity.name} has no alternative")
        if activity.switch_back and len(activity.alternatives) == 1:
            message = f"activity {activity.name} has one alternative: it cannot switch back to a better one"
            yield Problem(activity.source, message)
        for resource in dict.fromkeys(activity.produces):
            if resource in self.hardware:
                message = f"activity {activity.name} produces {resource}, which is a hardware resource"
                yield Problem(activity.source, message)
            elif resource not in self.software:
                yield undeclared(
                    self.hints, activity.source, f"activity {activity.name} produces", resource, self.software
                )
        for alternative in activity.alternatives:
            number = sum(resource not in self.standing for resource in alternative.consumes)
            if number > MAX_CONSUMED:
                who = f"alternative {alternative.name} of activity {activity.name} consumes"
                message = f"{who} {number} resources, expected at most {MAX_CONSUMED}"
                yield Problem(alternative.source, message)
            for resource in dict.fromkeys(alternative.consumes):
                if resource not in self.resources:
                    who = f"alternative {alternative.name} of activity {activity.name} consumes"
                    yield undeclared(self.hints, alternative.source, who, resource, self.resources)


def _consumed(activity: Activity) -> list[str]:
    return list(dict.fromkeys(k for alternative in activity.alternatives for k in alternative.consumes))
