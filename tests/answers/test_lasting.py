"""Hardware that is never repaired, or out of service at the start: verdicts, causes, numbers, controllers."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from mcpn.answers.causes.risk import risk
from mcpn.answers.verdicts.mission import check
from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Hardware
from mcpn.robot.runtime.controller import Controller
from mcpn.robot.targets import files
from mcpn.spaces.engine_names import Engine
from tests.controller.test_c import build, run_lines
from tests.controller.test_scxml import INTERPRETERS
from tests.controller.test_scxml import check as check_scxml
from tests.controller.traces import Traced, random_events
from tests.logic.asked import ENGINES, Asked
from tests.small import activity, mission, robot

FORMS: tuple[Form, ...] = ("flat", "hierarchical", "modular")


def going(hardware: Hardware, *objectives: Objective) -> Mission:
    """Objectives that need the hardware where they say ``go``."""
    return mission(robot((hardware,), activity("go", ("h",)), activity("wait", ())), *objectives)


def goes(name: str, failure: str | None = None) -> Objective:
    return Objective(name=name, activities=("go",), duration=1.0, failure_probability=0.0, failure=failure)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_loop_that_awaits_a_repair_needs_one(engine: Engine) -> None:
    tries = goes("tries", failure="tries")
    for repairable in (True, False):
        found = check(compose(going(Hardware(name="h", repairable=repairable), tries)), engine=engine)
        verdict = found.verdicts["can_always_finish"]
        assert verdict.holds is repairable
        if not repairable:
            (run,) = verdict.runs
            events = [str(e) for e in run.events]
            assert "h_EV_OOS" in events
            assert "h_EV_RD" not in events


@pytest.mark.parametrize("engine", ENGINES)
def test_what_is_out_of_service_at_the_start_must_be_repaired_first(engine: Engine) -> None:
    found = check(compose(going(Hardware(name="h", initial="oos"), goes("first"))), engine=engine)
    (run,) = found.verdicts["success_reachable"].runs
    assert [str(event) for event in run.events] == ["h_EV_RD", "MISSION_EV_START", "OBJ_first_EV_OK"]


@pytest.mark.parametrize("engine", ENGINES)
def test_numbers_by_hand(engine: Engine) -> None:
    # Each objective takes an hour on the mean; h fails at 0.5 per hour and is repaired at 2 per hour.
    waits = Objective(name="waits", activities=("wait",), duration=1.0, failure_probability=0.0)
    lasting = going(Hardware(name="h", failure_rate=0.5, repairable=False), goes("one"), goes("two"))
    late = going(Hardware(name="h", initial="oos", repair_rate=2.0), waits, goes("two"))
    numbers = risk(Asked(compose(lasting), engine).prospects)
    assert numbers.success == pytest.approx((1 / 1.5) ** 2)
    numbers = risk(Asked(compose(late), engine).prospects)
    assert numbers.success == pytest.approx(2 / 3)  # it is repaired before the hour is over
    assert numbers.importance == pytest.approx({"h": 1.0})


GOES = mission(
    robot(
        (Hardware(name="h", repairable=False), Hardware(name="g", initial="oos"), Hardware(name="k")),
        activity("go", ("h",), ("g",)),
    ),
    Objective(name="one", activities=("go",)),
)


@pytest.mark.parametrize("form", FORMS)
def test_a_controller_knows_what_is_out_and_what_stays_out(form: Form) -> None:
    net = compose(GOES)
    told = document(generate(net, form), net)
    assert (told["out_of_service"], told["unrepairable"]) == (["g"], ["h"])
    controller = Controller.from_document(told)
    assert controller.out_of_service == {"g"}
    assert list(controller.possible) == ["MISSION_EV_START", "g_EV_RD", "h_EV_OOS", "k_EV_OOS"]
    controller.handle("MISSION_EV_START")
    controller.handle("h_EV_OOS")
    assert controller.mode == {}
    assert list(controller.possible) == ["OBJ_one_EV_FAIL", "g_EV_RD", "k_EV_OOS"]
    controller.handle("OBJ_one_EV_FAIL")
    assert list(controller.possible) == ["g_EV_RD", "k_EV_OOS"]
    plain = compose(going(Hardware(name="h"), goes("one")))
    said = document(generate(plain, form), plain)
    assert said["out_of_service"] == said["unrepairable"] == []


HISTORY = ["", "g_EV_OOS", "h_EV_RD", "MISSION_EV_START", "h_EV_OOS", "h_EV_RD", "g_EV_RD", "OBJ_one_EV_OK"]
HISTORY += ["", "h_EV_OOS", "h_EV_RD", "g_EV_RD", "MISSION_EV_START", "OBJ_one_EV_OK", "h_EV_RD", "g_EV_OOS"]
STATUS = ["refused", "unknown", "taken", "taken", "unknown", "taken", "refused"]
STATUS += ["taken", "unknown", "taken", "taken", "taken", "unknown", "taken"]


@pytest.mark.parametrize("form", FORMS)
def test_generated_code_knows_it_too(form: Form, tmp_path: Path) -> None:
    net = compose(GOES)
    controller = generate(net, form)
    traced = Traced(document(controller, net))
    lines = traced.lines(HISTORY)
    assert [line.partition(":")[0] for line in lines] == STATUS
    events = HISTORY + random_events(traced, random.Random(1), 300)
    traced.restart()
    lines = traced.lines(events)
    assert run_lines(build(files(document(controller, net), "c"), tmp_path), events) == lines


@pytest.mark.parametrize("name", list(INTERPRETERS))
@pytest.mark.parametrize("flat", [True, False])
def test_charts_know_it_too(name: str, flat: bool, tmp_path: Path) -> None:
    net = compose(GOES)
    controller = generate(net, "flat" if flat else "hierarchical")
    ((file, text),) = files(document(controller, net), "scxml").items()
    (tmp_path / file).write_text(text)
    traced = Traced(document(controller, net))
    events = HISTORY + random_events(traced, random.Random(1), 100)
    check_scxml(name, tmp_path / file, controller, traced, events)
