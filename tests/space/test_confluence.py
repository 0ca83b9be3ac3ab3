"""The symbolic proof: where it says yes, every other way agrees; where it says no, nothing is lost."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from mcpn.errors import ConfluenceError, DivergenceError, LimitError, SemanticsError, UnsafeError
from mcpn.mission.model import Mission
from mcpn.net.compose import MissionNet, compose
from mcpn.net.events import Event
from mcpn.net.petri import NetBuilder, PetriNet
from mcpn.space.alternatives import AlternativesGraph, by_reduction
from mcpn.space.confluence import PROOF, direct_with_proof, open_conflicts
from mcpn.space.explicit import explore
from mcpn.space.symbolic import reach
from mcpn.testing import missions
from tests.net.nets import nets, reachable
from tests.shares import returns_early


def same(one: AlternativesGraph, other: AlternativesGraph) -> bool:
    parts = ("markings", "offsets", "targets", "labels")
    return all(np.array_equal(getattr(one, part), getattr(other, part)) for part in parts)


@given(nets(max_places=5, max_transitions=7))
def test_a_proof_is_never_wrong(drawn: PetriNet) -> None:
    net = PetriNet(drawn.name, drawn.places, drawn.transitions, priorities=True)
    if not reachable(net)[2]:
        with pytest.raises(UnsafeError):
            direct_with_proof(net)
        return
    graph = explore(net)
    try:
        reduced = by_reduction(graph)
    except (ConfluenceError, DivergenceError):
        with pytest.raises((ConfluenceError, DivergenceError)):
            direct_with_proof(net)
        return
    assert same(direct_with_proof(net), reduced)


@given(missions())
def test_missions_have_the_same_graph_with_either_proof(mission: Mission) -> None:
    net = compose(mission).net
    try:
        reduced = by_reduction(explore(net, max_states=20_000))
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    assert same(direct_with_proof(net), reduced)


def test_ulysse_is_proved_symbolically(ulysse_net: MissionNet) -> None:
    graph = direct_with_proof(ulysse_net.net)
    assert (graph.states, graph.edges, graph.proof) == (260, 1332, PROOF)
    assert list(open_conflicts(reach(ulysse_net.net))) == []


def test_a_conflict_that_no_marking_enables_is_no_obstacle() -> None:
    builder = NetBuilder("apart", priorities=True)
    for place, tokens in (("a", 1), ("b", 0), ("left", 0), ("right", 0), ("x", 0), ("y", 0)):
        builder.place(place, initial=tokens)
    builder.transition("go_left", consume=["a"], produce=["b", "left"], event=Event.parse("LEFT"))
    builder.transition("go_right", consume=["a"], produce=["b", "right"], event=Event.parse("RIGHT"))
    builder.transition("one", consume=["b", "left"], produce=["x"])
    builder.transition("other", consume=["b", "right"], produce=["y"])
    assert direct_with_proof(builder.build()).proof == PROOF


def test_a_conflict_that_rejoins_is_decided_edge_by_edge() -> None:
    builder = NetBuilder("rejoin", priorities=True)
    for place, tokens in (("a", 1), ("b", 0), ("x", 0), ("y", 0), ("end", 0)):
        builder.place(place, initial=tokens)
    builder.transition("go", consume=["a"], produce=["b"], event=Event.parse("GO"))
    builder.transition("one", consume=["b"], produce=["x"])
    builder.transition("other", consume=["b"], produce=["y"])
    builder.transition("from_x", consume=["x"], produce=["end"])
    builder.transition("from_y", consume=["y"], produce=["end"])
    graph = direct_with_proof(builder.build())
    assert (graph.states, graph.edges) == (2, 1)
    assert graph.proof is not None
    assert graph.proof != PROOF
