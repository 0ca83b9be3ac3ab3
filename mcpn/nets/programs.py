"""Linear programs over places and transitions, solved by HiGHS, and what their solutions prove exactly.

Q. Huangfu, J. A. J. Hall, *Parallelizing the dual revised simplex method*, Mathematical Programming
Computation 10, 2018. The solver rounds: what it proposes proves nothing until :func:`ceiling` has
checked it in whole numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import inf, isinf, lcm
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from fractions import Fraction

Row: TypeAlias = tuple[Mapping[int, float], float, float]
"""Weights by variable, and the least and the most that their sum may be."""


class Solved(NamedTuple):
    """What the solver says of a program.

    Args:
        kind: It has a solution, it has none, or neither was found, as where the cost has no least value.
        values: The best solution found, by variable; empty where there is none.
        cost: What that one costs.
        duals: By row, a proposal for :func:`ceiling`: prices at the best solution, or a ray where there is
            no solution. Empty where variables are whole, and there is one.
    """

    kind: Literal["solved", "infeasible", "unknown"]
    values: tuple[float, ...] = ()
    cost: float = inf
    duals: tuple[float, ...] = ()


class LinearProgram:
    """A linear program that can be changed and solved again, from where the solver left it.

    Args:
        cost: Of one unit of each variable.
        rows: What the values must satisfy.
        lower: The least value of each variable.
        upper: The greatest value of each.
        options: Of the solver.
    """

    def __init__(
        self,
        cost: Sequence[float],
        rows: Sequence[Row],
        lower: Sequence[float],
        upper: Sequence[float],
        **options: float | str,
    ) -> None:
        import numpy as np
        from highspy import HighsLp, MatrixFormat

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
        program.a_matrix_.value_ = np.array(
            [w for weights, _, _ in rows for w in weights.values()], np.float64
        )
        self._begin(program, options)

    def _begin(self, program: Any, options: Mapping[str, float | str]) -> None:
        from highspy import Highs

        # The class below Highs has no callbacks: as it makes them, Highs 1.16 prints its name.
        self._solver = Highs.__mro__[1]()
        self._options = options
        for option, value in {"output_flag": False, "threads": 1, **options}.items():
            self._solver.setOptionValue(option, value)
        self._solver.passModel(program)

    def extended(self, bounds: Sequence[tuple[float, float]], rows: Iterable[Row]) -> LinearProgram:
        """A program with more variables, of these bounds, and more rows, which is solved on its own."""
        other = object.__new__(LinearProgram)
        other._begin(self._solver.getLp(), self._options)
        for low, high in bounds:
            other._solver.addVar(low, high)
        for row in rows:
            other.require(row)
        return other

    def price(self, costs: Mapping[int, float]) -> None:
        """Changes the cost of some variables."""
        self._solver.changeColsCost(len(costs), _indices(costs), _numbers(costs.values()))

    def limit(self, bounds: Mapping[int, tuple[float, float]]) -> None:
        """Changes the least and the greatest value of some variables."""
        lower, upper = (_numbers(pair[side] for pair in bounds.values()) for side in (0, 1))
        self._solver.changeColsBounds(len(bounds), _indices(bounds), lower, upper)

    def require(self, row: Row) -> None:
        """Adds a row."""
        weights, least, most = row
        self._solver.addRow(least, most, len(weights), _indices(weights), _numbers(weights.values()))

    def minimise(self) -> Solved:
        """Looks for the cheapest values."""
        from highspy import HighsModelStatus, SolutionStatus

        solver = self._solver
        solver.run()
        status, info = solver.getModelStatus(), solver.getInfo()
        if status == HighsModelStatus.kInfeasible:
            _, known, ray = solver.getDualRay()
            return Solved("infeasible", duals=tuple(ray) if known else self._without_values())
        if (
            status == HighsModelStatus.kUnbounded
            or info.primal_solution_status != SolutionStatus.kSolutionStatusFeasible
        ):
            return Solved("unknown")
        solution = solver.getSolution()
        return Solved(
            "solved", tuple(solution.col_value), info.objective_function_value, tuple(solution.row_dual)
        )

    def _without_values(self) -> tuple[float, ...]:
        """What the solver proposes nothing for: rows that no sum of nothing satisfies."""
        rows = self._solver.getLp()
        pairs = zip(rows.row_lower_, rows.row_upper_, strict=True)
        return tuple(float(least > 0) - float(most < 0) for least, most in pairs)


def _indices(keys: Iterable[int]) -> Any:
    import numpy as np

    return np.fromiter(keys, np.int32)


def _numbers(values: Iterable[float]) -> Any:
    import numpy as np

    return np.fromiter(values, np.float64)


def minimise(
    cost: Sequence[float], rows: Sequence[Row], lower: Sequence[float], upper: Sequence[float]
) -> Solved:
    """Looks for the cheapest values of variables.

    Args:
        cost: Of one unit of each variable.
        rows: What the values must satisfy.
        lower: The least value of each variable.
        upper: The greatest value of each.

    Returns:
        The answer; unknown where a number is larger than any float.

    >>> found = minimise([1, 1], [({0: 2, 1: 1}, 3, inf)], [0, 0], [1, 5])
    >>> found.kind, found.values, found.cost
    ('solved', (1.0, 1.0), 2.0)
    >>> minimise([1, 1], [({0: 2, 1: 1}, 8, inf)], [0, 0], [1, 5]).kind
    'infeasible'
    """
    try:
        return LinearProgram(cost, rows, lower, upper).minimise()
    except OverflowError:  # nets read from JSON may have numbers of thousands of digits
        return Solved("unknown")


DENOMINATORS = (1, 12, 1_000, 1_000_000)
"""How finely a proposal of the solver is rounded, one after the other, until it proves something."""


def proposed(duals: Sequence[float]) -> Iterator[tuple[list[int], int]]:
    """Whole numbers and a common denominator that may be meant by what the solver has rounded."""
    from fractions import Fraction

    for most in DENOMINATORS:
        fractions = {r: Fraction(value).limit_denominator(most) for r, value in enumerate(duals) if value}
        common = lcm(*(f.denominator for f in fractions.values()))
        whole = [0] * len(duals)
        for r, fraction in fractions.items():
            whole[r] = int(fraction * common)
        yield whole, common


def ceiling(
    weights: Mapping[int, int],
    rows: Sequence[tuple[Mapping[int, int], float, float]],
    lower: Sequence[float],
    upper: Sequence[float],
    multipliers: Sequence[int],
    common: int = 1,
) -> float | Fraction:
    """What a weighted sum cannot exceed, by weak duality, in exact arithmetic, whatever the multipliers are.

    Each row times its multiplier is added to the sum, and the most that this can come to within the bounds of
    the variables is less by what the rows come to at least.

    Args:
        weights: By variable.
        rows: Whole weights by variable, and the least and the most that their sum may be.
        lower: The least value of each variable.
        upper: The greatest value of each.
        multipliers: By row.
        common: Their denominator.

    Returns:
        The bound; infinite where the multipliers prove none. Where a bound of the sum without weights is
        negative, the rows have no solution.

    >>> ceiling({0: 1}, [({0: 2, 1: 1}, -inf, 3)], [0, 0], [inf, inf], [-1], 2)
    Fraction(3, 2)
    """
    from fractions import Fraction

    total = {variable: common * weight for variable, weight in weights.items()}
    bound: int | Fraction = 0
    for multiplier, (row, least, most) in zip(multipliers, rows, strict=True):
        if multiplier:
            end = least if multiplier > 0 else most
            if isinf(end):
                return inf
            bound -= multiplier * int(end)
            for variable, weight in row.items():
                total[variable] = total.get(variable, 0) + multiplier * weight
    for variable, weight in total.items():
        if weight:
            end = upper[variable] if weight > 0 else lower[variable]
            if isinf(end):
                return inf
            bound += weight * int(end)
    return Fraction(bound, common)
