"""The runtime: refused events, queues, hooks, snapshots, files that are no controllers."""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, invariant, precondition, rule

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.mission.xml import read_mission
from mcpn.robot import runtime
from mcpn.robot.runtime import (
    Action,
    AsyncController,
    Controller,
    ControllerFileError,
    EventQueue,
    ParameterValue,
    QueueFull,
    Refused,
    SnapshotError,
)
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.robot.runtime.restoring import snapshot_text
from mcpn.robot.targets.json import write_json
from tests.conftest import ULYSSE

START = "MISSION_EV_START"
DIVING = ("OBJ_coral_head.manual_moving_EV_FAIL",)


def test_it_is_read_from_its_file(ulysse_net: MissionNet, tmp_path: Path) -> None:
    path = tmp_path / "controller.json"
    path.write_text(write_json(document(generate(ulysse_net), ulysse_net)))
    assert Controller.load(path).handle(START)[-1].verb == "start"


def test_it_needs_nothing_but_python() -> None:
    imported = "from mcpn.robot.runtime import *; import mcpn.robot.runtime.program"
    script = f"import sys; before = {{*sys.modules}}; {imported}; print(*{{*sys.modules}} - before)"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    loaded = run.stdout.split()
    assert {name for name in loaded if name.startswith("mcpn.robot.runtime.")} >= {
        f"mcpn.robot.runtime.{path.stem}" for path in Path(runtime.__path__[0]).glob("[!_]*.py")
    }
    foreign = {name for name in loaded if name.partition(".")[0] not in sys.stdlib_module_names}
    assert {name for name in foreign if not name.startswith("mcpn.robot.runtime")} <= {
        "mcpn",
        "mcpn.robot",
        "mcpn.version",
    }


def test_parameters_travel_with_the_alternative(controller: Controller) -> None:
    controller.handle(START)
    (select,) = [a for a in controller.handle(*DIVING) if a.alternative == "diving"]
    assert select.objective == "transect.diving"
    assert ParameterValue("depth", "10", "m") in select.parameters


def test_a_refused_event_changes_nothing_and_is_told(controller: Controller) -> None:
    before = controller.snapshot()
    for event, known in (("GPS_sensor_EV_RD", True), ("no_such_EV", False), ("", False), (DIVING[0], True)):
        with pytest.raises(Refused) as refused:
            controller.handle(event)
        assert (refused.value.event, refused.value.known) == (event, known)
        assert START in refused.value.possible
        assert (controller.log[-1].event, controller.log[-1].taken) == (event, False)
    with pytest.raises(Refused):
        controller.handle(7)  # type: ignore[arg-type]
    assert controller.refusals == controller.count == 5
    assert snapshot_text(json.loads(controller.snapshot()) | {"count": 0}) == before


def test_refused_events_may_be_handed_to_a_function(ulysse_document: dict[str, Any]) -> None:
    told: list[Refused] = []
    controller = Controller.from_document(ulysse_document, on_refused=told.append)
    assert controller.handle("no_such_EV") == ()
    assert [str(r.event) for r in told] == ["no_such_EV"]


def test_hardware_fails_before_the_start_and_after_the_end(controller: Controller) -> None:
    assert controller.handle("GPS_sensor_EV_OOS") == ()
    selected = {a.activity: a.alternative for a in controller.handle(START) if a.verb == "select"}
    assert selected["localisation"] == "imu_localisation"
    while controller.outcome is None:
        controller.handle(next(e for e in controller.possible if e.endswith("_EV_FAIL")))
    assert controller.outcome == "failure"
    assert controller.section is None
    assert dict(controller.mode) == {}
    assert controller.handle("GPS_sensor_EV_RD") == ()
    assert controller.out_of_service == frozenset()
    with pytest.raises(Refused):
        controller.handle(START)


def test_hooks_are_called_in_the_order_of_the_actions(controller: Controller) -> None:
    called: list[str] = []
    controller.on("localisation", lambda action: called.append(f"own {action}"))
    controller.on(None, lambda action: called.append(str(action)))
    actions = controller.handle(START)
    assert [c for c in called if not c.startswith("own")] == [str(a) for a in actions]
    at = called.index("select localisation gps_localisation")
    assert called[at - 1] == "own select localisation gps_localisation"


