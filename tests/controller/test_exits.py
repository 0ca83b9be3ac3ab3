"""Declared events leave sections by exits of their own: in every form, target and runtime."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any, get_args

import pytest

from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.controller.hierarchy import TableController
from mcpn.controller.minimise import minimise, partition
from mcpn.controller.modular import AnyController
from mcpn.drawing.compose import MissionNet, compose
from mcpn.mission.model import Objective, Parallel, Recursive
from mcpn.mission.robot import Fault, Hardware, Robot
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller as Runtime
from mcpn.robot.runtime import ControllerFileError, Refused
from mcpn.robot.targets import files
from tests.controller.bisimulation import is_bisimulation
from tests.controller.test_c import build, run_lines
from tests.controller.test_lockstep import walk
from tests.controller.test_scxml import check
from tests.controller.traces import Traced, random_events, tour
from tests.runtime.damage import signed
from tests.small import activity, hw, mission, robot

WATCH = Path(__file__).with_name("watch.xml")


@pytest.fixture(scope="module")
def watch() -> MissionNet:
    return compose(read_mission(WATCH))


@pytest.fixture(scope="module")
def both(watch: MissionNet) -> list[TableController]:
    return [generate(watch, "flat"), generate(watch)]


def test_routes_are_by_outcome(both: list[TableController]) -> None:
    flat, hierarchical = both
    assert [dict(s.routes) for s in flat.sections] == [{"success": "succeed", "failure": "fail"}]
    routes = {s.name: dict(s.routes) for s in hierarchical.sections}
    assert routes["out"] == {"success": "work", "failure": "out", "on storm": "back", "on call": "fail"}
    assert routes["work"]["on leak"] == "out"
    assert {*routes} == {"out", "work", "back"}
    types = {s.name: s.type for s in hierarchical.sections}
    assert types["out"] == types["back"] != types["work"]
    assert routes["back"]["on storm"] == "succeed"


def test_an_exit_stops_all_that_runs(both: list[TableController]) -> None:
    exits = 0
    for machine in both[1].types:
        for move in machine.moves:
            if isinstance(move.target, str) and move.target.startswith("on "):
                exits += 1
                stopped = [a.activity for a in move.actions if a.verb == "stop"]
                assert sorted(filter(None, stopped)) == sorted(machine.states[move.source].mode)
                assert {a.verb for a in move.actions} <= {"stop", "release"}
    assert exits > 20


def test_an_inner_handler_comes_first(watch: MissionNet, both: list[TableController]) -> None:
    for controller in both:
        runtime = Runtime.from_document(document(controller, watch))
        for event in ("MISSION_EV_START", "OBJ_out_EV_OK", "leak"):
            runtime.handle(event)
        assert set(runtime.state.objectives) == {"second", "see"}
        with pytest.raises(Refused):
            runtime.handle("no_such_EV")
        runtime.handle("leak")  # now the block's own handler
        assert runtime.state.objectives == ("out",)
        with pytest.raises(Refused):
            runtime.handle("leak")  # nothing handles it a second time, nor out there
        runtime.handle("call")
        assert (runtime.outcome, runtime.section) == ("failure", None)


def test_flat_hierarchical_and_the_net_do_the_same(watch: MissionNet, both: list[TableController]) -> None:
    small = [minimise(controller) for controller in both]
    for controller in both:
        assert all(is_bisimulation(machine, partition(machine)) for machine in controller.types)
    for seed in range(6):
        walk(watch, [*both, *small, generate(watch, "modular")], random.Random(seed), 60)


@pytest.mark.parametrize("target", ["c", "scxml"])
def test_every_edge_in_every_target(
    target: str, watch: MissionNet, both: list[TableController], tmp_path: Path
) -> None:
    made: list[AnyController] = []
    made += both if target == "scxml" else [*both, generate(watch, "modular")]
    for number, controller in enumerate(made):
        texts = files(document(controller, watch), target)
        traced = Traced(document(controller, watch))
        events, edges = tour(traced)
        taken = {event for _, event in edges}
        assert {"storm", "leak", "call"} <= taken
        events += random_events(traced, random.Random(1), 200)
        if target == "scxml":
            if controller.form == "flat":
                continue  # the interpreter is slow, and the exits are the other form's
            path = tmp_path / f"{number}.scxml"
            path.write_text(next(iter(texts.values())))
            assert isinstance(controller, TableController)
            check("Qt", path, controller, traced, events)
            continue
        traced.restart()
        expected = traced.lines(events)
        assert run_lines(build(texts, tmp_path / str(number)), events) == expected


def test_an_abort_in_every_target(tmp_path: Path) -> None:
    """A section that a branch aborts, and an end of the mission of its own."""
    aborting = Recursive(name="r", blocks=(Objective(name="x", activities=("b",), failure="abort"),))
    tasks = (activity("a", ("h",)), activity("b", ()))
    blocks = (
        Parallel(name="p", blocks=(aborting, Objective(name="y", activities=("a",))), abort="z"),
        Objective(name="z", activities=("a",), failure="abort"),
    )
    mission_net = compose(mission(robot(hw("h"), *tasks), *blocks))
    made: list[AnyController] = [
        generate(mission_net, "flat"),
        generate(mission_net),
        generate(mission_net, "modular"),
    ]
    for number, controller in enumerate(made):
        traced = Traced(document(controller, mission_net))
        events = [*tour(traced)[0], *random_events(traced, random.Random(2), 100)]
        traced.restart()
        expected = traced.lines(events)
        assert any("| abort" in line for line in expected)
        program = build(files(document(controller, mission_net), "c"), tmp_path / str(number))
        assert run_lines(program, events) == expected
        if isinstance(controller, TableController) and controller.form == "hierarchical":
            path = tmp_path / "abort.scxml"
            path.write_text(next(iter(files(document(controller, mission_net), "scxml").values())))
            check("Qt", path, controller, traced, events)


def test_a_common_cause_in_every_target(tmp_path: Path) -> None:
    """A fault of the hardware of both alternatives, and of that of a later section alone."""
    tasks = (activity("a", ("h",), ("g",)), activity("b", ("k",)))
    hardware = tuple(Hardware(name=name) for name in ("h", "g", "k"))
    faults = (Fault(name="board", affects=("h", "g")), Fault(name="fuse", affects=("k",)))
    of = Robot(name="r", hardware=hardware, faults=faults, activities=tasks)
    blocks = (
        Objective(name="x", activities=("a",), retries=1),
        Objective(name="y", activities=("b",), failure="x"),
    )
    mission_net = compose(mission(of, *blocks))
    forms: tuple[Form, ...] = get_args(Form)
    for number, controller in enumerate(generate(mission_net, form) for form in forms):
        traced = Traced(document(controller, mission_net))
        events = [*tour(traced)[0], *random_events(traced, random.Random(2), 100)]
        assert {"board_EV_OOS", "fuse_EV_OOS", "fuse_EV_RD"} <= set(events)
        traced.restart()
        expected = traced.lines(events)
        program = build(files(document(controller, mission_net), "c"), tmp_path / str(number))
        assert run_lines(program, events) == expected
    controller = generate(mission_net)
    traced, path = Traced(document(controller, mission_net)), tmp_path / "fault.scxml"
    path.write_text(next(iter(files(document(controller, mission_net), "scxml").values())))
    check("Qt", path, controller, traced, tour(traced)[0])


def test_more_outcomes_than_a_byte_has_numbers(tmp_path: Path) -> None:
    names = [f"e{i}" for i in range(260)]
    events = "".join(f'<event name="{name}"/>' for name in names)
    handlers = "".join(
        f'<on event="{name}" goto="{"fail" if i % 2 else "a"}"/>' for i, name in enumerate(names)
    )
    path = tmp_path / "mission.xml"
    path.write_text(
        f'<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><activity name="b"/>{events}</robot>'
        f'<objective name="a" activities="b">{handlers}</objective></mission>'
    )
    mission_net = compose(read_mission(path))
    controller = generate(mission_net)
    traced = Traced(document(controller, mission_net))
    given = [text for name in names for text in ("", "MISSION_EV_START", name, "OBJ_a_EV_OK")]
    expected = traced.lines(given)
    assert sum("| failure" in line for line in expected) == 2 * 130
    program = build(files(document(controller, mission_net), "c"), tmp_path / "c")
    assert run_lines(program, given) == expected


def test_an_exit_without_a_route_is_no_controller(watch: MissionNet, both: list[TableController]) -> None:
    said: dict[str, Any] = document(both[1], watch)
    del said["sections"][0]["routes"]["on storm"]
    with pytest.raises(ControllerFileError, match="routes"):
        Runtime.from_document(signed(said))
