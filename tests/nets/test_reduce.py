"""A reduced net has the answer of the net that it stands for, and its runs are runs of that net."""

from __future__ import annotations

import time
from collections.abc import Mapping, Set
from itertools import pairwise, product

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.nets.reduce.draft import Draft
from mcpn.nets.reduce.reduction import Reduction, reduce_for_deadlock, reduce_for_goal
from mcpn.nets.reduce.redundant import drop_never_marked
from tests.nets.nets import nets, state_machines, token_nets

STEPS_OF_LINE, SECONDS = 4_000, 1.0
"""Steps of a run, and CPU seconds that a rule may take for it: a quadratic one takes many times as many."""
EITHER, UP, DOWN = frozenset({1, -1}), frozenset({1}), frozenset({-1})

PLAIN = (
    nets(max_weight=1, events=False)
    | nets(max_places=8, max_transitions=8, max_weight=1, events=False)
    | nets(max_weight=2, events=False)
    | token_nets()
    | state_machines().map(lambda drawn: drawn[0])
)


def runs(net: PetriNet, limit: int = 1000) -> dict[Marking, tuple[int, ...]] | None:
    """Every reachable marking with a run to it, by the net's own rule; ``None`` where there are too many."""
    found: dict[Marking, tuple[int, ...]] = {net.initial: ()}
    queue = [net.initial]
    for marking in queue:
        for t in net.enabled(marking):
            after = net.fire(marking, t)
            if after not in found:
                found[after] = (*found[marking], t)
                queue.append(after)
        if len(found) > limit:
            return None
    return found


def lifted(net: PetriNet, reduced: Reduction, run: tuple[int, ...]) -> Marking:
    """The marking after a run of the smaller net, fired in the net that it stands for."""
    marking = net.initial
    for t in reduced.lift(run):
        assert t in net.enabled(marking)
        marking = net.fire(marking, t)
    return marking


def serves(found: int, asked: int, ways: Set[int]) -> bool:
    """Whether a goal that may profit from more (1) or fewer (-1) tokens has at least what was asked."""
    return (found >= asked or 1 not in ways) and (found <= asked or -1 not in ways)


def confirm(net: PetriNet, wanted: Mapping[int, Set[int]]) -> Reduction | None:
    """Compares all that both nets reach in the places of a goal."""
    every = runs(net)
    if every is None:
        return None
    reduced = reduce_for_goal(net, wanted)
    smaller = runs(reduced.net)
    assert smaller is not None
    there = [reduced.place_index[p] for p in wanted]
    for marking, run in smaller.items():
        after = lifted(net, reduced, run)
        assert [marking[i] for i in there] == [after[p] for p in wanted]
    found = {tuple(marking[i] for i in there) for marking in smaller}
    for marking in every:
        asked = [(marking[p], ways) for p, ways in wanted.items()]
        assert any(all(serves(f, *of) for f, of in zip(those, asked, strict=True)) for those in found)
    return reduced


@given(PLAIN, st.data())
def test_what_a_goal_asks_for_is_reached_as_before(net: PetriNet, data: st.DataObject) -> None:
    places = st.integers(0, len(net.places) - 1)
    for _ in range(4):
        ways = st.sampled_from([EITHER, UP, DOWN])
        assume(confirm(net, data.draw(st.dictionaries(places, ways, min_size=1, max_size=3))) is not None)


def confirm_deadlock(net: PetriNet) -> bool:
    """Compares whether both nets can die; nothing is said of nets with too many markings."""
    every = runs(net)
    if every is None:
        return False
    reduced = reduce_for_deadlock(net)
    smaller = runs(reduced.net)
    assert smaller is not None
    dead = [run for marking, run in smaller.items() if not reduced.net.enabled(marking)]
    assert bool(dead) == any(not net.enabled(marking) for marking in every)
    for run in dead:
        marking = lifted(net, reduced, run)
        for _ in range(len(every)):  # what is left are halves of sequences: they end, whatever the order
            if not (enabled := net.enabled(marking)):
                break
            marking = net.fire(marking, enabled[-1])
        assert not net.enabled(marking)
    return True


@given(PLAIN)
def test_a_deadlock_is_reached_as_before(net: PetriNet) -> None:
    assume(confirm_deadlock(net))


def net_of(initial: Mapping[str, int], *transitions: tuple[Mapping[str, int], Mapping[str, int]]) -> PetriNet:
    """A net by its transitions: what each consumes and produces."""
    builder = NetBuilder("net")
    names = dict.fromkeys((*initial, *(p for t in transitions for side in t for p in side)))
    for name in names:
        builder.place(name, initial=initial.get(name, 0))
    for number, (consume, produce) in enumerate(transitions):
        builder.transition(f"t{number}", consume=consume, produce=produce)
    return builder.build()


