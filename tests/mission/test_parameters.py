"""Which value an objective has of a parameter: the innermost, by a definition that writes nothing out."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import compose
from mcpn.mission.core.flattening import flatten
from mcpn.mission.core.objectives_graph import ElementarySection
from mcpn.mission.model import Block, Each, Mission, Objective, Parallel, Protocol, Recursive, Use
from mcpn.mission.robot import Activity, Alternative, Parameter, Robot
from mcpn.mission.validate import find_errors
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller as Runtime
from mcpn.robot.targets import files
from mcpn.testing import missions
from tests.controller.test_python import Generated

Said = tuple[dict[str, str], ...]
"""What is said around an objective, by name: the innermost first, defaults of protocols last."""


def said(parameters: tuple[Parameter, ...]) -> dict[str, str]:
    return {p.name: p.value for p in parameters}


def objectives(mission: Mission) -> Iterator[tuple[str, Said]]:
    """Every copy of every objective that is written: its own name, and what is said around it.

    The order is that of the text, rounds and tries one after the other.
    """
    protocols = {p.name: p for p in mission.protocols}

    def inside(
        blocks: tuple[Block, ...], blocks_say: Said, protocols_say: Said
    ) -> Iterator[tuple[str, Said]]:
        for block in blocks:
            rounds: list[dict[str, str]] = [{}]
            if isinstance(block, Each):
                rounds = [{block.bound: value} for value in block.values]
            for number in range(1, (block.repeat or 1) + 1):
                counted = {"round": str(number)} if block.repeat is not None else {}
                for _ in range(block.retries + 1):
                    for value in rounds:
                        yield from once(block, (value, counted, *blocks_say), protocols_say)

    def once(block: Block, blocks_say: Said, protocols_say: Said) -> Iterator[tuple[str, Said]]:
        own = () if isinstance(block, Parallel | Each) else block.parameters
        blocks_say = (said(own), *blocks_say)
        if isinstance(block, Objective):
            yield block.name, (*blocks_say, *protocols_say)
        elif isinstance(block, Use):
            protocol = protocols[block.protocol]
            yield from inside(protocol.blocks, blocks_say, (said(protocol.parameters), *protocols_say))
        else:
            yield from inside(block.blocks, blocks_say, protocols_say)

    yield from inside(mission.blocks, (), ())


def innermost(around: Said) -> dict[str, str]:
    return {name: next(says[name] for says in around if name in says) for says in around for name in says}


def in_order(mission: Mission) -> list[ElementarySection]:
    """The objectives as they are written out, those that no route reaches in their places."""
    graph = flatten(mission)
    return [*graph.walk(), *graph.never_entered()]


NAMES = ("room", "speed", "round", "depth")


@st.composite
def nested(draw: st.DrawFn) -> Mission:
    """Uses, rounds, recursive and parallel blocks one in the other, all of which say a few names."""
    count = iter(range(10_000))

    def parameters(names: tuple[str, ...] = NAMES) -> tuple[Parameter, ...]:
        chosen = draw(st.lists(st.sampled_from(names), unique=True, max_size=2)) if names else []
        return tuple(Parameter(name=name, value=f"v{next(count)}") for name in chosen)

    def block(depth: int, protocols: tuple[Protocol, ...], *, apart: bool = False) -> Block:
        kinds = ["objective"]
        if depth:
            kinds += ["recursive", "each", "use", "use"] if protocols else ["recursive", "each"]
            kinds += [] if apart else ["parallel"]
        kind, name = draw(st.sampled_from(kinds)), f"b{next(count)}"
        made: Block
        if kind == "objective":
            made = Objective(name=name, activities=("go",), parameters=parameters())
        elif kind == "recursive":
            made = Recursive(name=name, blocks=series(depth - 1, protocols), parameters=parameters())
        elif kind == "parallel":
            made = Parallel(name=name, blocks=tuple(block(depth - 1, protocols, apart=True) for _ in "ab"))
        elif kind == "each":
            bound = draw(st.sampled_from(NAMES))
            values = tuple(f"w{next(count)}" for _ in range(draw(st.integers(1, 2))))
            made = Each(name=name, values=values, blocks=series(depth - 1, protocols), parameter=bound)
        else:
            protocol = draw(st.sampled_from(protocols))
            own = parameters(tuple(p.name for p in protocol.parameters))
            made = Use(name=name, protocol=protocol.name, parameters=own)
        if draw(st.integers(0, 3)) == 0:
            made = replace(made, repeat=draw(st.integers(1, 2)), retries=draw(st.integers(0, 1)))
        return made

    def series(depth: int, protocols: tuple[Protocol, ...]) -> tuple[Block, ...]:
        return tuple(block(depth, protocols) for _ in range(draw(st.integers(1, 2))))

    protocols: tuple[Protocol, ...] = ()
    for _ in range(draw(st.integers(0, 3))):
        made = Protocol(name=f"p{next(count)}", blocks=series(2, protocols), parameters=parameters())
        protocols = (*protocols, made)
    blocks = series(3, protocols)
    go = Activity(name="go", alternatives=(Alternative(name="go"),))
    return Mission(name="m", robots=(Robot(name="r", activities=(go,)),), protocols=protocols, blocks=blocks)


def check_innermost_counts(mission: Mission) -> None:
    """The names at the end of written names and the values, as a multiset: copies are many, order is none."""
    found = sorted(
        (section.name, sorted((p.name, p.value) for p in section.parameters)) for section in in_order(mission)
    )
    wanted = sorted((name, sorted(innermost(around).items())) for name, around in objectives(mission))
    last = sorted((written(name), said_) for name, said_ in found)
    assert last == wanted


def written(name: str) -> str:
    """The name of an objective as it is written, without uses, rounds and tries."""
    return name.rpartition(".")[2].split("_")[0]


@given(nested())
def test_the_innermost_counts(mission: Mission) -> None:
    assert find_errors(mission) == []
    check_innermost_counts(mission)


@given(missions(text=True, max_sections=6))
def test_the_innermost_counts_in_missions_of_all_elements(mission: Mission) -> None:
    check_innermost_counts(mission)


FAULT = """<mission name="m" xmlns="urn:mcpn:mission:1">
<robot name="r"><activity name="a"><parameter name="k" value="act"/><parameter name="x" value="act"/>
  <parameter name="room" value="act"/>
  <alternative name="a0"><parameter name="x" value="alt"/><parameter name="room" value="alt"/></alternative>
