"""Status: what a section is entered with, may change, and hands on.

Hardware is in service or out of it, and that may be known or not; a handler with ``once`` is open or has
happened; a fact has one of its values. Each is a *status*: an element with one value of a few. What may be
true of an element are its *flags*, and a value is the set of those that are true.

A status is declared here, and the rest follows in loops over its flags: the slots of the composite's diagrams
(:mod:`mcpn.composite.renaming`), the entries, guards and changes of controllers, the bits of chains
(:mod:`mcpn.answers.causes`). Facts are all that has values and a start in
:attr:`mcpn.mission.fact_usage.FactUsage.facts`, whoever declares it: ``done(x)`` is one of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from typing import NamedTuple, TypeAlias

from mcpn.drawing.templates.canvas import Role
from mcpn.events import Event, What
from mcpn.mission.fact_conditions import all_flags, noticed
from mcpn.mission.fact_conditions import flags as flags_by_value
from mcpn.mission.robot import Crash, Fact, Hardware
from mcpn.records import record

Element: TypeAlias = tuple[str, str]
"""The kind and the name of an element, as provenances of places have them, or of a flag."""

KINDS = ("hardware", "dead", "once", "fact", "known")
"""The kinds of flags, in the order in which controllers and chains tell them."""


class Flag(NamedTuple):
    """Something that may be true of a status.

    Args:
        kind: One of :data:`KINDS`.
        name: The name of what it is true of; of a fact with the value.
        text: How controllers say it.
        so: What the place says that is marked where it is true; ``None`` where no place says that alone.
        otherwise: What a place says that is marked where it is false.
    """

    kind: str
    name: str
    text: str
    so: Role | None
    otherwise: Role | None

    @property
    def element(self) -> Element:
        """Its kind and name."""
        return self.kind, self.name

    @property
    def told(self) -> str:
        """Among what controllers say it: ``hardware`` out of service, what happens ``once``, ``facts``."""
        return self.kind if self.kind in ("hardware", "once") else "facts"


class FlagChange(NamedTuple):
    """What an event does to a status while nobody uses its element, by kinds of flags.

    Args:
        gained: What becomes true.
        lost: What becomes false, where it is there at all.
        kept: What must be true, and stays so.
        absent: What must be false, and stays so.
    """

    gained: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()
    absent: tuple[str, ...] = ()


class Before(NamedTuple):
    """How a status may have come to be another one before a part of the mission.

    Args:
        event: What may have happened.
        part: What its transition is called, of the hardware or of the mission.
        taken: What places say that are marked before, and not after.
        put: What places say that are marked after, and not before.
        asked: What places must say as well.
    """

    event: Event
    part: tuple[str, ...]
    taken: Role
    put: Role
    asked: tuple[Role, ...] = ()


@record(frozen=True)
class Status:
    """The status of one element.

    Args:
        kind: The kind of the element, as provenances of places call it.
        name: Its name.
        values: By value the names of the flags that are true.
        initial: The value at the start of the mission.
        flags: All its flags.
        said: By what a place says, the value that the element then has. What declared events do to it while
            nobody uses it is read off transitions that change such places alone.
        before: What may have happened to it before a part of the mission, which begins with the value of the
            start, or with hardware in service; failures and repairs of hardware may happen there anyway.
    """

    kind: str
    name: str
    values: Mapping[str, frozenset[Element]]
    initial: str
    flags: tuple[Flag, ...]
    said: Mapping[Role, str] = field(default_factory=dict)
    before: tuple[Before, ...] = ()

    @property
    def element(self) -> Element:
        """Its kind and name."""
        return self.kind, self.name


def of_hardware(hardware: Hardware) -> Status:
    """Hardware that can fail: in service, out of service, known to be so, lost for good.

    Only where hardware is detected late is there a flag that its loss is known.
    """
    name = hardware.name
    # Nothing crashes while nobody uses it: which places say that it has not is declared, not found out.
    ready: Role | None = ("ready", name) if isinstance(hardware, Crash) else None
    out = Flag("hardware", name, name, ("oos", name), ready)
    dead = Flag("dead", name, name, ("dead", name), ("alive", name))
    known = Flag("known", name, noticed(name), ("known", name), ("presumed", name))
    every = (out, dead, known) if hardware.detected == "late" else (out, dead)
    told = frozenset(flag.element for flag in every if flag is not dead)
    before = []
    if ready is not None:
        fails = Event(What.OUT_OF_SERVICE, name)
        before.append(Before(fails, ("earlier",), ready, ("oos", name)))
    if hardware.detected == "late":
        learnt = Before(
            Event(What.DETECTED, name), ("noticed",), ("presumed", name), ("known", name), (("oos", name),)
        )
        before.append(learnt)
    values = {"service": frozenset[Element](), "oos": told}
    return Status("hardware", name, values, hardware.initial, every, before=tuple(before))


HARDWARE: Mapping[What, FlagChange] = {
    What.OUT_OF_SERVICE: FlagChange(gained=("hardware",), absent=("dead", "known")),
    # Nobody repairs what is not known to be out of service.
    What.REPAIRED: FlagChange(lost=("hardware", "known"), absent=("dead",)),
    What.LOST: FlagChange(gained=("dead",), kept=("hardware",)),
}
"""By event of hardware what it changes."""


def of_handler(name: str) -> Status:
    """A handler that happens once: open, then happened."""
    flag = Flag("once", name, name, ("happened", name), ("open", name))
    values = {"open": frozenset[Element](), "happened": frozenset([flag.element])}
    said: dict[Role, str] = {("open", name): "open", ("happened", name): "happened"}
    before = Before(Event(What.EARLIER, name), ("earlier", name), ("open", name), ("happened", name))
    return Status("once", name, values, "open", (flag,), said, (before,))


def of_fact(fact: Fact) -> Status:
    """A fact, with the flags of :func:`mcpn.mission.fact_conditions.flags`."""
    said: dict[Role, str] = {("fact", f"{fact.name}={value}"): value for value in fact.values}
    at_start: Role = ("fact", f"{fact.name}={fact.start}")
    first, *others = all_flags(fact)
    # The place of the value at the start says that the first flag is false; nothing else says so of several.
    every = [Flag("fact", first, first, None if others else ("fact", first), at_start)]
    every += [Flag("fact", flag, flag, ("fact", flag), None) for flag in others]
    values = {
        value: frozenset(("fact", flag) for flag in true) for value, true in flags_by_value(fact).items()
    }
    before = tuple(
        Before(Event(What.EARLIER, to[1]), ("earlier", fact.name, value), at_start, to)
        for to, value in said.items()
        if value != fact.start
    )
    return Status("fact", fact.name, values, fact.start, tuple(every), said, before)


def statuses(
    hardware: Iterable[Hardware], handlers: Iterable[str], facts: Iterable[Fact]
) -> Iterator[Status]:
    """The status of all that has one, of some elements: a new kind of status is one line more.

    Args:
        hardware: Hardware that can fail.
        handlers: Handlers that happen once.
        facts: Facts.
    """
    yield from map(of_hardware, hardware)
    yield from map(of_handler, handlers)
    yield from map(of_fact, facts)


def kind_by_kind(every: Iterable[Status]) -> tuple[Flag, ...]:
    """The flags of some statuses in the order of :data:`KINDS`, but for what says that hardware has died."""
    flags = (flag for status in every for flag in status.flags if flag.kind != "dead")
    return tuple(sorted(flags, key=lambda flag: KINDS.index(flag.kind)))


def told_as_facts(every: Iterable[Status]) -> tuple[Flag, ...]:
    """Those of these flags that controllers tell beside hardware out of service and handlers."""
    return tuple(flag for flag in kind_by_kind(every) if flag.told == "facts")
