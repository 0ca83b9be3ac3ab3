"""Sparse matrices as their entries, row by row, with numpy alone: scipy takes longer to load than to use."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.intp]


class SparseMatrix:
    """A matrix of which few entries are not 0; several entries at one place count together.

    Args:
        values: Its entries.
        rows: By entry, its row; they are sorted by it.
        columns: By entry, its column.
        shape: How many rows and columns there are.
    """

    def __init__(self, values: Floats, rows: Ints, columns: Ints, shape: tuple[int, int]) -> None:
        if np.any(rows[1:] < rows[:-1]):
            order = np.argsort(rows, kind="stable")
            values, rows, columns = values[order], rows[order], columns[order]
        self.values, self.rows, self.columns, self.shape = values, rows, columns, shape

    @property
    def transposed(self) -> SparseMatrix:
        """The transposed matrix."""
        return SparseMatrix(self.values, self.columns, self.rows, self.shape[::-1])

    @property
    def sums(self) -> Floats:
        """By row, the sum of its entries."""
        return np.bincount(self.rows, self.values, self.shape[0]).astype(np.float64)

    @property
    def dense(self) -> Floats:
        """The matrix with all of its entries."""
        found = np.zeros(self.shape)
        np.add.at(found, (self.rows, self.columns), self.values)
        return found

    def __matmul__(self, right: Floats) -> Floats:
        """The product with a vector, or with a matrix that has all of its entries."""
        if right.ndim == 1:
            products = self.values * right[self.columns]
            return np.bincount(self.rows, products, self.shape[0]).astype(np.float64)
        found = np.zeros((self.shape[0], right.shape[1]))
        if len(self.rows):
            begins = np.flatnonzero(np.diff(self.rows, prepend=-1))
            products = right[self.columns]
            products *= self.values[:, None]
            found[self.rows[begins]] = np.add.reduceat(products, begins)
        return found

    def within(self, some: Ints, others: Ints | None = None) -> SparseMatrix:
        """The rows of some unknowns and the columns of the same, or of others, numbered anew."""
        others = some if others is None else others
        row, column = np.full(self.shape[0], -1), np.full(self.shape[1], -1)
        row[some], column[others] = np.arange(len(some)), np.arange(len(others))
        rows, columns = row[self.rows], column[self.columns]
        kept = np.flatnonzero((rows >= 0) & (columns >= 0))
        return SparseMatrix(self.values[kept], rows[kept], columns[kept], (len(some), len(others)))
