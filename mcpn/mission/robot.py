"""What the robot's engineer declares: resources, activities and events, as frozen dataclasses.

A new attribute of hardware, of an activity or of a fact is declared here, as a field of its class: reader,
writer, schema and the tables of the documentation follow from it (``python docs/tables.py`` writes them).
How a class declares an element is said in :mod:`mcpn.mission.model`, which declares blocks the same way. What
every element carries is declared here, because model imports this module and not the reverse.

Source: the paper, section 4.3.
"""

from dataclasses import field
from typing import Annotated

from mcpn.errors import Source
from mcpn.mission.language.datatypes import (
    DETECTION,
    NAME,
    OCCASION,
    STATUS,
    VALUE,
    Children,
    Core,
    FactName,
    Name,
    Probability,
    Rate,
    Reasons,
    Resources,
    Values,
    When,
)
from mcpn.records import record


@record(frozen=True, slots=True, kw_only=True)
class Described:
    """What every element of a mission file carries.

    Args:
        source: File and line; ``None`` for missions built in Python.
    """

    TAG = "description"
    description: Annotated[str | None, "Shown in reports."] = None
    source: Source | None = field(default=None, compare=False)


@record(frozen=True, slots=True, kw_only=True)
class Element(Described):
    """What has a name."""

    TAG = "common"
    NAMED = ""
    """The kind of names among which its own is unique, where others refer to it."""
    name: Annotated[Name, "Letters, digits and _, no digit first; unique in its kind."]


@record(frozen=True, slots=True, kw_only=True)
class Parameter(Element):
    """A value for the control laws.

    It travels to the controller untouched and changes nothing in the verification.
    """

    TAG = "parameter"
    value: Annotated[str, "The text as the control laws read it."]
    unit: Annotated[str | None, "The unit, as text."] = None


@record(frozen=True, slots=True, kw_only=True)
class Hardware(Element):
    """A sensor or an actuator. It may go out of service and come back at any moment."""  # paper, 4.3

    TAG = "hardware"
    NAMED = "resource"
    faulty: Annotated[bool, "false: it never goes out of service."] = True
    shared: Annotated[bool, "true: several activities may use it at a time."] = False
    repairable: Annotated[bool, "false: once out of service it never comes back."] = True
    initial: Annotated[str, STATUS, "oos: out of service at the start, until repaired."] = "service"
    detected: Annotated[
        str,
        DETECTION,
        "late: its loss is noticed only by an activity that detects it, or as an objective fails.",
    ] = "at_once"
    failure_rate: Annotated[Rate, "Risk: failures per hour in service."] = None
    repair_rate: Annotated[Rate, "Risk: repairs per hour; without it, none."] = None
    demand_probability: Annotated[
        Probability,
        "Risk: the probability, 0 to 1, that it fails when an alternative that consumes it starts.",
    ] = None
    affects: Annotated[
        Resources, Core(), "It stands for a common cause, which takes this hardware out of service."
    ] = ()


@record(frozen=True, slots=True, kw_only=True)
class Crash(Hardware):
    """What an activity that may crash consumes; it goes out of service only while the activity runs.

    Its name is that of the activity, or of the activity and of an alternative that may: localise.by_scan.
    """

    TAG = "crash"
    faulty: bool = field(default=True, init=False)
    shared: bool = field(default=False, init=False)
    initial: str = field(default="service", init=False)
    detected: str = field(default="at_once", init=False)
    demand_probability: float | None = field(default=None, init=False)
    affects: tuple[str, ...] = field(default=(), init=False)
    activity: Annotated[str, NAME.to("activity"), "The activity."]


@record(frozen=True, slots=True, kw_only=True)
class Fault(Element):
    """A common cause: one event takes all hardware that it affects out of service, its repair brings it back.

    What it affects may also fail by itself, where it is faulty.
    """

    TAG = "fault"
    NAMED = "resource"
    affects: Annotated[Resources, "Hardware, of any robot of the mission."]
    repairable: Annotated[bool, "false: once it has happened it lasts."] = True
    failure_rate: Annotated[Rate, "Risk: occurrences per hour."] = None
    repair_rate: Annotated[Rate, "Risk: repairs per hour; without it, none."] = None


@record(frozen=True, slots=True, kw_only=True)
class Software(Element):
    """Data that one activity produces and others consume, any number at a time unless it is exclusive."""

    TAG = "software"
    NAMED = "resource"
    exclusive: Annotated[bool, "true: one activity at a time reserves it."] = False


BOOLEAN_VALUES = ("false", "true")
"""The values of a fact that is false or true."""


