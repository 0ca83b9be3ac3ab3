"""Linear programs in whole numbers, against trying every value."""

from __future__ import annotations

from itertools import product
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.net.programs import Row, minimise

SMALL = st.integers(-3, 3)


@st.composite
def programs(draw: st.DrawFn) -> tuple[list[int], list[Row], list[int], list[int]]:
    """Costs, rows and bounds of up to three variables."""
    count = draw(st.integers(1, 3))
    numbers = st.lists(SMALL, min_size=count, max_size=count)
    rows: list[Row] = []
    for weights in draw(st.lists(numbers, max_size=4)):
        least = draw(st.one_of(st.just(-inf), SMALL.map(float)))
        most = draw(st.one_of(st.just(inf), st.integers(int(max(least, -3)), 6).map(float)))
        rows.append(({v: float(w) for v, w in enumerate(weights) if w}, least, most))
    lower = draw(st.lists(st.integers(-2, 0), min_size=count, max_size=count))
    upper = draw(st.lists(st.integers(0, 2), min_size=count, max_size=count))
    return draw(numbers), rows, lower, upper


@given(programs())
def test_a_program_in_whole_numbers_is_solved_as_by_trying_all(
    program: tuple[list[int], list[Row], list[int], list[int]],
) -> None:
    cost, rows, lower, upper = program
    best = min(
        (
            sum(c * v for c, v in zip(cost, values, strict=True))
            for values in product(*(range(a, b + 1) for a, b in zip(lower, upper, strict=True)))
            if all(least <= sum(w * values[v] for v, w in row.items()) <= most for row, least, most in rows)
        ),
        default=None,
    )
    whole = minimise(cost, rows, lower, upper, whole=range(len(cost)))
    assert whole.kind == ("infeasible" if best is None else "solved")
    if best is not None:
        assert whole.cost == pytest.approx(best, abs=1e-6)
        real = minimise(cost, rows, lower, upper)
        assert real.kind == "solved"
        assert real.cost <= best + 1e-6


def test_what_has_no_least_cost_is_not_solved() -> None:
    assert minimise([-1], [({0: 1}, 0, inf)], [0], [inf]).kind == "unknown"


def test_some_solution_will_do_where_nodes_are_few() -> None:
    found = minimise([1, 1], [({0: 2, 1: 2}, 3, inf)], [0, 0], [5, 5], whole=(0, 1), nodes=100)
    assert found.kind == "solved"
    assert all(value == pytest.approx(round(value)) for value in found.values)
    assert 2 * sum(found.values) >= 3 - 1e-6


def test_the_solver_prints_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    """What commands print on standard output is theirs alone: JSON, often."""
    assert minimise([1.0], [({0: 1.0}, 1.0, 2.0)], [0.0], [5.0]).kind == "solved"
    assert capfd.readouterr() == ("", "")
