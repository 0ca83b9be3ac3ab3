"""What a mission must satisfy: requirements, as formulas or as patterns.

The patterns are those of Dwyer, Avrunin, Corbett (*Patterns in property specifications for finite-state
verification*, ICSE 1999) and of Menghi, Tsigkanos, Pelliccione, Ghezzi, Berger (*Specification patterns for
robotic missions*, IEEE TSE 2019). What each means is said in :mod:`mcpn.answers.patterns`.
"""

from collections.abc import Iterator
from typing import Annotated, TypeAlias, get_args, get_type_hints

from mcpn.mission.language.datatypes import (
    ENTRIES,
    FORMULA,
    LOCATIONS,
    ORDER,
    REACTION,
    SEVERITY,
    TRUTH,
    Called,
)
from mcpn.mission.robot import Described, Element
from mcpn.records import record

Avoided = Annotated[tuple[str, ...], Called("of"), LOCATIONS, "Objectives, each of them."]
Locations = Annotated[tuple[str, ...], Called("in"), LOCATIONS, "Objectives, in this order where it counts."]


@record(frozen=True, slots=True, kw_only=True)
class _Pattern(Described):
    """What a requirement says."""

    @property
    def misuse(self) -> str:
        """What is wrong with its attributes, taken together; nothing where all is well."""
        return ""


@record(frozen=True, slots=True, kw_only=True)
class _Scoped(_Pattern):
    """A pattern of Dwyer, Avrunin and Corbett, in one of their five scopes."""

    after: Annotated[str | None, FORMULA, "A formula: from the first moment on at which it holds."] = None
    before: Annotated[
        str | None,
        FORMULA,
        "A formula: up to the first moment at which it holds, if there is one; with after: from each moment "
        "of the one to the next moment of the other, if there is one.",
    ] = None
    until: Annotated[
        str | None,
        FORMULA,
        "A formula, with after: as between, and for ever where this one never holds.",
    ] = None

    @property
    def misuse(self) -> str:
        """What is wrong with its attributes, taken together; nothing where all is well."""
        return _wrong_scope(self)


@record(frozen=True, slots=True, kw_only=True)
class Absence(_Scoped):
    """It never holds."""

    TAG = "absence"
    of: Annotated[str, FORMULA, "The formula that never holds."]


@record(frozen=True, slots=True, kw_only=True)
class Universality(_Scoped):
    """It always holds."""

    TAG = "universality"
    of: Annotated[str, FORMULA, "The formula that always holds."]


@record(frozen=True, slots=True, kw_only=True)
class Existence(_Scoped):
    """It holds at some moment."""

    TAG = "existence"
    of: Annotated[str, FORMULA, "The formula that holds at some moment."]


@record(frozen=True, slots=True, kw_only=True)
class BoundedExistence(_Scoped):
    """It becomes true at most so many times."""

    TAG = "bounded_existence"
    of: Annotated[str, FORMULA, "The formula whose stretches are counted."]
    most: Annotated[int, ENTRIES, "How many times at most it becomes true."] = 2


@record(frozen=True, slots=True, kw_only=True)
class Precedence(_Scoped):
    """It holds only after something else has held, or together with it."""

    TAG = "precedence"
    of: Annotated[str, FORMULA, "The formula that needs the other first."]
    followed_by: Annotated[
        str | None, FORMULA, "A formula: only of, and later this one, together need the other first."
    ] = None
    by: Annotated[str, FORMULA, "The formula that holds first."]
    then: Annotated[str | None, FORMULA, "A formula: by, and later this one, hold first."] = None

    @property
    def misuse(self) -> str:
        """What is wrong with its attributes, taken together; nothing where all is well."""
        if self.followed_by is not None and self.then is not None:
            return "both followed_by and then, expected a chain on one side"
        return _wrong_scope(self)


@record(frozen=True, slots=True, kw_only=True)
class Response(_Scoped):
    """Whenever one thing holds, another holds then or later."""

    TAG = "response"
    to: Annotated[str, FORMULA, "The formula that calls for the response."]
    followed_by: Annotated[
        str | None, FORMULA, "A formula: to, and later this one, together call for it."
    ] = None
    gives: Annotated[str, FORMULA, "The formula that responds."]
    then: Annotated[str | None, FORMULA, "A formula: gives, and later this one, respond."] = None
    without: Annotated[
        str | None, FORMULA, "A formula, with then: it does not hold from gives up to then."
    ] = None

    @property
    def misuse(self) -> str:
        """What is wrong with its attributes, taken together; nothing where all is well."""
        if self.followed_by is not None and self.then is not None:
            return "both followed_by and then, expected a chain on one side"
        if self.without is not None and self.then is None:
            return "without and no then, expected both"
        return _wrong_scope(self)


@record(frozen=True, slots=True, kw_only=True)
class Visit(_Pattern):
    """The robot visits some objectives."""

    TAG = "visit"
    objectives: Locations
    order: Annotated[
        str,
        ORDER,
        "any; sequenced: each after the one before it; ordered: none before the one before it, too; "
        "strict: and none is entered twice before the next one; fair: none is entered again before the next "
        "one in the ring.",
    ] = "any"

    @property
    def misuse(self) -> str:
        """What is wrong with its attributes, taken together; nothing where all is well."""
        return _too_few(self.objectives, self.order)


