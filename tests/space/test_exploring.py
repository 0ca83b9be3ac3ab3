"""Sections whose stable states are listed, and sections reached as diagrams: the composite is the same."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import event, given

from mcpn._kernel import Store
from mcpn.errors import ConfluenceError, DivergenceError
from mcpn.mission.model import Mission, Objective, Recursive
from mcpn.net.compose import MissionNet, compose
from mcpn.net.mortal import mortal
from mcpn.net.sections import SectionParts
from mcpn.space.diagrams.symbolic import reach
from mcpn.space.local import exploring
from mcpn.space.local.composing import composite_space
from mcpn.space.local.exploring import Explored, explore_and_prove, explore_local
from mcpn.space.markings.explicit import KernelNet
from mcpn.space.stable.settling import settled
from mcpn.testing import missions
from mcpn.testing.stacks import stacked_missions
from tests.draws import composed, fewer
from tests.net.nets import nets
from tests.small import activity, hw, mission, robot


def told(mission_net: MissionNet, *, may_die: bool) -> tuple[Any, ...] | type[Exception]:
    """What a composite says: sizes, firings by transition, what leads where."""
    try:
        space = composite_space(mission_net, may_die=may_die)
    except (ConfluenceError, DivergenceError) as error:
        return type(error)
    goals = [space.marked([mission_net.success]), space.marked([mission_net.failure]), space.dead]
    oos = [p for p, (role, _) in mission_net.roles.items() if role == "oos"]
    goals += [space.marked([place]) for place in oos]
    sets = [
        *(space.reaching(goal) for goal in goals),
        *(space.reached(goal) for goal in goals),
        *(space.before(goal) for goal in goals),
        *(space.reaching(goals[0], along=space.everything - goal) for goal in goals[3:]),
    ]
    return (
        space.everything.count(),
        sorted(space.firings(space.everything).items()),
        [found.count() for found in (*goals, *sets)],
        {t: found.count() for goal in goals for t, found in space.crossing(space.everything, goal)},
    )


@fewer(0.5)
@given(missions() | missions(events=2, sections=8) | stacked_missions())
def test_a_section_is_the_same_listed_and_as_a_diagram(of: Mission) -> None:
    mission_net = composed(of)
    for may_die in (False, True):
        listed = told(mission_net, may_die=may_die)
        event("confluent" if isinstance(listed, tuple) else "not confluent")
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(exploring, "MOST_LISTED", 0)
            assert told(mission_net, may_die=may_die) == listed
        if not isinstance(listed, tuple):  # dying is asked of what is confluent
            return


TWO = mission(
    robot(hw("h", "g"), activity("d", ("h",), ("g",), produces=("s",)), activity("a", ("s",), ("g",))),
    Recursive(
        name="r", blocks=(Objective(name="o", activities=("a",)), Objective(name="p", activities=("a",)))
    ),
)


@pytest.mark.parametrize("most", ["MOST_LISTED", "MOST_CHANGES"])
def test_past_each_bound_sections_are_diagrams(most: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found = compose(TWO)
    net = SectionParts(found.usage).alone(found.graph.sections[0]).net().net
    assert explore_local(net).changes
    monkeypatch.setattr(exploring, most, 1)
    assert explore_local(net).changes is None


@pytest.mark.parametrize("listed", [True, False])
@pytest.mark.parametrize("dies", [True, False])
def test_what_is_explored_goes_from_process_to_process(
    listed: bool, dies: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = compose(TWO)
    local = SectionParts(found.usage).alone(found.graph.sections[0]).net()
    dying = mortal(local).net if dies else None
    if not listed:
        monkeypatch.setattr(exploring, "MOST_LISTED", 0)
    here = explore_and_prove(local.net, dying)
    there: Explored = pickle.loads(pickle.dumps(here))
    assert (there.changes is not None) == (here.changes is not None) == listed
    one, other = here.alternatives(), there.alternatives()
    for transition in (None, *one.waiting):
        asked = None if transition is None else [transition]
        for name in ("after", "before"):
            states = [getattr(space, name)(space.everything, asked) for space in (one, other)]
            assert states[0].to_bytes() == states[1].to_bytes()
    assert dies or (there.ends and not there.conflicts)


@given(nets())
def test_changes_of_events_make_every_edge(net: Any) -> None:
    """Each edge of a listing is one change at one of its sources, and no change has another source."""
    net = replace(net, priorities=True)
    prepared = KernelNet(net)
    found = settled(prepared, orders="one", max_states=2_000)
    if found.trouble is not None:
        return
    store = Store(len(net.places))
    changes = store.changes(found, range(len(net.places)), 100_000)
    assert changes is not None
    everything = store.from_exploration(found, range(len(net.places)))
    assert everything.count() == found.states
    assert sum(sources.count() for *_, sources in changes) == found.edges
    edges = {
        (label, tuple(source), tuple(sorted({*source} - {*lost} | {*gained})))
        for label, lost, gained, sources in changes
        for source in sources
    }
    rows, offsets, targets, labels = (
        found.take_markings(), found.take_offsets(), found.take_targets(), found.take_labels()
    )  # fmt: skip
    levels = [tuple(p for p in range(len(net.places)) if int(row[p // 64]) >> p % 64 & 1) for row in rows]
    assert edges == {
        (int(labels[edge]), levels[state], levels[int(targets[edge])])
        for state in range(len(levels))
        for edge in range(int(offsets[state]), int(offsets[state + 1]))
    }


def test_what_was_taken_is_refused() -> None:
    found = compose(TWO)
    prepared = KernelNet(found.net)
    listing = settled(prepared, orders="one", max_states=2_000)
    places = len(found.net.places)
    store = Store(places)
    for bits in ([0], [*range(places - 1), 64 * 64], [*range(places - 1), -2]):
        with pytest.raises(ValueError, match="bit"):
            store.from_exploration(listing, bits)
        with pytest.raises(ValueError, match="bit"):
            store.changes(listing, bits, 10)
    assert store.changes(listing, range(places), 1) is None
    unmarked = store.from_exploration(listing, [-1] * places)
    assert [*unmarked] == [[]]
    listing.take_markings()
    with pytest.raises(ValueError, match="taken"):
        store.from_exploration(listing, range(places))
    with pytest.raises(ValueError, match="taken"):
        store.changes(listing, range(places), 10)
    without = prepared.kernel.explore(prepared.initial, False, 2_000, 1 << 30)
    with pytest.raises(ValueError, match="without its edges"):
        store.changes(without, range(places), 10)


def test_a_listed_section_holds_no_transient_marking() -> None:
    found = compose(TWO)
    local = SectionParts(found.usage).alone(found.graph.sections[0]).net().net
    explored = explore_local(local)
    whole = reach(local)
    assert whole.stable is not None
    assert explored.space.reachable.count() == whole.stable.count() < whole.reachable.count()
