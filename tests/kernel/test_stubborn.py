"""Stubborn sets spare orders, never a verdict: enough orders of internal transitions against every one."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from typing import Literal

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn._kernel import Exploration
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError
from mcpn.events import Event
from mcpn.mission.model import Mission
from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.spaces.markings.explicit import KernelNet
from mcpn.spaces.stable.run_to_completion import Walk, settled
from mcpn.testing import missions
from tests.nets.nets import cascades, conflicting_nets, falls, nets, reachable
from tests.shares import returns_early

MOST = 3_000
"""Stable states of a drawn mission; in every order, a hundred times as many transient markings."""

FEW = 3_000
"""Transient markings in which a run of drawn nets may lose itself before ends are no longer listed."""


def both(net: PetriNet) -> tuple[Exploration, Exploration, KernelNet]:
    """What enough orders and what every order find."""
    prepared = KernelNet(net)
    enough, every = (settled(prepared, orders=orders, max_states=MOST) for orders in ORDERS)
    return enough, every, prepared


ORDERS: tuple[Literal["enough", "every"], ...] = ("enough", "every")


def judged_alike(net: PetriNet) -> str:
    """Both find the same graph, or trouble that is there; what they find."""
    enough, every, prepared = both(net)
    for found in (enough, every):
        if found.trouble is not None:
            shown(net, prepared, found)
    if enough.trouble is None or every.trouble is None:
        assert enough.trouble is None
        assert every.trouble is None
        assert enough.transient <= every.transient
        assert sum(enough.decided) == sum(every.decided) == enough.edges
        assert enough.parted or not enough.decided[-1]
        one, other = prepared.arrays(enough), prepared.arrays(every)
        assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
        return "confluent"
    return enough.trouble[2]


def shown(net: PetriNet, prepared: KernelNet, found: Exploration) -> None:
    """The firings of trouble are a run of the net, and end in what they are said to."""
    assert found.trouble is not None
    state, firings, kind = found.trouble
    last = [prepared.transitions[t] for t in firings]
    walk = Walk(net)
    if not net.transitions[last[0]].internal:
        walk.settle()
        for t in found.run(state):
            walk.fire(prepared.transitions[t])
            walk.settle()
    at = tuple(walk.marking)
    ways = [last.pop(), last.pop()] if kind == "parted" else [last.pop()] if kind == "unsafe" else []
    passed = [at]
    for t in last:
        assert t in net.enabled(at)
        at = net.fire(at, t)
        assert max(at) <= 1
        passed.append(at)
    assert {*ways} <= {*net.enabled(at)}
    if kind == "unsafe":
        assert max(net.fire(at, ways[0])) == 2
    elif kind == "endless":
        assert at in passed[:-1]
        assert all(net.transitions[t].internal for t in last[passed.index(at) :])
    else:
        first, second = (ends(net, net.fire(at, t)) for t in ways)
        if first is not None and second is not None:
            assert len(first) == len(second) == 1
            assert first != second


def ends(net: PetriNet, marking: Marking) -> set[Marking] | None:
    """The stable markings in which internal evolution from a marking ends, unless too many are passed."""
    found, queue, stable = {marking}, [marking], set[Marking]()
    for at in queue:
        enabled = [t for t in net.enabled(at) if net.transitions[t].internal]
        if not enabled:
            stable.add(at)
        for t in enabled:
            after = net.fire(at, t)
            if after not in found:
                found.add(after)
                queue.append(after)
        if len(found) > FEW:
            return None
    return stable


ALL = (
    nets(max_places=7, max_transitions=9)
    | falls()
    | cascades()
    | st.integers(1, 3).flatmap(lambda ranks: conflicting_nets(ranks=ranks))
)


@given(ALL)
def test_enough_orders_judge_as_every_order(drawn: PetriNet) -> None:
    net = PetriNet(drawn.name, drawn.places, drawn.transitions, priorities=True)
    event(judged_alike(net))


@given(missions())
def test_missions_are_judged_alike(mission: Mission) -> None:
    try:
        event(judged_alike(compose(mission).net))
    except LimitError:
        returns_early("too many markings")


@given(ALL)
def test_units_hold_one_token_at_most(net: PetriNet) -> None:
    prepared = KernelNet(net)
    units = prepared.kernel.units(prepared.initial)
    event("units" if units else "no units")
    for marking in reachable(net)[0]:
        if max(marking) == 1:
            assert all(sum(marking[p] for p in unit) <= 1 for unit in units)


@given(missions())
def test_most_places_of_missions_are_in_units(mission: Mission) -> None:
    net = compose(mission).net
    prepared = KernelNet(net)
    covered = {p for unit in prepared.kernel.units(prepared.initial) for p in unit}
    assert len(covered) >= 2 / 3 * len(net.places)  # less than elsewhere where hardware is used by nobody


def side_by_side(machines: int) -> PetriNet:
    """Machines that one event starts, each in as many steps: no two are ever in conflict."""
    builder = NetBuilder("beside", priorities=True)
    builder.place("begin", initial=1)
    names = [[f"m{m}s{s}" for s in range(5)] for m in range(machines)]
    for places in names:
        for place in places:
            builder.place(place)
        for one, other in pairwise(places):
            builder.transition(f"from_{one}", consume=[one], produce=[other])
    builder.transition("go", consume=["begin"], produce=[n[0] for n in names], event=Event.parse("GO"))
    return builder.build()


def test_no_order_of_what_does_not_conflict_is_tried_twice() -> None:
    enough, every, _ = both(side_by_side(6))
    assert (enough.transient, enough.parted) == (0, 0)
    assert every.transient == every.parted == 5**6 - 1
    assert (enough.states, enough.edges) == (2, 1)
    assert enough.decided == [0, 1, 0, 0, 0]
    assert every.decided == [0, 0, 0, 0, 1]


MEANS = {
    "one at a time": ["p -> q", "q ->"],
    "no arcs conflict": ["p -> q", "x ->"],
    "units exclude": ["p -> q", "x ->", "p q ->"],
    "out of reach": ["p -> q", "x ->", "p x never ->"],
    "every way": ["p -> q", "p -> r", "q -> end", "r -> end"],
}
"""By what decides an edge, what may fire behind it, where p is marked, and x if there is one."""


@pytest.mark.parametrize("means", MEANS)
def test_what_decides_an_edge_is_counted(means: str) -> None:
    builder = NetBuilder("means", priorities=True)
    arcs = [[side.split() for side in line.split("->")] for line in MEANS[means]]
    used = {place for sides in arcs for side in sides for place in side}
    for name in sorted({"begin"} | used):
        builder.place(name, initial=int(name == "begin"))
    begun = [place for place in ("p", "x") if place in used]
    builder.transition("go", consume=["begin"], produce=begun, event=Event.parse("GO"))
    for line, (taken, put) in zip(MEANS[means], arcs, strict=True):
        builder.transition(line, consume=taken, produce=put)
    net = builder.build()
    assert judged_alike(net) == "confluent"
    assert both(net)[0].decided == [int(each == means) for each in MEANS]


@pytest.mark.parametrize("length", [1, 50, 6_000])
def test_a_long_circle_of_what_may_fire_alone_is_found(length: int) -> None:
    builder = NetBuilder("circle", priorities=True)
    builder.place("begin", initial=1)
    for number in range(length + 1):
        builder.place(f"c{number}")
    builder.transition("go", consume=["begin"], produce=["c0"], event=Event.parse("GO"))
    for number in range(length + 1):
        builder.transition(f"on{number}", consume=[f"c{number}"], produce=[f"c{(number + 1) % (length + 1)}"])
    net = builder.build()
    prepared = KernelNet(net)
    found = settled(prepared, orders="enough", max_states=10)
    assert found.trouble is not None
    assert found.trouble[2] == "endless"
    assert len(found.trouble[1]) >= length + 2  # the event, and once round
    if length < 100:
        shown(net, prepared, found)


def test_a_token_that_some_order_puts_twice_is_found() -> None:
    """Alone, the first to fire takes the token away before the second one comes."""
    builder = NetBuilder("twice", priorities=True)
    for name in ("begin", "a", "b", "held", "out"):
        builder.place(name, initial=int(name == "begin"))
    builder.transition("go", consume=["begin"], produce=["a", "b"], event=Event.parse("GO"))
    builder.transition("out", consume=["held"], produce=[])
    builder.transition("one", consume=["a"], produce=["held"])
    builder.transition("other", consume=["b"], produce=["held"])
    assert judged_alike(builder.build()) == "unsafe"


def test_no_orders_by_another_name() -> None:
    prepared = KernelNet(side_by_side(1))
    with pytest.raises(ValueError, match="one, enough or every"):
        prepared.kernel.settle([0], "all", 10, 10, 1 << 30)  # type: ignore[arg-type]


def test_only_nets_with_priorities_are_settled() -> None:
    prepared = KernelNet(replace(side_by_side(1), priorities=False))
    with pytest.raises(ValueError, match="a net with priorities"):
        settled(prepared, orders="enough", max_states=10)


CROWD = """
import resource
from mcpn._kernel import SafeNet
net = SafeNet(2, [([0], [0], [1], 0, False)] * 30_000, False)
found = net.explore([0], False, 10, 1 << 30)
print(found.states, found.edges, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10)
"""


def test_many_transitions_that_share_a_place_take_memory_in_proportion() -> None:
    """All pairs of them would be 900 million numbers, twice."""
    ran = subprocess.run([sys.executable, "-c", CROWD], capture_output=True, text=True, check=False)
    states, edges, megabytes = map(int, ran.stdout.split())
    assert (states, edges) == (2, 30_000)
    assert megabytes < 2_000
