"""Siphons, traps, classes and semiflows by their definitions, and on nets of textbooks."""

from __future__ import annotations

from itertools import chain, combinations, product

import pytest
from hypothesis import given

from mcpn.errors import LimitError
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.nets.semiflows import p_semiflows, state_machine_components, t_semiflows
from mcpn.nets.siphons import commoner, greatest_trap, siphons, traps
from mcpn.nets.structural_classes import classes
from mcpn.nets.surroundings import surroundings
from tests.nets.nets import nets, pt_nets
from tests.shares import returns_early


def subsets(count: int) -> list[frozenset[int]]:
    return [
        frozenset(c) for c in chain.from_iterable(combinations(range(count), k) for k in range(1, count + 1))
    ]


def sides(net: PetriNet) -> list[tuple[set[int], set[int]]]:
    return [
        (
            {p for p, _ in (*t.consume, *t.read)},
            {p for p, _ in t.produce} | ({p for p, _ in t.read} - {p for p, _ in t.consume}),
        )
        for t in net.transitions
    ]


def minimal(sets: list[frozenset[int]]) -> set[frozenset[int]]:
    return {s for s in sets if not any(other < s for other in sets)}


@given(nets(max_places=6, max_transitions=6))
def test_siphons_and_traps_by_their_definitions(net: PetriNet) -> None:
    around = sides(net)
    all_siphons = [s for s in subsets(len(net.places)) if all(b & s for b, a in around if a & s)]
    all_traps = [s for s in subsets(len(net.places)) if all(a & s for b, a in around if b & s)]
    assert {frozenset(s) for s in siphons(net)} == minimal(all_siphons)
    assert {frozenset(s) for s in traps(net)} == minimal(all_traps)
    for chosen in subsets(len(net.places))[:20]:
        inside = [t for t in all_traps if t <= chosen]
        assert frozenset(greatest_trap(net, chosen)) == frozenset[int]().union(*inside)
    touched = set[int]().union(*(b | a for b, a in around))
    marked_traps = [t for t in all_traps if any(net.initial[p] for p in t)]
    unmarked = [s for s in minimal(all_siphons) if s & touched and not any(t <= s for t in marked_traps)]
    assert (commoner(net) is None) == (not unmarked)


@given(pt_nets())
def test_semiflows_change_nothing_and_are_of_minimal_support(net: PetriNet) -> None:
    def change(t: int, p: int) -> int:
        arcs = net.transitions[t]
        return dict(arcs.produce).get(p, 0) - dict(arcs.consume).get(p, 0)

    try:
        places, transitions = p_semiflows(net), t_semiflows(net)
    except LimitError as error:
        returns_early(type(error).__name__)
        return
    for flow in places:
        assert all(weight > 0 for weight in flow.values())
        assert all(sum(w * change(t, p) for p, w in flow.items()) == 0 for t in range(len(net.transitions)))
    for flow in transitions:
        assert all(sum(n * change(t, p) for t, n in flow.items()) == 0 for p in range(len(net.places)))
    for flows in (places, transitions):
        supports = [frozenset(flow) for flow in flows]
        assert len(minimal(supports)) == len(supports)
    # None is missed: every small combination that changes nothing holds one of them.
    for chosen in product(range(3), repeat=min(len(net.places), 5)):
        solves = all(
            sum(w * change(t, p) for p, w in enumerate(chosen)) == 0 for t in range(len(net.transitions))
        )
        if any(chosen) and solves:
            assert any(all(chosen[p] for p in flow) for flow in places if max(flow) < len(chosen))
    for counts in product(range(3), repeat=min(len(net.transitions), 5)):
        cycles = all(sum(n * change(t, p) for t, n in enumerate(counts)) == 0 for p in range(len(net.places)))
        if any(counts) and cycles:
            assert any(all(counts[t] for t in flow) for flow in transitions if max(flow) < len(counts))


