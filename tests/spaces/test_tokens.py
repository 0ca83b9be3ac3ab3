"""Nets with many tokens: counts, bounds, and runs that show that there is none."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from unittest.mock import patch

import pytest
from hypothesis import event, example, given
from hypothesis import strategies as st

import mcpn
from mcpn.errors import LimitError, UnboundedError
from mcpn.events import Event
from mcpn.logic.behaviour import check_net
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.markings import boundedness as walks
from mcpn.spaces.markings.boundedness import OMEGA, boundedness
from mcpn.spaces.markings.counted import count_tokens, explore_tokens
from mcpn.testing.nets import FAMILIES
from tests.draws import fewer
from tests.nets.nets import graph_of, nets, token_nets
from tests.shares import returns_early


def producer_consumer(*, events: bool = False) -> PetriNet:
    """The unbounded one of the textbooks: the buffer has no size."""
    builder = NetBuilder("producer-consumer", priorities=events)
    for place, tokens in (("ready", 1), ("made", 0), ("buffer", 0), ("hungry", 1), ("full", 0)):
        builder.place(place, initial=tokens)
    for name, before, after in (
        ("make", ["ready"], ["made"]),
        ("put", ["made"], ["ready", "buffer"]),
        ("get", ["buffer", "hungry"], ["full"]),
        ("eat", ["full"], ["hungry"]),
    ):
        builder.transition(name, consume=before, produce=after, event=Event.parse(name) if events else None)
    return builder.build()


def replay(net: PetriNet, names: tuple[str, ...], marking: tuple[int, ...]) -> tuple[int, ...]:
    for name in names:
        t = net.transition_index[name]
        assert t in net.enabled(marking)
        marking = net.fire(marking, t)
    return marking


def check_pump(net: PetriNet, run: tuple[str, ...], pump: tuple[str, ...]) -> None:
    at = replay(net, run, net.initial)
    for _ in range(10):
        after = replay(net, pump, at)
        assert after != at
        assert all(a >= b for a, b in zip(after, at, strict=True))
        at = after


def test_an_unbounded_buffer_is_found_with_the_run_that_fills_it() -> None:
    net = producer_consumer()
    found = boundedness(net)
    assert found.bounded is False
    assert found.bounds is not None
    assert [net.places[p].name for p, bound in enumerate(found.bounds) if bound == OMEGA] == ["buffer"]
    assert [bound for bound in found.bounds if bound != OMEGA] == [1, 1, 1, 1]
    check_pump(net, found.run, found.pump)
    with pytest.raises(UnboundedError, match="buffer can hold any number"):
        explore_tokens(net)


def test_with_priorities_it_may_be_left_open() -> None:
    found = boundedness(producer_consumer(events=True), max_states=500)
    assert found.bounded is None
    assert found.bounds is None
    assert "priorities" in found.reason


@pytest.mark.parametrize(("rank", "needed", "bounded"), [(0, 3, True), (1, 3, False), (2, 3, False)])
def test_a_run_repeats_unless_what_it_fills_lets_a_lower_rank_fire(
    rank: int, needed: int, bounded: bool
) -> None:
    """A heap grows until so much of it is there that a transition of a lower rank, if it has one, ends it."""
    builder = NetBuilder("heap", priorities=True)
    builder.place("on", initial=1)
    builder.place("heap")
    builder.place("missing")
    builder.transition("grow", read=["on"], produce=["heap"], rank=1)
    builder.transition("end", consume=["on"], read={"heap": needed}, rank=rank)
    builder.transition("never", consume=["on", "missing"], read={"heap": needed})
    net = builder.build()
    found = boundedness(net, max_states=100)
    assert found.bounded is bounded
    if bounded:
        assert found.bounds == count_tokens(net).bounds == (1, needed, 0)
        assert count_tokens(net).states == needed + 2
    else:
        check_pump(net, found.run, found.pump)


@given(nets(max_weight=2, max_places=4, max_transitions=4))
def test_bounds_are_those_of_exploration(net: PetriNet) -> None:
    try:
        found = boundedness(net, max_states=2_000)
    except LimitError as error:
        returns_early(type(error).__name__)
        return
    if found.bounded:
        assert count_tokens(net).bounds == found.bounds
        assert found.bound == max(count_tokens(net).bounds)
    elif found.bounded is False:
        check_pump(net, found.run, found.pump)
        with pytest.raises((LimitError, UnboundedError)):
            explore_tokens(net, max_states=3_000)


@given(token_nets() | nets(max_weight=2, max_places=4, max_transitions=4, events=False))
def test_walks_that_have_their_turn_at_once_tell_the_same(net: PetriNet) -> None:
    """They find what can be repeated, and nothing where every marking has been listed."""
    with patch.object(walks, "TURN", 1):
        try:
            found = boundedness(net, max_states=2_000)
        except LimitError as error:
            returns_early(type(error).__name__)
            return
    event(f"bounded: {found.bounded}, by a walk: {found.bounded is False and found.bounds is None}")
    assert (found.bounded is not False) or graph_of(net) is None
    if found.bounded is False:
        check_pump(net, found.run, found.pump)


@pytest.mark.parametrize(
    ("family", "size"),
    [("token_ring", 200), ("component_ring", 8), ("philosophers", 8), ("philosophers", 60)],
)
def test_what_grows_in_a_large_net_is_found_without_its_tree(family: str, size: int) -> None:
    """One transition counts how often it fires: the tree has many nodes before one covers another."""
    net = FAMILIES[family].net(size)
    builder = NetBuilder("counting")
    names = [place.name for place in net.places]
    for place in net.places:
        builder.place(place.name, initial=place.initial)
    builder.place("counted")
    for number, t in enumerate(net.transitions):
        consume, produce, read = ({names[p]: w for p, w in arcs} for arcs in (t.consume, t.produce, t.read))
        counts = {} if number else {"counted": 1}
        builder.transition(t.name, consume=consume, produce=produce | counts, read=read)
    counting = builder.build()
    found = boundedness(counting, max_states=1_000)
    assert found.bounded is False
    check_pump(counting, found.run, found.pump)


def test_where_the_limit_is_hit_bounds_are_left_out_but_not_what_is_known() -> None:
    builder = NetBuilder("heaps")
    for place in "abcd":
        builder.place(place)
        builder.transition(f"fill {place}", produce=[place])
        builder.transition(f"empty {place}", consume=[place])
    net = builder.build()
    seen = set[tuple[int, ...] | None]()
    for limit in range(1, 120):
        try:
            found = boundedness(net, max_states=limit)
        except LimitError:
            assert not seen  # once a run that repeats is found, the answer stands
            continue
        assert found.bounded is False
        check_pump(net, found.run, found.pump)
        seen.add(found.bounds)
    assert seen == {None, (OMEGA,) * 4}


def grown(count: int, *arcs: tuple[list[str], list[str]]) -> PetriNet:
    """A net whose first place is marked."""
    builder = NetBuilder("grown")
    for number in range(count):
        builder.place(f"p{number}", initial=1 if number == 0 else 0)
    for number, (before, after) in enumerate(arcs):
        builder.transition(f"t{number}", consume=before, produce=after)
    return builder.build()


def by_the_heap(net: PetriNet, heap: int) -> PetriNet:
    """All tokens and weights times one number, which leaves the graph as it is."""
    places = tuple(replace(place, initial=place.initial * heap) for place in net.places)

    def piled(arcs: Iterable[tuple[int, int]]) -> tuple[tuple[int, int], ...]:
        return tuple((place, weight * heap) for place, weight in arcs)

    transitions = tuple(
        replace(t, consume=piled(t.consume), produce=piled(t.produce), read=piled(t.read))
        for t in net.transitions
    )
    return replace(net, places=places, transitions=transitions)


@fewer(0.3)
@given(token_nets(), st.sampled_from([3, 10**6, 10**10, 10**20, 10**400]))
@example(grown(2, (["p0"], ["p1"]), (["p1"], [])), 10**400)
def test_tokens_by_the_heap_are_counted_or_beyond_a_limit(net: PetriNet, heap: int) -> None:
    """Numbers of files may have 4,000 digits: what cannot hold them says so."""
    graph, piled = graph_of(net), by_the_heap(net, heap)
    for asked in ("states", "check"):
        try:
            states = mcpn.open(piled).states().states if asked == "states" else check_net(piled).states
        except UnboundedError:
            assert graph is None
        except LimitError:
            assert heap > 3 or graph is None
        else:
            assert states is None or graph is None or states == len(graph)
    with suppress(LimitError, UnboundedError):
        assert mcpn.open(piled).ctl("EF deadlock").holds == mcpn.open(net).ctl("EF deadlock").holds


@pytest.mark.parametrize("taken", [1, 10**400 - 1], ids=["one", "nearly all"])
def test_what_takes_little_of_a_heap(taken: int) -> None:
    """Neither the coverability tree nor a linear program says a bound beyond floats as a float."""
    builder = NetBuilder("little")
    builder.place("p", initial=1)
    builder.place("q")
    builder.transition("heap", consume=["p"], produce={"q": 10**400})
    builder.transition("take", consume={"q": taken})
    with pytest.raises(LimitError):
        mcpn.open(builder.build()).states()
