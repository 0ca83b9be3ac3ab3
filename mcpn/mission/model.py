"""What the designer writes: the mission as frozen dataclasses that remember their lines.

The model keeps the mission as it was written (uses of protocols are not expanded, imports are merged);
:mod:`mcpn.mission.flatten` turns it into the objectives graph. Two missions are equal when they say the
same, wherever they were written: sources take no part in comparisons.

Source: the paper, section 4 (objective, parallel block, activity, alternative, resource).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

from mcpn.errors import Source
from mcpn.notebook import Drawn

SUCCEED = "succeed"
"""The route to the success exit of the enclosing block."""
FAIL = "fail"
"""The route to the failure exit of the enclosing block."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Element:
    """What every element of a mission file carries.

    Args:
        name: Unique in its kind.
        description: Shown in reports.
        source: File and line; ``None`` for missions built in Python.
    """

    name: str
    description: str | None = None
    source: Source | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter(Element):
    """A value for the control laws; it travels untouched to the controller.

    Args:
        value: The text as written.
        unit: The unit as written, if any.
    """

    value: str
    unit: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Hardware(Element):
    """A hardware resource: a sensor or an actuator (paper, 4.3).

    Args:
        faulty: Whether it can go out of service.
        failure_rate: Failures per hour of service, for numbers of risk; ``None`` where not known.
        repair_rate: Repairs per hour out of service; ``None`` where nobody repairs it.
        shared: Whether several activities may use it at a time (a sensor that many read).
    """

    faulty: bool = True
    failure_rate: float | None = None
    repair_rate: float | None = None
    shared: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Software(Element):
    """A software resource: a data carrier that exactly one activity produces (paper, 4.3).

    Args:
        exclusive: Whether one activity at a time reserves it, as in the paper; else any number may use it.
    """

    exclusive: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Alternative(Element):
    """One way to perform an activity (paper, 4.3).

    Args:
        consumes: Names of the resources that it needs, all at once; may be empty.
        parameters: For the control law.
    """

    consumes: tuple[str, ...] = ()
    parameters: tuple[Parameter, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Activity(Element):
    """A basic robotic task with its alternatives in priority order (paper, 4.3).

    Args:
        alternatives: At least one; the first is preferred. The short form ``<activity consumes="…">`` is
            one alternative that bears the activity's name.
        produces: Names of the software resources that it produces; may be empty.
        parameters: For the control law, whatever the alternative.
        switch_back: Whether it evaluates its alternatives again when one of higher priority than the running
            one becomes possible; else it keeps the one that runs (paper, 6.2).
    """

    alternatives: tuple[Alternative, ...]
    produces: tuple[str, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    switch_back: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredEvent(Element):
    """Something that may happen at any moment and interrupt what the robot does: a leak, a call back.

    Args:
        rate: How often it happens per hour, for numbers of risk; in them it never does where ``None``.
    """

    rate: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Robot(Element):
    """What the robot's engineer declares: resources, activities and events.

    Args:
        hardware: In document order.
        software: In document order.
        activities: In document order.
        events: In document order.
    """

    hardware: tuple[Hardware, ...] = ()
    software: tuple[Software, ...] = ()
    activities: tuple[Activity, ...] = ()
    events: tuple[DeclaredEvent, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Handler:
    """What a block does when an event happens while it runs: it is stopped and left at once.

    Of the handlers of one event the innermost that stands around what runs counts.

    Args:
        event: The declared event.
        goto: Where it leads: a sibling of the block, ``succeed`` or ``fail``; from the mission itself, one of
            its own blocks, ``succeed`` or ``fail``.
        once: Whether it happens at most once in the whole mission, whichever copy of it (value, use, round,
            try, branch) it happens in; then the next handler outwards counts, if there is one.
        description: Shown in reports.
        source: File and line.
    """

    event: str
    goto: str
    once: bool = False
    description: str | None = None
    source: Source | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockElement(Element):
    """What every block carries, whatever its kind.

    Args:
        success: Where success leads: a sibling's name, ``succeed``, ``fail``, or ``None`` for the default
            (the next sibling, or ``succeed`` from the last).
        failure: Where failure leads; ``None`` for the default, ``fail``.
        mandatory: Counts in the outcome of the parallel block that holds it; of no effect elsewhere.
        retries: How many times it is tried again when it fails; it fails when the last try does.
        repeat: How many times it is done, one round after the other; ``None`` for once, without rounds. The
            first round that fails ends it in failure. Each round has its own retries.
        handlers: What it does on events, rounds and tries included; at most one for each event.
    """

    success: str | None = None
    failure: str | None = None
    mandatory: bool = True
    retries: int = 0
    repeat: int | None = None
    handlers: tuple[Handler, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Objective(BlockElement):
    """An elementary objective: the activities that it runs together (paper, 4.1).

    Args:
        activities: At least one name.
        parameters: For the control laws of its activities.
        duration: Its mean duration in hours, for numbers of risk; ``None`` where not known.
        failure_probability: How probable it is that it ends in failure though it could succeed; 0 if not
            given.
    """

    activities: tuple[str, ...]
    parameters: tuple[Parameter, ...] = ()
    duration: float | None = None
    failure_probability: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Recursive(BlockElement):
    """A recursive objective: blocks of a lower level, entered at the first (paper, 4.1).

    Args:
        blocks: At least one.
        parameters: For the control laws of the activities inside.
    """

    blocks: tuple[Block, ...]
    parameters: tuple[Parameter, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Parallel(BlockElement):
    """A parallel block: its children run at the same time (paper, 4.2).

    Args:
        blocks: Objectives, elementary or recursive, or uses; at least one of them mandatory.
    """

    blocks: tuple[Block, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Use(BlockElement):
    """One use of a protocol; names inside it are qualified by the use's own name.

    Args:
        protocol: The protocol's name.
        parameters: Of names that the protocol declares: they count in it, but where its blocks say otherwise.
    """

    protocol: str
    parameters: tuple[Parameter, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Each(BlockElement):
    """Blocks that are done once for each of some values, one round after the other.

    A round that succeeds leads to the round of the next value; the first that fails ends all in failure. A
    block inside is named with the value appended (``visit_12``), which qualifies what it holds
    (``visit_12.travel``).

    Args:
        values: At least one, in order.
        blocks: At least one; each round is entered at the first.
        parameter: The parameter that has the value in each round; by default it has the block's own name.
    """

    values: tuple[str, ...]
    blocks: tuple[Block, ...]
    parameter: str | None = None

    @property
    def bound(self) -> str:
        """The name of the parameter that has the value."""
        return self.parameter or self.name


Block: TypeAlias = Objective | Recursive | Parallel | Use | Each
"""Whatever stands in a series."""
Holder: TypeAlias = Recursive | Parallel | Each
"""Blocks that hold blocks."""
ROUND = "round"
"""The parameter that has the number of the round, from 1, in a block that is repeated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Protocol(Element):
    """A reusable series of blocks, entered at the first.

    Args:
        blocks: At least one.
        parameters: Defaults for the control laws inside: they count where no block says the name, neither one
            inside, nor a use of the protocol, nor one around that.
    """

    blocks: tuple[Block, ...]
    parameters: tuple[Parameter, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Mission(Drawn, Element):
    """A whole mission, imports merged.

    Args:
        blocks: The blocks of the mission itself, entered at the first.
        robots: The robots' declarations; names are unique across them.
        protocols: Every protocol known to the mission.
        handlers: What the whole mission does on events; they lead to its own blocks.
    """

    blocks: tuple[Block, ...]
    robots: tuple[Robot, ...] = ()
    protocols: tuple[Protocol, ...] = ()
    handlers: tuple[Handler, ...] = ()
    # Whether it has been found valid: who asks again need not look again.
    checked: bool = field(default=False, init=False, repr=False, compare=False)

    def __repr__(self) -> str:
        sizes = {
            "blocks": sum(1 for _ in walk(self.blocks)),
            "protocols": len(self.protocols),
            "activities": len(self.activities),
            "hardware": len(self.hardware),
        }
        return f"<mission {self.name}: {', '.join(f'{n} {what}' for what, n in sizes.items())}>"

    @property
    def hardware(self) -> tuple[Hardware, ...]:
        """All hardware resources, in document order."""
        return tuple(resource for robot in self.robots for resource in robot.hardware)

    @property
    def software(self) -> tuple[Software, ...]:
        """All software resources, in document order."""
        return tuple(resource for robot in self.robots for resource in robot.software)

    @property
    def activities(self) -> tuple[Activity, ...]:
        """All activities, in document order."""
        return tuple(activity for robot in self.robots for activity in robot.activities)

    @property
    def events(self) -> tuple[DeclaredEvent, ...]:
        """All declared events, in document order."""
        return tuple(event for robot in self.robots for event in robot.events)


def walk(blocks: tuple[Block, ...]) -> Iterator[Block]:
    """Every block at any depth, parents first, in document order; uses are not expanded.

    The walk keeps its own stack, so depth is bounded by memory alone.
    """
    stack = list(reversed(blocks))
    while stack:
        block = stack.pop()
        yield block
        if isinstance(block, Holder):
            stack.extend(reversed(block.blocks))