def textbook(*transitions: tuple[str, str], marked: str = "") -> PetriNet:
    """A net from pairs of inputs and outputs, one letter a place."""
    builder = NetBuilder("textbook")
    for place in sorted({p for pair in transitions for side in pair for p in side}):
        builder.place(place, initial=int(place in marked))
    for i, (before, after) in enumerate(transitions):
        builder.transition(f"t{i}", consume=list(before), produce=list(after))
    return builder.build()


def test_classes_of_textbook_nets() -> None:
    ring = textbook(("a", "b"), ("b", "a"), marked="a")
    assert classes(ring) >= {"ordinary", "pure", "state machine", "marked graph", "free choice"}
    fork = textbook(("a", "bc"), ("bc", "a"))
    assert "marked graph" in classes(fork)
    assert "state machine" not in classes(fork)
    # Two consumers of a, one of which also wants b: asymmetric, not free choice (Murata, Fig. 22).
    unfree = textbook(("a", "b"), ("ab", "a"))
    assert "free choice" not in classes(unfree)
    assert "extended free choice" not in classes(unfree)
    assert "asymmetric choice" in classes(unfree)
    assert "asymmetric choice" not in classes(textbook(("ab", "a"), ("bc", "b"), ("ac", "c")))


def test_commoner_tells_a_free_choice_net_that_is_not_live() -> None:
    # A choice whose two branches must both be taken for the join: it blocks (Desel and Esparza, Fig. 4.1).
    blocking = textbook(("a", "b"), ("a", "c"), ("bc", "a"), marked="a")
    assert "free choice" in classes(blocking)
    assert commoner(blocking) is not None
    assert commoner(textbook(("a", "b"), ("a", "c"), ("b", "a"), ("c", "a"), marked="a")) is None


def test_a_mutual_exclusion_is_covered_by_state_machines() -> None:
    mutex = textbook(("am", "b"), ("b", "am"), ("cm", "d"), ("d", "cm"), marked="acm")
    found = {
        "".join(mutex.places[p].name for p in component) for component in state_machine_components(mutex)
    }
    assert found == {"ab", "cd", "bdm"}


def test_what_does_not_stay_is_no_trap_and_a_place_alone_hinders_nothing() -> None:
    builder = NetBuilder("once")
    builder.place("p", initial=1)
    builder.transition("t", consume=["p"], read=["p"])
    once = builder.build()
    assert traps(once) == ()
    assert commoner(once) == (0,)  # it fires once, and never again
    builder = NetBuilder("alone")
    for place, tokens in (("off", 1), ("on", 0), ("alone", 0)):
        builder.place(place, initial=tokens)
    builder.transition("press", consume=["off"], produce=["on"])
    builder.transition("again", consume=["on"], produce=["off"])
    assert commoner(builder.build()) is None


def test_limits_say_which() -> None:
    wide = textbook(*(("ab"[i % 2] + "cdefgh"[i], "cdefgh"[i - 1]) for i in range(6)))
    with pytest.raises(LimitError, match="search for siphons"):
        siphons(wide, max_steps=2)
    with pytest.raises(LimitError, match="P-semiflows"):
        p_semiflows(textbook(("ab", "cd"), ("cd", "ab"), ("ac", "bd")), max_rows=1)
    assert len(surroundings(wide)) == 6


def test_sets_that_all_differ_are_not_compared_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mcpn.nets.siphons.COMPARISONS_OF_A_STEP", 100)
    builder = NetBuilder("pairs")  # a siphon takes one place of each pair: 2^14 of them
    for i in range(14):
        builder.place(f"a{i}", initial=1)
        builder.place(f"b{i}", initial=1)
    for i in range(14):
        after = (i + 1) % 14
        taken, put = [f"a{i}", f"b{i}"], [f"a{after}", f"b{after}"]
        builder.transition(f"t{i}", consume=taken, produce=put)
    net = builder.build()
    for find, what in ((siphons, "siphons"), (traps, "traps")):
        with pytest.raises(LimitError, match=f"comparisons of sets: the limit on the search for {what}"):
            find(net)
    with pytest.raises(LimitError, match="the limit on P-semiflows was hit"):
        p_semiflows(net, max_rows=200)
