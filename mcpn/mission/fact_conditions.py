"""Conditions on facts: ``door=open !holding done(survey)``, all of which must be so.

A word is the name of a fact with a value, or, of a fact that is false or true, its name alone, for true, or
with ``!`` before it, for false. ``done(OBJECTIVE)`` is the name of a fact that nobody declares: whether an
elementary objective, any copy of it, has succeeded before.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from typing import Any, NamedTuple, TypeAlias

from mcpn.mission.model import Mission, walk
from mcpn.mission.robot import BOOLEAN_VALUES, Described, Fact

Condition: TypeAlias = tuple[tuple[str, str], ...]
"""Facts, each with the value that it must have: all of them at once."""

_WORD = re.compile(r"(!?)(done\([^()\s]*\)|[^=!()\s]+)(?:=(\S*))?")
_DONE = re.compile(r"done\(\s*([A-Za-z_][A-Za-z0-9_.]*)\s*\)")


FACTS = "(facts)"
"""Stands for a change of facts where causes are named by hardware: why an alternative ends or is possible."""


class Word(NamedTuple):
    """One word of a condition.

    Args:
        fact: The fact's name.
        value: The value that it must have; ``None`` where the word names none.
        negated: Whether it begins with ``!``.
    """

    fact: str
    value: str | None
    negated: bool


def word(text: str) -> Word:
    """A word of a condition, taken apart.

    Examples:
        >>> word("door=open"), word("!holding")
        (Word(fact='door', value='open', negated=False), Word(fact='holding', value=None, negated=True))
    """
    found = _WORD.fullmatch(text)
    assert found is not None, "the datatype of conditions holds nothing else"
    return Word(found[2], found[3], bool(found[1]))


def resolved(texts: Iterable[str], facts: Mapping[str, Fact]) -> Condition:
    """A valid condition as facts and values.

    Examples:
        >>> facts = {"door": Fact(name="door", values=("closed", "open")), "holding": Fact(name="holding")}
        >>> resolved(["door=open", "!holding"], facts)
        (('door', 'open'), ('holding', 'false'))
    """
    found = dict[str, str]()
    for text in texts:
        said = word(text)
        found[said.fact] = said.value or facts[said.fact].values[not said.negated]
    return tuple(found.items())


def in_words(condition: Condition, facts: Mapping[str, Fact]) -> tuple[str, ...]:
    """The words of a condition, as :func:`resolved` reads them.

    Examples:
        >>> facts = {"door": Fact(name="door", values=("closed", "open")), "holding": Fact(name="holding")}
        >>> in_words((("door", "open"), ("holding", "false")), facts)
        ('door=open', '!holding')
    """
    short = {"true": "{}", "false": "!{}"}
    return tuple(
        short[value].format(fact) if is_boolean(facts[fact]) else f"{fact}={value}"
        for fact, value in condition
    )


def objective_done(name: str) -> str | None:
    """The objective of which a fact says whether it has succeeded before; ``None`` for other facts.

    Examples:
        >>> objective_done("done(dive)"), objective_done("holding")
        ('dive', None)
    """
    found = _DONE.fullmatch(name)
    return found[1] if found else None


def conditions(mission: Mission) -> Iterator[str]:
    """Every word of every condition that a mission reads, in its routes and of its robot."""
    for activity in mission.activities:
        yield from activity.requires
        for alternative in activity.alternatives:
            yield from alternative.requires
    for blocks in (mission.blocks, *(protocol.blocks for protocol in mission.protocols)):
        for block in walk(blocks):
            for handler in block.handlers:
                yield from handler.when
                for route in handler.routes:
                    yield from route.when
            for guard in block.guards:
                yield from guard.when
            for route in block.routes:
                yield from route.when


def facts_of(mission: Mission) -> dict[str, Fact]:
    """The facts of a mission by name: those that it declares, then each ``done(x)`` that it reads.

    Examples:
        >>> from mcpn.mission.model import Mission, Robot
        >>> robot = Robot(name="r", facts=(Fact(name="holding"),))
        >>> facts_of(Mission(name="m", robots=(robot,), blocks=()))["holding"].values
        ('false', 'true')
    """
    found = {fact.name: fact for fact in mission.every_fact}
    for name in dict.fromkeys(word(text).fact for text in conditions(mission)):
        if name not in found and objective_done(name) is not None:
            found[name] = Fact(name=name)
    for text in required(mission):
        for objective in _DONE.findall(text):
            found.setdefault(f"done({objective})", Fact(name=f"done({objective})"))
    return found


def required(mission: Mission) -> Iterator[str]:
    """The texts of all requirements of a mission, formulas among them."""
    stack: list[Any] = [*mission.all_requirements]
    while stack:
        said = stack.pop()
        if isinstance(said, str):
            yield said
        elif isinstance(said, tuple):
            stack.extend(said)
        elif isinstance(said, Described):
            stack.extend(getattr(said, field.name) for field in fields(said) if field.name != "source")


def flags(fact: Fact) -> dict[str, frozenset[str]]:
    """By value of a fact, the flags that are true while it has this value; at the start none is.

    Every value but that at the start has a flag (``door=open``). Where there are several of these values, a
    further flag (``door!=closed``) says that the fact is not what it was at the start.
    """
    others = [value for value in fact.values if value != fact.start]
    changed = [f"{fact.name}!={fact.start}"] if len(others) > 1 else []
    return {v: frozenset([*changed, f"{fact.name}={v}"] if v in others else []) for v in fact.values}


def cause(hardware: str) -> str:
    """The cause that a member of a condition is: the hardware itself, :data:`FACTS` for ``door=open``.

    Examples:
        >>> cause("camera"), cause("door=open")
        ('camera', '(facts)')
    """
    return FACTS if "=" in hardware else hardware


def all_flags(fact: Fact) -> tuple[str, ...]:
    """All that :func:`flags` may say of a fact, in one order.

    Examples:
        >>> all_flags(Fact(name="door", values=("closed", "ajar", "open")))
        ('door!=closed', 'door=ajar', 'door=open')
        >>> all_flags(Fact(name="holding"))
        ('holding=true',)
    """
    others = [value for value in fact.values if value != fact.start]
    changed = [f"{fact.name}!={fact.start}"] if len(others) > 1 else []
    return (*changed, *(f"{fact.name}={value}" for value in others))


def noticed(hardware: str) -> str:
    """What may be true of hardware that is detected late: it is out of service, and the robot knows it.

    Controllers carry it from section to section beside the flags of facts, whose names have no space.
    """
    return f"{hardware} known"


def is_boolean(fact: Fact) -> bool:
    """Whether a fact is false or true, so that its name alone says that it is true.

    Examples:
        >>> is_boolean(Fact(name="holding")), is_boolean(Fact(name="door", values=("closed", "open")))
        (True, False)
    """
    return fact.values == BOOLEAN_VALUES
