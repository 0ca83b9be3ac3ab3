"""certcheck evaluates drawn formulas of CTL* on drawn nets as mcpn's logic does."""

from __future__ import annotations

from random import Random
from types import ModuleType
from typing import Any

import pytest

from mcpn.certificates import certcheck
from mcpn.errors import ConfluenceError, DivergenceError, UnsafeError
from tests.certificates.test_mutants import script
from tests.certificates.test_orders import drawn

__all__ = ["script"]
ARITY = {"not": 1, "X": 1, "EX": 1, "EG": 1, "E": 1, "U": 2, "R": 2, "EU": 2, "and": 2, "or": 2}


def formula(draw: Random, events: list[list[str]], depth: int, paths: bool = False) -> list[Any]:
    """A formula on the states of a net, or on paths."""
    if not depth:
        match draw.choice(["at most", "at most", "fires", "deadlock", "happens" if paths else "fires"]):
            case "at most":
                return ["at most", 0, [[draw.randrange(4), 1]]]
            case "deadlock":
                return ["deadlock"]
            case word:
                return [word, *draw.sample(events, draw.randint(0, min(2, len(events))))]
    operators = ["not", "and", "or", *(["X", "U", "R", "U", "R"] if paths else ["E", "E", "EX", "EU", "EG"])]
    operator = draw.choice(operators)
    inside = paths or operator == "E"
    return [operator, *(formula(draw, events, depth - 1, inside) for _ in range(ARITY[operator]))]


@pytest.mark.parametrize("count", [30, pytest.param(20_000, marks=pytest.mark.slow)])
def test_drawn_formulas(script: ModuleType, fresh_seed: int, count: int) -> None:
    said = set[bool]()
    for number in range(count):
        draw = Random(f"{fresh_seed} {number}")
        net: dict[str, Any] = drawn(draw)
        for t in net["transitions"]:
            if draw.random() < 0.5:
                t.update(event=["declared", t["name"]], rank=0)
        try:
            truth = script.Truth(net)
        except (UnsafeError, ConfluenceError, DivergenceError):
            continue
        formulas = certcheck.Listing(certcheck.Net(net), 20_000, float("inf")).formulas
        for _ in range(6):
            form = formula(draw, [t["event"] for t in net["transitions"] if t["event"]], draw.randint(2, 3))
            expected = truth.evaluation.holds(truth.formula(form))
            assert formulas.at_first(formulas.read(form)) == expected, f"net {number} of --seed {fresh_seed}"
            assert (0 in formulas.states(formulas.read(form))) == expected, f"--seed {fresh_seed}: {form}"
            said.add(expected)
    assert said == {False, True}