@record(frozen=True, slots=True, kw_only=True)
class Patrolling(_Pattern):
    """The robot visits some objectives again and again."""

    TAG = "patrolling"
    objectives: Locations
    order: Annotated[str, ORDER, "As of a visit, in a ring: the first follows the last."] = "any"

    @property
    def misuse(self) -> str:
        """What is wrong with its attributes, taken together; nothing where all is well."""
        return _too_few(self.objectives, self.order)


@record(frozen=True, slots=True, kw_only=True)
class Avoidance(_Pattern):
    """The robot keeps away from some objectives."""

    TAG = "avoidance"
    objectives: Avoided
    until: Annotated[str | None, FORMULA, "A formula, which becomes true: up to then."] = None
    after: Annotated[str | None, FORMULA, "A formula: from when it holds."] = None

    @property
    def misuse(self) -> str:
        """What is wrong with its attributes, taken together; nothing where all is well."""
        both = self.until is not None and self.after is not None
        return "both until and after, expected one of them" if both else _too_few(self.objectives)


@record(frozen=True, slots=True, kw_only=True)
class RestrictedAvoidance(_Pattern):
    """The robot enters each of some objectives so many times."""

    TAG = "restricted_avoidance"
    objectives: Avoided
    at_most: Annotated[int | None, ENTRIES, "How many times at most."] = None
    at_least: Annotated[int | None, ENTRIES, "How many times at least."] = None
    exactly: Annotated[int | None, ENTRIES, "How many times."] = None

    @property
    def misuse(self) -> str:
        """What is wrong with its attributes, taken together; nothing where all is well."""
        given = [n for n in (self.at_most, self.at_least, self.exactly) if n is not None]
        if len(given) != 1:
            return f"{len(given)} of at_most, at_least and exactly, expected one of them"
        return _too_few(self.objectives)


@record(frozen=True, slots=True, kw_only=True)
class Reaction(_Pattern):
    """Whenever one thing holds, the robot reacts."""

    TAG = "reaction"
    to: Annotated[str, FORMULA, "The formula that calls for the reaction."]
    gives: Annotated[str, FORMULA, "The formula that is the reaction."]
    when: Annotated[
        str,
        REACTION,
        "instantaneous: at that moment; prompt: after the next event; delayed: then or later; bound: at that "
        "moment, and only then; bound_delay: after the next event, and only then.",
    ]


@record(frozen=True, slots=True, kw_only=True)
class Wait(_Pattern):
    """The robot stays in some objectives up to the moment at which something becomes true."""

    TAG = "wait"
    objectives: Locations
    until: Annotated[str, FORMULA, "The formula that ends the wait, and becomes true."]

    @property
    def misuse(self) -> str:
        """What is wrong with its attributes, taken together; nothing where all is well."""
        return _too_few(self.objectives)


def _wrong_scope(pattern: _Scoped) -> str:
    if pattern.until is not None and pattern.before is not None:
        return "both before and until, expected one of them"
    if pattern.until is not None and pattern.after is None:
        return "until without after, expected before, or after and until"
    return ""


def _too_few(objectives: tuple[str, ...], order: str = "any") -> str:
    if not objectives:
        return "no objective, expected one or more"
    if order != "any" and len(objectives) < 2:
        return f"order {order} and one objective, expected two or more"
    return ""


Scoped: TypeAlias = Absence | Universality | Existence | BoundedExistence | Precedence | Response
"""The patterns of Dwyer, Avrunin and Corbett: eleven, with the chains, in five scopes."""
Pattern: TypeAlias = Scoped | Visit | Patrolling | Avoidance | RestrictedAvoidance | Reaction | Wait
"""Elements that say what a mission must satisfy: those, and the 22 of Menghi and others."""


def formulas_of(pattern: Pattern) -> Iterator[tuple[str, str]]:
    """The attributes of a pattern that are formulas and are given, each with its text."""
    for attribute, type_ in get_type_hints(type(pattern), include_extras=True).items():
        if FORMULA in get_args(type_) and (text := getattr(pattern, attribute)) is not None:
            yield attribute, text


@record(frozen=True, slots=True, kw_only=True)
class Requirement(Element):
    """What a mission must satisfy, as a formula or as one pattern inside; ``check`` answers it.

    In a protocol it is asked of each use, and names are first looked for in that use.
    """

    TAG = "requirement"
    formula: Annotated[str | None, FORMULA, "In CTL or LTL: G (happens(leak) -> X objective(surface))."] = (
        None
    )
    expected: Annotated[str, TRUTH, "fails: it must not hold."] = "holds"
    severity: Annotated[str, SEVERITY, "advice: it is reported and does not fail the check."] = "required"
    fair: Annotated[bool, "true: asked only of runs on which no objective runs for ever."] = False
    patterns: tuple[Pattern, ...] = ()

    @property
    def misuse(self) -> str:
        """What is wrong with it as a whole; nothing where all is well."""
        if self.formula is not None and self.patterns:
            return f"both a formula and <{self.patterns[0].TAG}>, expected one of them"
        if self.formula is None and len(self.patterns) != 1:
            found = f"{len(self.patterns)} patterns" if self.patterns else "neither a formula nor a pattern"
            return f"{found}, expected a formula or one pattern"
        return ""
