"""Dense linear systems of risk, ``x = N x + b``, solved without subtraction, so that every digit is right.

No number is negative in them: ``N`` holds the probabilities of steps between unknowns, what is missing in a
row is the probability to leave them all, and the solution is a sum of products of such numbers. Where each
of these is computed as itself, so is each unknown, however small: to a few roundings *relative to itself*.
A failure of probability 1e-30 is as exact as a success of probability 0.9. What would spoil this is a
difference of nearly equal numbers, and elimination has one, ``1 - N_ii`` on the diagonal. It is the
probability to go anywhere else, so that it can be summed up instead (Grassmann, Taksar, Heyman, Operations
Research 33, 1985; that each entry is accurate is shown by O'Cinneide, Numerische Mathematik 65, 1993).
"""

from __future__ import annotations

from copy import copy

import numpy as np

from mcpn.answers.causes.sparse import Floats, Ints

TOO_SMALL = 32
"""Unknowns of a system that are not taken by halves."""


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
    if size == 2:
        return _of_two(steps[..., 0, 1], steps[..., 1, 0], leaving[..., 0], leaving[..., 1])
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


def _of_two(there: Floats, back: Floats, first: Floats, last: Floats) -> Floats:
    """The same of two unknowns: each step by itself costs as much as these all."""
    before = 1.0 / (first + there)
    around = back * before
    found = np.empty((*before.shape, 2, 2))
    found[..., 1, 1] = after = 1.0 / (last + around * first)
    found[..., 1, 0] = after * around
    found[..., 0, 1] = onward = before * there * after
    found[..., 0, 0] = before + onward * around
    return found


class Eliminated:
    """The system ``(I - N) x = b`` without subtraction, half of the unknowns eliminated after the other.

    It takes less than half the work of its inverse, and what it is applied to as much.

    Args:
        steps: ``N``, as of :func:`resolvent`.
        leaving: By row, what it lacks to the sum 1.
    """

    def __init__(self, steps: Floats, leaving: Floats) -> None:
        self._halves = list[tuple[Floats, Floats, Floats]]()
        while leaving.shape[-1] > TOO_SMALL:
            half = leaving.shape[-1] // 2
            first, last = slice(0, half), slice(half, None)
            there, back = steps[..., first, last], steps[..., last, first]
            before = resolvent(steps[..., first, first], leaving[..., first] + there.sum(axis=-1))
            around = back @ before
            self._halves.append((before, around, there))
            leaving = leaving[..., last] + (around @ leaving[..., first, None])[..., 0]
            steps = steps[..., last, last] + around @ there
        self._last = resolvent(steps, leaving)

    def __getitem__(self, some: Ints | tuple[slice, slice]) -> Eliminated:
        """Some of several systems."""
        found = copy(self)
        found._halves = [(one[some], two[some], three[some]) for one, two, three in self._halves]
        found._last = self._last[some]
        return found

    def solved(self, right: Floats, *, forward: bool = False) -> Floats:
        """The solution for a right side, or that of the transposed system.

        Args:
            right: By system, unknown, and a free axis.
            forward: Whether it is of the transposed system.
        """
        found, begin = right.copy(), 0
        for before, around, there in self._halves:
            half = begin + before.shape[-1]
            first, last = found[..., begin:half, :], found[..., half:, :]
            if forward:
                first[...] = before.swapaxes(-1, -2) @ first
                last += there.swapaxes(-1, -2) @ first
            else:
                last += around @ first
            begin = half
        left = found[..., begin:, :]
        left[...] = (self._last.swapaxes(-1, -2) if forward else self._last) @ left
        for before, around, there in reversed(self._halves):
            half, begin = begin, begin - before.shape[-1]
            first, last = found[..., begin:half, :], found[..., half:, :]
            if forward:
                first += around.swapaxes(-1, -2) @ last
            else:
                first[...] = before @ (first + there @ last)
        return found
