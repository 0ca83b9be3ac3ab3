"""The way through a section, from values at its exits to values at its entry; loops of sections.

Sections that lead to each other are a linear system in the values at their entries. It is solved in one of
three ways, whichever is expected to cost least: by block elimination, where equal blocks are computed once
(:mod:`mcpn.check.causes.elimination`); or reduced to the *heads*, the entries that sections lead back to, one
sweep through the loop giving the operator on their values, which is solved directly or by iteration.

A resource beside a section is a small chain of its own, while the section takes a random time ``T``. The
probabilities of its statuses after the time ``T`` are sums of exponentials ``exp(-s T)``, each with a row
of the values at the end that it looks at and a column of the statuses at the beginning that it counts for.
For several resources the exponents add up, and rows and columns multiply (Kronecker).

Hardware in service fails, and out of service is repaired: ``s`` is 0 or the sum of both rates. Hardware
that is detected late has one status more. Beside a section nobody finds out that it is lost, and nobody
repairs it until it is known: ``known`` leads to ``well`` at the repair rate, ``well`` to ``lost`` at the
failure rate, and there it stays.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mcpn.check.causes.chain import Chain
from mcpn.check.causes.elimination import Elimination
from mcpn.check.causes.linear_systems import MOST_DENSE, Floats, solver_of
from mcpn.space.markings.graph import Ints, Mask

MOST_BYTES = 1 << 30
"""Of the matrices between sections; where they would take more, they are not made."""

CLOSE = 1e-5
"""Relative difference of two rates below which they are taken to be equal where it would be a divisor."""

STEP = 1e-3
"""Relative step of the five-point formula for a derivative."""

STENCIL = ((-2, 1 / 12), (-1, -8 / 12), (1, 8 / 12), (2, -1 / 12))


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
    def exponents(self) -> Floats:
        """The exponents ``s``."""
        return np.array([s for s, _, _ in self._terms])

    @property
    def rows(self) -> Floats:
        """By exponent, how much the value at each status at the end counts."""
        return np.array([row for _, row, _ in self._terms])

    @property
    def columns(self) -> Floats:
        """By status at the beginning, how much each exponent counts."""
        return np.array([column for _, _, column in self._terms]).T

    @cached_property
    def _terms(self) -> list[tuple[float, tuple[float, ...], tuple[float, ...]]]:
        if self.late:
            return list(self._late())
        # The share of time out of service, and the difference that the status makes.
        out = self.fails / ((self.fails + self.back) or 1.0)
        return [(0.0, (1.0 - out, out), (1.0, 1.0)), (self.fails + self.back, (1.0, -1.0), (out, out - 1.0))]

    def _late(self) -> Iterator[tuple[float, tuple[float, ...], tuple[float, ...]]]:
        """Statuses in order: well, what never is, lost, known. In the end it is lost but for the rest."""
        fails, back = self.fails, self.back
        yield 0.0, (0.0, 0.0, 1.0, 0.0), (1.0, 0.0, 1.0, 1.0)
        well, known = (1.0, 0.0, -1.0, 0.0), (0.0, 0.0, -1.0, 1.0)
        yield fails, well, (1.0, 0.0, 0.0, 0.0)
        yield back, known, (0.0, 0.0, 0.0, 1.0)
        # From known to well: back * (exp(-fails T) - exp(-back T)) / (back - fails), or its limit.
        if not back:
            return
        if abs(back - fails) > CLOSE * max(back, fails):
            share = back / (back - fails)
            yield fails, well, (0.0, 0.0, 0.0, share)
            yield back, well, (0.0, 0.0, 0.0, -share)
            return
        middle = (fails + back) / 2
        for steps, weight in STENCIL:
            yield middle * (1 + steps * STEP), well, (0.0, 0.0, 0.0, -weight * back / (middle * STEP))

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
        return sum(of.bits for of in self.beside)

    def _each_beside(self, values: Floats, maps: Iterable[Floats]) -> Floats:
        """Applies a matrix for each resource beside the section, their Kronecker product."""
        found, before = values, 1
        for matrix in maps:
            found = matrix @ found.reshape(before, matrix.shape[1], -1)
            before *= len(matrix)
        return found.reshape(before, *values.shape[1:])

    @cached_property
    def _kernels(self) -> tuple[Floats, Ints]:
        """The chain's kernels at the rates at which products of exponentials of what is beside decay.

        Returns:
            The kernels, and by product the number of its kernel.
        """
        found = np.zeros(1)
        for of in self.beside:
            found = np.add.outer(found, of.exponents).reshape(-1)
        decays, numbers = np.unique(found, return_inverse=True)
        return self.chain.kernels(decays), numbers

    def back(self, values: Floats) -> Floats:
        """Expected values at the entry of values at the exits.

        Args:
            values: By status beside, exit and own status there, and a free axis.

        Returns:
            By entry, and the free axis.
        """
        if not self.beside:
            return self.chain.expected(values[0])
        kernels, numbers = self._kernels
        products = self._each_beside(values, (of.rows for of in self.beside))
        found = self._each_beside(kernels[numbers] @ products, (of.columns for of in self.beside))
        return found.reshape(-1, values.shape[-1])

    def may_come_to(self, flags: Mask) -> Mask:
        """By entry, whether what is flagged, by status beside, exit and own status there, is possible."""
        if not self.beside:
            return self.chain.may_come_to(flags[0])
        at_once, later = (pairs.T.astype(np.float64) for pairs in self.chain.possible)
        before = flags.astype(np.float64)
        after = self._each_beside(before, (of.possible for of in self.beside))
        return np.asarray(before @ at_once + after @ later > 0, np.bool_).reshape(-1)

    @property
    def work(self) -> int:
        """Multiplications of :meth:`back` for each place of the free axis."""
        return self.chain.listed.statuses * self.chain.listed.columns << self.bits


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
        at_heads = solver_of(self._reduced, heads)

        def solved(gained: Floats) -> Floats:
            found = self._swept(gained)
            found = self._swept(gained, at_heads(found[self.heads]))
            return found[: self.size]

        return solved

    def _eliminated(self) -> tuple[Elimination, dict[Hashable, _Between]]:
        """How sections are eliminated, and the blocks between them by name."""
        names, given = dict[tuple[int, int], Hashable](), dict[Hashable, _Between]()
        for i, (passage, after, _, inner) in enumerate(self.steps):
            for j in np.unique(after // self.width).tolist():
                if j < len(self.steps):
                    there = np.where(after // self.width == j, after % self.width, self.width)
                    name = id(passage), there.tobytes(), inner.tobytes()
                    names[i, j] = name
                    given[name] = _Between(passage, there, inner)
        return Elimination(names, len(self.steps)), given

    def _swept(self, gained: Floats, at_heads: Floats | None = None) -> Floats:
        """The values at all entries after one sweep through the loop from given values at the heads."""
        found = np.zeros((self.size + 1, gained.shape[1]))
        if at_heads is not None:
            found[self.heads] = at_heads
        for passage, after, here, inner in self.steps:
            # Sections that lead back to this one were swept before it, with its given value.
            found[here] = gained[here] + np.where(inner[:, None], passage.back(found[after]), 0.0)
        return found

    def _reduced(self, matrix: Floats) -> Floats:
        """The reduced operator: values at the heads minus what one sweep through the loop makes of them."""
        found = self._swept(np.zeros((self.size, matrix.shape[1])), matrix)
        return np.asarray(matrix - found[self.heads], np.float64)