def test_a_hook_that_fails_stops_nothing(controller: Controller) -> None:
    called: list[Action] = []

    def fails(action: Action) -> None:
        raise RuntimeError(action.verb)

    controller.on("localisation", fails)
    controller.on(None, called.append)
    with pytest.raises(ExceptionGroup) as group:
        controller.handle(START)
    assert [str(e) for e in group.value.exceptions] == ["select", "start"]
    assert controller.section == "coral_head.manual_moving"
    assert tuple(called) == controller.log[-1].actions


def test_the_log_is_bounded_and_times_are_kept(ulysse_document: dict[str, Any]) -> None:
    controller = Controller.from_document(ulysse_document, log=4)
    for _ in range(10):
        controller.handle("GPS_sensor_EV_OOS")
        controller.handle("GPS_sensor_EV_RD")
    assert [step.number for step in controller.log] == [17, 18, 19, 20]
    assert 0 < controller.slowest <= controller.seconds
    assert all(step.seconds <= controller.slowest for step in controller.log)


def test_snapshots_are_whole_or_refused(controller: Controller, ulysse_document: dict[str, Any]) -> None:
    controller.handle("IMU_sensor_EV_OOS")
    controller.handle(START)
    text, mode = controller.snapshot(), dict(controller.mode)
    other = Controller.from_document(ulysse_document)
    untouched = other.snapshot()
    for length in range(len(text)):
        with pytest.raises(SnapshotError):
            other.restore(text[:length])
    said = json.loads(text)
    changes: tuple[dict[str, Any], ...] = (
        {"state": 10**9},
        {"state": -1},
        {"state": True},
        {"section": None},
        {"section": "nowhere"},
        {"phase": "success"},
        {"out_of_service": []},  # the state says otherwise
        {"out_of_service": ["no_such_sensor"]},
        {"count": -1},
        {"controller": "0"},
        {"version": 1},
    )
    for changed in changes:
        with pytest.raises(SnapshotError):
            other.restore(snapshot_text(said | changed))
    assert other.snapshot() == untouched
    other.restore(text)
    assert dict(other.mode) == mode
    assert other.snapshot() == text


def test_no_changed_byte_of_a_snapshot_goes_unseen(controller: Controller) -> None:
    """Nor does one that leaves it a snapshot of this controller, in a state that it can be in."""
    controller.handle("IMU_sensor_EV_OOS")
    controller.handle(START)
    text = controller.snapshot()
    possible = 0
    for at, byte in enumerate(text):
        for bit in range(8):
            changed = text[:at] + chr(ord(byte) ^ 1 << bit) + text[at + 1 :]
            with pytest.raises(SnapshotError) as refused:
                controller.restore(changed)
            possible += "digest" in str(refused.value)
            with suppress(ValueError, TypeError, AttributeError, SnapshotError):
                controller.restore(snapshot_text(json.loads(changed)))
    assert possible > 8 * 64
    controller.restore(text + "\n")


@given(st.binary(max_size=60) | st.text(max_size=60))
def test_no_text_is_taken_for_a_snapshot(text: str | bytes) -> None:
    with pytest.raises(SnapshotError):
        shared().restore(text)  # type: ignore[arg-type]


