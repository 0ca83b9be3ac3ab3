"""Facts of the world: who changes and reads them, on missions of our own, drawn ones, and broken ones."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import HealthCheck, event, given, settings

from mcpn.answers.mission_names import MissionNames
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.answers.verdicts.mission import check
from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.logic.syntax import parse
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Fact, FactChange, Robot
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.validate import find_errors
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller as Runtime
from mcpn.robot.targets import files
from mcpn.spaces.engine_names import Engine
from mcpn.testing import missions
from tests.conftest import ROOT
from tests.controller.test_c import build, run_lines
from tests.controller.traces import Traced, random_events

DUMPSTER = ROOT / "tests" / "natural" / "dumpster.xml"
FORMS: tuple[Form, ...] = ("hierarchical", "flat", "modular")
ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")


def closing(mission: Mission) -> Mission:
    """The mission with the dumpster closed at its end."""
    shut = Objective(
        name="close_dumpster", activities=("close",), sets=(FactChange(fact="dumpster", to="closed"),)
    )
    return replace(mission, blocks=(*mission.blocks, shut))


@pytest.mark.parametrize("engine", ENGINES)
def test_the_dumpster_is_left_open(engine: Engine) -> None:
    found = check(compose(read_mission(DUMPSTER)), engine=engine)
    answers = {answer.asked.name: answer for answer in found.requirements}
    assert answers["all_in"].met
    assert answers["shut"].met is False
    assert not found.passed
    witness = answers["shut"].witness
    assert witness is not None
    fired = [str(found.mission_net.net.transitions[edge.transition].event) for edge in witness.steps]
    assert fired[-1] == "OBJ_drop_second_EV_OK"
    assert "OBJ_open_dumpster_EV_OK" in fired


@pytest.mark.parametrize("engine", ENGINES)
def test_with_closing_at_the_end_it_holds(engine: Engine) -> None:
    found = check(compose(closing(read_mission(DUMPSTER))), engine=engine)
    assert found.passed
    assert all(answer.met for answer in found.requirements)
    assert find_warnings(found.mission_net.mission) == []


FACTS = missions(sections=4, hardware=1, producers=1, facts=2, events=1) | missions(
    sections=4, hardware=2, producers=2, facts=2, own_hardware=True, shared_activities=False
)


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(FACTS)
def test_values_of_a_fact_are_a_unit(mission: Mission) -> None:
    mission_net = compose(mission)
    places: dict[str, list[int]] = {}
    for place, said in mission_net.saying("fact").items():
        places.setdefault(said.partition("=")[0], []).append(place)
    assert places.keys() >= {fact.name for fact in mission.facts}
    assert all(tuple(unit) in mission_net.net.units for unit in places.values())


@given(missions(sections=4, facts=0, events=1), missions(sections=1, parallel=False, facts=2))
def test_facts_that_nothing_touches_change_no_net(mission: Mission, other: Mission) -> None:
    declared = replace(mission.robots[0], facts=other.facts)
    nets = [compose(m).net for m in (mission, replace(mission, robots=(declared, *mission.robots[1:])))]
    own = [p.name for p in nets[1].places if p.provenance and p.provenance.kind == "fact"]
    assert [p.name for p in nets[0].places] == [p.name for p in nets[1].places if p.name not in own]
    assert [t.name for t in nets[0].transitions] == [t.name for t in nets[1].transitions]
    assert len(own) == sum(len(fact.values) for fact in other.facts)


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(FACTS)
def test_engines_count_the_same_states(mission: Mission) -> None:
    mission_net = compose(mission)
    try:
        found = {engine: spaces_of(mission_net).space(engine, "alternatives") for engine in ENGINES}
    except Exception as error:
        event(type(error).__name__)
        return
    assert len({space.everything.count() for space in found.values()}) == 1
    for fact in mission.facts:
        for value in fact.values:
            (place,) = mission_net.by_role["fact", f"{fact.name}={value}"]
            assert len({space.marked([place]).count() for space in found.values()}) == 1


NS = 'xmlns="urn:mcpn:mission:1"'
ROBOT = """<robot name="r">
<fact name="door" values="open closed"/><fact name="held"/><event name="wind"/>
<activity name="go"/>
</robot>
"""


def body(blocks: str, robot: str = ROBOT) -> str:
    """A mission whose blocks are in line 6."""
    return f'<mission name="m" {NS}>\n{robot}{blocks}\n</mission>'


def go(inside: str) -> str:
    return f'<objective name="o" activities="go">{inside}</objective>'


def declaring(inside: str) -> str:
    """A robot with more in line 3."""
    return ROBOT.replace('<event name="wind"/>', inside)


OK = go("")
BROKEN: dict[str, tuple[str, int, str]] = {
    "unknown fact": (body(go('<sets fact="dor" to="open"/>')), 6, "did you mean door"),
    "unknown value": (body(go('<sets fact="door" to="opne"/>')), 6, "did you mean open"),
    "set twice": (
        body(go('<sets fact="held" to="true"/><sets fact="held" to="false"/>')),
        6,
        "sets held twice on success",
    ),
    "no such occasion": (
        body(go('<sets fact="held" to="true" on="end"/>')),
        6,
        "expected success, failure or start",
    ),
    "set in a block of blocks": (
        body(f'<objective name="p"><sets fact="held" to="true"/>{OK}</objective>'),
        6,
        "expected <sets> in elementary objectives only",
    ),
    "one value": (
        body(OK, declaring('<fact name="x" values="a"/>')),
        3,
        "has 1 value, expected",
    ),
    "a value twice": (body(OK, declaring('<fact name="x" values="a b a"/>')), 3, "names a 2 times"),
    "initial is no value": (
        body(OK, declaring('<fact name="x" initial="off"/>')),
        3,
        "expected one of false",
    ),
    "declared twice": (body(OK, declaring('<fact name="held"/>')), 3, "fact held is declared twice"),
    "an event on success": (
        body(OK, declaring('<event name="e"><sets fact="held" to="true" on="success"/></event>')),
        3,
        "expected no on",
    ),
    "an event that changes facts is handled": (
        body(
            go('<on event="e" goto="fail"/>'),
            declaring('<event name="e"><sets fact="held" to="true"/></event>'),
        ),
        6,
        "it interrupts nothing",
    ),
    "unknown fact in a route": (body(go('<route when="hled" goto="fail"/>')), 6, "did you mean held"),
    "unknown value in a route": (
        body(go('<route when="door=opened" goto="fail"/>')),
        6,
        "did you mean open",
    ),
    "a fact of other values alone": (
        body(go('<route when="door" goto="fail"/>')),
        6,
        "door=open, door=closed",
    ),
    "not a value": (body(go('<route when="!door=open" goto="fail"/>')), 6, "! stands before a name alone"),
    "both at once": (body(go('<route when="held !held" goto="fail"/>')), 6, "at once"),
    "no condition": (body(go('<route when="" goto="fail"/>')), 6, "expected facts with their values"),
    "a route to nowhere": (body(go('<route when="held" goto="p"/>')), 6, "leads to p"),
    "a route without a condition": (body(go('<route goto="fail"/>')), 6, "asks for no fact"),
    "a route of a branch": (
        body('<parallel name="p">' + go('<route when="held" goto="fail"/>') + "</parallel>"),
        6,
        "child of a parallel block",
    ),
    "done of nothing": (body(go('<route when="done(oo)" goto="fail"/>')), 6, "did you mean o?"),
    "done with a value that it has not": (
        body(go('<route when="done(o)=yes" goto="fail"/>')),
        6,
        "expected one of false",
    ),
    "requires an unknown fact": (
        body(OK, ROBOT.replace('"go"/>', '"go" requires="hold"/>')),
        4,
        "activity go requires the fact hold",
    ),
    "requires of an alternative": (
        body(OK, ROBOT.replace('"go"/>', '"go"><alternative name="a" requires="door=ajar"/></activity>')),
        4,
        "expected one of open, closed",
    ),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_uses_have_a_line(name: str, tmp_path: Path) -> None:
    text, line, said = BROKEN[name]
    path = tmp_path / "m.xml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_mission(path)
    told = [(p.source.line, p.message) for p in caught.value.problems if p.source]
    assert any(at == line and said in message for at, message in told), told


def test_an_empty_occasion_is_none() -> None:
    """A file cannot say it, a mission that is built can."""
    sets = FactChange(fact="held", to="true", on="")
    go = Activity(name="go", alternatives=(Alternative(name="go"),))
    mission = Mission(
        name="m",
        robots=(Robot(name="r", activities=(go,), facts=(Fact(name="held"),)),),
        blocks=(Objective(name="o", activities=("go",), sets=(sets,)),),
    )
    (problem,) = find_errors(mission)
    assert problem.message == "objective o sets held on '', expected success, failure or start"


WARNED = {
    "never set": (go('<route when="held" goto="fail"/>'), "fact held is never set"),
    "never read": (go('<sets fact="held" to="true"/>'), "fact held is never read"),
    "set to what it is": (go('<sets fact="door" to="open"/>'), "sets door to open, which it always is"),
    "a route that is never taken": (
        go('<route when="held" goto="fail"/>'),
        "held is never true",
    ),
}


@pytest.mark.parametrize("name", WARNED)
def test_what_is_suspicious_is_told(name: str, tmp_path: Path) -> None:
    blocks, said = WARNED[name]
    path = tmp_path / "m.xml"
    path.write_text(body(blocks))
    assert any(said in problem.message for problem in find_warnings(read_mission(path)))


def test_an_alternative_that_facts_never_allow_is_told(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(body(OK, ROBOT.replace('"go"/>', '"go" requires="door=closed"/>')))
    messages = [problem.message for problem in find_warnings(read_mission(path))]
    assert any("never possible: door is never closed" in message for message in messages)


@pytest.mark.parametrize(
    ("formula", "said"),
    [
        ("fact(dor)=open", "did you mean door"),
        ("fact(door)=opne", "did you mean open"),
        ("fact(door)", "expected fact(door)=open or fact(door)=closed"),
        ("done(p)", "no objective is named p"),
        ("done(o)", "is not kept"),
    ],
)
def test_formulas_say_what_is_wrong(formula: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(body(OK))
    mission_net = compose(read_mission(path))
    with pytest.raises(InputError, match=said.replace("(", "[(]").replace(")", "[)]")):
        parse(formula, MissionNames(mission_net))


@pytest.mark.parametrize("form", FORMS)
def test_controllers_keep_facts(form: Form) -> None:
    mission_net = compose(closing(read_mission(DUMPSTER)))
    runtime = Runtime.from_document(document(generate(mission_net, form), mission_net))
    runtime.handle("MISSION_EV_START")
    while runtime.outcome is None:
        (objective,) = runtime.state.objectives
        runtime.handle(f"OBJ_{objective}_EV_OK")
        if objective == "open_dumpster":
            assert runtime.facts["dumpster"] == "open"
    assert runtime.facts == {
        "near_door": "open",
        "far_door": "closed",
        "dumpster": "closed",
        "holding": "false",
        "in_dumpster": "both",
    }


@pytest.mark.parametrize("form", get_args(Form))
def test_generated_controllers_know_facts(form: Form, tmp_path: Path) -> None:
    mission_net = compose(closing(read_mission(DUMPSTER)))
    controller = generate(mission_net, form)
    traced = Traced(document(controller, mission_net))
    events = ["MISSION_EV_START"]
    traced.controller.handle(events[0])
    while traced.controller.outcome is None:
        (objective,) = traced.controller.state.objectives
        events.append(f"OBJ_{objective}_EV_OK")
        traced.controller.handle(events[-1])
    events += random_events(traced, random.Random(27), 300)
    traced.restart()
    expected = traced.lines(events)
    assert any(line.endswith("success") for line in expected)
    assert run_lines(build(files(document(controller, mission_net), "c"), tmp_path), events) == expected


def test_what_has_been_done_is_known(tmp_path: Path) -> None:
    blocks = (
        '<requirement name="r" formula="G (success -> done(b) &amp; !done(c))"/>'
        '<objective name="a" activities="go" success="b"><route when="done(b)" goto="succeed"/></objective>'
        '<objective name="b" activities="go" success="a"/>'
        '<objective name="c" activities="go"/>'
    )
    path = tmp_path / "m.xml"
    path.write_text(body(blocks))
    for engine in ENGINES:
        found = check(compose(read_mission(path)), engine=engine)
        assert [answer.met for answer in found.requirements] == [True]
