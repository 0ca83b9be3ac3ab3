"""Formulas and sentences of failure."""

from __future__ import annotations

import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.errors import LimitError
from mcpn.report import causes
from mcpn.report.causes import condition, minimal_formula

NAMES = ["GPS", "IMU", "_odd", "camera", "thruster"]


def test_sentences() -> None:
    assert condition("x", [("A",), ("B", "C", "D")]) == "x fails if A, or if B, C and D"
    assert condition("x", [()]) == "x can never succeed"


def test_the_formula_of_ulysse() -> None:
    found = minimal_formula([("thruster",), ("GPS", "IMU"), ("GPS", "IMU", "thruster")])
    assert found == "thruster | GPS & IMU"


@given(st.sets(st.frozensets(st.sampled_from(NAMES)), max_size=8))
def test_espresso_finds_the_minimal_solutions(products: set[frozenset[str]]) -> None:
    minimal = {s for s in products if not any(t < s for t in products)}
    found = minimal_formula([tuple(sorted(s)) for s in products])
    if minimal <= {frozenset[str]()}:
        assert found == ("1" if minimal else "0")
    else:
        assert {frozenset(term.split(" & ")) for term in found.split(" | ")} == minimal


def test_without_pyeda_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyeda.boolalg.expr", None)
    with pytest.raises(LimitError, match=r'pip install "mcpn\[pyeda\]"'):
        minimal_formula([("A",)])


def test_formulas_of_any_size_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(causes, "MAX_TERMS", 2)
    assert minimal_formula([("A",), ("B",)]) == "A | B"
    with pytest.raises(LimitError, match="3 products: more than 2, the limit on products"):
        minimal_formula([("A",), ("B",), ("C",)])