</activity></robot>
<protocols>
  <protocol name="inner"><parameter name="room" value="inner"/><parameter name="z" value="inner"/>
    <objective name="q" activities="a"/></protocol>
  <protocol name="outer"><parameter name="room" value="outer"/><parameter name="speed" value="outer"/>
    <objective name="o" activities="a"/>
    <objective name="w" activities="a"><parameter name="room" value="own"/></objective>
    <use name="in" protocol="inner"><parameter name="z" value="use"/></use></protocol>
</protocols>
<each name="room" in="12">
  <use name="u" protocol="outer"/>
  <use name="v" protocol="outer">
    <parameter name="room" value="said"/><parameter name="speed" value="2"/></use>
  <objective name="y" activities="a" repeat="1"><parameter name="round" value="own"/></objective>
</each>
<use name="alone" protocol="outer"/>
<objective name="last" activities="a"/></mission>"""
SAID = {
    "u_12.o": {"room": "12", "speed": "outer"},
    "u_12.w": {"room": "own", "speed": "outer"},  # not what the use or the round says
    "u_12.in.q": {"room": "12", "speed": "outer", "z": "use"},  # a protocol within a protocol
    "v_12.o": {"room": "said", "speed": "2"},
    "v_12.w": {"room": "own", "speed": "2"},
    "v_12.in.q": {"room": "said", "speed": "2", "z": "use"},
    "y_12_1": {"room": "12", "round": "own"},
    "alone.o": {"room": "outer", "speed": "outer"},
    "alone.w": {"room": "own", "speed": "outer"},
    "alone.in.q": {"room": "inner", "speed": "outer", "z": "use"},
    "last": {},
}


@pytest.fixture
def fault(tmp_path: Path) -> Mission:
    (tmp_path / "m.xml").write_text(FAULT)
    return read_mission(tmp_path / "m.xml")


def test_what_an_objective_says_itself_counts_first(fault: Mission) -> None:
    assert {s.name: {p.name: p.value for p in s.parameters} for s in flatten(fault).walk()} == SAID


def test_the_objective_s_count_before_the_alternative_s_and_these_before_the_activity_s(
    fault: Mission,
) -> None:
    found = compose(fault)
    of_the_robot = {"k": "act", "x": "alt", "room": "alt"}
    controller = generate(found)
    runtime = Runtime.from_document(document(controller, found))
    ((_, text),) = files(document(controller, found), "python").items()
    events = ["MISSION_EV_START", *(f"OBJ_{name}_EV_OK" for name in list(SAID)[:-1])]
    for each in (runtime, Generated(text).controller()):
        carried = {}
        for event in events:
            (select,) = [a for a in each.handle(event) if a.verb == "select"]
            carried[select.objective] = {p.name: p.value for p in select.parameters}
        assert carried == {name: of_the_robot | own for name, own in SAID.items()}


HOSTILE = "\"'<&>]]>\n\t\\u0041 --> {{ é"


@pytest.mark.parametrize("form", ["flat", "hierarchical"])
def test_scxml_carries_what_counts_whatever_it_is(form: Form, fault: Mission) -> None:
    (of,) = fault.activities
    hostile = replace(of, parameters=(Parameter(name="k", value=HOSTILE, unit=HOSTILE),))
    found = compose(replace(fault, robots=(replace(fault.robots[0], activities=(hostile,)),)))
    ((_, text),) = files(document(generate(found, form), found), "scxml").items()
    carried = [
        {name: p["value"] for name, p in json.loads(json.loads(log.get("expr", ""))).items()}
        for log in etree.fromstring(text.encode()).iter("{*}log")
        if log.get("label", "").startswith("select ")
    ]
    of_the_robot = {"k": HOSTILE, "x": "alt", "room": "alt"}
    assert [said_ for said_ in carried if said_ not in [of_the_robot | own for own in SAID.values()]] == []
    assert all(of_the_robot | own in carried for own in SAID.values())
