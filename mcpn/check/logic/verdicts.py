"""Answers to files and examinations of the Model Checking Contest, as they come, with how they were had.

Formulas are simplified, by invariants and by the initial marking; what asks for one reachable marking goes to
a search, once where several formulas ask for the same; others are asked of few markings, as they are needed
(:mod:`mcpn.check.logic.local`). What is left is asked of the space, built once. The formulas of
all files and the examinations share it: cheap ones first, each with a time slice that grows round by round,
so that one hard question does not cost the easy ones.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain, count, repeat
from typing import Any, TypeAlias

from mcpn._kernel import Store
from mcpn.check.logic.contest import Property
from mcpn.check.logic.formulas import EU, TRUE, Const, Deadlock, Formula, as_goal, as_reachability, walk
from mcpn.check.logic.local import LocalCheck
from mcpn.check.logic.questions import Questions
from mcpn.check.logic.simplify import at_first, parts_at_first, replaced, simplified
from mcpn.check.nets import EXAMINATIONS, Behaviour
from mcpn.check.spaces import Asked
from mcpn.errors import InputError, McpnError
from mcpn.net.petri import PetriNet
from mcpn.space.algebra import Space
from mcpn.space.diagrams.spaces import DiagramAlternatives, DiagramMarkings
from mcpn.space.search.equation import place_bounds
from mcpn.space.search.goal import holds
from mcpn.space.search.portfolio import EXPLICIT, INITIAL_STATE, RANDOM_WALK, Portfolio
from mcpn.space.search.searches import Searches

DIAGRAMS, REWRITING = "DECISION_DIAGRAMS", "QUERY_REDUCTION"
FIRST_SLICE, GROWTH = 1.5, 4.0
WALK_STEPS = 50_000
ONE_SAFE = "OneSafe"
SOME_DEADLOCK = EU(TRUE, Deadlock())
EFFORT_OF_LIVENESS = 30
"""As many operators a formula has that takes about as long: closures to and fro."""
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


Meaning: TypeAlias = Formula | tuple[int, ...] | str
"""A formula; places, where the most tokens that they hold together is asked; or an examination's name."""


def answer_all(
    questions: Questions, properties: Iterable[Property] = (), examinations: Iterable[str] = ()
) -> Iterator[Verdict]:
    """Answers properties, of one file or several, and examinations, on one space.

    Args:
        questions: About the net.
        properties: What is asked.
        examinations: Names of :data:`mcpn.check.nets.EXAMINATIONS`.

    Returns:
        The answers in the order in which they are found. Taking them raises UnboundedError, UnsafeError (of
        nets with priorities) or LimitError where what is left needs the space.

    Raises:
        InputError: Two properties have one name; this is found before anything is answered.
    """
    meant: dict[str, Meaning] = {}
    for name in examinations:
        searched = name == "ReachabilityDeadlock" and questions.searchable
        meant[f"{questions.net.name}-{name}"] = SOME_DEADLOCK if searched else name
    for asked in properties:
        if asked.name in meant:
            raise InputError.at(asked.source, f"found {asked.name} a second time, expected a name of its own")
        meant[asked.name] = asked.meaning
    return _answers(questions, _Waiting(meant))


def _answers(questions: Questions, waiting: _Waiting) -> Iterator[Verdict]:
    yield from _found_unsafe(questions, waiting)
    local = None
    if questions.searchable:
        yield from _simplified(questions.net, waiting)
        if waiting.parts() and Searches(questions.net).fits:
            local = _Local(questions.net, waiting)
            yield from local.round(LOCAL_STEPS[0], searched=False)
        yield from _reached(questions, waiting)
        if local is not None:
            yield from local.round(LOCAL_STEPS[1], searched=False)
    try:
        yield from _one_safe(questions, waiting)
        space = questions.space if waiting.formulas else None
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
    for name in waiting.cheap_first():
        value = _value(questions, waiting.formulas[name])
        yield waiting.answer(name, value, _technique(questions.choice.engine))


def _technique(engine: Asked) -> str:
    return EXPLICIT if engine == "explicit" else DIAGRAMS


def _found_unsafe(questions: Questions, waiting: _Waiting) -> Iterator[Verdict]:
    """Answers whether the net is 1-safe, where the initial marking or a walk shows that it is not."""
    searches = Searches(questions.net)
    for name in waiting.asking(ONE_SAFE):
        if max(questions.net.initial, default=0) > 1:
            yield waiting.answer(name, False, INITIAL_STATE)
        elif questions.engine == "auto" and searches.fits and searches.walk_unsafe(steps=WALK_STEPS):
            yield waiting.answer(name, False, RANDOM_WALK)


