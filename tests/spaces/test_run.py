"""Runs of fewest events, against shortest paths of another library; how runs are completed."""

from __future__ import annotations

from typing import Any

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.errors import LimitError, SemanticsError, UnsafeError
from mcpn.mission.model import Mission
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.algebra import S, Space
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.run import Completion, Run, run_of_fewest_events
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from mcpn.testing.stacked import stacked_missions
from tests.draws import composed, fewer
from tests.nets.nets import nets


@given(nets(events=True), st.data())
def test_no_run_has_fewer_events(net: PetriNet, data: st.DataObject) -> None:
    try:
        graph = explore(net, max_states=300)
    except (UnsafeError, LimitError):
        return
    weighted: nx.DiGraph[int] = nx.DiGraph()
    weighted.add_nodes_from(range(graph.states))
    for source, label, target in zip(graph.sources, graph.labels, graph.targets, strict=True):
        cost = int(not net.transitions[int(label)].internal)
        known = weighted.get_edge_data(int(source), int(target), {"weight": 1})
        weighted.add_edge(int(source), int(target), weight=min(cost, known["weight"]))
    fewest = nx.single_source_dijkstra_path_length(weighted, 0)
    places = data.draw(st.sets(st.integers(0, len(net.places) - 1), min_size=1))
    wanted = [s for s in range(graph.states) if any(graph.marking(s)[p] for p in places)]
    least = min((fewest[s] for s in wanted), default=None)
    check(net, ArraySpace(graph), places, least)
    check(net, DiagramMarkings(reach(net)), places, least)


def check(net: PetriNet, space: Space[S], places: set[int], least: float | None) -> None:
    run = run_of_fewest_events(space, space.marked(places))
    if least is None:
        assert run is None
        return
    assert run is not None
    marking = net.initial
    for edge in run:
        assert edge.transition in net.enabled(marking)
        marking = net.fire(marking, edge.transition)
    assert any(marking[p] for p in places)
    assert sum(not net.transitions[edge.transition].internal for edge in run) == least


def test_a_run_takes_guarded_edges_only_where_it_may() -> None:
    """Two ways to the goal of one length, of which the first one is barred at the start."""
    builder = NetBuilder("two ways")
    for name in ("start", "left", "right", "goal"):
        builder.place(name, initial=int(name == "start"))
    for source, target in (("start", "left"), ("start", "right"), ("left", "goal"), ("right", "goal")):
        builder.transition(f"{source} {target}", consume=[source], produce=[target])
    net = builder.build()

    def run(space: Space[S], guards: dict[int, S]) -> list[str] | None:
        found = space.run(space.initial.pick(), space.marked([3]), None, None, guards)
        return None if found is None else [net.transitions[edge.transition].name for edge in found]

    spaces: tuple[Space[Any], ...] = ArraySpace(explore(net)), DiagramMarkings(reach(net))
    for space in spaces:
        barred = space.marked([1])
        assert run(space, {0: barred}) == ["start right", "right goal"]
        assert run(space, {1: barred}) == ["start left", "left goal"]
        assert run(space, {0: barred, 3: space.nothing}) is None


@fewer(0.5)
@given(missions() | stacked_missions(), st.data())
def test_what_waits_in_a_crowd_is_found_by_its_rarest_place(given_: Mission, data: st.DataObject) -> None:
    net = composed(given_).net
    try:
        graph = direct(net, max_states=3_000)
    except (LimitError, SemanticsError):
        return
    end = data.draw(st.integers(0, graph.states - 1))
    edges = graph.run_to(np.arange(graph.states) == end)
    assert edges is not None
    events = tuple(int(graph.labels[edge]) for edge in edges)

    def stable() -> list[tuple[int, ...]]:
        """The markings at events, and the last. What fires between them is one of several ways there."""
        found, last = list[tuple[int, ...]](), net.initial
        for t, at in Run(net, events, settles=True).steps():
            assert t in net.enabled(last)
            if not net.transitions[t].internal:
                found.append(last)
            last = tuple(at)
        assert not any(net.transitions[t].internal for t in net.enabled(last))
        return [*found, last]

    apart = stable()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mcpn.spaces.run.MOST_BESIDE", 0)
        assert stable() == apart
        for edge in range(int(graph.offsets[end]), int(graph.offsets[end + 1])):
            _, after = Completion(net).after(graph.marking(end), int(graph.labels[edge]))
            assert after == graph.marking(int(graph.targets[edge]))
    assert apart[-1] == graph.marking(end)
