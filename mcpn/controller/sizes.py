"""How large the controllers of a mission are, before anything is listed."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence

from mcpn.composite.composite import CompositeSpace
from mcpn.composite.section_type import SectionType
from mcpn.errors import LimitError
from mcpn.spaces.stable.big_steps import FEW_STEPS, is_function

MAX_TABLE_STATES = 1_000_000
"""States of a section that its machine lists at most."""

MOST_TABLED = 50_000
"""States of a section up to which ``auto`` makes a machine of it, where rules are possible, too."""

MOST_TABLED_EDGES = 200_000
"""Edges up to which ``auto`` makes machines, where rules are possible, too: files of some 50 MB."""

MOST_ENTRIES = 1 << 20
"""States of hardware and facts with which a section may be entered, each with an entry of its own."""

WHY = "a machine lists every state"


def refuse_entries(hardware: Sequence[str], flags: Sequence[str] = (), section: str | None = None) -> None:
    """Raises an error where a machine would have too many entries, one for each state of hardware and facts.

    Raises:
        LimitError: There are more than :data:`MOST_ENTRIES`.
    """
    bits = len(hardware) + len(flags)
    if 1 << bits > MOST_ENTRIES:
        where = "" if section is None else f"section {section}: "
        facts = f" and {len(flags)} flags of facts and of late detection" if flags else ""
        raise LimitError(
            f"{where}{len(hardware)} hardware resources that may fail{facts} have 2^{bits} states, "
            f"the limit on the entries of a machine is {MOST_ENTRIES:,}"
        )


def each_step(rows: bytes) -> Iterator[array[int]]:
    """The big steps of an event, each as what it does to levels (:class:`mcpn._kernel.BigSteps`)."""
    words, at = array("I"), 0
    words.frombytes(rows)
    while at < len(words):
        end = at + 1 + words[at]
        yield words[at + 1 : end]
        at = end


def count_steps(rows: bytes) -> int:
    """How many big steps an event has."""
    return sum(1 for _ in each_step(rows))


def representatives(composite: CompositeSpace) -> dict[SectionType, str]:
    """The types of sections, each with the name of the section that stands for it."""
    names: dict[SectionType, str] = {}
    for placed in composite.sections.values():
        names.setdefault(placed.type, placed.name)
    return names


def too_large(names: Mapping[SectionType, str], limit: int) -> LimitError | None:
    """Why some types of sections are too large for machines, before the first is listed."""
    try:
        for type_, name in names.items():
            type_.refuse_list(name, limit, WHY)
            refuse_entries(type_.part.faulty, type_.part.entry_flags, name)
    except LimitError as error:
        return error
    return None


def table_edges(type_: SectionType) -> int:
    """How many edges the machine of a type has by its own events, counted before one is listed."""
    own, _ = type_.firings(type_.inside, ())
    return sum(own.values()) * type_.size // type_.graph.everything.count()


def has_rules(names: Iterable[SectionType]) -> bool:
    """Whether the modular form can tell all types of sections."""
    return all(type_.steps is not None for type_ in names)


def rather_rules(names: Mapping[SectionType, str], max_states: int | None) -> LimitError | None:
    """Why a mission gets rules where no form is named; ``None`` where it gets tables.

    Args:
        names: The types of sections, each with the name of the section that stands for it.
        max_states: How many states a machine may have.

    Raises:
        LimitError: Tables are too large, and some section has no rules.
    """
    if not has_rules(names):
        if error := too_large(names, MAX_TABLE_STATES if max_states is None else max_states):
            raise error
        return None
    if error := too_large(names, MOST_TABLED if max_states is None else max_states):
        return error
    if max_states is None and (edges := sum(map(table_edges, names))) > MOST_TABLED_EDGES:
        return LimitError(f"{WHY}: {edges:,} edges, the limit of --form auto is {MOST_TABLED_EDGES:,}")
    return None


def rules_instead(names: Mapping[SectionType, str]) -> str:
    """What the modular form takes instead, where there is one and its size is known."""
    if not has_rules(names):
        return ""
    rows = [row for type_ in names for row in (type_.steps or {}).values() if row is not None]
    most = "" if any(map(is_function, rows)) else f"at most {sum(map(count_steps, rows)):,} "
    return f"; --form modular has {most}rules instead, mostly a small part of it"


def foreseen(composite: CompositeSpace, max_states: int | None = None) -> str:
    """Which form of controller a mission gets by itself, and how large it is, in words.

    Nothing is listed: machines have at most the states that are counted, since those before a section and
    after it become entries and exits, and rules are at most the big steps, of which some do the same.

    Args:
        composite: The mission's composite.
        max_states: How many states a machine may have.
    """
    names = representatives(composite)
    try:
        error = rather_rules(names, max_states)
    except LimitError as found:
        return f"none: {found}"
    if error is None:
        return f"hierarchical, at most {sum(type_.size for type_ in names):,} states"
    rows = [row for type_ in names for row in (type_.steps or {}).values() if row is not None]
    if many := sum(map(is_function, rows)):
        each = f"for each of {many:,} events" if many > 1 else "for one event"
        return f"modular, more than {FEW_STEPS:,} rules {each} before any is split; {error}"
    return f"modular, at most {sum(map(count_steps, rows)):,} rules before any is split; {error}"