def _one_safe(questions: Questions, waiting: _Waiting) -> Iterator[Verdict]:
    """Answers whether the net is 1-safe; if it is, the space is then there for all that is asked."""
    for name in waiting.asking(ONE_SAFE):
        safe = questions.one_safe()
        engine = questions.choice.engine if safe else questions.engine
        yield waiting.answer(name, safe, _technique(engine))


@dataclass
class _Waiting:
    """What is still to be answered.

    Args:
        formulas: By name; of a formula, what is left to ask in the initial marking.
        techniques: By which ways parts of them were decided.
    """

    formulas: dict[str, Meaning]
    techniques: dict[str, dict[str, None]] = field(default_factory=dict)

    def answer(self, name: str, value: int, *techniques: str) -> Verdict:
        """The answer to what then waits no more, with the ways by which parts were decided before."""
        del self.formulas[name]
        ways = {**self.techniques.pop(name, {}), **dict.fromkeys(techniques)}
        return Verdict(name, str(value).upper(), tuple(ways))

    def asking(self, examination: str) -> list[str]:
        """The name of an examination, if it waits."""
        return [name for name, meaning in self.formulas.items() if meaning == examination]

    def cheap_first(self) -> list[str]:
        """The names of what waits."""
        return sorted(self.formulas, key=lambda name: _effort(self.formulas[name]))

    def temporal(self) -> dict[str, Formula]:
        """The formulas that wait."""
        return {
            name: formula for name, formula in self.formulas.items() if not isinstance(formula, tuple | str)
        }

    def parts(self) -> list[Formula]:
        """The parts whose values in the initial marking are asked for, each once, cheap ones first."""
        parts = chain.from_iterable(map(parts_at_first, self.temporal().values()))
        return sorted(dict.fromkeys(parts), key=_effort)

    def learn(self, part: Formula, value: bool, techniques: Iterable[str]) -> Iterator[Verdict]:
        """Puts the value of a part where it is asked for, and yields what that answers."""
        for name, formula in self.temporal().items():
            if part not in parts_at_first(formula):
                continue
            self.techniques.setdefault(name, {}).update(dict.fromkeys(techniques))
            self.formulas[name] = rest = replaced(formula, lambda at: Const(value) if at == part else at)
            if isinstance(rest, Const):
                yield self.answer(name, rest.value)


def _simplified(net: PetriNet, waiting: _Waiting) -> Iterator[Verdict]:
    """Answers what rewriting and the initial marking decide; of other formulas keeps what is left to ask."""
    left = {name: formula for name, formula in waiting.temporal().items() if formula != SOME_DEADLOCK}
    if not left:
        return
    marking, bounds = net.initial, place_bounds(net)

    def at_start(atom: Formula) -> bool:
        goal = as_goal(atom, net)
        return goal is not None and holds(goal, net, marking)

    for name, formula in left.items():
        smaller = simplified(formula, net, bounds)
        waiting.formulas[name] = rest = at_first(smaller, at_start)
        if isinstance(rest, Const):
            how = REWRITING if isinstance(smaller, Const) else INITIAL_STATE
            yield waiting.answer(name, rest.value, how)


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
        for name in waiting.cheap_first():
            until = time.process_time() + limit
            store.progress = watch
            try:
                value = _value(questions, waiting.formulas[name])
            except _SliceSpent:
                continue
            finally:
                store.progress = before
            yield waiting.answer(name, value, DIAGRAMS)
        if local is not None:
            yield from local.round(next(later))
        if not waiting.formulas:
            return


def _effort(meaning: Meaning) -> int:
    if isinstance(meaning, str):
        return EFFORT_OF_LIVENESS if meaning == "Liveness" else 0
    return 0 if isinstance(meaning, tuple) else sum(1 for _ in walk(meaning))


def _value(questions: Questions, meaning: Meaning) -> int:
    """The answer by the space: a truth value or a number."""
    if isinstance(meaning, tuple):
        return largest(questions.space, Counter(meaning))
    if isinstance(meaning, str):
        return EXAMINATIONS[meaning](Behaviour(questions.space))
    return questions.evaluation.holds(meaning)


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
