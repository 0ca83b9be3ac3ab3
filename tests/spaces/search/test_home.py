"""Markings that every reachable one leads to, by rules and the state equation, against all markings."""

from __future__ import annotations

from fractions import Fraction
from unittest.mock import patch

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.search import home
from mcpn.spaces.search.equation import StateEquation
from mcpn.spaces.search.facts import Facts
from mcpn.spaces.search.home import Home, descent_of, proved_home
from mcpn.spaces.search.searches import Searches
from mcpn.testing.nets import FAMILIES
from mcpn.turns import finished
from tests.nets.nets import graph_of, nets, state_machines, token_nets
from tests.spaces.search.test_equation import assert_proved


@st.composite
def leading_back(draw: st.DrawFn) -> PetriNet:
    """Nets of which most transitions have another that undoes them, alone or together with one."""
    net = draw(token_nets())
    builder = NetBuilder("back")
    for place in net.places:
        builder.place(place.name, initial=place.initial)
    names = [place.name for place in net.places]
    for t in net.transitions:
        consume, produce, read = ({names[p]: w for p, w in arcs} for arcs in (t.consume, t.produce, t.read))
        builder.transition(t.name, consume=consume, produce=produce, read=read)
        if draw(st.integers(0, 3)):
            builder.transition(f"{t.name}_back", consume=produce, produce=consume)
    return builder.build()


NETS = (
    leading_back()
    | token_nets()
    | nets(max_weight=1, events=False)
    | nets(max_weight=2, events=False)
    | state_machines().map(lambda pair: pair[0])
)


@given(NETS, st.sampled_from([1, 3, 24]))
def test_a_home_marking_is_one(net: PetriNet, rounds: int) -> None:
    graph = graph_of(net)
    assume(graph is not None)
    assert graph is not None
    before = {marking: set[tuple[int, ...]]() for marking in graph}
    for marking, edges in graph.items():
        for _, after in edges:
            before[after].add(marking)
    dead = [marking for marking, edges in graph.items() if not edges]
    for marking in {net.initial, *dead[:2]}:
        with patch.object(home, "ROUNDS", rounds):
            found = proved_home(StateEquation(net), Searches(net), marking)
        leading, stack = {marking}, [marking]
        while stack:
            more = before[stack.pop()] - leading
            leading |= more
            stack.extend(more)
        event(f"proved: {found is not None}, is: {len(leading) == len(graph)}, alone: {len(graph) == 1}")
        if found is not None:
            assert len(leading) == len(graph)
            assert_rules(net, found)
            if found.ends:
                assert not graph[marking]
                assert not has_cycle(graph)


def assert_rules(net: PetriNet, found: Home) -> None:
    """Each rule may be fired with what it needs, and no less; it lowers the weighted sum."""
    assert min(found.weights, default=0) >= 0
    for rule in found.rules:
        least = tuple(rule.needs.get(place, 0) for place in range(len(net.places)))
        assert not rule.applies(found.marking)
        assert fires(net, least, rule.run)
        for place in rule.needs:
            assert not fires(net, [n - (p == place) for p, n in enumerate(least)], rule.run)
        after = list(least)
        for t in rule.run:
            net.fire_in_place(after, t)
        lowered = sum(w * (b - a) for w, b, a in zip(found.weights, least, after, strict=True))
        assert lowered > 0
        assert {p: a - b for p, (a, b) in enumerate(zip(after, least, strict=True)) if a != b} == {
            p: change for p, change in rule.effect.items() if change
        }


def fires(net: PetriNet, marking: list[int] | tuple[int, ...], run: tuple[int, ...]) -> bool:
    here = list(marking)
    for t in run:
        if not net.covers(here, t):
            return False
        net.fire_in_place(here, t)
    return True


def has_cycle(graph: dict[tuple[int, ...], list[tuple[int, tuple[int, ...]]]]) -> bool:
    left = {marking: {after for _, after in edges} for marking, edges in graph.items()}
    while ended := [marking for marking, after in left.items() if not after]:
        for marking in ended:
            del left[marking]
        for after in left.values():
            after.difference_update(ended)
    return bool(left)


@pytest.mark.parametrize(
    ("family", "size"), [("kanban", 1_000), ("fms", 200), ("component_ring", 6), ("token_ring", 50)]
)
def test_large_nets_that_lead_back(family: str, size: int) -> None:
    facts = Facts(FAMILIES[family].net(size))
    found = finished(facts.going_home())
    assert found is not None
    assert found.marking == facts.net.initial
    assert finished(facts.live())[0] is True


def test_what_stops_all_rules_is_proved_in_fractions() -> None:
    net = FAMILIES["kanban"].net(3)
    found = finished(Facts(net).going_home())
    assert found is not None
    assert found.proofs
    for proof in found.proofs:
        assert_proved(proof, net, {}, Fraction(-1, 10**9))


def test_a_run_becomes_a_rule_where_no_single_transition_leads_back() -> None:
    """Half a pair waits for its other half, which only what leaves the beginning can bring."""
    builder = NetBuilder("pair")
    for name, tokens in (("a", 1), ("b", 1), ("left", 0), ("right", 0)):
        builder.place(name, initial=tokens)
    builder.transition("go_a", consume=["a"], produce=["left"])
    builder.transition("go_b", consume=["b"], produce=["right"])
    builder.transition("meet", consume=["left", "right"], produce=["a", "b"])
    net = builder.build()
    found = finished(Facts(net).going_home())
    assert found is not None
    assert sorted(len(rule.run) for rule in found.rules) == [1, 2, 2]
    assert descent_of(net, (0, 2)).needs == {0: 1, 3: 1}
