"""The values that documents may hold."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.robot.runtime.shapes import Integer, Misfit, Number


@given(st.none() | st.integers(-3, 3), st.integers(-5, 5))
def test_numbers_are_bounded_from_below(least: int | None, value: int) -> None:
    for shape in (Integer("", least), Number("", least)):
        if least is None or value >= least:
            shape._check(value)
        else:
            with pytest.raises(Misfit, match=f"from {least}"):
                shape._check(value)


def test_an_integer_is_by_default_not_negative() -> None:
    Integer()._check(0)
    for other in (-1, True, 0.0, "1"):
        with pytest.raises(Misfit):
            Integer()._check(other)


@given(st.integers(-3, 3), st.integers(-5, 5) | st.floats(-5, 5))
def test_an_exclusive_bound_is_itself_refused(above: int, value: float) -> None:
    shape = Number("", above=above)
    if value > above:
        shape._check(value)
    else:
        with pytest.raises(Misfit, match=f"greater than {above}"):
            shape._check(value)
