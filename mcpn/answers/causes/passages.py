"""The way through a section, from values at its exits to values at its entry; loops of sections.

Sections that lead to each other are a linear system in the values at their entries. It is solved in one of
three ways, whichever is expected to cost least: by block elimination, where equal blocks are computed once
(:mod:`mcpn.answers.causes.linear_systems`); or reduced to the *heads*, the entries that sections lead back
to, one sweep through the loop giving the operator on their values, which is solved directly or by iteration.

A resource beside a section is a small chain of its own, while the section takes a random time ``T``. It is
described by a clock that starts with the section. Hardware in service fails at the rate ``f``, and out of
service is repaired at the rate ``r``: that is the same as if at the rate ``f + r`` its status were drawn
anew, out of service with probability ``f / (f + r)``. So its status at the end is that of the beginning if
the clock has not rung, and else is drawn once. No probability is a difference of others here. For several
resources the section runs against several clocks (:class:`mcpn.answers.causes.chain.Clocks`), and what they
say multiplies (Kronecker).

Hardware that is detected late has one status more. Beside a section nobody finds out that it is lost, and
nobody repairs it until it is known: ``known`` leads to ``well`` at the repair rate, ``well`` to ``lost`` at
the failure rate, and there it stays. Its clock tells which of the two have rung, and whether a failure came
after the repair.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import NamedTuple

import numpy as np

from mcpn.answers.causes.block_elimination import Elimination
from mcpn.answers.causes.chain import Chain, Clocks, Phases
from mcpn.answers.causes.linear_systems import MOST_DENSE, solver_of
from mcpn.answers.causes.sparse import Floats
from mcpn.spaces.markings.graph import Ints, Mask

MOST_BYTES = 1 << 30
"""Of the matrices between sections; where they would take more, they are not made."""

MOST_TERMS = 1 << 12
"""Products of terms of what is beside that are held at a time, for each place in a section's kernels."""


class Term(NamedTuple):
    """A part of what a resource does beside a section.

    Args:
        phases: By phase of its clock, 1 where the part counts.
        row: By status at the end, how probable it is then.
        column: By status at the beginning, 1 where the part counts.
    """

    phases: Sequence[float]
    row: Sequence[float]
    column: Sequence[float]