def confirmed(net: PetriNet, *names: str, ways: Set[int] = EITHER) -> Reduction:
    reduced = confirm(net, {net.place_index[name]: ways for name in names})
    assert reduced is not None
    return reduced


@pytest.mark.parametrize("tokens", [0, 1, 3])
@pytest.mark.parametrize("second", [0, 1, 2], ids=["one way on", "another way on", "another that needs two"])
def test_around_one_place_in_every_small_net(tokens: int, second: int) -> None:
    """One place, with transitions before and after it that need, make and leave more than its tokens."""
    options = product((1, 2), (1, 2), *[(False, True)] * 4)
    for before, after, needs_more, makes_more, rival_before, rival_after in options:
        transitions: list[tuple[dict[str, int], dict[str, int]]] = [
            ({"start": 1}, {"mid": before} | ({"also": 1} if makes_more else {})),
            ({"mid": after} | ({"more": 1} if needs_more else {}), {"out": 1}),
            ({"out": 1}, {"far": 1}),
        ]
        if second:
            transitions.append(({"mid": second}, {"aside": 1}))
        if rival_before:
            transitions.append(({"start": 1}, {"aside": 1}))
        if rival_after:
            transitions.append(({"more": 1}, {"aside": 1}))
        names = ("mid", "start", "out") if tokens else ("out", "start", "mid")  # in this order they are tried
        net = net_of({**dict.fromkeys(names, 0), "mid": tokens, "start": 2, "more": 1}, *transitions)
        for asked in (("out",), ("far",), ("far", "also"), ("far", "aside"), ("start", "aside")):
            wanted = {net.place_index[name]: EITHER for name in asked if name in net.place_index}
            if wanted:
                assert confirm(net, wanted) is not None
        assert confirm_deadlock(net)


def test_a_first_token_that_has_two_ways_may_go_each() -> None:
    net = net_of(
        {"fork": 1},
        ({"fork": 1}, {"left": 1}),
        ({"fork": 1}, {"right": 1}),
        ({"left": 1}, {"a": 1}),
        ({"right": 1}, {"b": 1}),
        ({"a": 1}, {"fork": 1}),
    )
    for name in ("a", "b"):
        confirmed(net, name)
    confirmed(net, "a", "b")


def test_first_tokens_that_do_not_make_a_whole_firing_stay_behind() -> None:
    # Three tokens, two a firing: one passes at first, and the third never.
    net = net_of(
        {"in": 3, "feed": 1}, ({"in": 2}, {"mid": 1}), ({"mid": 1}, {"out": 1}), ({"feed": 1}, {"in": 2})
    )
    reduced = confirmed(net, "out")
    assert len(reduced.net.places) < len(net.places)
    every = runs(net)
    assert every is not None
    assert max(marking[net.place_index["out"]] for marking in every) == 2


def test_more_first_tokens_than_may_be_fired_at_first() -> None:
    # A thousand firings at first are done, more are left to the search: the answer is the same.
    for tokens in (1000, 1001):
        net = net_of(
            {"in": tokens, "feed": 1},
            ({"feed": 1}, {"in": 1}),
            ({"in": 1}, {"mid": 1}),
            ({"mid": 1}, {"out": 1}),
        )
        out = net.place_index["out"]
        reduced = reduce_for_goal(net, {out: EITHER})
        assert len(reduced.prefix) <= 1000
        every = runs(reduced.net, 10_000)
        assert every is not None
        there = reduced.place_index[out]
        most = max(every, key=lambda marking: marking[there])
        assert lifted(net, reduced, every[most])[out] == most[there] == tokens + 1


def test_a_line_is_one_transition() -> None:
    names = "abcdefgh"
    net = net_of({"a": 1}, *(({s: 1}, {t: 1}) for s, t in pairwise(names)))
    reduced = confirmed(net, "h")
    assert len(reduced.net.transitions) <= 1
    assert lifted(net, reduced, (0,) * len(reduced.net.transitions))[net.place_index["h"]] == 1


def test_of_two_equal_places_the_one_with_fewer_tokens_decides() -> None:
    net = net_of(
        {"few": 1, "many": 3}, ({"few": 1, "many": 1}, {"out": 1}), ({"out": 2}, {"few": 2, "many": 2})
    )
    reduced = confirmed(net, "out")
    every = runs(net)
    assert every is not None
    assert {marking[net.place_index["out"]] for marking in every} == {0, 1}
    assert net.place_index["many"] not in reduced.places


