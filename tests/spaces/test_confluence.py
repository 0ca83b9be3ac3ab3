"""Proofs of confluence: where one says yes, every other way agrees; where it says no, nothing is lost."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable
from functools import reduce
from operator import or_

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from mcpn._kernel import Zdd
from mcpn.composite.clash import find_clash
from mcpn.composite.composing import composite_space
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, DivergenceError, LimitError, SemanticsError, UnsafeError
from mcpn.events import Event
from mcpn.mission.model import Mission
from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.diagrams.internal_evolution import leading
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import AlternativesGraph, by_reduction, direct, direct_with_proof
from mcpn.spaces.stable.confluence_by_ranks import open_conflicts
from mcpn.spaces.stable.confluence_by_sets import (
    PROOF_BY_PATTERNS,
    PROOF_OF_ENDS,
    proof_of_conflicts,
    prove_confluent,
)
from mcpn.spaces.stable.nearest_nonconfluence import fault_by, nearest_fault
from mcpn.spaces.stable.run_to_completion import PROOF_BY_MARKINGS, fault_after
from mcpn.testing import missions
from tests.nets.nets import cascades, conflicting_nets, graph_of, made_safe, nets, reachable, reordered
from tests.shares import returns_early


def same(one: AlternativesGraph, other: AlternativesGraph) -> bool:
    parts = ("markings", "offsets", "targets", "labels")
    return all(np.array_equal(getattr(one, part), getattr(other, part)) for part in parts)


@given(nets(max_places=5, max_transitions=7))
def test_a_proof_is_never_wrong(drawn: PetriNet) -> None:
    net = PetriNet(drawn.name, drawn.places, drawn.transitions, priorities=True)
    if not reachable(net)[2]:
        with pytest.raises(SemanticsError) as caught:
            direct_with_proof(net)
        if isinstance(caught.value, UnsafeError):
            doubles(net, caught.value)
        else:  # either of two faults may be told
            ends_differ(net, caught.value)
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
    assert (graph.states, graph.edges, graph.proof) == (260, 1332, PROOF_BY_MARKINGS)
    space = reach(ulysse_net.net)
    assert prove_confluent(ulysse_net.net, space=space) == PROOF_OF_ENDS
    assert list(open_conflicts(space.encoding, space.reachable)) == []


def test_a_conflict_that_no_marking_enables_is_no_obstacle() -> None:
    builder = NetBuilder("apart", priorities=True)
    for place, tokens in (("a", 1), ("b", 0), ("left", 0), ("right", 0), ("x", 0), ("y", 0)):
        builder.place(place, initial=tokens)
    builder.transition("go_left", consume=["a"], produce=["b", "left"], event=Event.parse("LEFT"))
    builder.transition("go_right", consume=["a"], produce=["b", "right"], event=Event.parse("RIGHT"))
    builder.transition("one", consume=["b", "left"], produce=["x"])
    builder.transition("other", consume=["b", "right"], produce=["y"])
    assert prove_confluent(builder.build()) == PROOF_OF_ENDS
    assert same(direct_with_proof(builder.build()), by_reduction(explore(builder.build())))


@given(nets(max_places=6, max_transitions=9) | nets(max_places=6, max_transitions=9).map(made_safe))
def test_the_proof_decides_what_a_list_of_all_markings_decides(drawn: PetriNet) -> None:
    net = PetriNet(drawn.name, drawn.places, drawn.transitions, priorities=True)
    if not reachable(net)[2]:
        returns_early("not 1-safe")
        return
    try:
        by_reduction(explore(net))
        expected: type[SemanticsError] | None = None
    except SemanticsError as error:
        expected = type(error)
        ends_differ(net, error)
        with pytest.raises(SemanticsError) as caught:
            direct(net)
        ends_differ(net, caught.value)
    near = nearest_fault(net)
    if near is not None:
        assert expected is not None
        ends_differ(net, near)
    try:
        proof_of_conflicts(reach(net))
    except (ConfluenceError, DivergenceError) as error:
        assert expected is not None
        ends_differ(net, error)
        event("parts")
    else:
        assert expected is None
        event("rejoins")


@settings(max_examples=max(3 * settings().max_examples, 100))  # small nets: a hundredth of a second each
@given(
    st.integers(1, 3).flatmap(lambda ranks: conflicting_nets(ranks=ranks)) | cascades(),
    st.integers(0, 2**32),
)
def test_conflicts_are_judged_alike_in_every_order(drawn: PetriNet, seed: int) -> None:
    """The proof against every marking; places and transitions in several orders."""
    order, ends = random.Random(seed), list[bool]()
    try:
        by_reduction(explore(drawn))
        confluent = True
    except ConfluenceError:
        confluent = False
    event("confluent" if confluent else "not confluent")
    for net in (drawn, *(reordered(drawn, order) for _ in range(5))):
        space = reach(net)
        nothing_open = next(open_conflicts(space.encoding, space.reachable), None) is None
        assert confluent or not nothing_open
        try:
            proof_of_conflicts(space)
            ends.append(True)
        except ConfluenceError as error:
            ends_differ(net, error)
            ends.append(False)
    assert ends == [confluent] * len(ends)


@settings(max_examples=max(2 * settings().max_examples, 80))  # nets of a few markings
@given(nets(max_places=5, max_transitions=7) | conflicting_nets(ranks=3), st.integers(0, 2**32))
def test_internal_runs_are_followed_back_by_rank(drawn: PetriNet, seed: int) -> None:
    net = PetriNet(drawn.name, drawn.places, drawn.transitions, priorities=True)
    graph = graph_of(net)
    if graph is None or not reachable(net)[2]:
        event("not 1-safe")
        return
    space, markings = reach(net), sorted(graph)
    internal = {m: [a for t, a in after if net.transitions[t].internal] for m, after in graph.items()}
    stable = {m for m in markings if not internal[m]}

    def leading_to(goal: set[Marking]) -> set[Marking]:
        while more := {m for m in markings if m not in goal and not goal.isdisjoint(internal[m])}:
            goal = goal | more
        return goal

    def told(some: Iterable[Marking]) -> Zdd:
        return reduce(or_, map(space.encoding.set_of, some), space.encoding.store.empty())

    assert space.endless == told(set(markings) - leading_to(stable))
    goal = {random.Random(seed).choice(markings)}
    found = leading(space.encoding, told(goal), space.allowed)
    assert found & space.reachable == told(leading_to(goal))


@settings(max_examples=max(5 * settings().max_examples, 150))  # nets of a few dozen markings
@given(cascades())
def test_where_no_conflict_is_open_the_end_is_one(drawn: PetriNet) -> None:
    """What follows several steps brings about conflicts that each step alone does not."""
    space = reach(drawn)
    if next(open_conflicts(space.encoding, space.reachable), None) is None:
        event("nothing is open")
        by_reduction(explore(drawn))


@pytest.mark.parametrize(("endless", "forks"), [(True, False), (False, True), (True, True)])
def test_runs_of_an_error_behind_events(endless: bool, forks: bool) -> None:
    builder = NetBuilder("behind", priorities=True)
    for place in ("begin", "begun", "at", "long", "longer", "left", "right", "top"):
        builder.place(place, initial=int(place == "begin"))
    builder.transition("first", consume=["begin"], produce=["begun"], event=Event.parse("FIRST"))
    builder.transition("second", consume=["begun"], produce=["at"], event=Event.parse("SECOND"))
    # The first way is long, or never ends.
    builder.transition("to_long", consume=["at"], produce=["long"])
    builder.transition("on", consume=["long"], produce=["longer"])
    builder.transition("up", consume=["longer"], produce=["long" if endless else "top"])
    if forks:
        builder.transition("to_left", consume=["at"], produce=["left"])
        builder.transition("to_right", consume=["at"], produce=["right"])
    net = builder.build()
    builds: tuple[Callable[[], object], ...] = (lambda: by_reduction(explore(net)), lambda: direct(net))
    for build in builds:
        with pytest.raises(SemanticsError) as caught:
            build()
        error = caught.value
        assert {run[:2] for run in error.runs} == {("first", "second")}
        ends_differ(net, error)
        assert endless or isinstance(error, ConfluenceError)
        assert forks or isinstance(error, DivergenceError)
        if isinstance(error, ConfluenceError):
            assert error.events == ("FIRST", "SECOND")
            assert "after SECOND" in str(error)


def ends_differ(net: PetriNet, error: SemanticsError) -> None:
    """The runs of an error fire, and end in stable markings that differ; one that has no end comes back."""
    ends = []
    for run in error.runs:
        passed = [net.initial]
        for name in run:
            t = net.transition_index[name]
            assert t in net.enabled(passed[-1])
            passed.append(net.fire(passed[-1], t))
        ends.append(passed[-1])
        if isinstance(error, DivergenceError):
            assert passed[-1] in passed[:-1]
            since = run[passed.index(passed[-1]) :]
            assert all(net.transitions[net.transition_index[name]].internal for name in since)
    if isinstance(error, ConfluenceError):
        assert ends[0] != ends[1]
        for end in ends:
            assert all(not net.transitions[t].internal for t in net.enabled(end))


def doubles(net: PetriNet, error: UnsafeError) -> None:
    """The run of an error fires, and the last firing puts a second token in the place."""
    marking = net.initial
    for name in (*error.run, error.transition) if error.transition else ():
        assert max(marking) <= 1
        t = net.transition_index[name]
        assert t in net.enabled(marking)
        marking = net.fire(marking, t)
    assert marking[net.place_index[error.place]] > 1


@given(missions())
@settings(max_examples=30)
def test_a_contended_mission_is_judged_alike_by_every_proof(mission: Mission) -> None:
    mission_net = compose(mission)
    try:
        by_reduction(explore(mission_net.net, max_states=20_000))
        expected: type[SemanticsError] | None = None
    except LimitError:
        returns_early("too many markings")
        return
    except SemanticsError as error:
        expected = type(error)
    event(f"{expected}")
    near = nearest_fault(mission_net.net)
    assert near is None or expected is not None
    if isinstance(near, ConfluenceError):
        clash = find_clash(mission_net, near)
        rivals = tuple(sorted(rival.name for rival in clash.rivals))
        listed = {(c.wanted, c.rivals) for c in mission_net.usage.contentions}
        assert clash.kind != "hardware" or {(wanted, rivals) for wanted in clash.wanted} <= listed
    found: SemanticsError | None = None
    for prove in (lambda: proof_of_conflicts(reach(mission_net.net)), lambda: composite_space(mission_net)):
        try:
            prove()
            found = None
        except SemanticsError as error:
            found = error
            ends_differ(mission_net.net, error)
        assert (found is None) == (expected is None)


def test_a_conflict_that_rejoins_by_ways_of_any_length_is_joined() -> None:
    builder = NetBuilder("rejoin", priorities=True)
    for place, tokens in (("a", 1), ("b", 0), ("x", 0), ("y", 0), ("end", 0)):
        builder.place(place, initial=tokens)
    builder.transition("go", consume=["a"], produce=["b"], event=Event.parse("GO"))
    builder.transition("one", consume=["b"], produce=["x"])
    builder.transition("other", consume=["b"], produce=["y"])
    builder.transition("from_x", consume=["x"], produce=["end"])
    builder.transition("from_y", consume=["y"], produce=["end"])
    graph = direct_with_proof(builder.build())
    assert (graph.states, graph.edges, graph.proof) == (2, 1, PROOF_BY_MARKINGS)
    assert prove_confluent(builder.build()) == PROOF_BY_PATTERNS
    builder.transition("straight", consume=["b"], produce=["end"])
    graph = direct_with_proof(builder.build())
    assert (graph.states, graph.edges, graph.proof) == (2, 1, PROOF_BY_MARKINGS)
    assert prove_confluent(builder.build()) == PROOF_BY_PATTERNS
    builder.transition("back", consume=["x"], produce=["b"])
    with pytest.raises(DivergenceError):
        direct_with_proof(builder.build())


def torn_behind(*ways: tuple[str, ...]) -> PetriNet:
    """Runs of events from the start, in this order, to a marking in which one of two comes first."""
    builder = NetBuilder("torn", priorities=True)
    for name, tokens in (("start", 1), ("torn", 0), ("one", 0), ("two", 0)):
        builder.place(name, initial=tokens)
    for way in ways:
        at = "start"
        for number, happens in enumerate(way):
            last = number == len(way) - 1
            after = "torn" if last else builder.place(f"{'-'.join(way)} {number}")
            builder.transition(
                f"{'-'.join(way)}: {happens}", consume=[at], produce=[after], event=Event.parse(happens)
            )
            at = after
    builder.transition("left", consume=["torn"], produce=["one"])
    builder.transition("right", consume=["torn"], produce=["two"])
    return builder.build()


@pytest.mark.parametrize(
    ("ways", "nearest"),
    [
        ((("A", "B"), ("C",)), ("C",)),
        ((("C",), ("A", "B")), ("C",)),
        # A failure before the last event counts twice, and so does a repair.
        ((("H_EV_OOS", "A"), ("OBJ_x_EV_OK", "B")), ("OBJ_x_EV_OK", "B")),
        ((("H_EV_RD", "A"), ("OBJ_x_EV_OK", "B")), ("OBJ_x_EV_OK", "B")),
        ((("H_EV_OOS", "A"), ("B", "C", "D", "E")), ("H_EV_OOS", "A")),
        ((("H_EV_OOS", "G_EV_OOS", "A"), ("B", "C", "D", "E")), ("B", "C", "D", "E")),
    ],
)
def test_the_nearest_fault_has_few_events_and_fewer_failures(
    ways: tuple[tuple[str, ...], ...], nearest: tuple[str, ...]
) -> None:
    net = torn_behind(*ways)
    error = nearest_fault(net)
    assert isinstance(error, ConfluenceError)
    assert error.events == nearest
    assert {run[-1] for run in error.runs} == {"left", "right"}
    # The rivals have no element of a mission: they are named themselves.
    assert f"after {nearest[-1]} the outcome depends on the interleaving of" in str(error)
    assert "left" in str(error)
    assert "right" in str(error)
    assert nearest_fault(net, firings=0) is None


def test_a_fault_before_any_event_is_the_nearest() -> None:
    builder = NetBuilder("torn", priorities=True)
    for name in ("torn", "one", "two"):
        builder.place(name, initial=int(name == "torn"))
    for name, after in (("left", "one"), ("right", "two")):
        builder.transition(name, consume=["torn"], produce=[after])
    error = nearest_fault(builder.build())
    assert isinstance(error, ConfluenceError)
    assert error.events == ()
    assert "at the start the outcome depends" in str(error)


@pytest.mark.parametrize("fault", [fault_by, fault_after])
def test_a_run_of_events_ends_at_the_first_that_has_two_outcomes(
    fault: Callable[[PetriNet, list[int]], SemanticsError | None],
) -> None:
    net = torn_behind(("A", "B"), ("C",))
    first, last, other = (net.transition_index[name] for name in ("A-B: A", "A-B: B", "C: C"))
    assert fault(net, []) is None
    assert fault(net, [first]) is None
    for run, said in (([first, last], ("A", "B")), ([other], ("C",)), ([other, first], ("C",))):
        error = fault(net, run)
        assert isinstance(error, ConfluenceError)
        assert error.events == said


def test_listing_with_proof_makes_no_diagram(monkeypatch: pytest.MonkeyPatch, ulysse_net: MissionNet) -> None:
    def refused(*args: object) -> None:
        raise AssertionError("a diagram was made")

    monkeypatch.setattr(Encoding, "__init__", refused)
    assert direct_with_proof(ulysse_net.net).states == 260
    with pytest.raises(ConfluenceError):
        direct_with_proof(torn_behind(("A",)))
