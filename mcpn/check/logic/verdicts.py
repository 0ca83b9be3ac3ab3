"""Answers to files and examinations of the Model Checking Contest, as they come, with how they were had.

What asks for one reachable marking goes to a search first; what is left is asked of the space, built once.
The formulas of a file share it: cheap ones first, each with a time slice that grows round by round, so that
one hard formula does not cost the easy ones.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mcpn.check.logic.contest import Property
from mcpn.check.logic.formulas import Core, walk
from mcpn.check.logic.questions import Questions
from mcpn.check.logic.reachability import ReachabilityQuestion, as_reachability
from mcpn.check.nets.behaviour import examine
from mcpn.errors import InputError, UnsafeError
from mcpn.space.search.goal import DEADLOCK
from mcpn.space.search.portfolio import EXPLICIT, RANDOM_WALK, ROUNDS, Portfolio
from mcpn.space.search.searches import Searches

DIAGRAMS = "DECISION_DIAGRAMS"
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


def answer_file(questions: Questions, properties: Sequence[Property]) -> Iterator[Verdict]:
    """Answers the properties of a file.

    Args:
        questions: About the net.
        properties: What is asked.

    Yields:
        The answers in the order in which they are found.

    Raises:
        InputError: A name is unknown; nothing is answered then.
        UnsafeError: What is left needs the space, and the net is not 1-safe.
        LimitError: What is left needs the space, and a limit was hit.
    """
    cores = {asked.name: _core(questions, asked) for asked in properties}
    answered: set[str] = set()
    for verdict in _by_search(questions, cores):
        answered.add(verdict.name)
        yield verdict
    waiting = [asked for asked in properties if asked.name not in answered]
    if not waiting:
        return
    if questions.engine == "explicit":
        for asked in waiting:
            yield Verdict(asked.name, _value(questions, asked, cores[asked.name]), (EXPLICIT,))
        return
    yield from _by_slices(questions, waiting, cores)


def _core(questions: Questions, asked: Property) -> Core | None:
    if asked.formula is None:
        for name in asked.bound:
            if name not in questions.net.place_index:
                raise InputError.at(asked.source, f"no place is named {name}")
        return None
    try:
        return questions.core(asked.formula)
    except InputError as error:
        raise InputError.at(asked.source, f"{asked.name}: {error}") from error


def _by_search(questions: Questions, cores: dict[str, Core | None]) -> Iterator[Verdict]:
    if not questions.searchable:
        return
    asked: list[tuple[str, ReachabilityQuestion]] = []
    for name, core in cores.items():
        question = None if core is None else as_reachability(core, questions.net)
        if question is not None:
            asked.append((name, question))
    goals = [question.goal for _, question in asked]
    for index, found in Portfolio(questions.net).decide(goals, ROUNDS[:2]):
        name, question = asked[index]
        value = found.reachable == question.if_reachable
        yield Verdict(name, str(value).upper(), found.techniques)


def _by_slices(
    questions: Questions, waiting: Sequence[Property], cores: dict[str, Core | None]
) -> Iterator[Verdict]:
    store = questions.space.encoding.store
    before, until = store.progress, 0.0

    def watch(nodes: int) -> None:
        if before is not None:
            before(nodes)
        if time.monotonic() > until:
            raise _SliceSpent

    def effort(asked: Property) -> int:
        core = cores[asked.name]
        return 0 if core is None else sum(1 for _ in walk(core))

    left, limit = sorted(waiting, key=effort), FIRST_SLICE
    try:
        store.progress = watch
        while left:
            later = []
            for asked in left:
                until = time.monotonic() + limit
                try:
                    value = _value(questions, asked, cores[asked.name])
                except _SliceSpent:
                    later.append(asked)
                    continue
                yield Verdict(asked.name, value, (DIAGRAMS,))
            left, limit = later, limit * GROWTH
    finally:
        store.progress = before


def _value(questions: Questions, asked: Property, core: Core | None) -> str:
    if core is not None:
        evaluation = questions.explicit if questions.engine == "explicit" else questions.symbolic
        return str(evaluation.holds(core)).upper()
    weights: dict[int, int] = {}
    for name in asked.bound:
        place = questions.net.place_index[name]
        weights[place] = weights.get(place, 0) + 1
    if questions.engine != "explicit":
        levels, always = questions.space.encoding.weigh(weights)
        return str(questions.space.reachable.largest(levels) + always)
    graph = questions.explicit.graph
    tokens = np.zeros(graph.states, np.int64)
    for place, weight in weights.items():
        tokens += weight * graph.marked(place)
    return str(tokens.max())


def answer_examination(questions: Questions, examination: str) -> Verdict:
    """Answers an examination of the contest (see :func:`mcpn.check.nets.behaviour.examine`).

    Raises:
        UnsafeError: It needs the space, and the net is not 1-safe.
        LimitError: It needs the space, and a limit was hit.
    """
    net = questions.net
    name = f"{net.name}-{examination}"
    if examination == "OneSafe":
        if max(net.initial, default=0) > 1:
            return Verdict(name, "FALSE", ("INITIAL_STATE",))
        searches = Searches(net)
        if questions.engine == "auto" and searches.fits and searches.walk_unsafe(steps=WALK_STEPS):
            return Verdict(name, "FALSE", (RANDOM_WALK,))
    elif examination == "ReachabilityDeadlock" and questions.searchable:
        for _, found in Portfolio(net).decide([DEADLOCK], ROUNDS[:2]):
            return Verdict(name, str(found.reachable).upper(), found.techniques)
    try:
        return Verdict(name, str(examine(examination, questions.space)).upper(), (DIAGRAMS,))
    except UnsafeError:
        if examination == "OneSafe":
            return Verdict(name, "FALSE", (DIAGRAMS,))
        raise
