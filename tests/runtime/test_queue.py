"""Queues: hooks that fail, urgent events, watchdogs, coroutines."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections import defaultdict
from collections.abc import Mapping

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.robot.runtime import (
    Action,
    AsyncController,
    Controller,
    EventQueue,
    HookError,
    HookErrors,
    QueueClosed,
    QueueFull,
    Refused,
    Step,
    Watchdog,
)

START, LOST, BACK = "MISSION_EV_START", "GPS_sensor_EV_OOS", "GPS_sensor_EV_RD"


def fails(action: Action) -> None:
    raise RuntimeError(str(action))


def test_a_hook_that_fails_is_logged_and_the_queue_goes_on(
    controller: Controller, caplog: pytest.LogCaptureFixture
) -> None:
    called: list[Action] = []
    controller.on("localisation", fails)
    controller.on(None, called.append)
    queue = EventQueue(controller, size=2)
    worker = threading.Thread(target=queue.run)
    worker.start()
    with caplog.at_level(logging.ERROR, "mcpn.robot.runtime"):
        for event in (START, LOST, BACK, LOST):
            queue.put(event, timeout=10)
        queue.close()
        worker.join(10)
    assert not worker.is_alive()
    assert [step.event for step in controller.log] == [START, LOST, BACK, LOST]
    assert called == [action for step in controller.log for action in step.actions]
    first = next(record.getMessage() for record in caplog.records)
    assert START in first
    assert "select localisation gps_localisation" in first


def test_a_queue_may_stop_at_a_hook_that_fails_and_go_on(controller: Controller) -> None:
    controller.on("localisation", fails)
    queue = EventQueue(controller, size=2, on_error="stop")
    queue.put(START)
    queue.put(LOST)
    with pytest.raises(HookErrors) as errors:
        queue.run()
    assert {each.event for each in errors.value.failed} == {START}
    assert [str(each.error) for each in errors.value.failed] == [
        "select localisation gps_localisation",
        "start localisation",
    ]
    assert queue.waiting == 1
    queue.close()  # does not block
    with pytest.raises(HookErrors):
        queue.run()
    queue.run()
    assert [step.event for step in controller.log] == [START, LOST]
    with pytest.raises(QueueClosed):
        queue.put(BACK)


def test_a_function_may_be_told_of_hooks_that_fail(controller: Controller) -> None:
    told: list[HookError] = []
    controller.on("localisation", fails)
    queue = EventQueue(controller, on_error=told.append)
    queue.put(START)
    queue.close()
    queue.run()
    assert [(each.event, str(each.action)) for each in told] == [
        (START, "select localisation gps_localisation"),
        (START, "start localisation"),
    ]


def test_an_observer_that_fails_keeps_no_hook_from_being_called(controller: Controller) -> None:
    def observer(step: Step) -> None:
        raise RuntimeError(step.event)

    called: list[Action] = []
    controller.observe(observer)
    controller.on(None, called.append)
    with pytest.raises(HookErrors) as errors:
        controller.handle(START)
    assert [(each.event, each.action) for each in errors.value.failed] == [(START, None)]
    assert tuple(called) == controller.log[-1].actions != ()


class Recorded:
    """A controller that takes anything, and notes it."""

    overdue = None
    timers: Mapping[str, float] = {}

    def __init__(self) -> None:
        self.handled: list[str] = []

    def handle(self, event: str) -> None:
        self.handled.append(event)


@given(st.lists(st.tuples(st.sampled_from("abc"), st.sampled_from(["OOS", "RD"]), st.integers(0, 2))))
def test_urgency_is_an_order_and_drops_nothing(drawn: list[tuple[str, str, int]]) -> None:
    """What waits is handled once each, of one element in order, and urgent elements first."""
    taken = Recorded()
    events = [f"{element}_EV_{what}.{n}.{urgency}" for n, (element, what, urgency) in enumerate(drawn)]
    queue = EventQueue(taken, urgency=lambda event: int(event.rsplit(".", 1)[1]))  # type: ignore[arg-type]
    for event in events:
        queue.put(event)
    queue.close()
    queue.run()
    assert sorted(taken.handled) == sorted(events)
    left: dict[str, list[str]] = defaultdict(list)
    for event in events:
        left[event[0]].append(event)
    for event in taken.handled:
        assert event == left[event[0]][0]  # of one element in the order of their coming
        most = max(int(e.rsplit(".", 1)[1]) for of in left.values() for e in of)
        assert most == max(int(e.rsplit(".", 1)[1]) for e in left[event[0]])
        rivals = [of[0] for of in left.values() if of and max(int(e[-1]) for e in of) == most]
        assert int(event.split(".")[1]) == min(int(e.split(".")[1]) for e in rivals)
        left[event[0]].pop(0)


def test_an_urgent_failure_does_not_overtake_the_repair_before_it(controller: Controller) -> None:
    controller.handle(LOST)
    queue = EventQueue(controller, urgency=lambda event: event.endswith("_OOS"))
    for event in ("IMU_sensor_EV_OOS", START, BACK, LOST):
        queue.put(event)
    queue.close()
    queue.run()
    assert [step.event for step in controller.log][1:] == ["IMU_sensor_EV_OOS", BACK, LOST, START]
    assert controller.out_of_service == {"GPS_sensor", "IMU_sensor"}
    assert controller.refusals == 0


def test_coroutine_hooks_are_awaited_in_the_order_of_the_actions(controller: Controller) -> None:
    done: list[str] = []

    async def slow(action: Action) -> None:
        await asyncio.sleep(0)
        done.append(str(action))

    async def breaks(action: Action) -> None:
        raise RuntimeError(str(action))

    controller.on(None, slow)

    async def mission() -> None:
        robot = AsyncController(controller)
        actions = await robot.handle(START)
        assert done == [str(action) for action in actions]
        controller.on("localisation", breaks)
        told: list[HookError] = []
        robot = AsyncController(controller, on_error=told.append)
        for event in (LOST, "no_such_EV", BACK):
            await robot.put(event)
        await robot.close()
        seen = [event async for event, _ in robot.reactions()]
        assert seen == [LOST, BACK]
        assert {each.event for each in told} == {LOST}
        with pytest.raises(HookErrors):
            await robot.handle("IMU_sensor_EV_OOS")

    asyncio.run(mission())
    assert done == [str(action) for step in controller.log for action in step.actions]


def test_two_events_at_once_are_handled_one_after_the_other(controller: Controller) -> None:
    order: list[str] = []

    async def slow(action: Action) -> None:
        order.append(f"begin {action}")
        await asyncio.sleep(0.001)
        order.append(f"end {action}")

    controller.on(None, slow)

    async def mission() -> None:
        robot = AsyncController(controller)
        await asyncio.gather(robot.handle(START), robot.handle(LOST))

    asyncio.run(mission())
    said = [str(action) for step in controller.log for action in step.actions]
    assert order == [f"{edge} {text}" for text in said for edge in ("begin", "end")]


def test_a_coroutine_hook_of_a_controller_without_coroutines_is_an_error(controller: Controller) -> None:
    async def hook(action: Action) -> None:
        raise AssertionError

    controller.on("localisation", hook)
    with pytest.raises(HookErrors) as errors:
        controller.handle(START)
    assert "AsyncController" in str(errors.value.failed[0])


def test_a_watchdog_tells_of_each_silence_once(controller: Controller) -> None:
    silences: list[float] = []
    heard = threading.Event()

    def alarm(silence: float) -> None:
        silences.append(silence)
        heard.set()

    watchdog = Watchdog(0.02, alarm)
    controller.observe(watchdog)
    for number, event in enumerate((LOST, BACK), 1):
        assert heard.wait(10)
        assert len(silences) == number
        heard.clear()
        assert not heard.wait(0.06)  # told once
        controller.handle(event)
    assert heard.wait(10)
    watchdog.close()
    assert all(silence >= 0.02 for silence in silences)
    with pytest.raises(ValueError, match="more than 0"):
        Watchdog(0, alarm)


def test_a_closed_queue_still_hands_out_what_waits(controller: Controller) -> None:
    queue = EventQueue(controller, size=1)
    queue.put(LOST)
    with pytest.raises(QueueFull):
        queue.put(BACK)
    queue.close()
    queue.run()
    assert controller.out_of_service == {"GPS_sensor"}


def over(controller: Controller) -> None:
    """Arms a timer whose event the controller never takes, and that is over."""
    controller._timers.follow([Action("arm", objective="ghost", seconds=0.0)])
    assert controller.overdue == "OBJ_ghost_EV_TIMEOUT"


def test_a_timer_that_is_refused_is_told_once(controller: Controller) -> None:
    over(controller)
    queue = EventQueue(controller)
    queue.put(LOST)
    queue.close()
    queue.run()
    assert controller.refusals == 1
    assert controller.out_of_service == {"GPS_sensor"}
    assert (controller.overdue, controller.timers) == (None, {})
    over(controller)
    with pytest.raises(Refused):
        controller.tick()
    assert controller.tick() == ()


def test_coroutines_hear_once_of_a_timer_that_is_refused(controller: Controller) -> None:
    async def run() -> list[str]:
        over(controller)
        events = AsyncController(controller)
        await events.put(LOST)
        await events.close()
        return [event async for event, _ in events.reactions()]

    assert asyncio.run(run()) == [LOST]
    assert controller.refusals == 1


def test_a_queue_holds_as_many_events_as_it_may(controller: Controller) -> None:
    queue = EventQueue(controller, size=2)
    for _ in range(2):
        queue.put(LOST)
        queue.put(BACK)
        assert queue.waiting == 2
        with pytest.raises(QueueFull, match="2 events wait already"):
            queue.put(LOST)
        assert [queue._next(), queue._next()] == [LOST, BACK]
        assert queue.waiting == 0


def test_an_event_waits_for_a_free_place(controller: Controller) -> None:
    queue = EventQueue(controller, size=1)
    queue.put(LOST)
    taking = threading.Timer(0.05, queue._next)
    taking.start()
    queue.put(BACK, timeout=60)
    taking.join()
    assert queue._next() == BACK
