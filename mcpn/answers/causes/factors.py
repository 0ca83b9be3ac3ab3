"""Sparse factors, by scipy: an extra for its size, which is loaded where unknowns are too many for numpy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mcpn.answers.causes.sparse import Floats, SparseMatrix
from mcpn.errors import LimitError

try:
    from scipy.sparse import csc_array, csr_array, eye_array
    from scipy.sparse.linalg import splu
except ModuleNotFoundError as error:
    raise LimitError("this needs scipy: pip install 'mcpn[risk]'") from error

__all__ = ["csc_array", "csr_array", "factors", "splu"]


def factors(steps: SparseMatrix, *, by_the_diagonal: bool = False) -> Callable[..., Floats]:
    """What solves ``x = N x + b`` for a right side, and with ``trans="T"`` the transposed system.

    Args:
        steps: ``N``.
        by_the_diagonal: Whether no rows are exchanged, so that nothing but the diagonal is subtracted.
    """
    entries = steps.values, (steps.rows, steps.columns)
    matrix = eye_array(steps.shape[0]) - csr_array(entries, shape=steps.shape)
    if by_the_diagonal:
        options = {"SymmetricMode": True}  # each pivot is that of the diagonal
        made = splu(csc_array(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    else:
        made = splu(csc_array(matrix))
    solve: Callable[..., Floats] = made.solve  # its stub does not know of transposing
    return lambda right, trans="N": np.asarray(solve(right, trans=trans))
