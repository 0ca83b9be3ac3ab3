"""The alternatives graph: both ways, and the premises that they rest on."""

from __future__ import annotations

from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from hypothesis import given

from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.events import Event
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.markings.graph import StateGraph
from mcpn.spaces.stable import run_to_completion
from mcpn.spaces.stable.alternatives import by_reduction, direct
from tests.nets.nets import nets, reachable
from tests.shares import returns_early
from tests.spaces.runs import markings_of


def test_ulysse_by_both_ways(ulysse_net: MissionNet, ulysse_markings: StateGraph) -> None:
    reduced = by_reduction(ulysse_markings)
    assert (reduced.states, reduced.edges) == (260, 1332)
    for graph in (direct(ulysse_net.net), direct(ulysse_net.net, proof=False)):
        assert np.array_equal(graph.markings, reduced.markings)
        assert np.array_equal(graph.targets, reduced.targets)
        assert np.array_equal(graph.labels, reduced.labels)


def test_ulysse_with_every_failure_routed_to_mission_failure(tmp_path: Path) -> None:
    folder = Path(__file__).parents[2] / "experiments" / "ulysse"
    for name in ("mission.xml", "protocols.xml", "robot.xml"):
        text = (folder / name).read_text()
        for route in (' failure="transect"', ' failure="going_up"'):
            text = text.replace(route, "")
        (tmp_path / name).write_text(text)
    found = compose(read_mission(tmp_path / "mission.xml"))
    markings = explore(found.net)
    assert (len(found.net.places), len(found.net.transitions)) == (133, 150)
    # Counted by two independent explorers before this program was written.
    assert (markings.states, markings.edges) == (40771, 113281)
    reduced = by_reduction(markings)
    assert (reduced.states, reduced.edges) == (260, 1332)


def ends(net: PetriNet, marking: Marking) -> set[Marking] | None:
    """All stable ends of a marking by plain search, or ``None`` if an internal run need not end."""
    found: set[Marking] = set()
    seen = {marking}
    path = [(marking, iter(internal(net, marking)))]
    on_path = {marking}
    if not internal(net, marking):
        return {marking}
    while path:
        at, left = path[-1]
        following = next(left, None)
        if following is None:
            path.pop()
            on_path.discard(at)
        elif following in on_path:
            return None
        elif following not in seen:
            seen.add(following)
            onward = internal(net, following)
            if onward:
                on_path.add(following)
                path.append((following, iter(onward)))
            else:
                found.add(following)
    return found


def internal(net: PetriNet, marking: Marking) -> list[Marking]:
    return [net.fire(marking, t) for t in net.enabled(marking) if net.transitions[t].internal]


@given(nets(max_places=5, max_transitions=7))
def test_premises_are_decided_as_by_plain_search(drawn: PetriNet) -> None:
    net = PetriNet(drawn.name, drawn.places, drawn.transitions, priorities=True)
    markings, _, safe = reachable(net)
    if not safe:
        returns_early("not safe")
        return
    found = [ends(net, marking) for marking in markings]
    divergent = any(e is None for e in found)
    split = any(e is not None and len(e) > 1 for e in found)
    graph = explore(net)
    if divergent or split:
        expected = (ConfluenceError, DivergenceError)
        with pytest.raises(expected) as reduced:
            by_reduction(graph)
        with pytest.raises(expected) as walked:
            direct(net)
        # As where too much is behind the event to be listed.
        with pytest.raises(expected) as kept, mock.patch.object(run_to_completion, "MOST_LISTED", 0):
            direct(net)
        for caught in (reduced.value, walked.value, kept.value):
            if isinstance(caught, DivergenceError):
                assert divergent
                check_divergence(net, caught)
            else:
                assert isinstance(caught, ConfluenceError)
                check_split(net, caught)
        return
    by_reduced, by_walk = by_reduction(graph), direct(net)
    assert np.array_equal(by_reduced.markings, by_walk.markings)
    assert np.array_equal(by_reduced.targets, by_walk.targets)
    assert np.array_equal(by_reduced.labels, by_walk.labels)
    for state in range(by_walk.states):
        assert ends(net, by_walk.marking(state)) == {by_walk.marking(state)}
        for t, target in by_walk.successors(state):
            after = net.fire(by_walk.marking(state), t)
            assert ends(net, after) == {by_walk.marking(target)}


def check_divergence(net: PetriNet, error: DivergenceError) -> None:
    (run,) = error.runs
    markings = markings_of(net, run)
    again = markings.index(markings[-1])
    assert again < len(markings) - 1
    assert all(net.transitions[net.transition_index[name]].internal for name in run[again:])


def check_split(net: PetriNet, error: ConfluenceError) -> None:
    first, second = error.runs
    parted = next(i for i, (a, b) in enumerate(zip(first, second, strict=False)) if a != b)
    for run in (first, second):
        assert all(net.transitions[net.transition_index[name]].internal for name in run[parted:])
    one, other = markings_of(net, first)[-1], markings_of(net, second)[-1]
    assert one != other
    assert not internal(net, one)
    assert not internal(net, other)


def test_an_endless_run_is_told_past_branches_that_end() -> None:
    builder = NetBuilder("branches", priorities=True)
    for place in ("begin", "way", "end", "loop"):
        builder.place(place, initial=int(place == "begin"))
    builder.transition("go", consume=["begin"], produce=["way"])
    builder.transition("arrive", consume=["way"], produce=["end"])
    builder.transition("stray", consume=["begin"], produce=["loop"])
    builder.transition("spin", read=["loop"])
    with pytest.raises(DivergenceError) as caught:
        by_reduction(explore(builder.build()))
    assert caught.value.runs == (("stray", "spin"),)


def test_the_direct_way_without_proof_still_ends_where_it_would_diverge() -> None:
    builder = NetBuilder("loop", priorities=True)
    builder.place("a", initial=1)
    builder.place("b")
    builder.place("c")
    builder.transition("go", consume=["a"], produce=["b"], event=Event.parse("EV"))
    builder.transition("there", consume=["b"], produce=["c"])
    builder.transition("back", consume=["c"], produce=["b"])
    for proof in (True, False):
        with pytest.raises(DivergenceError):
            direct(builder.build(), proof=proof)


def test_limits_say_which_was_hit(ulysse_net: MissionNet) -> None:
    with pytest.raises(LimitError, match="more than 100 stable states"):
        direct(ulysse_net.net, max_states=100)
