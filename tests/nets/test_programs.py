"""Linear programs and what they prove, against trying every value."""

from __future__ import annotations

from itertools import product
from math import inf

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from mcpn.nets.programs import LinearProgram, Row, ceiling, minimise, proposed

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


@example(([0], [({}, -inf, -1.0)], [0], [0]))
@example(([0, 0], [({}, -inf, 1.0), ({}, 1.0, inf)], [0, 0], [0, 0]))
@given(programs())
def test_no_choice_of_whole_values_beats_a_solution_or_its_proof(
    program: tuple[list[int], list[Row], list[int], list[int]],
) -> None:
    cost, rows, lower, upper = program
    best = min(
        (
            sum(c * v for c, v in zip(cost, values, strict=True))
            for values in product(*(range(a, b + 1) for a, b in zip(lower, upper, strict=True)))
            if all(least <= sum(w * values[v] for v, w in row.items()) <= most for row, least, most in rows)
        ),
        default=inf,
    )
    found = LinearProgram(cost, rows, lower, upper, presolve="off").minimise()
    whole = [({v: int(w) for v, w in row.items()}, least, most) for row, least, most in rows]
    if found.kind == "infeasible":
        assert best == inf
        bounds = [
            ceiling({}, whole, lower, upper, multipliers, common)
            for sign in (1, -1)
            for multipliers, common in proposed([sign * value for value in found.duals])
        ]
        assert min(bounds) < 0
        return
    assert found.kind == "solved"
    assert found.cost <= best + 1e-6
    gain = {v: -c for v, c in enumerate(cost) if c}
    bounds = [ceiling(gain, whole, lower, upper, *pair) for pair in proposed(found.duals)]
    assert float(-min(bounds)) == pytest.approx(found.cost, abs=1e-6)
    assert all(-bound <= best for bound in bounds)


@given(programs(), st.data())
def test_whatever_the_multipliers_are_no_values_exceed_the_ceiling(
    program: tuple[list[int], list[Row], list[int], list[int]], data: st.DataObject
) -> None:
    weights, rows, lower, upper = program
    whole = [({v: int(w) for v, w in row.items()}, least, most) for row, least, most in rows]
    multipliers = data.draw(st.lists(SMALL, min_size=len(rows), max_size=len(rows)))
    bound = ceiling(dict(enumerate(weights)), whole, lower, upper, multipliers)
    for values in product(*(range(a, b + 1) for a, b in zip(lower, upper, strict=True))):
        if all(least <= sum(w * values[v] for v, w in row.items()) <= most for row, least, most in rows):
            assert sum(w * v for w, v in zip(weights, values, strict=True)) <= bound


def test_what_has_no_least_cost_is_not_solved() -> None:
    assert minimise([-1], [({0: 1}, 0, inf)], [0], [inf]).kind == "unknown"


def test_a_program_is_solved_again_after_it_was_changed() -> None:
    program = LinearProgram([1, 1], [({0: 2, 1: 1}, 3, inf)], [0, 0], [1, 5])
    assert program.minimise().cost == 2
    program.price({0: 3})
    assert program.minimise().cost == 3
    program.limit({1: (0, 2)})
    assert program.minimise().cost == pytest.approx(3.5)
    program.require(({0: 1}, 1, inf))
    assert program.minimise().cost == pytest.approx(4)
    program.limit({0: (0, 0.5)})
    assert program.minimise().kind == "infeasible"
