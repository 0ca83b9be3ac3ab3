"""Nets with several tokens in a place: engines against the plain rule, closed forms, published counts."""

from __future__ import annotations

import pickle
from dataclasses import asdict
from functools import partial
from math import comb, inf
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from mcpn.errors import LimitError, UnboundedError, UnsafeError
from mcpn.events import Event
from mcpn.logic.behaviour import Behaviour, check_net
from mcpn.logic.evaluate import Evaluation
from mcpn.nets.formats import read_net
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.algebra import Space
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.diagrams.bounded import reach_markings, reach_tokens
from mcpn.spaces.diagrams.counters import TokenEncoding
from mcpn.spaces.diagrams.order import candidates
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.diagrams.symbolic import closing
from mcpn.spaces.markings import widths
from mcpn.spaces.markings.counted import count_tokens, explore_tokens
from mcpn.spaces.sizes import summarise
from mcpn.turns import finished
from tests.draws import fewer
from tests.logic.formulas import formulas, read, satisfying
from tests.logic.test_behaviour import ahead
from tests.logic.test_ctl import names, satisfy
from tests.nets.nets import graph_of, nets, token_nets
from tests.shares import returns_early
from tests.spaces.members import members
from tests.spaces.test_tokens import check_pump, producer_consumer, replay

SIZES = ("states", "edges", "stable_states", "dead_states", "max_tokens", "max_tokens_in_place")


def tokens_in_a_ring(tokens: int, places: int, weight: int = 1) -> PetriNet:
    """C(n + k - 1, k - 1) markings: n tokens, or stacks of them, over k places."""
    builder = NetBuilder("ring")
    for place in range(places):
        builder.place(f"p{place}", initial=0 if place else tokens * weight)
    for place in range(places):
        arcs = {f"p{place}": weight}, {f"p{(place + 1) % places}": weight}
        builder.transition(f"t{place}", consume=arcs[0], produce=arcs[1])
    return builder.build()


def sizes(space: SymbolicSpace) -> tuple[int, int, int, int, int]:
    return space.states, space.edges, space.dead_states, space.max_tokens, space.max_tokens_in_place


@fewer(0.5, least=8)
@given(token_nets(), st.integers(0, 3))
@example(tokens_in_a_ring(9, 3, 2), 0)
def test_markings_are_those_of_the_plain_rule(net: PetriNet, rank: int) -> None:
    graph = graph_of(net)
    if graph is None:
        returns_early("too many markings")
        return
    orders = [order for _, order in candidates(net)]
    space = reach_tokens(net, order=orders[rank] if rank < len(orders) else None)
    assert {space.encoding.marking(levels) for levels in space.reachable} == set(graph)
    assert sizes(space) == (
        len(graph),
        sum(map(len, graph.values())),
        sum(not firings for firings in graph.values()),
        max(map(sum, graph)),
        max(map(max, graph)),
    )
    bounds = [max(marking[p] for marking in graph) for p in range(len(net.places))]
    assert space.encoding.most(space.reachable) == bounds
    fired = DiagramMarkings(space).firings(space.reachable)
    for t in range(len(net.transitions)):
        assert fired.get(t, 0) == sum(any(u == t for u, _ in firings) for firings in graph.values())
    assert sizes(reach_markings(net)) == sizes(space)
    assert sizes(high_first(net, wider=rank)) == sizes(space)
    assert sizes(pickle.loads(pickle.dumps(space))) == sizes(space)
    again = pickle.loads(pickle.dumps(high_first(net)))
    assert {again.encoding.marking(levels) for levels in again.reachable} == set(graph)
    counted = count_tokens(net)
    assert counted.bounds == tuple(bounds)
    expected = *sizes(space)[:3], space.max_tokens
    assert (counted.states, counted.edges, counted.dead, counted.max_tokens) == expected
    assert {field: asdict(summarise(net, "explicit"))[field] for field in SIZES} == {
        field: asdict(summarise(net, "symbolic"))[field] for field in SIZES
    }


