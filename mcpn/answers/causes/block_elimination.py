"""Block elimination of the linear systems of loops of sections: equal blocks are evaluated once.

A system ``x_i = sum_j A_ij x_j + b_i`` has one vector of unknowns for each section of a loop, all of one
length, and a dense matrix for each pair of sections of which the first leads to the second. Vectors are
eliminated in rounds: of those that fill in fewest blocks, some that are not neighbours (multiple minimum
degree: Liu, ACM Transactions on Mathematical Software 11, 1985). Sections of one type have equal matrices,
and a round leaves of a row of equal sections one half as long, of equal ones again (cyclic reduction). So
matrices are expressions first, each is evaluated once, and a row of *n* equal sections takes some ``log n``
products, wherever it leads back to.

No matrix has a negative entry. What rows lack to the sum 1, the probability to leave the loop, is eliminated
with them as one more column, so that nothing is subtracted (:mod:`mcpn.answers.causes.resolvents`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mcpn.answers.causes.resolvents import resolvent
from mcpn.answers.causes.sparse import Floats

SPREAD = 4
"""Unknowns may be eliminated together with one that fills in fewer blocks, up to this factor."""


class _Eliminated(NamedTuple):
    """Unknowns that are eliminated together, in the order of their solving; pairs by the matrix between them.

    Args:
        solving: By inverse of a diagonal block, ``None`` for the identity, the eliminated unknowns.
        before: Forward substitution: by matrix, pairs of an unknown and the eliminated one that it needs.
        behind: Back substitution: by matrix, pairs of an eliminated unknown and one that it needs.
    """

    solving: Mapping[int | None, list[int]]
    before: Mapping[int, list[tuple[int, int]]]
    behind: Mapping[int, list[tuple[int, int]]]


class Elimination:
    """The plan of an elimination.

    Args:
        blocks: By pair of unknowns the name of the matrix between them; equal matrices have equal names.
        leaving: By unknown the name of the column that says what its rows lack to the sum 1.

    Attributes:
        count: The number of unknowns.
        products: The number of inverses, and of products of two matrices.
        matrices: The number of all matrices that are computed.
    """

    def __init__(self, blocks: Mapping[tuple[int, int], Hashable], leaving: Sequence[Hashable]) -> None:
        self.count = count = len(leaving)
        self._number: dict[Hashable, int] = {}
        self._terms: list[tuple[str, tuple[int, ...]]] = []
        needs: list[dict[int, int]] = [{} for _ in range(count)]
        known: dict[Hashable, int] = {}
        for (i, j), name in blocks.items():
            if name not in known:
                known[name] = self._expression("given", len(known))
            needs[i][j] = known[name]
        for name in leaving:
            if name not in known:
                known[name] = self._expression("given", len(known))
        self._names = list(known)
        self._rounds = self._planned(needs, [known[name] for name in leaving])
        kinds = [kind for kind, _ in self._terms]
        self.products = kinds.count("product") + kinds.count("inverse")
        self.matrices = len(kinds) - kinds.count("column") - len(set(leaving))

    def _expression(self, kind: str, *parts: int) -> int:
        """The number of an expression; equal expressions have one."""
        if (found := self._number.get((kind, *parts))) is None:
            found = self._number[kind, *parts] = len(self._terms)
            self._terms.append((kind, parts))
        return found

    def _sum(self, *parts: int) -> int:
        """The number of a sum; sums in it are taken apart and sorted, so that equal sums are found."""
        each: list[int] = []
        for part in parts:
            kind, terms = self._terms[part]
            each += terms if kind == "sum" else (part,)
        return self._expression("sum", *sorted(each))

    def _planned(self, needs: list[dict[int, int]], leaving: list[int]) -> list[_Eliminated]:
        """The rounds, by symbolic elimination; rows of unknowns and what they lack to 1 are changed."""
        users: list[set[int]] = [set() for _ in needs]
        for i, row in enumerate(needs):
            for j in row.keys() - {i}:
                users[j].add(i)
        left, rounds, inverses = list(range(len(needs))), list[_Eliminated](), dict[int, int]()
        while left:
            fill = {i: len(users[i]) * len(needs[i].keys() - {i}) for i in left}
            most, beside, chosen = SPREAD * max(1, min(fill.values())), set[int](), list[int]()
            for i in left:
                if fill[i] <= most and i not in beside:
                    chosen.append(i)
                    beside |= users[i] | needs[i].keys()
            solving, before, behind = defaultdict(list), defaultdict(list), defaultdict(list)
            for i in chosen:
                own = needs[i].pop(i, None)
                inverse, row, out = None, needs[i], leaving[i]
                if own is not None:
                    # Rows and what they lack sum to 1: for equal blocks the sum of all else is one, too.
                    if own not in inverses:
                        inverses[own] = self._expression("inverse", own, *sorted([*row.values(), out]))
                    inverse = inverses[own]
                    row = {j: self._expression("product", inverse, a) for j, a in row.items()}
                    out = self._expression("column", inverse, out)
                solving[inverse].append(i)
                for j, a in row.items():
                    behind[a].append((i, j))
                    users[j].discard(i)
                for user in users[i]:
                    a = needs[user].pop(i)
                    before[a].append((user, i))
                    leaving[user] = self._sum(leaving[user], self._expression("column", a, out))
                    for j, b in row.items():
                        made = self._expression("product", a, b)
                        known = needs[user].get(j)
                        needs[user][j] = made if known is None else self._sum(known, made)
                        if j != user:
                            users[j].add(user)
            gone = set(chosen)
            left = [i for i in left if i not in gone]
            rounds.append(_Eliminated(solving, before, behind))
        return rounds

    def factored_with(self, given: Callable[[Hashable], Floats]) -> Callable[[Floats], Floats]:
        """Evaluates the matrices.

        Args:
            given: The matrix of a name; what rows lack to the sum 1 is a matrix of one column.

        Returns:
            What solves the system for a right side: both by unknown, place in it, and a free axis.
        """
        values: list[Floats] = []
        for kind, parts in self._terms:
            if kind == "given":
                found = given(self._names[parts[0]])
            elif kind == "sum":
                found = np.asarray(sum(values[part] for part in parts))
            elif kind == "inverse":
                found = resolvent(values[parts[0]], sum(values[part].sum(axis=1) for part in parts[1:]))
            else:
                found = values[parts[0]] @ values[parts[1]]
            values.append(found)
        return lambda right: self._solved(values, right)

    def _solved(self, values: Sequence[Floats], right: Floats) -> Floats:
        _, size, columns = right.shape
        found = np.array(right.transpose(1, 0, 2))  # a matrix is applied to many unknowns at once

        def added(pairs_of: Mapping[int, list[tuple[int, int]]]) -> None:
            for matrix, pairs in pairs_of.items():
                to, by = np.array(pairs).T
                made = values[matrix] @ found[:, by].reshape(size, -1)
                np.add.at(found.swapaxes(0, 1), to, made.reshape(size, -1, columns).swapaxes(0, 1))

        for each in self._rounds:
            for number, members in each.solving.items():
                if number is not None:
                    solved = values[number] @ found[:, members].reshape(size, -1)
                    found[:, members] = solved.reshape(size, -1, columns)
            added(each.before)
        for each in reversed(self._rounds):
            added(each.behind)
        return found.transpose(1, 0, 2)
