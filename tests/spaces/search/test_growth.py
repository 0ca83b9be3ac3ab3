"""What is said to have no bound grows each time that its run is fired: the net's own rule fires it."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from mcpn.errors import Source
from mcpn.logic.answering import answer_all
from mcpn.logic.contest import Property
from mcpn.logic.questions import Questions
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.markings.counted import explore_markings
from mcpn.spaces.search.facts import Facts
from mcpn.spaces.search.growth import Growth, growing
from mcpn.spaces.search.searches import Searches
from mcpn.turns import finished
from tests.draws import fewer
from tests.spaces.search.goals import all_markings
from tests.spaces.search.test_portfolio import PLAIN_NETS


def assert_grows(net: PetriNet, growth: Growth, places: tuple[int, ...]) -> None:
    """Fires the run, and what repeats twice: the sum has grown each time, and no place has fewer tokens."""
    marking = net.initial
    for t in growth.run:
        assert t in net.enabled(marking)
        marking = net.fire(marking, t)
    for _ in range(2):
        before = marking
        for t in growth.cycle:
            assert t in net.enabled(marking)
            marking = net.fire(marking, t)
        assert all(now >= then for now, then in zip(marking, before, strict=True))
        assert sum(marking[p] for p in places) > sum(before[p] for p in places)


@given(PLAIN_NETS, st.data())
def test_a_sum_that_grows_has_no_bound(net: PetriNet, data: st.DataObject) -> None:
    places = tuple(data.draw(st.lists(st.integers(0, len(net.places) - 1), min_size=1, max_size=2)))
    growth = finished(growing(Searches(net), Counter(places)))
    event(f"grows: {growth is not None}")
    if growth:
        assert_grows(net, growth, places)
        assert all_markings(net) is None


def producers(count: int) -> PetriNet:
    """Each producer writes for the next one, and is woken first; what the last one writes piles up."""
    builder = NetBuilder("producers")
    for i in range(count):
        builder.place(f"asleep{i}", initial=1)
        builder.place(f"awake{i}")
        builder.place(f"pile{i}")
        builder.transition(f"wake{i}", consume=[f"asleep{i}"], produce=[f"awake{i}"])
        builder.transition(
            f"write{i}", consume=[f"pile{i - 1}"] if i else [], read=[f"awake{i}"], produce=[f"pile{i}"]
        )
    return builder.build()


@pytest.mark.parametrize("count", [1, 12])
def test_bounds_that_are_infinite_are_told_with_what_repeats(count: int) -> None:
    net = producers(count)
    pile, awake = net.place_index[f"pile{count - 1}"], net.place_index["awake0"]
    asked = [Property("pile", (pile,), Source("here")), Property("awake", (awake,), Source("here"))]
    found = {verdict.name: verdict.value for verdict in answer_all(Questions(net), asked)}
    assert found == {"pile": "INF", "awake": "1"}
    facts = Facts(net)
    assert [told for told in facts.sums([(pile,)]) if told]
    growth = facts.grows[(pile,)]
    assert_grows(net, growth, (pile,))
    assert len(growth.cycle) == count  # each writes once, for the next one


@fewer(0.5)
@given(PLAIN_NETS)
def test_bounds_are_those_of_all_markings(net: PetriNet) -> None:
    markings = all_markings(net, 500)
    assume(markings is not None)
    assert markings is not None
    assert explore_markings(net).states == len(markings)
    every = range(len(net.places))
    asked = [Property(str(place), (place,), Source("drawn")) for place in every]
    for verdict in answer_all(Questions(net), asked):
        assert verdict.value == str(max(marking[int(verdict.name)] for marking in markings))


def doubling(stages: int) -> PetriNet:
    """One token says what may fire: it makes two of one ``x`` and then each of them an ``x`` again."""
    builder = NetBuilder("doubling")
    builder.place("go0", initial=1)
    for i in range(stages):
        for place in ("go", "x", "y", "up", "made", "down", "back"):
            if place != "go" or i + 1 < stages:
                builder.place(f"{place}{i + 1 if place == 'go' else i}")
        builder.transition(f"begin{i}", consume=[f"go{i}"], produce=[f"up{i}", f"x{i}"])
        builder.transition(f"double{i}", consume=[f"up{i}", f"x{i}"], produce=[f"made{i}", f"y{i}", f"y{i}"])
        builder.transition(f"turn{i}", consume=[f"made{i}"], produce=[f"down{i}"])
        builder.transition(f"return{i}", consume=[f"down{i}", f"y{i}"], produce=[f"back{i}", f"x{i}"])
        builder.transition(f"loop{i}", consume=[f"back{i}"], produce=[f"down{i}"])
        builder.transition(f"flip{i}", consume=[f"back{i}"], produce=[f"up{i}"])
        if i + 1 < stages:
            builder.transition(f"next{i}", consume=[f"down{i}", f"x{i}"], produce=[f"go{i + 1}"])
    return builder.build()


@pytest.mark.parametrize("stage", [0, 3])
def test_what_repeats_is_put_in_an_order_that_one_token_allows(stage: int) -> None:
    net = doubling(4)
    place = net.place_index[f"x{stage}"]
    growth = finished(growing(Searches(net), {place: 1}))
    assert growth is not None
    assert_grows(net, growth, (place,))
    assert len(growth.cycle) == 6  # double, turn, return, loop, return, flip
