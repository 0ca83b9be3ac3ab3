"""Linear systems of risk, ``x = N x + b``, solved without subtraction: dense, by factors, by iteration.

No number is negative in them: ``N`` holds the probabilities of steps between unknowns, what is missing in a
row is the probability to leave them all.

Dense systems are solved without subtraction (:mod:`mcpn.answers.causes.resolvents`), and sparse ones of
chains too, one component of unknowns that lead to each other after the other: from one to the next there are
products alone. Where components are large, all have scipy's factors, without an exchange of rows, so that
nothing but the diagonal is subtracted. What that costs is at most the rounding times the number of steps that
are expected on the way to what is asked for (the componentwise condition of Skeel, Journal of the ACM 26,
1979, which of such a matrix is one more system). That number is computed with each solution, and where it is
too large the system is solved as a dense one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mcpn.answers.causes.resolvents import Eliminated, resolvent
from mcpn.answers.causes.sparse import Floats, Ints, SparseMatrix
from mcpn.errors import LimitError
from mcpn.spaces.components import strongly_connected

CHUNK = 64
"""Right-hand sides of a system that are solved at a time."""

MOST_DENSE = 4096
"""Unknowns of a system that is solved directly where it is dense; a larger one by iteration."""

MOST_TOGETHER = 1024
"""Unknowns that lead to each other which are solved as a dense system, whichever of their steps are none."""

LITTLE_WORK = 1 << 31
"""Multiplications of the dense inverses of all components that take no longer than loading scipy does."""

A_STEP = 1e-15
"""What one step costs of an unknown, relative to it: some ten roundings of 1.1e-16."""

ROOM = 1 << 20
"""Entries of dense systems that are eliminated together: so Python has fewer steps than one by one."""

MOST_STEPS = 1e4
"""Expected steps on the way to what is asked for, up to which factors of a sparse matrix are taken."""

PRECISION = A_STEP * MOST_STEPS
"""Of an unknown, relative to it, at worst: by factors, and by iteration."""

MOST_SWEEPS = 2_000
"""Of the iteration."""

SPLITS = tuple(2**power for power in range(5, 11))
"""After how many sweeps without an end it is looked whether unknowns fall into parts."""

LIKE = 1e-3
"""Shares that are this close belong to the same part."""


def solver_of(
    system: Callable[[Floats], Floats], leaving: Callable[[], Floats], size: int
) -> Callable[[Floats], Floats]:
    """A solver for any right side of ``x = N x + b``, by its dense matrix or by iteration.

    Args:
        system: Applies ``N`` to the columns of a matrix.
        leaving: What the rows of ``N`` lack to the sum 1.
        size: The number of unknowns.
    """
    if size <= MOST_DENSE:
        parts = np.array_split(np.eye(size), -(-size // CHUNK), axis=1)
        inverse = resolvent(np.hstack([system(part) for part in parts]), leaving())
        return lambda right: inverse @ right

    def iterated(right: Floats) -> Floats:
        return np.stack([_iterated(system, column) for column in right.T], axis=1)

    return iterated


def _iterated(system: Callable[[Floats], Floats], right: Floats) -> Floats:
    """The sum of all ``N^k b``, between bounds.

    Where each unknown gains by the next sweep between ``p`` and ``q`` times what it gained by this one, so
    it does ever after, since ``N`` has no negative entry: what is to come is between ``p / (1 - p)`` and
    ``q / (1 - q)`` times the last gain. Some ``1 / (1 - q)`` steps are expected; the bounds need not be
    closer than the roundings of so many. Unknowns that do not lead to each other may gain by shares that
    stay apart for ever; these are solved one after the other.
    """
    found, gained = right, right
    for sweep in range(1, MOST_SWEEPS + 1):
        more = system(gained[:, None])[:, 0]
        met = gained > 0
        if not np.any(more[~met] > 0):
            shares = np.divide(more, gained, out=np.zeros_like(more), where=met)
            low, high = shares[met].min(initial=1.0), shares.max(initial=0.0)
            if high < 1:
                least, most = (share / (1 - share) if np.any(met) else 0.0 for share in (low, high))
                precision = min(A_STEP / (1 - high), PRECISION)
                if np.all((most - least) / 2 * gained <= precision * found):
                    return np.asarray(found + (most + least) / 2 * gained)
            if sweep in SPLITS and len(parts := _parts(system, shares)) > 1:
                return _one_by_one(system, right, parts)
        found, gained = found + more, more
    raise LimitError(f"the values at {len(right)} entries of sections in loops did not settle")


def _parts(system: Callable[[Floats], Floats], shares: Floats) -> list[Ints]:
    """Unknowns of like shares that lead to each other, each such part after those that it leads to."""
    order = np.argsort(shares)
    number = np.empty(len(shares), dtype=np.intp)
    number[order] = np.cumsum(np.diff(shares[order], prepend=shares[order[0]]) > LIKE)
    of = np.arange(number.max() + 1)[:, None] == number
    leads = of @ system(of.T.astype(np.float64)) > 0
    components = strongly_connected([np.flatnonzero(row).tolist() for row in leads])
    return [np.flatnonzero(np.any(of[component], axis=0)) for component in components]


def _one_by_one(system: Callable[[Floats], Floats], right: Floats, parts: Sequence[Ints]) -> Floats:
    """The solution where no part leads to a later one."""
    found = np.zeros_like(right)
    for part in parts:
        known = right + system(found[:, None])[:, 0]
        found[part] = _iterated(_within(system, part, len(right)), known[part])
    return found


def _within(system: Callable[[Floats], Floats], part: Ints, size: int) -> Callable[[Floats], Floats]:
    """The system of a part of the unknowns alone."""

    def within(matrix: Floats) -> Floats:
        of_all = np.zeros((size, matrix.shape[1]))
        of_all[part] = matrix
        return system(of_all)[part]

    return within


class Block(NamedTuple):
    """Components of a layer that have one size.

    Args:
        members: By component, its unknowns; entries number these, those of the first component first.
        within: Entries between unknowns of one component.
        ahead: Entries of the members to unknowns of other components.
        back: The transposed entries: of the members, from unknowns of other components.
    """

    members: Ints
    within: SparseMatrix
    ahead: SparseMatrix
    back: SparseMatrix

    @property
    def dense(self) -> Floats:
        """By component, the entries between its unknowns."""
        count, size = self.members.shape
        at = self.within.rows * size + self.within.columns % size
        found = np.bincount(at, self.within.values, count * size * size).astype(np.float64)
        return found.reshape(count, size, size)


class Layers:
    """Unknowns of a sparse system, layer by layer: those of a layer lead to each other, or to earlier layers.

    Args:
        steps: Which unknowns lead to which.

    Attributes:
        steps: The same.
        blocks: By layer, by size, the components of unknowns that lead to each other.
        every: The blocks of all layers.
        largest: How many unknowns lead to each other, at most.
    """

    def __init__(self, steps: SparseMatrix) -> None:
        self.steps, size = steps, steps.shape[0]
        ends, targets = np.searchsorted(steps.rows, np.arange(1, size + 1)).tolist(), steps.columns.tolist()
        rows = [targets[begin:end] for begin, end in zip([0, *ends], ends, strict=False)]
        height, layers = [0] * size, list[dict[int, list[list[int]]]]()
        for component in strongly_connected(rows):
            # Of the component itself none has a height yet.
            above = 0
            for i in component:
                for target in rows[i]:
                    if height[target] > above:
                        above = height[target]
            if above == len(layers):
                layers.append({})
            layers[above].setdefault(len(component), []).append(component)
            for i in component:
                height[i] = above + 1
        members = [[np.array(each) for each in layer.values()] for layer in layers]
        self.blocks: list[list[Block]] = self._parted(members)
        self.every = [block for layer in self.blocks for block in layer]
        self.largest = max((block.members.shape[1] for block in self.every), default=0)

    def _parted(self, layers: list[list[Ints]]) -> list[list[Block]]:
        """The entries of each block, out of those of all."""
        each, steps = [members for layer in layers for members in layer], self.steps
        size = steps.shape[0]
        order = np.concatenate([np.zeros(0, np.intp), *(members.reshape(-1) for members in each)])
        begins = np.cumsum([0, *(members.size for members in each)])
        position, component = np.zeros((2, size), np.intp)
        position[order] = np.arange(size)
        component[order] = np.concatenate(
            [np.zeros(0, np.intp), *(np.repeat(members[:, 0], members.shape[1]) for members in each)]
        )
        first = np.repeat(begins[:-1], np.diff(begins))

        def parts(values: Floats, of: Ints, to: Ints, *, placed: bool) -> list[SparseMatrix]:
            """By block, entries by the position that they are of; where they lead may be numbered in it."""
            ends = np.searchsorted(of, begins)
            rows, columns = of - first[of], position[to] - first[of] if placed else to
            return [
                SparseMatrix(
                    values[begin:end],
                    rows[begin:end],
                    columns[begin:end],
                    (members.size, members.size if placed else size),
                )
                for members, begin, end in zip(each, ends[:-1].tolist(), ends[1:].tolist(), strict=True)
            ]

        # Rows are in order: those of each position, and its entries, without sorting.
        count = np.diff(np.searchsorted(steps.rows, np.arange(size + 1)))
        start = (np.cumsum(count) - count)[order]
        count = count[order]
        entries = np.arange(len(steps.rows)) + np.repeat(start - np.cumsum(count) + count, count)
        of, to, values = np.repeat(np.arange(size), count), steps.columns[entries], steps.values[entries]
        among = component[order[of]] == component[to]
        within = parts(values[among], of[among], to[among], placed=True)
        of, to, values = of[~among], to[~among], values[~among]
        ahead = parts(values, of, to, placed=False)
        sources, of = order[of], position[to]
        entries = np.argsort(of, kind="stable")
        back = parts(values[entries], of[entries], sources[entries], placed=False)
        blocks = map(Block, each, within, ahead, back)
        return [[next(blocks) for _ in layer] for layer in layers]


class StepSystem:
    """The sparse system ``(leaving + decay) x = rates x + b`` of a chain, for several decays at once.

    Unknowns that lead to each other are a dense system each, all of one size inverted at once; where they are
    too many for that the whole system has sparse factors.

    Args:
        layers: The rates between its unknowns; the diagonal is empty.
        out: By unknown, the rate at which all unknowns are left from there.
        decays: By system and unknown, what is added to that.
    """

    def __init__(self, layers: Layers, out: Floats, decays: Floats) -> None:
        self._layers, self._out = layers, out + decays
        self.many, self.size = self._out.shape
        self._leaving = layers.steps.sums + self._out

    def of(self, some: Ints) -> StepSystem:
        """The systems of some of its decays, which are not inverted again."""
        found = copy(self)
        found._out, found._leaving, found.many = self._out[some], self._leaving[some], len(some)
        if self._layers.largest <= MOST_TOGETHER:
            found._systems = [system[some] for system in self._systems]
        return found

    def solved(self, right: Floats, *, forward: bool = False) -> Floats:
        """The solution for given right sides.

        Args:
            right: By system, unknown, and a free axis; no number is negative.
            forward: Whether the system is the transposed one: of what has been, not of what is to come.

        Raises:
            LimitError: The system is too large to be solved as a dense one, and needs to be.
        """
        if self._layers.largest <= MOST_TOGETHER:
            return self._by_layers(right, forward)
        return self._by_factors(right, forward)

    @cached_property
    def _systems(self) -> list[Eliminated]:
        """By block, in the order of the layers, the systems of components, by decay and component."""
        found, alike = dict[int, Eliminated](), dict[int, list[tuple[int, Block]]]()
        for number, block in enumerate(self._layers.every):
            alike.setdefault(block.members.shape[1], []).append((number, block))
        for size, numbered in alike.items():
            together = max(1, ROOM // (self.many * size * size))
            held = np.cumsum([len(block.members) for _, block in numbered]) // together
            for same in np.unique(held).tolist():
                some = [numbered[i] for i in np.flatnonzero(held == same)]
                begin, system = 0, self._eliminated([block for _, block in some])
                for number, block in some:
                    found[number] = system[:, begin : begin + len(block.members)]
                    begin += len(block.members)
        return [found[number] for number in range(len(found))]

    def _eliminated(self, blocks: Sequence[Block]) -> Eliminated:
        """The systems of blocks of one size, one block's after the other's."""
        members = np.concatenate([block.members for block in blocks])
        beyond = np.concatenate([block.ahead.sums for block in blocks]).reshape(members.shape)
        scale = 1.0 / self._leaving[:, members]
        steps = scale[..., None] * np.concatenate([block.dense for block in blocks])
        return Eliminated(steps, (beyond + self._out[:, members]) * scale)

    def _by_layers(self, right: Floats, forward: bool) -> Floats:
        """The solution, of the layers one after the other; none needs a difference of numbers."""
        given, scale = right.transpose(1, 0, 2), 1.0 / self._leaving.T[..., None]
        found, free = np.zeros(given.shape), (self.many, right.shape[2])
        every = found.reshape(self.size, -1)
        layers = list(zip(self._layers.every, self._systems, strict=True))
        for block, system in reversed(layers) if forward else layers:
            members = block.members.reshape(-1)
            known, coming = given[members], block.back if forward else block.ahead
            if len(coming.rows):
                known += (coming @ every).reshape(-1, *free)
            if not forward:
                known *= scale[members]
            each = known.reshape(*block.members.shape, *free).transpose(2, 0, 1, 3)
            solved = system.solved(each, forward=forward).transpose(1, 2, 0, 3).reshape(known.shape)
            found[members] = solved * scale[members] if forward else solved
        return found.transpose(1, 0, 2)

    @cached_property
    def _solve(self) -> Callable[..., Floats]:
        from mcpn.answers.causes.factors import factors  # an extra

        scale, step = 1.0 / self._leaving.reshape(-1), self._layers.steps
        # One block-diagonal matrix holds all systems, since each call of scipy has a cost of its own.
        block = np.repeat(np.arange(self.many) * self.size, len(step.rows))
        rows, columns = (np.tile(each, self.many) + block for each in (step.rows, step.columns))
        values = np.tile(step.values, self.many) * scale[rows]
        return factors(SparseMatrix(values, rows, columns, (len(scale),) * 2), by_the_diagonal=True)

    def _by_factors(self, right: Floats, forward: bool) -> Floats:
        """The solution, of systems that take too many steps for factors as dense ones."""
        leaving, free = self._leaving[:, :, None], right.shape[2]

        def by_factors(right: Floats) -> Floats:
            flat = right.reshape(-1, free)
            return self._solve(flat, trans="T" if forward else "N").reshape(right.shape)

        found = by_factors(right if forward else right / leaving)
        steps, met = by_factors(found), found > 0
        lengthy = np.any((steps > MOST_STEPS * found) & met, axis=(1, 2))
        for number in np.flatnonzero(lengthy | ~np.all(found >= 0, axis=(1, 2))).tolist():
            found[number] = self._dense(number, right[number], forward=forward)
        return found / leaving if forward else found

    def _dense(self, number: int, right: Floats, *, forward: bool) -> Floats:
        """The solution of one system, as a dense one."""
        if self.size > MOST_DENSE:
            raise LimitError(
                f"{self.size} states are left only after more than {MOST_STEPS:.0f} events, too many to "
                f"compute exactly what comes of them; the limit on such states is {MOST_DENSE}"
            )
        scale = 1.0 / self._leaving[number]
        inverse = resolvent(self._layers.steps.dense * scale[:, None], self._out[number] * scale)
        return np.asarray(inverse.T @ right if forward else inverse @ (right * scale[:, None]))


class LayeredSystem:
    """The sparse system ``x = N x + b``, layer by layer: of what is never come back to, nothing is filled in.

    A layer holds unknowns that lead to each other, and others that have as many such components behind them.
    Each has factors of its own, or where that is less work than to load scipy for it, dense inverses.

    Args:
        steps: ``N``.
        leaving: By row, what it lacks to the sum 1.
    """

    def __init__(self, steps: SparseMatrix, leaving: Floats) -> None:
        layers = Layers(steps)
        work = sum(block.members.size * block.members.shape[1] ** 2 for block in layers.every)
        self._dense = (
            StepSystem(layers, leaving, np.zeros((1, len(leaving)))) if work <= LITTLE_WORK else None
        )
        self._layers, self._solve = list[Ints](), list[Callable[..., Floats]]()
        if self._dense is None:
            from mcpn.answers.causes.factors import factors  # an extra

            self._ahead, self._back = steps, steps.transposed
            self._layers = [np.concatenate([b.members.reshape(-1) for b in layer]) for layer in layers.blocks]
            self._solve = [factors(steps.within(layer)) for layer in self._layers]

    def solved(self, right: Floats, *, forward: bool = False) -> Floats:
        """The solution for a right side.

        Args:
            right: By unknown.
            forward: Whether the system is the transposed one: of what has been, not of what is to come.
        """
        if self._dense is not None:
            return self._dense.solved(right[None, :, None], forward=forward)[0, :, 0]
        found = np.zeros(len(right))
        both = list(zip(self._layers, self._solve, strict=True))
        for layer, solve in reversed(both) if forward else both:
            known = ((self._back if forward else self._ahead) @ found)[layer]
            found[layer] = solve(right[layer] + known, trans="T" if forward else "N")
        return found
