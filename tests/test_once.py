"""Handlers that happen once: one for each that is written, on every engine and in every controller."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.answers.verdicts.mission import check
from mcpn.composite.composing import composite_space
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.hierarchy import TableController
from mcpn.controller.minimise import minimise
from mcpn.controller.modular import AnyController
from mcpn.controller.simulator import Simulation
from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.forgetful import forgetful
from mcpn.drawing.local_nets import local_net
from mcpn.drawing.sections import section_part
from mcpn.errors import LimitError, McpnError, SemanticsError
from mcpn.events import Event
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.robot.targets import files
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.engines import Choice
from mcpn.spaces.stable.alternatives import direct_with_proof
from mcpn.testing import missions
from mcpn.testing.elements import IN_ROUNDS
from tests.controller.test_c import build, run_lines
from tests.controller.test_lockstep import walk
from tests.controller.test_scxml import check as check_scxml
from tests.controller.traces import Traced, random_events
from tests.draws import composed
from tests.shares import returns_early

ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")

ROBOT = """<robot name="q"><hardware name="h"/><event name="leak"/><event name="call"/>
<activity name="a"/><activity name="b" consumes="h"/><activity name="c"/></robot>"""

HANDLER = '<on event="leak" goto="succeed" once="true"/>'

IN_EACH = f'<each name="v" in="x y"><objective name="o" activities="a">{HANDLER}</objective></each>'

IN_USE = f"""<protocols><protocol name="P"><objective name="o" activities="a">{HANDLER}</objective></protocol>
</protocols><use name="u" protocol="P"/><use name="w" protocol="P"/>"""

IN_REPEATED_PARENT = f"""<objective name="r" repeat="2">
<objective name="o" activities="a">{HANDLER}</objective></objective>"""

IN_TRIES = """<objective name="o" activities="a" retries="1">
<on event="leak" goto="p" once="true"/></objective>
<objective name="p" activities="c" success="o"/>"""

COPIES = {
    "each": (IN_EACH, ["o_x", "o_y"], "o.leak"),
    "use": (IN_USE, ["u.o", "w.o"], "P.o.leak"),
    "repeated parent": (IN_REPEATED_PARENT, ["r_1.o", "r_2.o"], "o.leak"),
}

STACKED = """<objective name="outer" success="last" failure="last"><on event="leak" goto="last"/>
<objective name="middle"><on event="leak" goto="spare" once="true"/>
<objective name="inner" activities="a" success="inner"><on event="leak" goto="inner" once="true"/></objective>
</objective><objective name="spare" activities="c" success="middle" failure="middle"/></objective>
<objective name="last" activities="b"/>"""

BRANCHES = """<protocols><protocol name="P">
<objective name="way" activities="a" success="way"><on event="leak" goto="way" once="true"/></objective>
</protocol><protocol name="R">
<objective name="way" activities="c" success="way"><on event="leak" goto="way" once="true"/></objective>
</protocol></protocols>
<parallel name="both" success="both" failure="both"><on event="leak" goto="after" once="true"/>
<on event="call" goto="after"/><use name="u" protocol="P"/><use name="w" protocol="R"/></parallel>
<objective name="after" activities="b" success="both" failure="fail"/>"""

MEETING = """<protocols><protocol name="P"><objective name="o" activities="a">
<on event="leak" goto="succeed" once="true"/></objective></protocol></protocols>
<parallel name="both" success="both" failure="both"><on event="leak" goto="after"/>
<use name="u" protocol="P"/>
<objective name="beside"><objective name="x" activities="c"/><use name="w" protocol="P"/></objective>
</parallel>
<objective name="after" activities="b" success="both" failure="fail"/>"""


def drawn(path: Path, text: str) -> MissionNet:
    file = path / "mission.xml"
    file.write_text(f'<mission name="m" xmlns="urn:mcpn:mission:1">{ROBOT}{text}</mission>')
    return compose(read_mission(file))


def happens(found: MissionNet, *events: str) -> list[tuple[str, ...]]:
    """The objectives that run, or wait for their activities, after each of some events."""
    simulation, running = Simulation(found), list[tuple[str, ...]]()
    for event in events:
        change = simulation.take(Event.parse(event))
        assert change is not None, event
        running.append((*change.after.objectives, *change.after.pending))
    return running


def controllers(found: MissionNet) -> list[AnyController]:
    made = [generate(found, "flat"), generate(found, "hierarchical")]
    return [*made, *map(minimise, made), generate(found, "modular")]


def holding(found: MissionNet, engine: Engine) -> dict[str, bool | None]:
    return {name: verdict.holds for name, verdict in check(found, engine=engine).verdicts.items()}


def hold_together(found: MissionNet, tmp_path: Path, seeds: Sequence[int] = (1, 2)) -> None:
    """Every engine counts the same, and every controller does what the net does."""
    listed = direct_with_proof(found.net)
    markings = {
        engine: spaces_of(found).space(Choice(engine), "markings") for engine in ("explicit", "symbolic")
    }
    assert markings["explicit"].everything.count() == markings["symbolic"].everything.count()
    for engine in ENGINES:
        space = spaces_of(found).space(Choice(engine), "alternatives")
        assert space.everything.count() == listed.states, engine
        assert sum(space.firings(space.everything).values()) == listed.edges, engine
        assert holding(found, engine) == holding(found, "explicit"), engine
    made = controllers(found)
    for seed in seeds:
        walk(found, made, random.Random(seed), 60)
    for number, controller in enumerate(made):
        traced = Traced(document(controller, found))
        events = random_events(traced, random.Random(number), 150)
        traced.restart()
        expected = traced.lines(events)
        program = build(files(document(controller, found), "c"), tmp_path / f"c{number}")
        assert run_lines(program, events) == expected


@pytest.mark.parametrize("copies", COPIES)
def test_it_happens_once_in_all_copies(copies: str, tmp_path: Path) -> None:
    text, (first, second), written = COPIES[copies]
    found = drawn(tmp_path, text)
    assert found.graph.once() == [written]
    assert [s.name for s in found.graph.walk()] == [first, second]
    run = happens(found, "MISSION_EV_START", "leak")
    assert run == [(first,), (second,)]
    simulation = Simulation(found)
    for event in ("MISSION_EV_START", "leak"):
        simulation.take(Event.parse(event))
    assert simulation.take(Event.parse("leak")) is None  # it has happened
    other = happens(found, "MISSION_EV_START", f"OBJ_{first}_EV_OK", "leak")
    assert other == [(first,), (second,), ()]
    # By hand, each doubled by the hardware: before, first, second with and without the leak, success
    # with it and without, failure with it and without.
    listed = direct_with_proof(found.net)
    assert listed.states == 2 * 8
    hold_together(found, tmp_path)


@pytest.mark.parametrize("name", ["once_in_each", "once_in_use", "once_in_repeated_parent"])
def test_missions_in_which_it_once_happened_twice(name: str, faults: Path, tmp_path: Path) -> None:
    found = compose(read_mission(faults / f"{name}.xml"))
    simulation = Simulation(found)
    assert simulation.take(Event.parse("MISSION_EV_START"))
    assert simulation.take(Event.parse("leak"))
    assert simulation.situation.outcome is None
    assert simulation.take(Event.parse("leak")) is None
    hold_together(found, tmp_path)


def test_it_happens_once_in_all_tries(tmp_path: Path) -> None:
    found = drawn(tmp_path, IN_TRIES)
    run = happens(found, "MISSION_EV_START", "OBJ_o_try1_EV_FAIL", "leak", "OBJ_p_EV_OK")
    assert run == [("o_try1",), ("o_try2",), ("p",), ("o_try1",)]
    simulation = Simulation(found)
    for event in ("MISSION_EV_START", "OBJ_o_try1_EV_FAIL", "leak", "OBJ_p_EV_OK"):
        simulation.take(Event.parse(event))
    assert simulation.take(Event.parse("leak")) is None
    hold_together(found, tmp_path)


def test_then_the_next_handler_outwards_counts(tmp_path: Path) -> None:
    found = drawn(tmp_path, STACKED)
    assert found.graph.once() == ["inner.leak", "middle.leak"]
    run = happens(found, "MISSION_EV_START", "leak", "leak", "OBJ_spare_EV_OK", "leak")
    assert run == [("inner",), ("inner",), ("spare",), ("inner",), ("last",)]
    # What stands before it in the chain has not happened where the next one is met from elsewhere.
    hold_together(found, tmp_path)


def test_branches_with_handlers_of_their_own(tmp_path: Path) -> None:
    found = drawn(tmp_path, BRANCHES)
    assert found.graph.once() == ["both.leak", "P.way.leak", "R.way.leak"]
    run = happens(found, "MISSION_EV_START", "leak", "leak", "OBJ_after_EV_OK", "call")
    assert run[0] == run[1] == ("u.way", "w.way")
    assert run[2] == ("after",)  # both branches' have happened: that of the block counts
    hold_together(found, tmp_path)


def test_one_written_handler_in_two_branches_is_taken_by_both_at_one_event(tmp_path: Path) -> None:
    found = drawn(tmp_path, MEETING)
    assert found.graph.once() == ["P.o.leak"]
    run = happens(found, "MISSION_EV_START", "OBJ_x_EV_OK", "leak", "leak")
    # The second waits for the activity of the first. Both branches end, so that the block begins again.
    assert run == [("u.o", "x"), ("u.o", "w.o"), ("u.o", "x"), ("after",)]
    apart = happens(found, "MISSION_EV_START", "leak", "OBJ_x_EV_OK", "leak")
    assert apart == [("u.o", "x"), ("x",), ("w.o",), ("after",)]
    hold_together(found, tmp_path)


@pytest.mark.parametrize("text", [IN_EACH, IN_USE, IN_REPEATED_PARENT, STACKED, BRANCHES])
def test_in_scxml(text: str, tmp_path: Path) -> None:
    found = drawn(tmp_path, text)
    for number, controller in enumerate(controllers(found)):
        if not isinstance(controller, TableController):
            continue
        traced = Traced(document(controller, found))
        events = random_events(traced, random.Random(7), 60, noise=0)
        path = tmp_path / f"{number}.scxml"
        path.write_text(next(iter(files(document(controller, found), "scxml").values())))
        check_scxml("Qt", path, controller, traced, events)


def test_sections_that_differ_in_their_handlers_are_of_one_type(tmp_path: Path) -> None:
    found = drawn(
        tmp_path,
        f'<objective name="o" activities="a">{HANDLER}</objective>'
        f'<objective name="p" activities="c">{HANDLER}</objective><objective name="r" activities="b"/>',
    )
    assert found.graph.once() == ["o.leak", "p.leak"]
    composite = composite_space(found)
    o, p, r = composite.sections.values()
    assert o.type is p.type is not r.type
    controller = generate(found)
    assert [dict(s.names["once"]) for s in controller.sections] == [
        {"o.leak": "o.leak"},
        {"o.leak": "p.leak"},
        {},
    ]
    hold_together(found, tmp_path)


@pytest.mark.parametrize("count", [3, 10])
def test_machines_do_not_grow_by_what_has_happened(count: int, tmp_path: Path) -> None:
    """Handlers of the mission, each of an event of its own: all states with any of them happened are met."""
    events = "".join(f'<event name="e{i}"/>' for i in range(count))
    handlers = "".join(f'<on event="e{i}" goto="home" once="true"/>' for i in range(count))
    file = tmp_path / "mission.xml"
    file.write_text(
        f'<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="q"><hardware name="h"/>{events}'
        f'<activity name="a" consumes="h"/></robot>{handlers}<objective name="away" activities="a"/>'
        '<objective name="home" activities="a" success="away"/></mission>'
    )
    found = compose(read_mission(file))
    assert len(found.graph.sections) == 2
    composite = composite_space(found)
    # The hardware before; in each of two sections it runs, or is in error with h out, or h back; the end.
    assert composite.everything.count() == 2 + (2 * 3 + 2) * 2**count
    controller = generate(found)
    assert (controller.states, len(controller.types)) == (3, 1)
    # Two entries. While it runs h fails, it succeeds or fails; in error it fails, h comes back or goes.
    assert controller.moves == 2 + (3 + 2 + 2) + 3 * count


@given(IN_ROUNDS, st.integers(0, 2**32))
def test_snapshots_know_what_has_happened(mission: Mission, seed: int) -> None:
    found = composed(mission)
    try:
        controller = generate(found, max_states=2000)
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    traced = Traced(document(controller, found))
    events = random_events(traced, random.Random(seed), 100)
    traced.restart()
    expected = traced.lines(events)
    traced.restart()
    again = list[str]()
    for happened in events:
        again += traced.lines([happened])
        at = traced.controller.snapshot()
        traced.restart()
        traced.controller.restore(at)
    assert again == expected


@given(missions(max_events=2))
def test_nets_that_forget_have_every_stable_state(mission: Mission) -> None:
    """What a section's net does is what the one that forgets does under the guards of its transitions."""
    try:
        whole = compose(mission)
        parts = [section_part(whole.usage, section) for section in whole.graph.sections]
        nets = [local_net(part) for part in parts if part.once]
        graphs = [(net, direct_with_proof(net.net, max_states=2000)) for net in nets]
    except McpnError:
        return
    for net, graph in graphs:
        without, guards = forgetful(net)
        places = [net.net.place_index[place.name] for place in without.net.places]
        inner = without.net.transition_index
        for state in range(graph.states):
            marking = graph.marking(state)
            happened = {name for p, name in net.saying("happened").items() if marking[p]}
            short = tuple(marking[p] for p in places)
            allowed = {
                without.net.transitions[t].name
                for t in without.net.enabled(short)
                if t not in guards
                or (happened.isdisjoint(guards[t].open) and happened.issuperset(guards[t].happened))
            }
            fired = {net.net.transitions[t].name for t in net.net.enabled(marking)}
            assert allowed == {name for name in fired if name in inner}
            for t in net.net.enabled(marking):
                after = net.net.fire(marking, t)
                then = {name for p, name in net.saying("happened").items() if after[p]}
                if (own := inner.get(net.net.transitions[t].name)) is not None:
                    asked = guards[own].open if own in guards else ()
                    assert then == happened.union(asked)


def test_a_handler_that_could_happen_again_is_not_forgotten(tmp_path: Path) -> None:
    """No template draws a net that takes back that a handler has happened."""
    net = drawn(tmp_path, IN_EACH)
    assert forgetful(net)[1]
    (place,) = net.saying("happened")
    number = next(t for t, of in enumerate(net.net.transitions) if of.internal)
    changed = replace(net.net.transitions[number], consume=((place, 1),))
    transitions = (*net.net.transitions[:number], changed, *net.net.transitions[number + 1 :])
    with pytest.raises(SemanticsError, match=f"{changed.name} takes the token of .*has happened"):
        forgetful(replace(net, net=replace(net.net, transitions=transitions)))
