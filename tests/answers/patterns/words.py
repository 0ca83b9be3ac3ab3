"""All short words, and what formulas and plain definitions say of each of them.

A word is endless: some letters, of which those from one on are repeated. All words of a length are judged at
once: what is true of an atom at a position is an array with an entry for each word.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import reduce
from itertools import combinations
from operator import and_, or_
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from mcpn.logic.formulas import EG, EU, EX
from mcpn.logic.ltl.formulas import Next, Release, SomePath, Until
from mcpn.logic.syntax import parse
from mcpn.nets.petri import NetBuilder
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.goal import And, AtMost, Deadlock, Formula, Not, Or

Truths: TypeAlias = npt.NDArray[np.bool_]
ROUNDS = 5
"""How often the repeated part is looked at besides: no definition here counts further."""


class Words:
    """All words of some letters and of one length, which go on from one position for ever.

    Args:
        atoms: What letters are made of.
        length: So many letters, the repeated ones once.
        cycle: The position that is repeated first.
        at_once: Most atoms that are true at one position.
    """

    def __init__(self, atoms: str, length: int, cycle: int, at_once: int | None = None) -> None:
        letters = [
            {*letter}
            for size in range((len(atoms) if at_once is None else at_once) + 1)
            for letter in combinations(atoms, size)
        ]
        self.length, self.cycle = length, cycle
        numbers = np.arange(len(letters) ** length)
        digits = [numbers // len(letters) ** i % len(letters) for i in range(length)]
        self.of = {
            atom: [np.array([atom in letter for letter in letters])[digit] for digit in digits]
            for atom in atoms
        }
        self.none = np.zeros(len(numbers), dtype=bool)
        self.horizon = length + ROUNDS * (length - cycle)

    def __getitem__(self, atom: str) -> list[Truths]:
        """What is true of an atom at each position up to the horizon."""
        return [self.of[atom][self.base(i)] for i in range(self.horizon)]

    def base(self, position: int) -> int:
        """The position among the letters that a later one repeats."""
        if position < self.length:
            return position
        return self.cycle + (position - self.cycle) % (self.length - self.cycle)

    def all(self, of: Iterable[Truths]) -> Truths:
        """Where all of some truths are so."""
        return reduce(and_, of, ~self.none)

    def any(self, of: Iterable[Truths]) -> Truths:
        """Where one of some truths is so."""
        return reduce(or_, of, self.none)

    def satisfying(self, text: str) -> Truths:
        """The words that satisfy a formula of the program's language: each is the only path of a graph."""
        builder = NetBuilder("word")
        atoms = list(self.of)
        for atom in atoms:
            builder.place(atom)
        known: dict[Formula, list[Truths]] = {}
        after = [*range(1, self.length), self.cycle]

        def least(now: list[Truths], along: list[Truths]) -> list[Truths]:
            found = [self.none] * self.length
            for _ in range(2):
                for i in reversed(range(self.length)):
                    found[i] = now[i] | (along[i] & found[after[i]])
            return found

        def of(formula: Formula) -> list[Truths]:
            if formula not in known:
                known[formula] = made(formula)
            return known[formula]

        def negated(of_: list[Truths]) -> list[Truths]:
            return [~each for each in of_]

        def made(formula: Formula) -> list[Truths]:
            match formula:
                case AtMost(((place, -1),), -1):
                    return self.of[atoms[place]]
                case Not((operand,)):
                    return negated(of(operand))
                case And(operands):
                    return [self.all(each) for each in self._each(map(of, operands))]
                case Or(operands):
                    return [self.any(each) for each in self._each(map(of, operands))]
                case Deadlock():
                    return [self.none] * self.length
                case Next((operand,)) | EX((operand,)):
                    return [of(operand)[i] for i in after]
                case Until((left, right)) | EU((left, right)):
                    return least(of(right), of(left))
                case EG((operand,)):
                    return negated(least(negated(of(operand)), [~self.none] * self.length))
                case Release((left, right)):
                    return negated(least(negated(of(right)), negated(of(left))))
                case SomePath((operand,)):
                    return of(operand)
            raise TypeError(formula)

        return of(parse(text, Names(builder.build())))[0]

    def _each(self, of: Iterator[list[Truths]]) -> Iterator[Sequence[Truths]]:
        operands = list(of)
        return ([operand[i] for operand in operands] for i in range(self.length))

    def shown(self, which: Truths) -> str:
        """The first of some words."""
        (number, *_) = np.flatnonzero(which)
        letters = ["".join(a for a in self.of if self.of[a][i][number]) or "-" for i in range(self.length)]
        return f"{' '.join(letters[: self.cycle])} ({' '.join(letters[self.cycle :])})"


def short(atoms: str, length: int, at_once: int | None = None) -> Iterator[Words]:
    """All words of up to so many letters."""
    for n in range(1, length + 1):
        for cycle in range(n):
            yield Words(atoms, n, cycle, at_once)