def test_of_two_transitions_of_one_effect_the_one_that_needs_less_is_left() -> None:
    net = net_of(
        {"a": 2, "guard": 1},
        ({"a": 1, "guard": 1}, {"b": 1, "guard": 1}),
        ({"a": 1}, {"b": 1}),
        ({"guard": 1}, {"off": 1}),
        ({"off": 1}, {"guard": 1}),
    )
    for names in (("a", "guard"), ("b", "off"), ("a", "b", "guard")):
        reduced = confirmed(net, *names)
        assert sum(run == (0,) for run in reduced.runs) == 0
    # Neither needs less than the other: both are left.
    net = net_of(
        {"a": 1, "one": 1, "two": 1},
        ({"a": 1, "one": 1}, {"b": 1, "one": 1}),
        ({"a": 1, "two": 1}, {"b": 1, "two": 1}),
        ({"one": 1}, {"off": 1}),
        ({"two": 1}, {"off": 1}),
        ({"b": 1}, {"a": 1}),
    )
    confirmed(net, "b", "off")
    confirmed(net, "b", "one")
    confirmed(net, "b", "two")


def test_a_loop_without_effect_matters_for_deadlocks_alone() -> None:
    net = net_of({"a": 1}, ({"a": 1}, {"a": 1}))
    assert reduce_for_deadlock(net).net.transitions
    assert not reduce_for_goal(net, {0: EITHER}).net.transitions


@pytest.mark.parametrize("own", [False, True])
def test_a_choice_that_is_made_before_it_is_known_to_be_bad(own: bool) -> None:
    # Once in the middle there is no way back, and what is needed there may be gone.
    net = net_of(
        {"start": 1, "more": 1, "own": 1},
        ({"start": 1} | ({"own": 1} if own else {}), {"mid": 1}),
        ({"mid": 1, "more": 1}, {"start": 1, "own": 1} if own else {"start": 1}),
        ({"start": 1}, {"aside": 1}),
        ({"aside": 1}, {"start": 1}),
        ({"more": 1}, {"gone": 1}),
    )
    assert confirm_deadlock(net)
    every = runs(net)
    assert every is not None
    assert any(not net.enabled(marking) for marking in every)


def test_what_needs_nothing_may_always_fire() -> None:
    net = net_of({"more": 1}, ({}, {"mid": 1}), ({"mid": 1, "more": 1}, {"out": 1}))
    reduced = reduce_for_deadlock(net).net
    marking = reduced.initial
    for _ in range(10):
        assert reduced.enabled(marking)
        marking = reduced.fire(marking, reduced.enabled(marking)[-1])


def test_a_loop_on_one_way_leaves_the_dead_end_of_the_other() -> None:
    net = net_of(
        {"fork": 1}, ({"fork": 1}, {"busy": 1}), ({"busy": 1}, {"busy": 1}), ({"fork": 1}, {"end": 1})
    )
    assert confirm_deadlock(net)
    assert any(not net.enabled(marking) for marking in runs(net) or ())
    # Without the other way there is no dead marking.
    assert confirm_deadlock(net_of({"fork": 1}, ({"fork": 1}, {"busy": 1}), ({"busy": 1}, {"busy": 1})))


def test_transitions_are_compared_by_what_they_change() -> None:
    # Both take from "p" and put one out; the first one takes two at a time.
    net = net_of({"p": 3}, ({"p": 3}, {"p": 1, "out": 1}), ({"p": 1}, {"out": 1}))
    for names in (("out",), ("p", "out"), ("p",)):
        confirmed(net, *names)


def test_what_is_never_marked_is_found_in_time_linear_in_the_arcs() -> None:
    """A place that each step of a long run could mark, if another place were not empty for ever."""
    builder = NetBuilder("hub")
    places = [builder.place(f"p{i}", initial=int(i == 0)) for i in range(STEPS_OF_LINE)]
    hub, never = builder.place("hub"), builder.place("never")
    for i, place in enumerate(places[:-1]):
        builder.transition(f"t{i}", consume=[place], produce=[places[i + 1]])
        builder.transition(f"u{i}", consume=[place, never], produce=[hub])
    draft = Draft(builder.build())
    begun = time.process_time()
    assert drop_never_marked(draft)
    assert time.process_time() - begun < SECONDS
    assert len(draft.pre) == STEPS_OF_LINE - 1
