"""Questions that are open: what of each is left to ask, and what one value says of the others.

A technique that decides a part of a formula hands its value to :meth:`OpenQuestions.learn`, and gets the
answers that follow.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from mcpn.logic.implications import Meaning, implied
from mcpn.logic.initial_state import at_first, parts_at_first
from mcpn.logic.without_space import Known
from mcpn.nets.petri import PetriNet
from mcpn.records import record
from mcpn.spaces.search import HOME, INITIAL_STATE
from mcpn.spaces.search.goal import FALSE, TRUE, Formula
from mcpn.steps import Doing, step

REWRITING = "QUERY_REDUCTION"
EFFORT_OF_LIVENESS = 30
"""The number of operators of a formula that takes about as long: closures forward and backward."""


@record(frozen=True)
class ContestAnswer:
    """An answer to a question of the contest.

    Args:
        name: The question's.
        value: ``TRUE``, ``FALSE``, a number, or ``INF`` of what has no bound.
        techniques: How it was had, in the contest's words.
    """

    name: str
    value: str
    techniques: tuple[str, ...]

    def __str__(self) -> str:
        return f"FORMULA {self.name} {self.value} TECHNIQUES {' '.join(self.techniques)}"


class OpenQuestions:
    """Questions about a net that wait for an answer; each value that is learnt removes those that it decides.

    Args:
        net: The net.
        waiting: What is asked, by name; of a formula, what is left to ask in the initial marking.
        settled: Whether formulas speak of stable states.
    """

    def __init__(self, net: PetriNet, waiting: dict[str, Meaning], *, settled: bool) -> None:
        self.net, self.waiting, self.asked = net, waiting, dict(waiting)
        self.ways: dict[str, dict[str, None]] = {name: {} for name in waiting}  # that decided parts of it
        self.known = Known(net, settled=settled)
        self.bounding: dict[Formula, list[tuple[Formula, bool]]] = {}
        self.before: dict[str, list[Formula]] = {}  # what was asked until more was known
        self.nested: set[Formula] = set()  # parts inside others that have one value everywhere

    def tell_open(self) -> None:
        """Announces which questions are open: an interruption names them."""
        step(Doing.LEFT_OPEN, question=", ".join(self.waiting))

    def answer(self, name: str, value: float, *ways: str) -> Iterator[ContestAnswer]:
        """Answers a question, which no longer waits, with the techniques of its parts; and what follows."""
        del self.waiting[name]
        told = tuple({**self.ways[name], **dict.fromkeys(ways)})
        yield ContestAnswer(name, str(value).upper(), told)
        for other, follows in implied(self.asked[name], value, self.net, self.parts):
            yield from self.learn(other, follows, *told)

    def parts(self) -> list[Formula]:
        """The parts whose initial values are asked for, cheap ones first."""
        formulas = (asked for asked in self.waiting.values() if isinstance(asked, Formula))
        return sorted(dict.fromkeys(chain.from_iterable(map(parts_at_first, formulas))), key=effort)

    def sought(self) -> list[Formula]:
        """The parts that are asked for as they stand now, and what may decide them."""
        parts = self.parts()
        wanted = {*parts}
        beside = [
            part
            for part, bounded in self.bounding.items()
            if part in self.nested or any(other in wanted for other, _ in bounded)
        ]
        return list(dict.fromkeys((*parts, *beside)))

    def learn(self, part: Meaning, value: float, *ways: str) -> Iterator[ContestAnswer]:
        """Puts a value where it is asked for, and yields what that answers."""
        if isinstance(part, Formula):
            self.known.values[part] = bool(value)
            for other, follows in implied(part, value, self.net, self.parts):
                yield from self.learn(other, follows, *ways)
            for bounded, when in self.bounding.pop(part, ()):
                if value == when and bounded not in self.known.values:
                    yield from self.learn(bounded, value, *ways)
            if part in self.nested:
                self.nested.remove(part)
                self.known.forget()
                yield from self.rewritten(*ways, HOME)
        for name, asked in list(self.waiting.items()):
            if name not in self.waiting:
                continue
            if asked == part:
                yield from self.answer(name, value, *ways)
            elif isinstance(asked, Formula) and part in parts_at_first(asked):
                self.ways[name].update(dict.fromkeys(ways))
                yield from self.left(
                    name, at_first(asked, lambda atom: bool(value) if atom == part else None)
                )
            else:
                yield from self.looked_back(name, part, *ways)

    def looked_back(self, name: str, part: Meaning, *ways: str) -> Iterator[ContestAnswer]:
        """Answers a question that a part decides as it was asked before more was known."""
        for before in self.before.get(name, ()):
            if part in parts_at_first(before):
                rest = at_first(before, self.known.values.get)
                if rest in (TRUE, FALSE):
                    yield from self.answer(name, rest == TRUE, *ways)
                    return

    def left(self, name: str, rest: Formula, *ways: str) -> Iterator[ContestAnswer]:
        """Keeps what is left to ask of a formula, or yields the answer if nothing is."""
        self.waiting[name] = rest
        if rest in (TRUE, FALSE):
            yield from self.answer(name, rest == TRUE, *ways)

    def rewritten(self, *by: str) -> Iterator[ContestAnswer]:
        """Answers what rewriting and the initial marking decide; of others keeps what is left to ask.

        Args:
            by: How what is put into formulas was had; by default they are read for the first time.
        """
        for name, formula in list(self.waiting.items()):
            if isinstance(formula, Formula) and name in self.waiting:
                how = (
                    (by or (REWRITING,)) if self.known.simple(formula) in (TRUE, FALSE) else (INITIAL_STATE,)
                )
                rest = self.known.rest(formula)
                if rest != formula:
                    self.ways[name].update(dict.fromkeys(by))
                    self.before.setdefault(name, []).append(formula)
                yield from self.left(name, rest, *how)


def effort(meaning: Meaning) -> int:
    """About how long a question takes, in operators of a formula."""
    if isinstance(meaning, Formula):
        return sum(1 for _ in meaning.walk())
    return EFFORT_OF_LIVENESS if meaning == "Liveness" else 0
