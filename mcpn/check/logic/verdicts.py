"""Answers to files and examinations of the Model Checking Contest, as they come, with how they were had.

Formulas are simplified, by invariants and by the initial marking; what asks for one reachable marking goes to
a search, once where several formulas ask for the same. What is left is asked of the space, built once.
The formulas of a file share it: cheap ones first, each with a time slice that grows round by round, so that
one hard formula does not cost the easy ones.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from mcpn._kernel import Store
from mcpn.check.logic.contest import Property
from mcpn.check.logic.formulas import Const, Core, walk
from mcpn.check.logic.questions import Questions
from mcpn.check.logic.reachability import as_goal, as_reachability
from mcpn.check.logic.simplify import at_first, parts_at_first, replaced, simplified
from mcpn.check.nets.behaviour import examine
from mcpn.errors import InputError
from mcpn.space.algebra import Space
from mcpn.space.diagrams.spaces import DiagramAlternatives, DiagramMarkings
from mcpn.space.search.equation import place_bounds
from mcpn.space.search.goal import DEADLOCK, Goal, holds
from mcpn.space.search.portfolio import EXPLICIT, INITIAL_STATE, RANDOM_WALK, Portfolio
from mcpn.space.search.searches import Searches

DIAGRAMS, REWRITING = "DECISION_DIAGRAMS", "QUERY_REDUCTION"
FIRST_SLICE, GROWTH = 1.5, 4.0
WALK_STEPS = 50_000


@dataclass(frozen=True)
class Verdict:
    """An answer to a question of the contest.

    Args:
        name: The question's.
        value: ``TRUE``, ``FALSE`` or a number.
        techniques: How it was had, in the contest's words.
    """

    name: str
    value: str
    techniques: tuple[str, ...]

    def __str__(self) -> str:
        return f"FORMULA {self.name} {self.value} TECHNIQUES {' '.join(self.techniques)}"


class _SliceSpent(Exception):
    """A formula has had its time slice."""


Meaning: TypeAlias = Core | dict[int, int]
"""A formula, or places with their weights, where the most tokens that they hold together is asked."""


def answer_file(questions: Questions, properties: Sequence[Property]) -> Iterator[Verdict]:
    """Answers the properties of a file.

    Args:
        questions: About the net.
        properties: What is asked.

    Returns:
        The answers in the order in which they are found. Taking them raises UnboundedError, UnsafeError (of
        nets with priorities) or LimitError where what is left needs the space.

    Raises:
        InputError: A name is unknown; every name is looked up before anything is answered.
    """
    return _answers(questions, properties, {asked.name: look_up(questions, asked) for asked in properties})


def look_up(questions: Questions, asked: Property) -> Meaning:
    """What a property asks, names looked up.

    Raises:
        InputError: A name is unknown.
    """
    if asked.formula is not None:
        try:
            return questions.core(asked.formula)
        except InputError as error:
            raise InputError.at(asked.source, f"{asked.name}: {error}") from error
    weights: dict[int, int] = {}
    for name in asked.bound:
        if name not in questions.net.place_index:
            raise InputError.at(asked.source, f"no place is named {name}")
        place = questions.net.place_index[name]
        weights[place] = weights.get(place, 0) + 1
    return weights


def _answers(
    questions: Questions, properties: Sequence[Property], meant: dict[str, Meaning]
) -> Iterator[Verdict]:
    waiting = {asked.name: meant[asked.name] for asked in properties}
    for verdict in _without_space(questions, waiting):
        del waiting[verdict.name]
        yield verdict
    if not waiting:
        return
    space = questions.space
    if isinstance(space, DiagramMarkings | DiagramAlternatives):
        yield from _by_slices(questions, space.encoding.store, waiting)
        return
    technique = EXPLICIT if questions.choice.engine == "explicit" else DIAGRAMS
    for name, meaning in waiting.items():
        yield Verdict(name, _value(questions, meaning), (technique,))


def _without_space(questions: Questions, waiting: dict[str, Meaning]) -> Iterator[Verdict]:
    """What needs no space; what is left of the other formulas takes their place in ``waiting``."""
    if not questions.searchable:
        return
    net = questions.net
    marking, bounds = net.initial, place_bounds(net)

    def at_start(atom: Core) -> bool:
        goal = as_goal(atom, net)
        return goal is not None and holds(goal, net, marking)

    asked: dict[Core, Goal] = {}
    for name, meaning in list(waiting.items()):
        if isinstance(meaning, dict):
            continue
        smaller = simplified(meaning, net, bounds)
        rest = at_first(smaller, at_start)
        waiting[name] = rest
        if isinstance(rest, Const):
            yield Verdict(name, _told(rest), (REWRITING if isinstance(smaller, Const) else INITIAL_STATE,))
            continue
        for part in parts_at_first(rest):
            if (goal := as_reachability(part, net)) is not None:
                asked[part] = goal
    parts = list(asked)
    known: dict[Core, Core] = {}
    techniques: dict[str, dict[str, None]] = {}
    for index, found in Portfolio(net).decide(list(asked.values())):
        known[parts[index]] = Const(found.reachable)
        for name, meaning in list(waiting.items()):
            if isinstance(meaning, dict) or parts[index] not in parts_at_first(meaning):
                continue
            techniques.setdefault(name, {}).update(dict.fromkeys(found.techniques))
            waiting[name] = rest = replaced(meaning, lambda part: known.get(part, part))
            if isinstance(rest, Const):
                yield Verdict(name, _told(rest), tuple(techniques[name]))


def _told(value: Const) -> str:
    return str(value.value).upper()


def _by_slices(questions: Questions, store: Store, meant: dict[str, Meaning]) -> Iterator[Verdict]:
    before, until = store.progress, 0.0

    def watch(nodes: int) -> None:
        if before is not None:
            before(nodes)
        if time.monotonic() > until:
            raise _SliceSpent

    left, limit = sorted(meant, key=lambda name: _effort(meant[name])), FIRST_SLICE
    try:
        store.progress = watch
        while left:
            later = []
            for name in left:
                until = time.monotonic() + limit
                try:
                    value = _value(questions, meant[name])
                except _SliceSpent:
                    later.append(name)
                    continue
                yield Verdict(name, value, (DIAGRAMS,))
            left, limit = later, limit * GROWTH
    finally:
        store.progress = before


def _effort(meaning: Meaning) -> int:
    return 0 if isinstance(meaning, dict) else sum(1 for _ in walk(meaning))


def _value(questions: Questions, meaning: Meaning) -> str:
    if isinstance(meaning, dict):
        return str(largest(questions.space, meaning))
    return str(questions.evaluation.holds(meaning)).upper()


def largest(space: Space[Any], weights: dict[int, int]) -> int:
    """The largest weighted sum of tokens in a state of a space; weights are not negative."""
    if isinstance(space, DiagramMarkings):  # in one pass over the diagram
        levels, always = space.encoding.weigh(weights)
        return space.everything.largest(levels) + always
    low, high = 0, sum(weights.values())
    while space.everything - space.at_most(weights, high):
        low, high = high + 1, 2 * high + 1
    while low < high:
        middle = (low + high) // 2
        if space.everything - space.at_most(weights, middle):
            low = middle + 1
        else:
            high = middle
    return low


def answer_examination(questions: Questions, examination: str) -> Verdict:
    """Answers an examination of the contest (see :func:`mcpn.check.nets.behaviour.examine`).

    Raises:
        UnsafeError: It needs the space, and the net has priorities and is not 1-safe.
        UnboundedError: It needs the space, and the net is unbounded.
        LimitError: It needs the space, and a limit was hit.
    """
    net = questions.net
    name = f"{net.name}-{examination}"
    if examination == "OneSafe":
        if max(net.initial, default=0) > 1:
            return Verdict(name, "FALSE", (INITIAL_STATE,))
        searches = Searches(net)
        if questions.engine == "auto" and searches.fits and searches.walk_unsafe(steps=WALK_STEPS):
            return Verdict(name, "FALSE", (RANDOM_WALK,))
        safe = questions.one_safe()
        technique = EXPLICIT if safe is not None and safe.engine == "explicit" else DIAGRAMS
        return Verdict(name, str(safe is not None).upper(), (technique,))
    if examination == "ReachabilityDeadlock" and questions.searchable:
        for _, found in Portfolio(net).decide([DEADLOCK]):
            return Verdict(name, str(found.reachable).upper(), found.techniques)
    technique = EXPLICIT if questions.choice.engine == "explicit" else DIAGRAMS
    return Verdict(name, str(examine(examination, questions.space)).upper(), (technique,))
