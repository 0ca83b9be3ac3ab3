"""Conditions on facts: ``door=open !holding done(survey)``, all of which must be so.

A word is the name of a fact with a value, or, of a fact that is false or true, its name alone, for true, or
with ``!`` before it, for false. ``done(OBJECTIVE)`` is the name of a fact that nobody declares: whether an
elementary objective, any copy of it, has succeeded before.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from functools import cached_property
from typing import Any, NamedTuple

from mcpn.mission.expansion.routes import Condition
from mcpn.mission.graph import ElementarySection, ObjectivesGraph, Section
from mcpn.mission.model import Mission, walk
from mcpn.mission.robot import BOOLEAN_VALUES, Described, Fact

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
    found = {fact.name: fact for fact in mission.facts}
    for name in dict.fromkeys(word(text).fact for text in conditions(mission)):
        if name not in found and objective_done(name) is not None:
            found[name] = Fact(name=name)
    for text in required(mission):
        for objective in _DONE.findall(text):
            found.setdefault(f"done({objective})", Fact(name=f"done({objective})"))
    return found


def required(mission: Mission) -> Iterator[str]:
    """The texts of all requirements of a mission, formulas among them."""
    stack: list[Any] = [*mission.requirements, *(p.requirements for p in mission.protocols)]
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


def is_boolean(fact: Fact) -> bool:
    """Whether a fact is false or true, so that its name alone says that it is true.

    Examples:
        >>> is_boolean(Fact(name="holding")), is_boolean(Fact(name="door", values=("closed", "open")))
        (True, False)
    """
    return fact.values == BOOLEAN_VALUES


# --- Who changes and who reads which fact: static knowledge of a mission's facts --------------------------


class FactUsage:
    """Who changes and who reads which fact.

    Args:
        mission: A valid mission.

    Attributes:
        facts: Its facts by name, those of objectives that something reads among them.
        changing: By declared event that changes facts, for each of them by value the one that it has then.
    """

    def __init__(self, mission: Mission) -> None:
        self.mission = mission
        self.facts: Mapping[str, Fact] = facts_of(mission)
        self.changing: Mapping[str, Mapping[str, Mapping[str, str]]] = {
            event.name: {
                change.fact: dict.fromkeys(self.facts[change.fact].values, change.to) for change in event.sets
            }
            for event in mission.events
            if event.changes_facts
        }

    @cached_property
    def turning(self) -> Mapping[str, tuple[frozenset[str], frozenset[str]]]:
        """By declared event that changes facts, the flags (:func:`flags`) that it makes true, and false."""
        found = {}
        for event, changes in self.changing.items():
            every = frozenset(flag for fact in changes for flag in all_flags(self.facts[fact]))
            values = ((self.facts[fact], value) for fact, to in changes.items() for value in {*to.values()})
            true = frozenset(flag for fact, value in values for flag in flags(fact)[value])
            found[event] = true, every - true
        return found

    @cached_property
    def watched(self) -> frozenset[tuple[str, str]]:
        """Values of facts that blocks may be left for, when facts become so."""
        texts = (self.mission.blocks, *(protocol.blocks for protocol in self.mission.protocols))
        every = (handler.when for blocks in texts for block in walk(blocks) for handler in block.handlers)
        return frozenset(said for when in every for said in resolved(when, self.facts))

    @cached_property
    def _requires(self) -> Mapping[tuple[str, int], Condition]:
        return {
            (activity.name, i): resolved((*activity.requires, *way.requires), self.facts)
            for activity in self.mission.activities
            for i, way in enumerate(activity.alternatives)
            if activity.requires or way.requires
        }

    def requires(self, activity: str, alternative: int) -> Condition:
        """What facts must be for an alternative to be possible, its activity's own condition included."""
        return self._requires.get((activity, alternative), ())

    def read_by(self, activity: str) -> Iterator[str]:
        """Facts that some alternative of an activity requires to be so."""
        if self._requires:
            alternatives = next(a.alternatives for a in self.mission.activities if a.name == activity)
            for i in range(len(alternatives)):
                yield from (fact for fact, _ in self.requires(activity, i))

    @cached_property
    def requiring(self) -> frozenset[str]:
        """Activities with an alternative that requires facts to be so."""
        return frozenset(activity for activity, _ in self._requires)

    def closed(self, names: Iterable[str]) -> tuple[Fact, ...]:
        """Some facts, and all facts that events change together with them, in the order of the search."""
        found, stack = dict[str, None](), [*names][::-1]
        while stack:
            name = stack.pop()
            if name not in found:
                found[name] = None
                together = (facts for facts in self.changing.values() if name in facts)
                stack.extend(other for facts in together for other in facts)
        return tuple(self.facts[name] for name in found)


def touched_by(graph: ObjectivesGraph) -> Iterator[str]:
    """Facts that the sections of a graph change or read by themselves, at any depth, in their order."""
    for section in graph.all_sections():
        yield from _of_section(section)


def _of_section(section: Section) -> Iterator[str]:
    if isinstance(section, ElementarySection):
        yield from (setting.fact for setting in section.sets)
    for case in section.all_cases:
        yield from (fact for fact, _ in case.when)
