"""What the robot's engineer declares: resources, activities and events, as frozen dataclasses.

They are elements of the language of mission files as those of :mod:`mcpn.mission.model` are: its docstring
says how a class declares one. What every element carries is declared here, for imports point one way.

Source: the paper, section 4.3.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from mcpn.errors import Source
from mcpn.mission.language.datatypes import (
    Children,
    Name,
    Rate,
    Resources,
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
    failure_rate: Annotated[Rate, "Failures per hour of service, for numbers of risk."] = None
    repair_rate: Annotated[Rate, "Repairs per hour out of service; without it nobody repairs."] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Software(Element):
    """Data that one activity produces and others consume, any number at a time unless it is exclusive."""

    TAG = "software"
    NAMED = "resource"
    exclusive: Annotated[bool, "true: one activity at a time reserves it."] = False


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredEvent(Element):
    """Something that may happen at any moment and that blocks may handle: a leak, a call back."""

    TAG = "event"
    NAMED = "event"
    rate: Annotated[
        Rate, "How often it happens per hour, for numbers of risk; without it, it never happens in them."
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Alternative(Element):
    """One way to perform the activity; the first in the document that is possible runs."""  # paper, 4.3

    TAG = "alternative"
    NAMED = "alternative"
    consumes: Annotated[Resources, "Resources that it needs, all at once; none: it is always possible."] = ()
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
    parameters: tuple[Parameter, ...] = ()
    alternatives: Annotated[
        tuple[Alternative, ...],
        Children(short="consumes", words="Short for one alternative of the activity's own name."),
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Robot(Element):
    """What the robot's engineer declares: resources, activities and events."""

    TAG = "robot"
    hardware: tuple[Hardware, ...] = ()
    software: tuple[Software, ...] = ()
    events: tuple[DeclaredEvent, ...] = ()
    activities: tuple[Activity, ...] = ()
