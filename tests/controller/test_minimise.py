"""Minimisation: a bisimulation, the coarsest one, and nothing is lost with it."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.answers.verdicts.modes import Situation
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.hierarchy import Entry, SectionMachine
from mcpn.controller.machine import PlannedAction
from mcpn.controller.minimise import minimise, partition, quotient
from mcpn.controller.moves import Move
from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.forgetful import Guard
from mcpn.errors import LimitError, SemanticsError
from mcpn.events import Event
from mcpn.mission.model import Mission
from mcpn.testing import missions
from tests.controller.bisimulation import is_bisimulation
from tests.controller.test_lockstep import walk
from tests.controller.traces import Traced, random_events
from tests.draws import fewer

SHOWN = (
    Situation(),
    Situation(objectives=("a",)),
    Situation(pending=("a",)),
    Situation(done=("a",)),
    Situation(refused=("a",)),
    Situation(out_of_service=("a",)),
    Situation(unnoticed=("a",)),
    Situation(mode={"a": "one"}),
    Situation(waiting={"a": "one"}),
    Situation(facts={"a": "one"}),
)
"""One thing is so, of each kind, or nothing is."""


@st.composite
def machines(draw: st.DrawFn) -> SectionMachine:
    """Small machines with few outputs, so that many states are alike."""
    size = draw(st.integers(1, 8))
    states = tuple(draw(st.sampled_from(SHOWN)) for _ in range(size))
    moves = [
        Move(
            source,
            event,
            draw(st.integers(0, size - 1) | st.sampled_from(["success", "failure"])),
            draw(st.sampled_from([(), (PlannedAction("stop", "x"),)])),
        )
        for source in range(size)
        for event in range(2)
        if draw(st.booleans())
    ]
    events = (Event.parse("a_EV"), Event.parse("b_EV"))
    entry = Entry(draw(st.integers(0, size - 1)), ())
    return SectionMachine((), events, states, (entry,), tuple(moves))


def told_apart(machine: SectionMachine) -> set[tuple[int, int]]:
    """Pairs of states that some run tells apart, found pair by pair from what they show."""
    table = [{m.event: m for m in machine.moves if m.source == s} for s in range(len(machine.states))]
    size = range(len(table))
    apart = {
        (a, b)
        for a in size
        for b in size
        if machine.states[a] != machine.states[b]
        or {(e, m.actions) for e, m in table[a].items()} != {(e, m.actions) for e, m in table[b].items()}
    }
    while True:
        more = {
            (a, b)
            for a in size
            for b in size
            if (a, b) not in apart
            and any(
                (m.target, table[b][e].target) in apart
                if isinstance(m.target, int) and isinstance(table[b][e].target, int)
                else m.target != table[b][e].target
                for e, m in table[a].items()
            )
        }
        if not more:
            return apart
        apart |= more


@given(machines())
def test_it_is_the_coarsest_bisimulation(machine: SectionMachine) -> None:
    classes = partition(machine)
    assert is_bisimulation(machine, classes)
    apart = told_apart(machine)
    size = range(len(classes))
    assert {(a, b) for a in size for b in size if classes[a] != classes[b]} == apart
    small = quotient(machine, classes)
    assert partition(small) == list(range(len(small.states)))


@pytest.mark.parametrize("shown", SHOWN[1:], ids=str)
def test_what_a_state_shows_keeps_it_apart(shown: Situation) -> None:
    """Whatever it is, and from what shows nothing alone: both have no moves."""
    entry = Entry(0, ())
    assert partition(SectionMachine((), (), (Situation(), shown, shown), (entry,), ())) == [0, 1, 1]


@given(machines(), st.data())
def test_what_is_no_bisimulation_is_seen(machine: SectionMachine, data: st.DataObject) -> None:
    size = len(machine.states)
    classes = data.draw(st.lists(st.integers(0, size - 1), min_size=size, max_size=size))
    joined = {(a, b) for a in range(size) for b in range(size) if classes[a] == classes[b]}
    if joined & told_apart(machine):
        assert not is_bisimulation(machine, classes)


@given(machines(), st.data())
def test_twins_are_merged_and_one_difference_keeps_them_apart(
    machine: SectionMachine, data: st.DataObject
) -> None:
    """A copy of a state that nothing leads to, then with another action, guard or target of one move."""
    number = len(machine.states)
    source = data.draw(st.integers(0, number - 1))
    mine = [replace(move, source=number) for move in machine.moves if move.source == source]
    twins = replace(machine, states=(*machine.states, machine.states[source]))

    def together(moves: list[Move]) -> bool:
        classes = partition(replace(twins, moves=(*machine.moves, *moves)))
        return classes[source] == classes[number]

    assert together(mine)
    for at, move in enumerate(mine):
        other = "failure" if move.target == "success" else "success"
        for differs in (
            replace(move, actions=(*move.actions, PlannedAction("stop", "other"))),
            replace(move, guard=Guard(("handler",), ())),
            replace(move, guard=Guard((), ("handler",))),
            replace(move, target=other),
        ):
            assert not together([*mine[:at], differs, *mine[at + 1 :]])
        assert not together(mine[:at] + mine[at + 1 :])


@given(machines(), st.data())
def test_a_quotient_keeps_entries_guards_and_actions(machine: SectionMachine, data: st.DataObject) -> None:
    guards = st.sampled_from([Guard(), Guard(("handler",), ()), Guard((), ("handler",))])
    moves = tuple(replace(move, guard=data.draw(guards)) for move in machine.moves)
    machine = replace(machine, moves=moves)
    classes = partition(machine)
    small = quotient(machine, classes)

    def said(of: SectionMachine, state: int, classes: list[int]) -> set[object]:
        return {
            (m.event, m.guard, m.actions, classes[m.target] if isinstance(m.target, int) else m.target)
            for m in of.moves
            if m.source == state
        }

    own = list(range(len(small.states)))
    for state, of in enumerate(classes):
        assert said(machine, state, classes) == said(small, of, own)
    for before, after in zip(machine.entries, small.entries, strict=True):
        assert before is not None
        assert after == replace(before, target=classes[before.target])


def test_the_gain_on_ulysse(ulysse_net: MissionNet) -> None:
    sizes = {}
    for form in ("flat", "hierarchical"):
        found = generate(ulysse_net, "flat" if form == "flat" else "hierarchical")
        small = minimise(found)
        sizes[form] = (found.states, small.states)
        assert all(is_bisimulation(t, partition(t)) for t in found.types)
        assert minimise(small) == small
    assert sizes["flat"][0] == 236
    assert sizes["flat"][1] < 236
    assert sizes["hierarchical"][1] < sizes["hierarchical"][0] == 200


@fewer(0.5)
@given(missions(max_objectives=3, max_depth=2), st.integers(0, 2**32), st.booleans())
def test_a_small_controller_does_the_same(mission: Mission, seed: int, flat: bool) -> None:
    mission_net = compose(mission)
    try:
        found = generate(mission_net, "flat" if flat else "hierarchical", max_states=2000)
    except (SemanticsError, LimitError):
        return
    small = minimise(found)
    assert small.states <= found.states
    walk(mission_net, [found, small], random.Random(seed), 40)
    large, little = Traced(document(found, mission_net)), Traced(document(small, mission_net))
    events = random_events(large, random.Random(seed), 100)
    large.restart()
    assert little.lines(events) == large.lines(events)


def test_a_changed_machine_is_no_longer_told_alike(ulysse_net: MissionNet) -> None:
    machine = generate(ulysse_net).types[0]
    classes = partition(machine)
    for number, move in enumerate(machine.moves):
        if classes.count(classes[move.source]) > 1:
            broken = list(machine.moves)
            broken[number] = replace(move, actions=(*move.actions, PlannedAction("stop", "nothing")))
            assert not is_bisimulation(replace(machine, moves=tuple(broken)), classes)


FACTS = ("door=open",)


@pytest.mark.parametrize("changing", [Move(1, 0, 2, (), gained=FACTS), Move(1, 0, 2, (), lost=FACTS)])
def test_what_becomes_of_facts_keeps_states_apart(changing: Move) -> None:
    """Two states that show the same and move alike, but for what the move makes true or false of a fact."""
    shown, moves = (Situation(),) * 3, (Move(0, 0, 2, ()), changing)
    assert partition(SectionMachine((), (Event.parse("a_EV"),), shown, (Entry(0, ()),), moves)) == [0, 1, 2]
