"""Linear systems of risk, ``x = N x + b``, solved without subtraction: dense, by factors, by iteration.

No number is negative in them: ``N`` holds the probabilities of steps between unknowns, what is missing in a
row is the probability to leave them all, and the solution is a sum of products of such numbers. Where each
of these is computed as itself, so is each unknown, however small: to a few roundings *relative to itself*.
A failure of probability 1e-30 is as exact as a success of probability 0.9. What would spoil this is a
difference of nearly equal numbers, and elimination has one, ``1 - N_ii`` on the diagonal. It is the
probability to go anywhere else, so that it can be summed up instead (Grassmann, Taksar, Heyman, Operations
Research 33, 1985; that each entry is accurate is shown by O'Cinneide, Numerische Mathematik 65, 1993).

Dense systems are solved so, and sparse ones of chains too, one component of unknowns that lead to each other
after the other: from one to the next there are products alone. Where components are large, all have scipy's
factors, without an exchange of rows, so that nothing but the diagonal is subtracted. What that costs is at
most the rounding times the number of steps that are expected on the way to what is asked for (the
componentwise condition of Skeel, Journal of the ACM 26, 1979, which of such a matrix is one more system).
That number is computed with each solution, and where it is too large the system is solved as a dense one.

scipy is an extra for its size; only this needs it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from mcpn.errors import LimitError
from mcpn.spaces.components import strongly_connected

try:
    from scipy.sparse import csc_array, csr_array, eye_array
    from scipy.sparse.linalg import splu
except ModuleNotFoundError as error:
    raise LimitError("probabilities need scipy: pip install 'mcpn[risk]'") from error

__all__ = [
    "LayeredSystem",
    "Layers",
    "StepSystem",
    "csc_array",
    "csr_array",
    "resolvent",
    "solver_of",
    "splu",
]

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.intp]

CHUNK = 64
"""Right-hand sides of a system that are solved at a time."""

MOST_DENSE = 4096
"""Unknowns of a system that is solved directly where it is dense; a larger one by iteration."""

MOST_TOGETHER = 1024
"""Unknowns that lead to each other which are solved as a dense system, whichever of their steps are none."""

A_STEP = 1e-15
"""What one step costs of an unknown, relative to it: some ten roundings of 1.1e-16."""

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


def resolvent(steps: Floats, leaving: Floats) -> Floats:
    """The inverse of ``I - N`` without subtraction, each entry accurate relative to itself.

    Args:
        steps: The matrix ``N``, no entry of which is negative, or several. Its diagonal is not looked at.
        leaving: By row, what it lacks to the sum 1. From each row steps lead to one where that is not 0.

    Returns:
        The inverse: by unknown and right side, how often the one is expected to reach the other.
    """
    size = leaving.shape[-1]
    if size == 1:
        return np.asarray(1.0 / leaving[..., None])
    first, last = slice(0, size // 2), slice(size // 2, size)
    there, back = steps[..., first, last], steps[..., last, first]
    before = resolvent(steps[..., first, first], leaving[..., first] + there.sum(axis=-1))
    around = back @ before
    left = (around @ leaving[..., first, None])[..., 0]
    after = resolvent(steps[..., last, last] + around @ there, leaving[..., last] + left)
    found = np.empty((*leaving.shape, size))
    found[..., last, last] = after
    found[..., last, first] = after @ around
    found[..., first, last] = before @ there @ after
    found[..., first, first] = before + found[..., first, last] @ around
    return found


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


class Layers:
    """Unknowns of sparse systems, layer by layer: those of a layer lead to each other, or to earlier layers.

    Args:
        steps: Which unknowns lead to which.

    Attributes:
        blocks: By layer, by size, the components of unknowns that lead to each other: one a row.
        largest: How many unknowns lead to each other, at most.
    """

    def __init__(self, steps: csr_array) -> None:
        rows = [row.tolist() for row in np.split(steps.indices, steps.indptr[1:-1])][: steps.shape[0]]
        height, layers = [-1] * len(rows), list[dict[int, list[list[int]]]]()
        for component in strongly_connected(rows):
            above = 1 + max((height[target] for i in component for target in rows[i]), default=-1)
            for i in component:
                height[i] = above
            layers += [{} for _ in range(above + 1 - len(layers))]
            layers[above].setdefault(len(component), []).append(component)
        self.blocks: list[list[Ints]] = [[np.array(each) for each in layer.values()] for layer in layers]
        self.largest = max((block.shape[1] for layer in self.blocks for block in layer), default=0)


class StepSystem:
    """The sparse system ``(leaving + decay) x = rates x + b`` of a chain, for several decays at once.

    Unknowns that lead to each other are a dense system each, all of one size inverted at once; where they are
    too many for that the whole system has sparse factors.

    Args:
        rates: Between its unknowns; the diagonal is empty.
        out: By unknown, the rate at which all unknowns are left from there.
        decays: By system and unknown, what is added to that.
        layers: Of its unknowns, where they are known.
    """

    def __init__(self, rates: csr_array, out: Floats, decays: Floats, layers: Layers | None = None) -> None:
        self._rates, self._out = rates, out + decays
        self.many, self.size = self._out.shape
        self._leaving = rates.sum(axis=1) + self._out
        self._layers = Layers(rates) if layers is None else layers
        if self._layers.largest <= MOST_TOGETHER:
            self._inverses = self._inverted()
        else:
            self._solve = self._factored()

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

    def _inverted(self) -> dict[int, Floats]:
        """By size, the inverses of components, by system and component, in the order of the layers."""
        sizes, found = dict[int, list[Ints]](), dict[int, Floats]()
        for layer in self._layers.blocks:
            for block in layer:
                sizes.setdefault(block.shape[1], []).append(block)
        for size, blocks in sizes.items():
            members = np.concatenate(blocks)
            place = np.full(self.size, -1)
            place[members.reshape(-1)] = np.arange(members.size)
            step = self._rates[members.reshape(-1)].tocoo()
            at = place[step.col]
            inside = at // size == step.row // size  # -1 is of no component
            steps = np.zeros((len(members), size, size))
            steps[step.row[inside] // size, step.row[inside] % size, at[inside] % size] = step.data[inside]
            beyond = np.bincount(step.row[~inside], step.data[~inside], members.size).reshape(members.shape)
            scale = 1.0 / self._leaving[:, members]
            found[size] = resolvent(steps * scale[..., None], (beyond + self._out[:, members]) * scale)
        return found

    def _by_layers(self, right: Floats, forward: bool) -> Floats:
        """The solution, of the layers one after the other; none needs a difference of numbers."""
        given, scale = right.transpose(1, 0, 2), 1.0 / self._leaving.T[..., None]
        found, free = np.zeros(given.shape), (self.many, right.shape[2])
        at = dict.fromkeys(self._inverses, 0)
        ways, layers = (self._rates.T.tocsr() if forward else self._rates), list[tuple[Ints, Floats]]()
        for layer in self._layers.blocks:
            for block in layer:
                count, size = block.shape
                layers.append((block, self._inverses[size][:, at[size] : at[size] + count]))
                at[size] += count
        for block, inverse in reversed(layers) if forward else layers:
            members = block.reshape(-1)
            known = given[members] + (ways[members] @ found.reshape(self.size, -1)).reshape(-1, *free)
            if not forward:
                known *= scale[members]
            each = known.reshape(*block.shape, *free).transpose(2, 0, 1, 3)
            solved = (inverse.swapaxes(-1, -2) if forward else inverse) @ each
            solved = solved.transpose(1, 2, 0, 3).reshape(known.shape)
            found[members] = solved * scale[members] if forward else solved
        return found.transpose(1, 0, 2)

    def _factored(self) -> Callable[..., Floats]:
        scale, step = 1.0 / self._leaving.reshape(-1), self._rates.tocoo()
        # One block-diagonal matrix holds all systems, since each call of scipy has a cost of its own.
        number, block = np.arange(len(scale)), np.repeat(np.arange(self.many) * self.size, step.nnz)
        rows, columns = (np.tile(indices, self.many) + block for indices in (step.row, step.col))
        values = np.concatenate([np.ones(len(scale)), -np.tile(step.data, self.many) * scale[rows]])
        ends = np.concatenate([number, rows]), np.concatenate([number, columns])
        matrix = csc_array((values, ends), shape=(len(scale),) * 2)
        options = {"SymmetricMode": True}  # each pivot is that of the diagonal
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        solve: Callable[..., Floats] = factors.solve  # its stub does not know of transposing
        return solve

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
        inverse = resolvent(self._rates.toarray() * scale[:, None], self._out[number] * scale)
        return np.asarray(inverse.T @ right if forward else inverse @ (right * scale[:, None]))


class LayeredSystem:
    """The sparse system ``x = N x + b``, layer by layer: of what is never come back to, nothing is filled in.

    A layer holds unknowns that lead to each other, and others that have as many such components behind them.
    Each has factors of its own.

    Args:
        steps: ``N``.
    """

    def __init__(self, steps: csr_array) -> None:
        blocks = Layers(steps).blocks
        self._layers = [np.concatenate([block.reshape(-1) for block in layer]) for layer in blocks]
        self._ahead, self._back = steps, csr_array(steps.T)
        self._solve: list[Callable[..., Floats]] = [  # whose stub does not know of transposing
            splu(csc_array(eye_array(len(layer)) - steps[layer][:, layer])).solve for layer in self._layers
        ]

    def solved(self, right: Floats, *, forward: bool = False) -> Floats:
        """The solution for a right side.

        Args:
            right: By unknown.
            forward: Whether the system is the transposed one: of what has been, not of what is to come.
        """
        found = np.zeros(len(right))
        both = list(zip(self._layers, self._solve, strict=True))
        for layer, solve in reversed(both) if forward else both:
            known = (self._back if forward else self._ahead)[layer] @ found
            found[layer] = solve(right[layer] + known, trans="T" if forward else "N")
        return found
