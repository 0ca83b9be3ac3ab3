"""Linear programs over places and transitions, in numbers or in whole numbers, solved by HiGHS.

Q. Huangfu, J. A. J. Hall, *Parallelizing the dual revised simplex method*, Mathematical Programming
Computation 10, 2018. Solutions are rounded as the solver rounds: who needs exactness checks them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Literal, TypeAlias

Row: TypeAlias = tuple[Mapping[int, float], float, float]
"""Weights by variable, and the least and the most that their sum may be."""


@dataclass(frozen=True)
class Solved:
    """What the solver says of a program.

    Args:
        kind: It has a solution, it has none, or neither was found, as where the cost has no least value.
        values: The best solution found, by variable; empty where there is none.
        cost: What that one costs.
    """

    kind: Literal["solved", "infeasible", "unknown"]
    values: tuple[float, ...] = ()
    cost: float = inf


def minimise(
    cost: Sequence[float],
    rows: Sequence[Row],
    lower: Sequence[float],
    upper: Sequence[float],
    whole: Collection[int] = (),
    nodes: int | None = None,
) -> Solved:
    """Looks for the cheapest values of variables.

    Args:
        cost: Of one unit of each variable.
        rows: What the values must satisfy.
        lower: The least value of each variable.
        upper: The greatest value of each.
        whole: Variables that are whole numbers.
        nodes: Where given, any solution will do, and branch and bound visits at most so many nodes.

    Returns:
        The answer.

    >>> minimise([1, 1], [({0: 2, 1: 1}, 3, inf)], [0, 0], [1, 5])
    Solved(kind='solved', values=(1.0, 1.0), cost=2.0)
    >>> minimise([1, 1], [({0: 2, 1: 1}, 8, inf)], [0, 0], [1, 5])
    Solved(kind='infeasible', values=(), cost=inf)
    """
    import numpy as np
    from highspy import Highs, HighsLp, HighsModelStatus, HighsVarType, MatrixFormat, SolutionStatus

    program = HighsLp()
    program.num_col_, program.num_row_ = len(cost), len(rows)
    program.col_cost_ = np.array(cost, np.float64)
    program.col_lower_ = np.array(lower, np.float64)
    program.col_upper_ = np.array(upper, np.float64)
    program.row_lower_ = np.array([least for _, least, _ in rows], np.float64)
    program.row_upper_ = np.array([most for _, _, most in rows], np.float64)
    program.a_matrix_.format_ = MatrixFormat.kRowwise
    program.a_matrix_.start_ = np.cumsum([0, *(len(weights) for weights, _, _ in rows)], dtype=np.int32)
    program.a_matrix_.index_ = np.array([v for weights, _, _ in rows for v in weights], np.int32)
    program.a_matrix_.value_ = np.array([w for weights, _, _ in rows for w in weights.values()], np.float64)
    if whole:
        wanted = frozenset(whole)
        kinds = HighsVarType.kContinuous, HighsVarType.kInteger
        program.integrality_ = [kinds[v in wanted] for v in range(len(cost))]
    # The class below Highs has no callbacks: as it makes them, Highs 1.16 prints its name on standard output.
    solver = Highs.__mro__[1]()
    solver.setOptionValue("output_flag", False)
    solver.setOptionValue("threads", 1)
    if nodes is not None:
        solver.setOptionValue("mip_max_nodes", nodes)
        solver.setOptionValue("mip_rel_gap", 1e6)
    solver.passModel(program)
    solver.run()
    status, info = solver.getModelStatus(), solver.getInfo()
    if status == HighsModelStatus.kInfeasible:
        return Solved("infeasible")
    if (
        status == HighsModelStatus.kUnbounded
        or info.primal_solution_status != SolutionStatus.kSolutionStatusFeasible
    ):
        return Solved("unknown")
    return Solved("solved", tuple(solver.getSolution().col_value), info.objective_function_value)