@fewer(0.5, least=8)
@given(nets(max_weight=2, max_places=4, max_transitions=4))
def test_priorities_are_respected_with_several_tokens(net: PetriNet) -> None:
    graph = graph_of(net)
    if graph is None:
        returns_early("too many markings")
        return
    found = explore_tokens(net)
    assert {found.marking(state) for state in range(found.states)} == set(graph)
    assert found.edges == sum(map(len, graph.values()))
    for state in range(found.states):
        after = [(t, found.marking(target)) for t, target in found.successors(state)]
        assert after == graph[found.marking(state)]
    counted = count_tokens(net)
    assert (counted.states, counted.edges) == (found.states, found.edges)
    if net.priorities:
        unstable = [m for m in graph if any(net.transitions[t].internal for t in net.enabled(m))]
        assert counted.stable == len(graph) - len(unstable)


@fewer(0.25)
@given(token_nets(), st.data())
def test_formulas_hold_where_the_definitions_say(net: PetriNet, data: st.DataObject) -> None:
    graph = graph_of(net, 150)
    if graph is None:
        returns_early("too many markings")
        return
    evaluations = [Evaluation(space) for space in spaces(net)]
    for formula in data.draw(st.lists(formulas(*names(net)), min_size=4, max_size=4)):
        expected = satisfying(formula, net, graph)
        core = read(formula, net)
        for evaluation in evaluations:
            assert satisfy(evaluation, core) == expected
            assert evaluation.holds(core) == (net.initial in expected)


def spaces(net: PetriNet) -> list[Space[Any]]:
    return [
        DiagramMarkings(reach_tokens(net)),
        DiagramMarkings(high_first(net)),
        ArraySpace(explore_tokens(net)),
    ]


def high_first(net: PetriNet, wider: int = 0) -> SymbolicSpace:
    """The markings with the highest bit of each place on top, as wide as is needed or wider."""
    widths = [bound.bit_length() + wider for bound in count_tokens(net).bounds]
    encode = partial(TokenEncoding, widths=widths, low_first=False)
    order = tuple(range(len(net.places)))
    return finished(closing(net, encode, order=order, seed=None, memory_limit=1 << 28))


@fewer(0.5)
@given(token_nets())
def test_no_place_holds_more_than_linear_programs_say(net: PetriNet) -> None:
    if (graph := graph_of(net, 500)) is None:
        return
    places = range(len(net.places))
    bounds = widths.by_programs(net, places)
    for place in places:
        assert max(marking[place] for marking in graph) <= bounds.get(place, inf)


def test_linear_programs_know_the_tokens_of_a_ring() -> None:
    builder = NetBuilder("ring")
    for i in range(4):
        builder.place(f"p{i}", initial=0 if i else 5)
        builder.transition(f"t{i}", consume=[f"p{i}"], produce=[f"p{(i + 1) % 4}"])
    assert widths.by_programs(builder.build(), range(4)) == dict.fromkeys(range(4), 5.0)


@fewer(0.5, least=8)
@given(token_nets())
def test_behaviour_and_runs_by_their_definitions(net: PetriNet) -> None:
    graph = graph_of(net, 100)
    if graph is None:
        returns_early("too many markings")
        return
    from_each = {marking: ahead(graph, marking) for marking in graph}
    fired = {marking: {t for at in found for t, _ in graph[at]} for marking, found in from_each.items()}
    for space in spaces(net):
        found = Behaviour(space)
        assert found.quasi_live == fired[net.initial]
        assert found.live == {
            t for t in range(len(net.transitions)) if all(t in later for later in fired.values())
        }
        assert found.reversible == all(net.initial in later for later in from_each.values())
        assert found.home_markings == sum(all(m in later for later in from_each.values()) for m in graph)
        constant = {p for p in range(len(net.places)) if len({m[p] for m in graph}) == 1}
        assert found.constant_places == constant
        run = space.run(space.initial.pick(), space.dead)
        assert (run is not None) == any(not firings for firings in graph.values())
        marking = net.initial
        for edge in run or []:
            after = space.marking(edge.target)
            assert (edge.transition, after) in graph[marking]
            marking = after
        assert run is None or not graph[marking]
        # Each transition, forward and back.
        for t in range(len(net.transitions)):
            edges = {m: after for m in graph for u, after in graph[m] if u == t}
            assert members(space, space.after(space.everything, [t])) == set(edges.values())
            assert members(space, space.before(space.everything, [t])) == set(edges)


@fewer(0.5, least=8)
@given(nets(max_weight=2, max_places=4, max_transitions=4, events=False))
def test_what_is_unbounded_is_said_with_a_run_that_can_be_repeated(net: PetriNet) -> None:
    try:
        found = reach_markings(net, memory_limit=1 << 28)
    except UnboundedError as error:
        check_unbounded(net, error)
        return
    except LimitError as error:
        returns_early(type(error).__name__)
        return
    graph = graph_of(net, 2000)
    if graph is None:
        returns_early("too many markings")
        return
    assert found.states == len(graph)


