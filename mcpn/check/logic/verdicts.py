"""Answers to files and examinations of the Model Checking Contest, as they come, with how they were had.

Formulas are simplified, by invariants and by the initial marking; what asks for one reachable marking goes to
a search, once where several formulas ask for the same; others are asked of few markings, as they are needed
(:mod:`mcpn.check.logic.local`). What is left is asked of the space, built once. The formulas of a file share
it: cheap ones first, each with a time slice that grows round by round, so that one hard formula does not cost
the easy ones.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain, count, repeat
from typing import Any, TypeAlias

from mcpn._kernel import Store
from mcpn.check.logic.contest import Property
from mcpn.check.logic.formulas import Const, Formula, walk
from mcpn.check.logic.local import LocalCheck, as_goal, as_reachability
from mcpn.check.logic.questions import Questions
from mcpn.check.logic.simplify import at_first, parts_at_first, replaced, simplified
from mcpn.check.nets.behaviour import examine
from mcpn.errors import McpnError
from mcpn.net.petri import PetriNet
from mcpn.space.algebra import Space
from mcpn.space.diagrams.spaces import DiagramAlternatives, DiagramMarkings
from mcpn.space.search.equation import place_bounds
from mcpn.space.search.goal import DEADLOCK, holds
from mcpn.space.search.portfolio import EXPLICIT, INITIAL_STATE, RANDOM_WALK, Portfolio
from mcpn.space.search.searches import Searches

DIAGRAMS, REWRITING = "DECISION_DIAGRAMS", "QUERY_REDUCTION"
FIRST_SLICE, GROWTH = 1.5, 4.0
WALK_STEPS = 50_000
LOCAL_STEPS = (20_000, 200_000, 1_000_000, 5_000_000, 25_000_000, 125_000_000)
"""For each part of a formula: two rounds before the space is built, the others between rounds of slices."""


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


Meaning: TypeAlias = Formula | tuple[int, ...]
"""A formula, or places, where the most tokens that they hold together is asked."""


def answer_file(questions: Questions, properties: Sequence[Property]) -> Iterator[Verdict]:
    """Answers the properties of a file.

    Args:
        questions: About the net.
        properties: What is asked.

    Yields:
        The answers in the order in which they are found.

    Raises:
        UnboundedError: What is left needs the space, and the net is unbounded.
        UnsafeError: The same, and the net has priorities and is not 1-safe.
        LimitError: The same, and a limit was hit.
    """
    waiting = _Waiting({asked.name: asked.meaning for asked in properties})
    local = None
    if questions.searchable:
        yield from _simplified(questions.net, waiting)
        if Searches(questions.net).fits:
            local = _Local(questions.net, waiting)
            yield from local.round(LOCAL_STEPS[0], searched=False)
        yield from _reached(questions, waiting)
        if local is not None:
            yield from local.round(LOCAL_STEPS[1], searched=False)
    if not waiting.formulas:
        return
    try:
        space = questions.space
    except McpnError:
        if local is not None:
            for steps in LOCAL_STEPS[2:]:
                yield from local.round(steps)
        if waiting.formulas:
            raise
        return
    if isinstance(space, DiagramMarkings | DiagramAlternatives):
        yield from _by_slices(questions, space.encoding.store, waiting, local)
        return
    technique = EXPLICIT if questions.choice.engine == "explicit" else DIAGRAMS
    for name, meaning in waiting.formulas.items():
        yield waiting.verdict(name, _value(questions, meaning), technique)


@dataclass
class _Waiting:
    """What is still to be answered.

    Args:
        formulas: By name; of a formula, what is left to ask in the initial marking.
    """

    formulas: dict[str, Meaning]
    techniques: dict[str, dict[str, None]] = field(default_factory=dict)

    def verdict(self, name: str, value: str, *techniques: str) -> Verdict:
        """The answer, with the ways by which parts were decided before."""
        return Verdict(name, value, tuple({**self.techniques.get(name, {}), **dict.fromkeys(techniques)}))

    def parts(self) -> list[Formula]:
        """The parts whose values in the initial marking are asked for, each once, cheap ones first."""
        formulas = [meaning for meaning in self.formulas.values() if not isinstance(meaning, tuple)]
        return sorted({part: None for f in formulas for part in parts_at_first(f)}, key=_effort)

    def learn(self, part: Formula, value: bool, techniques: Iterable[str]) -> Iterator[Verdict]:
        """Puts the value of a part where it is asked for, and yields what that answers."""
        for name, meaning in list(self.formulas.items()):
            if isinstance(meaning, tuple) or part not in parts_at_first(meaning):
                continue
            self.techniques.setdefault(name, {}).update(dict.fromkeys(techniques))
            rest = replaced(meaning, lambda at: Const(value) if at == part else at)
            self.formulas[name] = rest
            if isinstance(rest, Const):
                del self.formulas[name]
                yield self.verdict(name, _told(rest))


def _simplified(net: PetriNet, waiting: _Waiting) -> Iterator[Verdict]:
    """Answers what rewriting and the initial marking decide; of other formulas keeps what is left to ask."""
    marking, bounds = net.initial, place_bounds(net)

    def at_start(atom: Formula) -> bool:
        goal = as_goal(atom, net)
        return goal is not None and holds(goal, net, marking)

    for name, meaning in list(waiting.formulas.items()):
        if isinstance(meaning, tuple):
            continue
        smaller = simplified(meaning, net, bounds)
        rest = at_first(smaller, at_start)
        waiting.formulas[name] = rest
        if isinstance(rest, Const):
            del waiting.formulas[name]
            yield Verdict(name, _told(rest), (REWRITING if isinstance(smaller, Const) else INITIAL_STATE,))


def _reached(questions: Questions, waiting: _Waiting) -> Iterator[Verdict]:
    """Answers what asks for reachable markings by search, until it turns out that the space is small."""
    net = questions.net
    goals = {part: goal for part in waiting.parts() if (goal := as_reachability(part, net)) is not None}
    parts = list(goals)
    for index, found in Portfolio(net).decide(list(goals.values()), go_on=lambda: not questions.brief()):
        yield from waiting.learn(parts[index], found.reachable, found.techniques)


class _Local:
    """Asks for markings as they are needed, in rounds of so many steps for each part of a formula.

    Args:
        net: The net.
        waiting: What is to be answered.
    """

    def __init__(self, net: PetriNet, waiting: _Waiting) -> None:
        self.net, self.waiting = net, waiting
        self.check = LocalCheck(net, waiting.parts())
        self.rounds = 0

    def round(self, steps: int, *, searched: bool = True) -> Iterator[Verdict]:
        """One round; with or without what a search for a reachable marking is asked anyway."""
        for part in self.waiting.parts():
            if not searched and as_reachability(part, self.net) is not None:
                continue
            value = self.check.decide(part, steps, seed=self.rounds)
            if value is not None:
                yield from self.waiting.learn(part, value, (EXPLICIT,))
        self.rounds += 1


def _told(value: Const) -> str:
    return str(value.value).upper()


def _by_slices(
    questions: Questions, store: Store, waiting: _Waiting, local: _Local | None
) -> Iterator[Verdict]:
    """Answers on the space and, between its rounds, by markings as they are needed.

    Slices are CPU time: what else the machine does costs no formula its turn.
    """
    before, until = store.progress, 0.0

    def watch(nodes: int) -> None:
        if before is not None:
            before(nodes)
        if time.process_time() > until:
            raise _SliceSpent

    later = chain(LOCAL_STEPS[2:], repeat(LOCAL_STEPS[-1]))
    for limit in (FIRST_SLICE * GROWTH**number for number in count()):
        for name in sorted(waiting.formulas, key=lambda name: _effort(waiting.formulas[name])):
            until = time.process_time() + limit
            store.progress = watch
            try:
                value = _value(questions, waiting.formulas[name])
            except _SliceSpent:
                continue
            finally:
                store.progress = before
            verdict = waiting.verdict(name, value, DIAGRAMS)
            del waiting.formulas[name]
            yield verdict
        if local is not None:
            yield from local.round(next(later))
        if not waiting.formulas:
            return


def _effort(meaning: Meaning) -> int:
    return 0 if isinstance(meaning, tuple) else sum(1 for _ in walk(meaning))


def _value(questions: Questions, meaning: Meaning) -> str:
    if isinstance(meaning, tuple):
        return str(largest(questions.space, Counter(meaning)))
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
        for _, found in Portfolio(net).decide([DEADLOCK], go_on=lambda: not questions.brief()):
            return Verdict(name, str(found.reachable).upper(), found.techniques)
    technique = EXPLICIT if questions.choice.engine == "explicit" else DIAGRAMS
    return Verdict(name, str(examine(examination, questions.space)).upper(), (technique,))