@record(frozen=True, slots=True, kw_only=True)
class Fact(Element):
    """Something about the world that has one of a few values: a door is open or closed."""

    TAG = "fact"
    NAMED = "fact"
    values: Annotated[Values, "Its values, two at least."] = BOOLEAN_VALUES
    initial: Annotated[str | None, VALUE, "Its value at the start. Default: the first."] = None

    @property
    def start(self) -> str:
        """The value that it has at the start."""
        return self.values[0] if self.initial is None else self.initial


@record(frozen=True, slots=True, kw_only=True)
class FactChange(Described):
    """A fact is given a value."""

    TAG = "sets"
    fact: Annotated[FactName, "The fact."]
    to: Annotated[str, VALUE, "Its new value."]
    on: Annotated[
        str | None,
        OCCASION,
        "Of an elementary objective: at its success, at its failure, or as it is entered. Default success. "
        "Not of an event.",
    ] = None

    @property
    def occasion(self) -> str:
        """``on``, or its default."""
        return "success" if self.on is None else self.on


@record(frozen=True, slots=True, kw_only=True)
class DeclaredEvent(Element):
    """Something that may happen at any moment and that blocks may handle: a leak, a call back."""

    TAG = "event"
    NAMED = "event"
    required: Annotated[bool, "true: where it is ignored, events_handled fails."] = False
    rate: Annotated[Rate, "Risk: occurrences per hour; without it, none."] = None
    sets: tuple[FactChange, ...] = ()

    @property
    def changed_facts(self) -> tuple[str, ...]:
        """The facts that it changes, whatever runs, as often as it says so."""
        return tuple(change.fact for change in self.sets)

    @property
    def changes_facts(self) -> bool:
        """Whether it changes facts; then no block handles it."""
        return bool(self.changed_facts)


@record(frozen=True, slots=True, kw_only=True)
class Alternative(Element):
    """One way to perform the activity; the first in the document that is possible runs."""  # paper, 4.3

    TAG = "alternative"
    NAMED = "alternative"
    consumes: Annotated[Resources, "Resources that it needs, all at once."] = ()
    requires: Annotated[When, "Facts that it needs: door=open !holding."] = ()
    faulty: Annotated[bool, "true: it may crash while it runs; then it is unavailable until it recovers."] = (
        False
    )
    recovers: Annotated[bool, "false: once it has crashed it never runs again."] = True
    failure_rate: Annotated[Rate, "Risk: crashes per hour while it runs."] = None
    repair_rate: Annotated[Rate, "Risk: recoveries per hour; without it, none."] = None
    parameters: tuple[Parameter, ...] = ()


@record(frozen=True, slots=True, kw_only=True)
class Activity(Element):
    """A basic task of the robot.

    It is started by the objectives that name it, or, if it produces, by whoever needs what it produces.
    """  # paper, 4.3; switch_back: 6.2

    TAG = "activity"
    NAMED = "activity"
    produces: Annotated[Resources, "Software resources, each produced by one activity."] = ()
    switch_back: Annotated[bool, "true: it changes back when a better alternative is available again."] = (
        False
    )
    failures: Annotated[Reasons, "Reasons for which an objective that runs it may fail."] = ()
    detects: Annotated[Resources, "Hardware detected late whose loss it may notice while it runs."] = ()
    detection_rate: Annotated[
        Rate,
        "Risk: how often per hour it notices each such loss; without it, never.",
    ] = None
    requires: Annotated[When, "Facts that all its alternatives need."] = ()
    faulty: Annotated[
        bool,
        "true: it may crash while it runs, whatever its alternative; then it is unavailable until it "
        "recovers.",
    ] = False
    recovers: Annotated[bool, "false: once it has crashed it never runs again."] = True
    failure_rate: Annotated[Rate, "Risk: crashes per hour while it runs."] = None
    repair_rate: Annotated[Rate, "Risk: recoveries per hour; without it, none."] = None
    parameters: tuple[Parameter, ...] = ()
    alternatives: Annotated[
        tuple[Alternative, ...],
        Children(short="consumes", words="Short for one alternative of the activity's own name."),
    ]


@record(frozen=True, slots=True, kw_only=True)
class Robot(Element):
    """What the robot's engineer declares: resources, facts, activities and events."""

    TAG = "robot"
    hardware: tuple[Hardware, ...] = ()
    crashes: Annotated[tuple[Crash, ...], Core()] = ()
    faults: tuple[Fault, ...] = ()
    software: tuple[Software, ...] = ()
    facts: tuple[Fact, ...] = ()
    events: tuple[DeclaredEvent, ...] = ()
    activities: tuple[Activity, ...] = ()
