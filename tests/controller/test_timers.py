"""Timers in the runtime, its queues, C and generated Python: the same times give the same events."""

from __future__ import annotations

import asyncio
import json
import random
import subprocess
import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import pytest

from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.mission.model import Handler, Mission, Objective, Parallel, Recursive
from mcpn.robot.runtime import AsyncController, Controller, EventQueue, Refused, SnapshotError
from mcpn.robot.runtime.restoring import snapshot_text
from mcpn.robot.targets import files
from tests.controller.test_c import SANITIZE, build
from tests.controller.test_python import Generated
from tests.runtime.damage import signed
from tests.small import activity, hw, mission, robot

FORMS: tuple[Form, ...] = get_args(Form)
START = "MISSION_EV_START"


def one(name: str, timeout: float | None = None, **others: Any) -> Objective:
    return Objective(name=name, activities=(name,), timeout=timeout, **others)


TIMED = mission(
    robot(hw("h"), activity("a", ("h",)), *(activity(name, ()) for name in "bcd"), events=("leak",)),
    one("a", 1.009, retries=1, failure="both"),
    Parallel(
        name="both",
        blocks=(
            one("b", 1.717),
            Recursive(
                name="r", blocks=(one("c", failure="d"), one("d", 2.323, failure="c", timeout_goto="d"))
            ),
        ),
        success="a",
        failure="a",
    ),
)
"""Times of which no two are over at one moment, where events come each tenth of a second."""


BLOCKS = mission(
    robot(hw("h"), activity("a", ("h",)), *(activity(name, ()) for name in "bcdef"), events=("leak",)),
    Recursive(
        name="whole",
        timeout=2.137,
        timeout_goto="whole",
        failure="e",
        handlers=(Handler(event="leak", goto="whole"),),
        blocks=(
            one("a", failure="both"),
            one("b", success="a", failure="both"),
            Parallel(
                name="both",
                timeout=0.509,
                retries=1,
                blocks=(one("c"), Recursive(name="r", timeout=0.311, blocks=(one("d"), one("f")))),
                success="a",
            ),
        ),
    ),
    one("e", success="whole", failure="whole"),
)
"""Times of which no two are over at one moment, where events come each tenth of a second."""

TIES = mission(
    robot((), *(activity(name, ()) for name in "abcdef")),
    Parallel(
        name="all",
        blocks=(
            Recursive(
                name="r",
                blocks=(
                    one("d", 0.1, timeout_goto="c"),
                    one("c", 0.2, timeout_goto="d", success="d", failure="d"),
                ),
            ),
            Recursive(
                name="s",
                blocks=(
                    one("b", 0.3, timeout_goto="a"),
                    one("a", 0.3, timeout_goto="b", success="b", failure="b"),
                ),
            ),
            one("e", 1.2),
        ),
        success="f",
        failure="f",
    ),
    one("f", 0.6, success="all", failure="all", timeout_goto="all"),
)
"""Times of which many are over at one moment."""

OFTEN = (
    (TIMED, ("OBJ_d_EV_TIMEOUT", "OBJ_b_EV_TIMEOUT")),
    (BLOCKS, ("OBJ_both_try1.r_EV_TIMEOUT", "OBJ_whole_EV_TIMEOUT")),
    (TIES, ("OBJ_a_EV_TIMEOUT", "OBJ_c_EV_TIMEOUT")),
)
"""Missions with timeouts that come often."""


class Clock:
    """A clock that is put forward by hand, in milliseconds."""

    def __init__(self) -> None:
        self.time = 0

    def __call__(self) -> float:
        return self.time / 1000


@pytest.fixture(scope="module")
def net() -> MissionNet:
    return compose(replace(TIMED, name="m"))


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture(params=FORMS)
def controller(request: pytest.FixtureRequest, net: MissionNet, clock: Clock) -> Controller:
    return Controller.from_document(document(generate(net, request.param), net), clock=clock)


def test_a_timer_runs_while_its_objective_does(controller: Controller, clock: Clock) -> None:
    actions = controller.handle(START)
    assert [str(a) for a in actions] == ["select a a", "start a", "arm a_try1"]
    assert actions[-1].seconds == 1.009
    assert controller.timers == {"a_try1": 1.009}
    clock.time = 1000
    assert controller.tick() == ()
    assert controller.timers["a_try1"] == pytest.approx(0.009)
    clock.time = 1009
    ((event, actions),) = controller.tick()
    assert event == "OBJ_a_try1_EV_TIMEOUT"
    expected = ["disarm a_try1", "stop a", "release h", "select a a", "start a", "arm a_try2"]
    assert [str(a) for a in actions] == expected
    assert controller.timers == {"a_try2": 1.009}
    controller.handle("OBJ_a_try2_EV_FAIL")
    assert controller.timers == {"b": 1.717}
    clock.time = 10_000
    assert controller.tick()[0][0] == "OBJ_b_EV_TIMEOUT"
    assert controller.timers == {}


