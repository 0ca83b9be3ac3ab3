"""What solves the linear systems of risk: scipy, which only this needs and which is an extra for its size."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from mcpn.errors import LimitError

try:
    from scipy.linalg import lu_factor, lu_solve
    from scipy.sparse import csc_array, csr_array
    from scipy.sparse.linalg import LinearOperator, gmres, splu
except ImportError as error:
    raise LimitError("probabilities need scipy: pip install 'mcpn[risk]'") from error

__all__ = ["csc_array", "csr_array", "lu_factor", "lu_solve", "solver_of", "splu"]

Floats = npt.NDArray[np.float64]

CHUNK = 64
"""Right-hand sides of a system that are solved at a time."""

MOST_DENSE = 4096
"""Unknowns of a system that is solved directly; a larger one by iteration."""

PRECISION = 1e-13
"""Of the iteration, relative to the right side."""


def solver_of(system: Callable[[Floats], Floats], size: int) -> Callable[[Floats], Floats]:
    """A solver for any right side of a linear system, by LU factors or by GMRES.

    Args:
        system: Applies the operator of the system to the columns of a matrix.
        size: The number of unknowns.
    """
    if size <= MOST_DENSE:
        parts = np.array_split(np.eye(size), -(-size // CHUNK), axis=1)
        factors = lu_factor(np.hstack([system(part) for part in parts]))
        return lambda right: np.asarray(lu_solve(factors, right), np.float64)
    operator = LinearOperator((size, size), lambda x: system(x.reshape(-1, 1))[:, 0], dtype=np.float64)

    def iterated(right: Floats) -> Floats:
        found = np.empty(right.shape)
        for i, column in enumerate(right.T):
            found[:, i], failed = gmres(operator, column, rtol=PRECISION, atol=0.0, restart=100, maxiter=20)
            if failed:
                raise LimitError(f"the values at {size} entries of sections in loops did not settle")
        return found

    return iterated
