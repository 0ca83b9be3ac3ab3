"""What solves the linear systems of risk: scipy, which only this needs and which is an extra for its size."""

from __future__ import annotations

from mcpn.errors import LimitError

try:
    from scipy.linalg import lu_factor, lu_solve
    from scipy.sparse import csc_array, csr_array
    from scipy.sparse.linalg import LinearOperator, gmres, splu
except ImportError as error:
    raise LimitError("probabilities need scipy: pip install 'mcpn[risk]'") from error

__all__ = ["LinearOperator", "csc_array", "csr_array", "gmres", "lu_factor", "lu_solve", "splu"]