def test_an_objective_that_begins_again_has_all_its_time(controller: Controller, clock: Clock) -> None:
    for event in (START, "OBJ_a_try1_EV_OK", "OBJ_c_EV_FAIL"):
        controller.handle(event)
    clock.time = 1000
    actions = controller.handle("OBJ_d_EV_TIMEOUT")
    assert [str(a) for a in actions] == ["disarm d", "stop d", "select d d", "start d", "arm d"]
    assert controller.timers == pytest.approx({"b": 0.717, "d": 2.323})


def test_several_that_are_over_come_in_their_order(controller: Controller, clock: Clock) -> None:
    for event in (START, "OBJ_a_try1_EV_OK", "OBJ_c_EV_FAIL"):
        controller.handle(event)
    clock.time = 10_000
    assert [event for event, _ in controller.tick()] == ["OBJ_b_EV_TIMEOUT", "OBJ_d_EV_TIMEOUT"]
    assert controller.timers == pytest.approx({"d": 2.323})


def test_of_two_timers_that_are_over_at_one_moment_the_first_event_by_its_bytes_comes_first(
    clock: Clock,
) -> None:
    """``b`` is armed first, at a moment and for a time whose sum is not exact."""
    of = mission(
        robot((), *(activity(name, ()) for name in "abc"), events=("leak",)),
        Parallel(
            name="p",
            blocks=(
                Recursive(name="r", blocks=(one("c", failure="a", success="a"), one("a", 0.2))),
                one("b", 0.3),
            ),
        ),
    )
    net = compose(replace(of, name="m"))
    for form in FORMS:
        clock.time = 0
        controller = Controller.from_document(document(generate(net, form), net), clock=clock)
        controller.handle(START)
        clock.time = 100
        controller.handle("OBJ_c_EV_OK")
        assert list(controller.timers) == ["a", "b"]
        clock.time = 300
        assert controller.overdue == "OBJ_a_EV_TIMEOUT"


def test_a_snapshot_has_the_times_that_are_left(controller: Controller, clock: Clock) -> None:
    controller.handle(START)
    clock.time = 1000
    taken = controller.snapshot()
    clock.time = 500_000
    controller.restore(taken)
    assert controller.timers == pytest.approx({"a_try1": 0.009})
    wrong: object
    for wrong in ({}, {"b": 0.1}, {"a_try1": 2}, []):
        with pytest.raises(SnapshotError, match=r"what cannot be|timers: found"):
            controller.restore(snapshot_text(json.loads(taken) | {"timers": wrong}))
    assert controller.timers == pytest.approx({"a_try1": 0.009})


def short(net: MissionNet) -> Controller:
    """A controller whose timers are a hundred times shorter."""
    made = document(generate(net), net)
    for of in made["objectives"].values():
        if of["timeout"] is not None:
            of["timeout"] /= 100
    return Controller.from_document(signed(made))


def test_the_asyncio_adapter_keeps_the_timers(net: MissionNet) -> None:
    async def run() -> list[str]:
        robot = AsyncController(short(net))
        seen: list[str] = []
        await robot.put(START)
        async for event, _ in robot.reactions():
            seen.append(event)
            if event == "OBJ_a_try2_EV_TIMEOUT":
                await robot.put("OBJ_c_EV_OK")
            if len(seen) == 6:
                await robot.close()
        return seen

    tries = ["OBJ_a_try1_EV_TIMEOUT", "OBJ_a_try2_EV_TIMEOUT"]
    assert asyncio.run(run())[:5] == [START, *tries, "OBJ_c_EV_OK", "OBJ_b_EV_TIMEOUT"]


def test_the_asyncio_adapter_sees_timers_that_others_arm(net: MissionNet) -> None:
    async def run() -> str:
        robot = AsyncController(short(net))
        reactions = robot.reactions()
        first = asyncio.ensure_future(anext(reactions))
        await asyncio.sleep(0.01)
        await robot.handle(START)
        event, _ = await asyncio.wait_for(first, 10)
        return event

    assert asyncio.run(run()) == "OBJ_a_try1_EV_TIMEOUT"


def test_the_queue_keeps_the_timers(net: MissionNet) -> None:
    controller = short(net)
    queue = EventQueue(controller)
    thread = threading.Thread(target=queue.run)
    thread.start()
    queue.put(START)
    for _ in range(1000):
        if any(step.event == "OBJ_a_try2_EV_TIMEOUT" for step in list(controller.log)):
            break
        threading.Event().wait(0.01)
    queue.close()
    thread.join(10)
    events = [step.event for step in controller.log]
    assert events[:3] == [START, "OBJ_a_try1_EV_TIMEOUT", "OBJ_a_try2_EV_TIMEOUT"]