def test_files_that_are_no_controllers_are_told(ulysse_document: dict[str, Any], tmp_path: Path) -> None:
    text = json.dumps(ulysse_document)
    path = tmp_path / "c.json"
    for broken in ("", "[]", "{}", text[: len(text) // 2], text.replace('"version": 1', '"version": 2')):
        path.write_text(broken)
        with pytest.raises(ControllerFileError):
            Controller.load(path)
    with pytest.raises(ControllerFileError):
        Controller.load(tmp_path / "none.json")
    for key in ("sections", "types", "initial", "hardware", "activities"):
        with pytest.raises(ControllerFileError, match=f"expected the key {key}"):
            Controller.from_document({k: v for k, v in ulysse_document.items() if k != key})


def test_events_from_several_threads_are_all_handled(controller: Controller) -> None:
    queue = EventQueue(controller, size=8)
    worker = threading.Thread(target=queue.run)
    worker.start()

    def send(hardware: str) -> None:
        for _ in range(200):
            queue.put(f"{hardware}_EV_OOS", timeout=10)
            queue.put(f"{hardware}_EV_RD", timeout=10)

    senders = [threading.Thread(target=send, args=(h,)) for h in ("GPS_sensor", "IMU_sensor")]
    for sender in senders:
        sender.start()
    for sender in senders:
        sender.join()
    queue.put("no_such_EV", timeout=10)
    queue.close()
    worker.join()
    assert (controller.count, controller.refusals) == (801, 1)
    assert controller.out_of_service == frozenset()


def test_a_full_queue_is_an_error_of_the_sender(controller: Controller) -> None:
    queue = EventQueue(controller, size=2)
    queue.put("GPS_sensor_EV_OOS")
    queue.put("IMU_sensor_EV_OOS")
    with pytest.raises(QueueFull):
        queue.put("thruster_actuator_EV_OOS")
    with pytest.raises(QueueFull):
        queue.put("thruster_actuator_EV_OOS", timeout=0.01)
    worker = threading.Thread(target=queue.run)
    worker.start()
    queue.close()
    worker.join()
    assert controller.out_of_service == {"GPS_sensor", "IMU_sensor"}
    for make in (EventQueue, AsyncController):
        with pytest.raises(ValueError, match="at least 1"):
            make(controller, 0)


def test_coroutines(controller: Controller) -> None:
    async def mission() -> list[str]:
        robot = AsyncController(controller, size=3)
        await robot.handle("GPS_sensor_EV_OOS")
        for event in (START, "no_such_EV"):
            await robot.put(event)
        robot.put_nowait("IMU_sensor_EV_OOS")
        with pytest.raises(QueueFull):
            robot.put_nowait("IMU_sensor_EV_RD")
        seen = []

        async def listen() -> None:
            async for event, _ in robot.reactions():
                seen.append(event)

        listening = asyncio.create_task(listen())
        await robot.close()
        await listening
        return seen

    assert asyncio.run(mission()) == [START, "IMU_sensor_EV_OOS"]
    assert controller.refusals == 1


_SHARED: list[Tables] = []


def shared() -> Controller:
    """A controller of Ulysse for tests that hypothesis runs."""
    if not _SHARED:
        net = compose(read_mission(ULYSSE))
        _SHARED.append(Tables(document(generate(net), net)))
    return Controller(_SHARED[0])


class Sessions(RuleBasedStateMachine):
    """A controller that is snapshot and restored at will does what one does that replays its events."""

    snapshots = Bundle("snapshots")

    def __init__(self) -> None:
        super().__init__()
        self.controller = shared()
        self.events: list[str] = []

    @precondition(lambda self: bool(self.controller.possible))
    @rule(data=st.data())
    def take(self, data: st.DataObject) -> None:
        event = data.draw(st.sampled_from(self.controller.possible))
        self.controller.handle(event)
        self.events.append(event)

    @rule(data=st.data())
    def refuse(self, data: st.DataObject) -> None:
        every = {f"{h}_EV_{e}" for h in ("GPS_sensor", "thruster_actuator") for e in ("OOS", "RD")}
        wrong = sorted((every | {START, "x"}) - set(self.controller.possible))
        with pytest.raises(Refused):
            self.controller.handle(data.draw(st.sampled_from(wrong)))

    @rule(target=snapshots)
    def save(self) -> tuple[str, list[str]]:
        return self.controller.snapshot(), list(self.events)

    @rule(saved=snapshots, anew=st.booleans())
    def load(self, saved: tuple[str, list[str]], anew: bool) -> None:
        if anew:
            self.controller = shared()
        self.controller.restore(saved[0])
        self.events = list(saved[1])

    @invariant()
    def does_what_a_replay_does(self) -> None:
        other = shared()
        for event in self.events:
            other.handle(event)
        assert other.possible == self.controller.possible
        assert other.state == self.controller.state
        assert other.outcome == self.controller.outcome


TestSessions = Sessions.TestCase
TestSessions.settings = settings(stateful_step_count=20, max_examples=40, deadline=None)
