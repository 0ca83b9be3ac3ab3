"""Losing regions on diagrams against those on listed states; cut sets on diagrams against the others."""

from __future__ import annotations

from collections import Counter

import numpy as np
from hypothesis import given, settings

from mcpn.check.cutsets import Losses, Moment
from mcpn.check.losing import Goal, Outlook
from mcpn.check.losing_symbolic import SymbolicOutlook, symbolic_cut_sets
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.net.compose import MissionNet, compose
from mcpn.net.events import Event
from mcpn.space.alternatives import direct
from mcpn.space.explicit import explore
from mcpn.space.symbolic import reach
from mcpn.testing import missions
from tests.check.oracle import fragile_missions
from tests.shares import returns_early


def agree(found: MissionNet, max_states: int) -> None:
    """Regions on the stable markings, on all markings and on the diagram are the same."""
    stable = Outlook(found, direct(found.net, max_states=max_states))
    everything = Outlook(found, explore(found.net))
    symbolic = SymbolicOutlook(found, reach(found.net))
    space = symbolic.space
    assert space.stable is not None
    levels = {place: level for level, place in enumerate(space.encoding.places)}

    def on_levels(marking: tuple[int, ...]) -> tuple[int, ...]:
        return tuple(sorted(levels[p] for p, tokens in enumerate(marking) if tokens and p in levels))

    pairs = [(stable.mission, everything.mission)]
    pairs += [(goal, everything.objectives[name]) for name, goal in stable.objectives.items()]
    for on_stable, on_all in pairs:
        for repairs in (True, False):
            if on_stable.kind == "mission":
                losing = symbolic.losing(repairs)
                open_ = space.reachable - symbolic.marked(found.success)
            else:
                losing = symbolic.losing_objective(on_stable.name, repairs)
                open_ = symbolic.marked(*found.by_role["objective", on_stable.name])
            listed = everything.losing(on_all, repairs)
            assert losing.count() == listed.sum()
            states = np.flatnonzero(stable.losing(on_stable, repairs)).tolist()
            assert {tuple(m) for m in losing & space.stable} == {
                on_levels(stable.graph.marking(s)) for s in states
            }
            if on_stable.kind == "mission":
                assert symbolic.critical(losing, open_, repairs) == crossings(stable, on_stable, repairs)


def crossings(outlook: Outlook, goal: Goal, repairs: bool) -> dict[Event | None, int]:
    edges = np.flatnonzero(outlook.crossing(goal, repairs)).tolist()
    transitions = outlook.graph.net.transitions
    return dict(Counter(transitions[int(outlook.graph.labels[e])].event for e in edges))


def test_ulysse_regions_agree(ulysse_net: MissionNet) -> None:
    agree(ulysse_net, 1000)


@settings(max_examples=40)
@given(
    missions(max_objectives=2, max_sections=5, max_hardware=2, max_producers=2)
    | fragile_missions(max_objectives=2, max_sections=5, max_hardware=3)
)
def test_regions_of_three_engines_agree(mission: Mission) -> None:
    found = compose(mission)
    try:
        agree(found, max_states=300)
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return


@settings(max_examples=60)
@given(
    missions(max_objectives=2, max_sections=5, max_hardware=3, max_producers=2)
    | fragile_missions(max_hardware=4)
)
def test_cut_sets_on_diagrams_are_those_of_the_graph(mission: Mission) -> None:
    found = compose(mission)
    try:
        losses = Losses(Outlook(found, direct(found.net, max_states=2000)))
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    outlook = losses.outlook
    names = list(outlook.objectives)
    start, ever = symbolic_cut_sets(found, names)
    assert start == losses.listed(losses.cut_sets(outlook.mission, Moment.START))
    for name in names:
        assert ever[name] == losses.listed(losses.cut_sets(outlook.objectives[name], Moment.START))
