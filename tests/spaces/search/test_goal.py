"""Formulas as keys: hashes are computed once, and what a formula means as a goal is found once."""

from __future__ import annotations

import pickle
from dataclasses import dataclass

import pytest

from mcpn.logic import without_space
from mcpn.logic.formulas import EU
from mcpn.logic.without_space import Known
from mcpn.nets.petri import PetriNet
from mcpn.spaces.search.goal import TRUE, And, Fires, Formula, Goal, Not, Or, as_goal, marked
from mcpn.testing.nets import philosophers

COUNTED: list[Formula] = []


@dataclass(frozen=True, eq=False)
class Leaf(Formula):
    """Notes that its hash was asked for."""

    number: int

    def __hash__(self) -> int:
        COUNTED.append(self)
        return self.number


def test_the_hash_of_an_operator_is_computed_once() -> None:
    leaf = formula = Leaf(1)
    for _ in range(20):
        formula = And(Not(formula), Or(formula, TRUE))  # type: ignore[assignment]
    COUNTED.clear()
    assert {formula: "found"}[formula] == "found"
    assert not COUNTED
    assert hash(Not(leaf)) == hash(Not(leaf))


def test_a_formula_from_another_process_is_the_same_key() -> None:
    formula = EU(TRUE, And(Not(marked(1)), Fires((2,))))
    there = pickle.loads(pickle.dumps(formula))
    assert there == formula
    assert {formula: 1}[there] == 1
    assert "_hash" not in str(pickle.dumps(formula))


def test_the_goal_of_a_part_is_found_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Formula] = []

    def counted(formula: Formula, net: PetriNet, wanted: bool = True) -> Goal | None:
        asked.append(formula)
        return as_goal(formula, net, wanted)

    monkeypatch.setattr(without_space, "as_goal", counted)
    net = philosophers(3)
    known = Known(net, settled=False)
    part = EU(TRUE, Fires((0, 1)))
    assert known.goal(part) == known.goal(part) == as_goal(Fires((0, 1)), net)
    assert asked == [Fires((0, 1))]