@dataclass(frozen=True)
class Beside:
    """A resource beside a section; also a handler that happens once, or a fact.

    Args:
        fails: Failures per hour in service.
        back: Repairs per hour out of service, of what is known to be.
        late: Whether it is detected late: its statuses are then those of two bits, out of service and known
            to be, of which one never is.
    """

    fails: float
    back: float
    late: bool = False

    @property
    def bits(self) -> int:
        """Bits of its status."""
        return 2 if self.late else 1

    @property
    def clock(self) -> Phases:
        """Its clock."""
        fails, back = self.fails, self.back
        if not self.late:
            return [[(fails + back, 1)], []] if fails + back else [[]]
        # Nothing has rung, a failure, the repair, a failure and then the repair, a failure after the repair.
        ways = [[(fails, 1), (back, 2)], [(back, 3)], [(fails, 4)], [(fails, 4)], []]
        return [[(rate, after) for rate, after in each if rate] for each in ways]

    @cached_property
    def terms(self) -> list[Term]:
        """What it does, by phase of its clock: each way from a status to a status is in the terms once."""
        if not self.late:
            out = self.fails / ((self.fails + self.back) or 1.0)
            back = self.back / ((self.fails + self.back) or 1.0)
            begun, *rung = np.eye(len(self.clock)).tolist()
            kept = [Term(begun, status, status) for status in np.eye(2).tolist()]
            return [*kept, *(Term(phase, (back, out), (1.0, 1.0)) for phase in rung)]
        well, _, lost, known = np.eye(4).tolist()
        return [
            Term((1, 1, 1, 1, 1), lost, lost),
            Term((1, 0, 1, 0, 0), well, well),
            Term((0, 1, 0, 1, 1), lost, well),
            Term((1, 1, 0, 0, 0), known, known),
            Term((0, 0, 1, 1, 0), well, known),
            Term((0, 0, 0, 0, 1), lost, known),
        ]

    @property
    def possible(self) -> Floats:
        """By status at the beginning and at the end, 1 where it is possible after some time."""
        fails, back = float(self.fails > 0), float(self.back > 0)
        if not self.late:
            return np.array([[1.0, fails], [back, 1.0]])
        return np.array(
            [
                [1.0, 0.0, fails, 0.0],
                [0.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
                [back, 0.0, back * fails, 1.0],
            ]
        )


@dataclass(frozen=True, eq=False)
class WayThrough:
    """The way through one section, from values at its exits to values at its entry.

    Args:
        chain: The section's.
        beside: Other resources that it or later ones use.
    """

    chain: Chain
    beside: tuple[Beside, ...]

    @property
    def bits(self) -> int:
        """Bits of the status of all that is beside."""
        return sum(other.bits for other in self.beside)

    def _each_beside(self, values: Floats, maps: Iterable[Floats]) -> Floats:
        """Applies a matrix for each resource beside the section, their Kronecker product."""
        found, before = values, 1
        for matrix in maps:
            found = matrix @ found.reshape(before, matrix.shape[1], -1)
            before *= len(matrix)
        return found.reshape(before, *values.shape[1:])

    @cached_property
    def _kernels(self) -> Floats:
        """The chain's kernels in a race with the clocks of what is beside."""
        return self.chain.kernels(Clocks([other.clock for other in self.beside]))

    def _through(self, kernels: Floats, values: Floats, beside: Sequence[Beside]) -> Floats:
        """Values at the entry, by status of what is beside, own status, and the free axis."""
        if len(beside) > 1 and prod(len(other.terms) for other in beside) > MOST_TERMS:
            first, *others = beside
            count, statuses, found = len(first.clock), 1 << first.bits, list[Floats]()
            for term in first.terms:
                by_phase = np.tensordot(term.phases, kernels.reshape(count, -1, *kernels.shape[1:]), 1)
                at_end = np.tensordot(term.row, values.reshape(statuses, -1, *values.shape[1:]), 1)
                found.append(self._through(by_phase, at_end, others))
            each = np.array([term.column for term in first.terms]).T
            return np.asarray(np.tensordot(each, np.stack(found), 1).reshape(-1, *found[0].shape[1:]))
        phases, rows, columns = (
            [np.array([term[part] for term in other.terms], np.float64) for other in beside]
            for part in range(3)
        )
        products = self._each_beside(kernels, phases) @ self._each_beside(values, rows)
        return self._each_beside(products, [matrix.T for matrix in columns])

    def back(self, values: Floats) -> Floats:
        """Expected values at the entry of values at the exits.

        Args:
            values: By status beside, exit and own status there, and a free axis.

        Returns:
            By entry, and the free axis.
        """
        if not self.beside:
            return self.chain.expected(values[0])
        return self._through(self._kernels, values, self.beside).reshape(-1, values.shape[-1])

    @cached_property
    def staying(self) -> Floats:
        """By entry, how probable it is that the section is never left."""
        return np.tile(self.chain.staying, 1 << self.bits)

    def may_come_to(self, flags: Mask) -> Mask:
        """By entry, whether what is flagged, by status beside, exit and own status there, is possible."""
        if not self.beside:
            return self.chain.may_come_to(flags[0])
        at_once, later = (pairs.T.astype(np.float64) for pairs in self.chain.possible)
        flagged = flags.astype(np.float64)
        # Not even at once is anything possible in the one status that never is.
        before = self._each_beside(flagged, (np.diag(other.possible.diagonal()) for other in self.beside))
        after = self._each_beside(flagged, (other.possible for other in self.beside))
        return np.asarray(before @ at_once + after @ later > 0, np.bool_).reshape(-1)

    @property
    def work(self) -> int:
        """Multiplications of :meth:`back` for each place of the free axis."""
        terms = prod(len(other.terms) for other in self.beside)
        return self.chain.listed.statuses * self.chain.listed.columns * terms


class LoopSection(NamedTuple):
    """A section of a loop.

    Args:
        passage: The way through it.
        after: The entries behind it, as of :meth:`WayThrough.back`, numbered in the loop; what is not of the
            loop has the number after all of these.
        here: Its own entries.
        inner: By entry of its own, whether it has a value other than 0.
    """

    passage: WayThrough
    after: Ints
    here: slice
    inner: Mask


class _Between(NamedTuple):
    """The block of the system by which values of one section depend on those of another, or its own.

    Args:
        passage: The way through it.
        after: The entries of the other behind it, and one number more for what is not of the other.
        inner: By entry of its own, whether it has a value other than 0.
    """

    passage: WayThrough
    after: Ints
    inner: Mask

    @property
    def work(self) -> int:
        """Multiplications that the matrix takes."""
        return len(self.inner) * self.passage.work

    def matrix(self) -> Floats:
        """The block as a dense matrix."""
        size = len(self.inner)
        found = self.passage.back(np.eye(size + 1, size)[self.after])
        return np.where(self.inner[:, None], found, 0.0)


class _Leaving(NamedTuple):
    """How probable it is to leave the loop out of one section.

    Args:
        passage: The way through it.
        outside: The entries behind it, whether they are not of the loop.
        inner: By entry of its own, whether it has a value other than 0.
    """

    passage: WayThrough
    outside: Mask
    inner: Mask

    @property
    def work(self) -> int:
        """Multiplications that the column takes."""
        return self.passage.work

    def matrix(self) -> Floats:
        """By entry, as a matrix of one column."""
        found = self.passage.back(self.outside[..., None].astype(np.float64))[:, 0] + self.passage.staying
        return np.where(self.inner, found, 1.0)[:, None]


class SectionLoop:
    """Sections that lead to each other.

    Args:
        steps: The sections, in the order of their entries.
        heads: The entries that sections lead back to.

    Attributes:
        kind: Equal for loops that differ in where their entries are alone.
    """

    def __init__(self, steps: Sequence[LoopSection], heads: Ints) -> None:
        self.steps = steps
        self.heads = heads
        self.size = steps[-1].here.stop
        self.width = steps[0].here.stop
        keys = ((id(step.passage), step.after.tobytes(), step.inner.tobytes()) for step in steps)
        self.kind: Hashable = (heads.tobytes(), *keys)

    def system(self) -> Callable[[Floats], Floats]:
        """A solver that gives the values at entries from the gains there; both with a free axis."""
        heads, made = len(self.heads), self._eliminated() if 8 * self.width**2 <= MOST_BYTES else None
        if made is not None:
            plan, given = made
            work = plan.products * self.width**3 + sum(block.work for block in given.values())
            through = heads * sum(step.passage.work for step in self.steps) + heads**3
            if plan.matrices * 8 * self.width**2 <= MOST_BYTES and (heads > MOST_DENSE or work <= through):
                solve = plan.factored_with(lambda name: given[name].matrix())
                shape = len(self.steps), self.width, -1
                return lambda gained: solve(gained.reshape(shape)).reshape(gained.shape)
        at_heads = solver_of(
            lambda matrix: self._swept(np.zeros((self.size, matrix.shape[1])), matrix)[self.heads],
            lambda: self._swept(np.vstack([self._leaving(i).matrix() for i in range(len(self.steps))]))[
                self.heads, 0
            ],
            heads,
        )

        def solved(gained: Floats) -> Floats:
            found = self._swept(gained)
            found = self._swept(gained, at_heads(found[self.heads]))
            return found[: self.size]

        return solved

    def _leaving(self, number: int) -> _Leaving:
        passage, after, _, inner = self.steps[number]
        return _Leaving(passage, after == self.size, inner)

    def _eliminated(self) -> tuple[Elimination, dict[Hashable, _Between | _Leaving]]:
        """How sections are eliminated, and by name the blocks between them and what leaves the loop."""
        names, given = dict[tuple[int, int], Hashable](), dict[Hashable, _Between | _Leaving]()
        leaving = list[Hashable]()
        for i, (passage, after, _, inner) in enumerate(self.steps):
            for j in np.unique(after // self.width).tolist():
                if j < len(self.steps):
                    there = np.where(after // self.width == j, after % self.width, self.width)
                    name = id(passage), there.tobytes(), inner.tobytes()
                    names[i, j] = name
                    given[name] = _Between(passage, there, inner)
            out = self._leaving(i)
            leaving.append((id(passage), "leaving", out.outside.tobytes(), inner.tobytes()))
            given[leaving[-1]] = out
        return Elimination(names, leaving), given

    def _swept(self, gained: Floats, at_heads: Floats | None = None) -> Floats:
        """The values at all entries after one sweep through the loop from given values at the heads."""
        found = np.zeros((self.size + 1, gained.shape[1]))
        if at_heads is not None:
            found[self.heads] = at_heads
        for passage, after, here, inner in self.steps:
            # Sections that lead back to this one were swept before it, with its given value.
            found[here] = gained[here] + np.where(inner[:, None], passage.back(found[after]), 0.0)
        return found