def check_unbounded(net: PetriNet, error: UnboundedError) -> None:
    """The run can be repeated, and leaves more tokens in one of the places named."""
    check_pump(net, error.run, error.pump)
    start = replay(net, error.run, net.initial)
    after = replay(net, error.pump, start)
    grown = {place.name for p, place in enumerate(net.places) if after[p] > start[p]}
    assert grown.intersection(error.places)


@pytest.mark.parametrize("places", [1, 10])
def test_a_place_that_nothing_fills_again_counts_to_a_million(places: int) -> None:
    builder = NetBuilder("falling")
    for place in range(places):
        builder.place(f"p{place}", initial=10**6)
        builder.transition(f"t{place}", consume=[f"p{place}"])
    space = reach_tokens(builder.build())
    assert space.states == (10**6 + 1) ** places
    assert space.max_tokens_in_place == 10**6


def test_an_unbounded_buffer_is_named() -> None:
    with pytest.raises(UnboundedError, match="buffer can hold any number of tokens"):
        reach_markings(producer_consumer())
    assert check_net(producer_consumer()).bounded.bounded is False


def test_with_priorities_a_second_token_is_an_error_still() -> None:
    builder = NetBuilder("two", priorities=True)
    builder.place("p", initial=1)
    builder.place("q", initial=1)
    builder.transition("t", consume=["p"], produce=["q"], event=Event.parse("t"))
    with pytest.raises(UnsafeError, match="second token in q"):
        reach_markings(builder.build())


@pytest.mark.parametrize(("tokens", "places", "weight"), [(1, 2, 1), (7, 4, 1), (7, 4, 3), (40, 12, 1)])
def test_tokens_in_a_ring(tokens: int, places: int, weight: int) -> None:
    space = reach_markings(tokens_in_a_ring(tokens, places, weight))
    states = comb(tokens + places - 1, places - 1)
    # A place feeds the next one wherever a token is in it: the others are anywhere.
    edges = places * comb(tokens - 1 + places - 1, places - 1)
    assert sizes(space) == (states, edges, 0, tokens * weight, tokens * weight)


@pytest.mark.parametrize("bound", [1, 2, 3, 4, 7, 8, 100, 1000])
def test_a_place_that_no_invariant_bounds_grows_as_far_as_it_must(bound: int) -> None:
    """What is read bounds the pump: a bag is filled while its room is not taken, in two steps each."""
    builder = NetBuilder("bag")
    for name, tokens in (("room", bound), ("bag", 0), ("twice", 0)):
        builder.place(name, initial=tokens)
    builder.transition("fill", consume=["room"], produce={"bag": 1, "twice": 2})
    space = reach_markings(builder.build())
    assert sizes(space) == (bound + 1, bound, 1, 3 * bound, 2 * bound)


@pytest.mark.parametrize(
    "model",
    [
        "HouseConstruction-PT-00002",
        "RobotManipulation-PT-00001",
        "Szymanski-PT-a02",
        "Kanban-PT-00005",
        "FMS-PT-00005",
    ],
)
def test_the_contest_s_nets_that_are_not_safe(
    mcc: Path, mcc_oracles: dict[str, dict[str, str]], model: str
) -> None:
    row = mcc_oracles[model]
    space = reach_markings(read_net(mcc / model / "model.pnml"))
    assert (space.states, space.edges) == (int(row["states"]), int(row["edges"]))
    assert space.max_tokens == int(row["max_tokens_per_marking"])
    assert row["safe"] == f"bound {space.max_tokens_in_place}"
    assert (space.dead_states > 0) == (row["deadlock_exists"] == "TRUE")
    if space.states < 100_000:
        counted = count_tokens(space.encoding.net)
        assert (counted.states, counted.edges) == (space.states, space.edges)
        assert list(counted.bounds) == space.encoding.most(space.reachable)
    found = Behaviour(DiagramMarkings(space))
    everything = frozenset(range(len(space.encoding.net.transitions)))
    assert (found.live == everything) == (row["live"] == "TRUE")
    assert (found.quasi_live == everything) == (row["quasi_live"] == "TRUE")
    assert bool(found.constant_places) == (row["stable_marking_exists"] == "TRUE")