HARNESS = """
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "m.h"
int main(void)
{
    m_controller controller;
    m_action actions[M_MAX_ACTIONS];
    char line[200];
    m_init(&controller);
    while (fgets(line, sizeof line, stdin) != NULL) {
        size_t count = 0U;
        line[strcspn(line, "\\n")] = '\\0';
        if (line[0] == '+') {
            const m_event event = m_tick(&controller, (uint32_t)strtoul(&line[1], NULL, 10));
            (void)puts((event == M_NO_EVENT) ? "-" : m_event_name(event));
        } else {
            const m_event event = m_event_of(line, strlen(line));
            (void)puts((m_handle(&controller, event, actions, &count) == M_TAKEN) ? "taken" : "no");
        }
        if (m_valid(&controller) == 0) { return 1; }
    }
    return 0;
}
"""


def plan(controller: Controller, clock: Clock, often: Sequence[str]) -> tuple[list[str], list[str]]:
    """Events and times at random, what is over handled at once, with what the runtime says to each."""
    rng = random.Random(5)
    lines, said = [START], ["taken"]
    controller.handle(START)
    for _ in range(600):
        if rng.random() < 0.6:
            wait = 100 * rng.randrange(1, 12)
            clock.time += wait
            lines.append(f"+{wait}")
            while True:
                over = next((name for name, left in controller.timers.items() if not left), None)
                said.append("-" if over is None else f"OBJ_{over}_EV_TIMEOUT")
                if over is None:
                    break
                lines += [said[-1], "+0"]
                said.append("taken")
                controller.handle(lines[-2])
        else:
            lines.append(rng.choice([*controller.possible, often[0]]))
            try:
                controller.handle(lines[-1])
                said.append("taken")
            except Refused:
                said.append("no")
    assert all(said.count(event) > 5 for event in often)
    return lines, said


@pytest.mark.parametrize(("of", "often"), OFTEN)
@pytest.mark.parametrize("form", FORMS)
def test_c_ticks_as_the_runtime_does(
    form: Form, of: Mission, often: Sequence[str], clock: Clock, tmp_path: Path
) -> None:
    net = compose(replace(of, name="m"))
    made = generate(net, form)
    lines, said = plan(Controller.from_document(document(made, net), clock=clock), clock, often)
    every = files(document(made, net), "c")
    texts = {name: text for name, text in every.items() if not name.endswith("_main.c")}
    program = build(texts | {"harness.c": HARNESS}, tmp_path, *SANITIZE)
    run = subprocess.run([program], input="\n".join(lines) + "\n", capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.split() == said


NARROW = """
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#define size_t uint16_t
"""


def test_where_sizes_have_16_bits_a_time_of_65536_milliseconds_is_one(tmp_path: Path) -> None:
    """The cast of the time to a size made it 0, and the controller was told to be impossible."""
    net = compose(replace(mission(robot((), activity("a", ())), one("a", 65.536)), name="m"))
    texts = {
        n: text for n, text in files(document(generate(net), net), "c").items() if not n.endswith("_main.c")
    }
    for name, text in (texts | {"harness.c": HARNESS, "narrow.h": NARROW}).items():
        (tmp_path / name).write_text(text)
    narrow = ["-include", str(tmp_path / "narrow.h"), "-I", str(tmp_path)]
    sources = [str(tmp_path / "m.c"), str(tmp_path / "harness.c")]
    program = tmp_path / "program"
    subprocess.run(["gcc", "-std=c99", *narrow, "-o", str(program), *sources], check=True)
    run = subprocess.run([program], input=f"{START}\n+65535\n+1\n", capture_output=True, text=True)
    assert (run.returncode, run.stdout.split()) == (0, ["taken", "-", "OBJ_a_EV_TIMEOUT"])


@pytest.mark.parametrize(("of", "often"), OFTEN)
@pytest.mark.parametrize("form", FORMS)
def test_generated_python_ticks_as_the_runtime_does(
    form: Form, of: Mission, often: Sequence[str], clock: Clock
) -> None:
    net = compose(replace(of, name="m"))
    made = generate(net, form)
    lines, said = plan(Controller.from_document(document(made, net), clock=clock), clock, often)
    ((_, text),) = files(document(made, net), "python").items()
    generated, later = Generated(text), Clock()
    other, found = generated.controller(clock=later), list[str]()
    for line in lines:
        if line.startswith("+"):
            later.time += int(line)
            found.append(other.overdue or "-")
        else:
            try:
                other.handle(line)
                found.append("taken")
            except generated.module.Refused:
                found.append("no")
    assert found == said
