"""Big steps against the listing of stable states: the same states, edges, closures, on nets and missions."""

from __future__ import annotations

import struct
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn._kernel import BigSteps, Store, Zdd, choices
from mcpn.mission.model import Mission, Objective, Parallel
from mcpn.net.compose import compose
from mcpn.net.petri import PetriNet
from mcpn.space.diagrams.encoding import Encoding
from mcpn.space.diagrams.symbolic import DEFAULT_MEMORY, SymbolicSpace
from mcpn.space.markings.explicit import KernelNet
from mcpn.space.stable import big_steps
from mcpn.space.stable.big_steps import BigStepSpace, reach_in_big_steps
from mcpn.space.stable.completion import settled
from mcpn.testing import missions
from mcpn.testing.stacks import stacked_missions
from tests.draws import composed, fewer
from tests.net.nets import nets
from tests.small import activity, hw, mission, robot

MOST = 2_000
"""Stable states that are listed."""

ALONE = mission(robot(hw("h"), activity("a", ("h",), ())), Objective(name="o", activities=("a",)))

Listed = tuple[list[tuple[int, ...]], set[tuple[int, int, int]]]


def listed(net: PetriNet) -> Listed | None:
    """Stable markings as marked places, and edges, all interleavings explored; ``None`` with trouble."""
    prepared = KernelNet(net)
    found = settled(prepared, orders="every", max_states=MOST)
    if found.trouble is not None:
        return None
    rows, offsets, targets, labels = (
        found.take_markings(), found.take_offsets(), found.take_targets(), found.take_labels()
    )  # fmt: skip
    states = [tuple(p for p in range(len(net.places)) if int(row[p // 64]) >> p % 64 & 1) for row in rows]
    edges = {
        (state, prepared.transitions[int(labels[edge])], int(targets[edge]))
        for state in range(len(states))
        for edge in range(int(offsets[state]), int(offsets[state + 1]))
    }
    return states, edges


def stepped(net: PetriNet) -> tuple[BigStepSpace, dict[int, bytes]] | None:
    """The same by big steps."""
    encoding = Encoding(net, tuple(range(len(net.places))), DEFAULT_MEMORY)
    found = reach_in_big_steps(KernelNet(net), encoding)
    if found is None:
        return None
    states, steps = found
    space = SymbolicSpace(encoding, states, states, "file", encoding.places, encoding.store.peak_nodes)
    return BigStepSpace(space, {**steps}, {}), steps


def places_of(space: BigStepSpace, states: Zdd) -> set[tuple[int, ...]]:
    """Some states as their marked places."""
    marked = (enumerate(space.marking(state)) for state in states)
    return {tuple(p for p, tokens in marking if tokens) for marking in marked}


def agree(net: PetriNet) -> None:
    """Big steps are as the listing has it, and where it comes to trouble they are refused."""
    one, other = listed(net), stepped(net)
    event("no outcome, or two" if one is None else f"states: {min(len(one[0]), 20) // 5 * 5} or more")
    assert (one is None) == (other is None)
    if one is None or other is None:
        return
    (states, edges), (space, steps) = one, other
    assert places_of(space, space.everything) == {*states}
    assert {*steps} == {t for _, t, _ in edges}
    for t in (None, *steps):
        asked = None if t is None else [t]
        for number, state in enumerate(states):
            here = space.encoding.set_of([int(p in state) for p in range(len(net.places))])
            after = {states[b] for a, u, b in edges if a == number and u == (u if t is None else t)}
            assert places_of(space, space.after(here, asked)) == after
            before = {states[a] for a, u, b in edges if b == number and u == (u if t is None else t)}
            assert places_of(space, space.before(here, asked)) == before
            if number >= 20:
                break


@given(nets())
def test_big_steps_of_nets(net: PetriNet) -> None:
    agree(replace(net, priorities=True))


@fewer(0.3)
@given(missions() | missions(events=2, sections=4) | stacked_missions())
def test_big_steps_of_missions(of: Mission) -> None:
    net = composed(of).net
    if settled(KernelNet(net), orders="one", max_states=50_000).states < 400:
        agree(net)


@fewer(0.3)
@given(missions() | stacked_missions(), st.data())
def test_closures_are_those_of_one_step_after_the_other(of: Mission, data: st.DataObject) -> None:
    found = stepped(composed(of).net)
    if found is None:
        return
    space, steps = found
    events = [*steps]
    asked = data.draw(st.none() | st.lists(st.sampled_from(events), unique=True)) if events else None
    conditions = [
        p for p in range(len(space.net.places)) if space.marked([p]) not in (space.nothing, space.everything)
    ]
    drawn = [
        space.marked([data.draw(st.sampled_from(conditions))]) if conditions else space.everything
        for _ in range(3)
    ]
    goal, along, guard = drawn
    guards = data.draw(st.none() | st.just(dict.fromkeys(events[:2], guard)))

    def closed(begin: Zdd, step: Any, within: Zdd) -> Zdd:
        states = begin
        while (more := states | (step(states, asked, guards) & within)) != states:
            states = more
        return states

    assert space.reaching(goal, along, asked, guards) == closed(goal, space.before, along)
    assert space.reached(goal, along, asked, guards) == closed(goal & along, space.after, along)


def test_few_big_steps_tell_of_many_states() -> None:
    """Three branches with hardware of their own: what befalls one is a big step whatever the others do."""
    names = ("a", "b", "c")
    branches = tuple(Objective(name=f"o{name}", activities=(name,)) for name in names)
    activities = (activity(name, (f"h{name}",), ()) for name in names)
    of = mission(robot(hw("ha", "hb", "hc"), *activities), Parallel(name="p", blocks=branches))
    one, other = listed(compose(of).net), stepped(compose(of).net)
    assert one is not None
    assert other is not None
    assert sum(map(rows_in, other[1].values())) * 4 < len(one[1])


def rows_in(steps: bytes) -> int:
    """How many big steps stand in some bytes."""
    numbers, count, at = struct.unpack(f"={len(steps) // 4}I", steps), 0, 0
    while at < len(numbers):
        at += 1 + numbers[at]
        count += 1
    return count


def test_the_bound_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    net = compose(ALONE).net
    assert stepped(net)
    monkeypatch.setattr(big_steps, "MOST_STEPS", 1)
    assert stepped(net) is None


def test_what_is_asked_wrongly_is_refused() -> None:
    net = compose(ALONE).net
    prepared = KernelNet(net)
    places = [*range(len(net.places))]
    store = Store(len(places))
    for wrong in ([*places[:-1], len(places)], [*places[:-1], -2]):
        with pytest.raises(ValueError, match="no such place"):
            BigSteps(prepared.kernel, prepared.initial, wrong, [], 1 << 30, 100)
    with pytest.raises(ValueError, match="no such level"):
        BigSteps(prepared.kernel, prepared.initial, places, [(0, len(places))], 1 << 30, 100)
    kernel = BigSteps(prepared.kernel, prepared.initial, places, [], 1 << 30, 100)
    with pytest.raises(ValueError, match="other levels"):
        kernel.start(Store(len(places) + 1))
    start = kernel.start(store)
    assert start is not None
    with pytest.raises(ValueError, match="no such event"):
        kernel.cover(start, 0, 10)  # an internal transition
    label = next(i for i, t in enumerate(prepared.transitions) if not net.transitions[t].internal)
    assert kernel.cover(start, label, 0) is None
    with pytest.raises(ValueError, match="trouble"):
        kernel.cover(start, label, 10)
    for bad in (
        b"123",
        struct.pack("=2I", 2, 1),
        struct.pack("=2I", 1, len(places) * 4),
        struct.pack("=3I", 2, 5, 4),
    ):
        with pytest.raises(ValueError, match=r"big steps|levels"):
            choices(store, bad, "ahead", [])
    with pytest.raises(ValueError, match="no way"):
        choices(store, b"", "ahead", [])
    with pytest.raises(ValueError, match="ahead, back or where"):
        choices(store, struct.pack("=2I", 1, 4), "sideways", [])
    with pytest.raises(ValueError, match="named twice"):
        choices(store, struct.pack("=2I", 1, 4), "ahead", [1])
