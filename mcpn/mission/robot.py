"""What the robot's engineer declares: resources, activities and events, as frozen dataclasses.

A new attribute of hardware, of an activity or of a fact is declared here, as a field of its class: reader,
writer, schema and the tables of the documentation follow from it (``python docs/tables.py`` writes them).
How a class declares an element is said in :mod:`mcpn.mission.model`, which declares blocks the same way. What
every element carries is declared here, because model imports this module and not the reverse.

Source: the paper, section 4.3.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from mcpn.errors import Source
from mcpn.mission.language.datatypes import (
    DETECTION,
    OCCASION,
    STATUS,
    VALUE,
    Children,
    FactName,
    Name,
    Probability,
    Rate,
    Resources,
    Values,
    When,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Described:
    """What every element of a mission file carries.

    Args:
        source: File and line; ``None`` for missions built in Python.
    """

    TAG = "description"
    description: Annotated[str | None, "Shown in reports."] = None
    source: Source | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Element(Described):
    """What has a name."""

    TAG = "common"
    NAMED = ""
    """The kind of names among which its own is unique, where others refer to it."""
    name: Annotated[Name, "Letters, digits and _, no digit first; unique in its kind."]


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter(Element):
    """A value for the control laws.

    It travels to the controller untouched and changes nothing in the verification.
    """

    TAG = "parameter"
    value: Annotated[str, "The text as the control laws read it."]
    unit: Annotated[str | None, "The unit, as text."] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Hardware(Element):
    """A sensor or an actuator. It may go out of service and come back at any moment."""  # paper, 4.3

    TAG = "hardware"
    NAMED = "resource"
    faulty: Annotated[bool, "false: it never goes out of service."] = True
    shared: Annotated[bool, "true: several activities may use it at a time, as a sensor that many read."] = (
        False
    )
    repairable: Annotated[bool, "false: once out of service it never comes back."] = True
    initial: Annotated[str, STATUS, "oos: out of service at the start, until it is repaired."] = "service"
    detected: Annotated[
        str,
        DETECTION,
        "late: the robot learns of its loss only from an activity that detects it, or as an objective fails.",
    ] = "at_once"
    failure_rate: Annotated[Rate, "Failures per hour of service, for numbers of risk."] = None
    repair_rate: Annotated[Rate, "Repairs per hour out of service; without it nobody repairs."] = None
    demand_probability: Annotated[
        Probability,
        "From 0 to 1: how probable it is that it fails when an alternative that consumes it starts, for "
        "numbers of risk.",
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault(Element):
    """A common cause: one event takes all hardware that it affects out of service, its repair brings it back.

    What it affects may also fail by itself, where it is faulty.
    """

    TAG = "fault"
    NAMED = "resource"
    affects: Annotated[Resources, "Hardware, of any robot of the mission."]
    repairable: Annotated[bool, "false: once it has happened it lasts."] = True
    failure_rate: Annotated[Rate, "How often it happens per hour, for numbers of risk."] = None
    repair_rate: Annotated[Rate, "Repairs per hour, while it lasts; without it nobody repairs."] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Software(Element):
    """Data that one activity produces and others consume, any number at a time unless it is exclusive."""

    TAG = "software"
    NAMED = "resource"
    exclusive: Annotated[bool, "true: one activity at a time reserves it."] = False


BOOLEAN_VALUES = ("false", "true")
"""The values of a fact that is false or true."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Fact(Element):
    """Something about the world that has one of a few values: a door is open or closed."""

    TAG = "fact"
    NAMED = "fact"
    values: Annotated[Values, "Its values, two at least."] = BOOLEAN_VALUES
    initial: Annotated[str | None, VALUE, "The one that it has at the start. Default: the first."] = None

    @property
    def start(self) -> str:
        """The value that it has at the start."""
        return self.values[0] if self.initial is None else self.initial


@dataclass(frozen=True, slots=True, kw_only=True)
class FactChange(Described):
    """A fact is given a value."""

    TAG = "sets"
    fact: Annotated[FactName, "The fact."]
    to: Annotated[str, VALUE, "The value that it has then."]
    on: Annotated[
        str | None,
        OCCASION,
        "Of an elementary objective: when it ends in success, in failure, or when it is come to. Default "
        "success. Not of an event.",
    ] = None

    @property
    def occasion(self) -> str:
        """``on``, or its default."""
        return "success" if self.on is None else self.on


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredEvent(Element):
    """Something that may happen at any moment and that blocks may handle: a leak, a call back."""

    TAG = "event"
    NAMED = "event"
    required: Annotated[
        bool, "true: it must be handled whatever runs; where it is ignored, events_handled fails."
    ] = False
    rate: Annotated[
        Rate, "How often it happens per hour, for numbers of risk; without it, it never happens in them."
    ] = None
    sets: tuple[FactChange, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Alternative(Element):
    """One way to perform the activity; the first in the document that is possible runs."""  # paper, 4.3

    TAG = "alternative"
    NAMED = "alternative"
    consumes: Annotated[Resources, "Resources that it needs, all at once; none: it is always possible."] = ()
    requires: Annotated[When, "What facts must be for it to be possible: door=open !holding."] = ()
    faulty: Annotated[
        bool, "true: it may crash while it runs, and is not possible until it has recovered."
    ] = False
    recovers: Annotated[bool, "false: once it has crashed it is never possible again."] = True
    failure_rate: Annotated[Rate, "Crashes per hour while it runs, for numbers of risk."] = None
    repair_rate: Annotated[Rate, "Recoveries per hour after a crash; without it, it does not recover."] = None
    parameters: tuple[Parameter, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Activity(Element):
    """A basic task of the robot.

    It is started by the objectives that name it, or, if it produces, by whoever needs what it produces.
    """  # paper, 4.3; switch_back: 6.2

    TAG = "activity"
    NAMED = "activity"
    produces: Annotated[Resources, "Software resources, each produced by one activity."] = ()
    switch_back: Annotated[
        bool, "true: it evaluates its alternatives again when a better one is possible again."
    ] = False
    detects: Annotated[Resources, "Hardware detected late of which it finds out the loss while it runs."] = ()
    detection_rate: Annotated[
        Rate,
        "How often per hour it finds out each of these losses while it runs, for numbers of risk; without it "
        "it finds none there.",
    ] = None
    requires: Annotated[When, "What facts must be for any of its alternatives to be possible."] = ()
    faulty: Annotated[
        bool,
        "true: it may crash while it runs, whatever its alternative, and none is possible until it has "
        "recovered.",
    ] = False
    recovers: Annotated[bool, "false: once it has crashed it never runs again."] = True
    failure_rate: Annotated[Rate, "Crashes per hour while it runs, for numbers of risk."] = None
    repair_rate: Annotated[Rate, "Recoveries per hour after a crash; without it, it does not recover."] = None
    parameters: tuple[Parameter, ...] = ()
    alternatives: Annotated[
        tuple[Alternative, ...],
        Children(short="consumes", words="Short for one alternative of the activity's own name."),
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Robot(Element):
    """What the robot's engineer declares: resources, facts, activities and events."""

    TAG = "robot"
    hardware: tuple[Hardware, ...] = ()
    faults: tuple[Fault, ...] = ()
    software: tuple[Software, ...] = ()
    facts: tuple[Fact, ...] = ()
    events: tuple[DeclaredEvent, ...] = ()
    activities: tuple[Activity, ...] = ()
