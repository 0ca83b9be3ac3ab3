"""Structure against definitions: linear algebra over fractions, and every reachable marking."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import inf
from pathlib import Path

import pytest
from hypothesis import given

from mcpn.nets import structure
from mcpn.nets.formats import read_net
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.nets.structure import (
    complements,
    conflicts,
    incidence,
    invariants,
    place_bounds,
    state_machine_units,
)
from mcpn.testing.nets import philosophers
from tests.nets.nets import nets, pt_nets, state_machines


def dense(net: PetriNet) -> list[list[int]]:
    """The incidence matrix by firing: places by transitions."""
    plenty = tuple([1000] * len(net.places))
    changes = [net.fire(plenty, t) for t in range(len(net.transitions))]
    return [[after[p] - 1000 for after in changes] for p in range(len(net.places))]


def rank(matrix: list[list[int]]) -> int:
    rows = [[Fraction(value) for value in row] for row in matrix]
    found = 0
    for column in range(len(rows[0]) if rows else 0):
        pivot = next((r for r in range(found, len(rows)) if rows[r][column]), None)
        if pivot is None:
            continue
        rows[found], rows[pivot] = rows[pivot], rows[found]
        for r in range(found + 1, len(rows)):
            factor = rows[r][column] / rows[found][column]
            rows[r] = [x - factor * y for x, y in zip(rows[r], rows[found], strict=True)]
        found += 1
    return found


@given(pt_nets())
def test_incidence_is_what_firing_changes(net: PetriNet) -> None:
    shown = [[row.get(t, 0) for t in range(len(net.transitions))] for row in incidence(net)]
    assert shown == dense(net)
    assert all(change for row in incidence(net) for change in row.values())


@given(pt_nets())
def test_invariants_are_a_basis_of_the_left_kernel(net: PetriNet) -> None:
    matrix, basis = dense(net), invariants(net)
    for vector in basis:
        for t in range(len(net.transitions)):
            assert sum(weight * matrix[p][t] for p, weight in vector.items()) == 0
    vectors = [[vector.get(p, 0) for p in range(len(net.places))] for vector in basis]
    assert len(basis) == len(net.places) - rank(matrix) == rank(vectors)


def test_invariants_are_exact_where_weights_are_large() -> None:
    builder = NetBuilder("n")
    weight = 10**17 + 3
    for number in range(30):
        builder.place(f"p{number}")
    for number in range(29):
        builder.transition(
            f"t{number}", consume={f"p{number}": weight}, produce={f"p{number + 1}": weight - 1}
        )
    (vector,) = invariants(builder.build())
    assert vector[0] == (weight - 1) ** 29
    assert vector[29] == weight**29


@given(pt_nets())
def test_complements_are_what_their_definition_says(net: PetriNet) -> None:
    matrix = dense(net)
    expected = tuple(
        (p, q)
        for p in range(len(net.places))
        for q in range(p + 1, len(net.places))
        if any(matrix[p])
        and all(a == -b for a, b in zip(matrix[p], matrix[q], strict=True))
        and net.places[p].initial + net.places[q].initial == 1
    )
    assert complements(net) == expected


def test_complements_of_a_switch() -> None:
    builder = NetBuilder("n")
    for place, tokens in (("on", 0), ("off", 1), ("idle", 0), ("used", 1)):
        builder.place(place, initial=tokens)
    builder.transition("a", consume=["off"], produce=["on"], read=["used"])
    builder.transition("b", consume=["on", "used"], produce=["off", "used"])
    assert complements(builder.build()) == ((0, 1),)


@given(pt_nets())
def test_units_hold_one_token_by_definition(net: PetriNet) -> None:
    matrix, before = dense(net), set[int]()
    for unit in state_machine_units(net):
        assert sum(net.places[p].initial for p in unit) == 1
        assert [sum(matrix[p][t] for p in unit) for t in range(len(net.transitions))] == [0] * len(
            net.transitions
        )
        assert list(unit) == sorted(set(unit))
        assert not before.issuperset(unit)
        before.update(unit)


@given(state_machines())
def test_units_cover_nets_made_of_state_machines(made: tuple[PetriNet, int]) -> None:
    net, machines = made
    units = state_machine_units(net)
    assert set().union(*units) == set(range(len(net.places)))
    assert len(units) >= machines


@given(nets())
def test_declared_units_are_believed_only_where_they_hold(net: PetriNet) -> None:
    everything = tuple(range(len(net.places)))
    declared = replace(net, units=(everything, ()))
    holds = sum(net.initial) == 1 and not any(map(sum, zip(*dense(net), strict=True)))
    assert (everything in state_machine_units(declared)) == holds


def test_the_search_for_units_takes_wrong_choices_back() -> None:
    # From a, both b and c balance the first transition; b looks better (fewer arcs) and is a dead end.
    builder = NetBuilder("n")
    for place, tokens in (("a", 1), ("b", 0), ("c", 0), ("d", 0)):
        builder.place(place, initial=tokens)
    builder.transition("split", consume=["a"], produce=["b", "c"])
    builder.transition("lose", consume=["b"])
    builder.transition("go", consume=["c"], produce=["d"])
    builder.transition("back", consume=["d"], produce=["a"])
    assert state_machine_units(builder.build()) == ((0, 2, 3),)


def test_no_unit_where_nothing_is_kept() -> None:
    builder = NetBuilder("n")
    builder.place("p", initial=1)
    builder.place("two", initial=2)
    builder.place("never")
    builder.place("always", initial=1)
    builder.transition("lose", consume=["p"], read=["always"])
    assert state_machine_units(builder.build()) == ((3,),)


@given(nets())
def test_conflicts_are_what_their_definition_says(net: PetriNet) -> None:
    safe, numbers = net.safe_transitions, range(len(net.transitions))
    expected = tuple(
        (t, u)
        for t in numbers
        for u in numbers
        if t < u
        and (
            {*safe[t].consume} & {*safe[u].consume, *safe[u].read}
            or {*safe[u].consume} & {*safe[t].consume, *safe[t].read}
        )
    )
    assert conflicts(net, numbers) == expected
    assert conflicts(net, [t for t in numbers if t % 2]) == tuple(
        pair for pair in expected if all(t % 2 for t in pair)
    )


@given(nets())
def test_transitions_without_conflict_leave_each_other_enabled(net: PetriNet) -> None:
    numbers = range(len(net.transitions))
    in_conflict = set(conflicts(net, numbers))
    for bits in range(1 << len(net.places)):
        marking = tuple(bits >> p & 1 for p in range(len(net.places)))
        enabled = [t for t in numbers if net.covers(marking, t)]
        for t in enabled:
            for u in enabled:
                if t != u and (min(t, u), max(t, u)) not in in_conflict:
                    assert net.covers(net.fire(marking, t), u)


# Covered places by hand count of the machines in these nets: each philosopher and each fork is one machine;
# Dekker has two machines a process (Murata's definition applied to the published nets).
@pytest.mark.parametrize(
    ("model", "units"), [("Philosophers-PT-000500", 1000), ("Dekker-PT-050", 100), ("TokenRing-PT-005", 6)]
)
def test_units_cover_large_nets_without_hints(mcc: Path, model: str, units: int) -> None:
    net = replace(read_net(mcc / model / "model.pnml"), units=())
    found = state_machine_units(net)
    assert len(found) == units
    assert set().union(*found) == set(range(len(net.places)))


def test_invariants_of_large_nets(mcc: Path) -> None:
    net = read_net(mcc / "Philosophers-PT-000500" / "model.pnml")
    rows, basis = incidence(net), invariants(net)
    for vector in basis:
        total: dict[int, int] = {}
        for p, weight in vector.items():
            for t, change in rows[p].items():
                total[t] = total.get(t, 0) + weight * change
        assert not any(total.values())
    assert len(basis) == 1000  # 500 philosophers, 500 forks


def test_no_unit_is_sought_for_a_place_that_an_invariant_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    grown, plain = list[int](), structure._UnitSearch.grow

    def grow(self: structure._UnitSearch, seed: int, steps: int) -> int:
        grown.append(seed)
        return plain(self, seed, steps)

    monkeypatch.setattr(structure._UnitSearch, "grow", grow)
    assert set(place_bounds(philosophers(5))) == {1}
    assert not grown
    net = NetBuilder("source")
    net.place("p", initial=1)
    net.place("q")
    net.transition("t", consume=["p"], produce=["p", "q"])
    assert place_bounds(net.build()) == [1, inf]
    assert grown == [1]
