"""Net, flat, hierarchical and modular controller do the same, action for action."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import get_args

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.controller.machine import VERBS
from mcpn.controller.modular import AnyController
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Hardware
from mcpn.robot.runtime import Action
from mcpn.robot.runtime import Controller as Runtime
from mcpn.testing import missions
from mcpn.testing.stacked import stacked_missions
from tests.controller.oracle import NetRobot
from tests.drawing.promises import check_each_is_one_thing
from tests.draws import composed, fewer
from tests.small import activity, hw, mission, robot

FORMS: tuple[Form, ...] = get_args(Form)


def plain(actions: tuple[Action, ...]) -> list[tuple[str, ...]]:
    parts = ((a.verb, a.activity or a.hardware or a.objective, a.alternative) for a in actions)
    return sorted(tuple(part for part in action if part is not None) for action in parts)


def check_order(mission_net: MissionNet, before: dict[str, str], actions: tuple[Action, ...]) -> None:
    """Stops, releases, selections, starts; consumers stop before producers, and start after them."""
    verbs = [VERBS.index(a.verb) for a in actions]
    assert verbs == sorted(verbs)
    usage = mission_net.usage
    for verb in ("stop", "start"):
        order = [a.activity for a in actions if a.verb == verb]
        assert len(order) == len(set(order))
        for i, one in enumerate(order):
            for other in order[i + 1 :]:
                assert one is not None
                assert other is not None
                first, second = (one, other) if verb == "stop" else (other, one)
                assert first not in usage.closure(second), f"{second} stands on {first}"
    mode = dict(before)
    for action in actions:
        name = action.activity or ""
        if action.verb == "stop":
            del mode[name]
        elif action.verb == "select":
            assert action.alternative is not None
            mode[name] = action.alternative
        elif action.verb == "start":
            assert name in mode, "an alternative is selected before its activity starts"


def walk(
    mission_net: MissionNet, controllers: Sequence[AnyController], rng: random.Random, steps: int
) -> list[Runtime]:
    robot = NetRobot(mission_net, rng)
    runtimes = [Runtime.from_document(document(c, mission_net), clock=lambda: 0.0) for c in controllers]
    for _ in range(steps):
        possible = sorted(robot.possible)
        for runtime in runtimes:
            assert runtime.possible == tuple(possible)
            assert dict(runtime.mode) == robot.mode
            assert runtime.outcome == robot.outcome
            assert runtime.timers.keys() == robot.objectives & robot.timed
            assert set(runtime.state.objectives) == robot.objectives
            check_each_is_one_thing(mission_net, runtime.state)
        if not possible:
            break
        chosen = rng.choice(possible)
        before = robot.mode
        expected = robot.handle(chosen)
        taken = [runtime.handle(chosen) for runtime in runtimes]
        for actions in taken:
            assert plain(actions) == expected
            assert actions == taken[0]
        check_order(mission_net, before, taken[0])
    return runtimes


@pytest.fixture(scope="module")
def every(ulysse_net: MissionNet) -> list[AnyController]:
    return [generate(ulysse_net, form) for form in FORMS]


def test_every_controller_of_ulysse_walks_beside_its_net(
    ulysse_net: MissionNet, every: list[AnyController]
) -> None:
    for seed in range(10):
        walk(ulysse_net, every, random.Random(seed), 200)


def either(mission_net: MissionNet) -> list[AnyController]:
    """The controllers that a mission has."""
    found: list[AnyController] = []
    for form in FORMS:
        try:
            found.append(generate(mission_net, form, max_states=1000))
        except (SemanticsError, LimitError) as error:
            event(f"{form}: {type(error).__name__}")
    return found


@fewer(0.25)
@given(
    missions(max_objectives=3, max_depth=2)
    | missions(max_objectives=2, max_depth=2, max_sections=6, faults=2)
    | missions(max_objectives=2, max_depth=2, max_sections=6, lasting=True, crashes=True)
    | missions(max_objectives=2, max_depth=2, max_sections=6, late=True, lasting=True),
    st.integers(0, 2**32),
)
def test_any_mission(mission: Mission, seed: int) -> None:
    mission_net = composed(mission)
    controllers = either(mission_net)
    event(f"{len(controllers)} controllers")
    if controllers:
        walk(mission_net, controllers, random.Random(seed), 60)


def one_goes_as_another_comes(together: tuple[str, ...]) -> Mission:
    """The failure of h0 ends ``first``, which releases s0, and makes ``beside`` want s0."""
    of = robot(
        (Hardware(name="h0", shared=True), Hardware(name="h1")),
        activity("producer", ("h0",), ("h1",), produces=("s0",)),
        activity("first", ("s0", "h0")),
        activity("beside", ("h0",), ("s0",)),
    )
    return mission(of, Objective(name="one", activities=together))


@pytest.mark.parametrize("together", [("first", "beside"), ("beside", "first")])
def test_whether_a_producer_goes_on_is_the_same_in_every_controller(together: tuple[str, ...]) -> None:
    mission_net = compose(one_goes_as_another_comes(together))
    controllers = either(mission_net)
    assert len(controllers) == len(FORMS)
    for seed in range(20):
        walk(mission_net, controllers, random.Random(seed), 30)


def test_a_section_need_not_be_confluent_where_the_mission_never_comes() -> None:
    """``both`` asks h0 twice, so the objective after it, where two activities want h0, never begins."""
    of = robot(
        hw("h0"),
        activity("producer", ("h0",), produces=("s0",)),
        activity("plain", ("h0",)),
        activity("both", ("s0", "h0"), ("s0", "h0"), ("h0",)),
        activity("other", (), ("s0",), ("h0",)),
    )
    blocks = (
        Objective(name="one", activities=("other",), failure="fail"),
        Objective(name="two", activities=("both", "other"), failure="one"),
        Objective(name="three", activities=("both", "plain"), failure="one"),
    )
    mission_net = compose(mission(of, *blocks))
    controllers = [generate(mission_net, "flat"), generate(mission_net, "hierarchical")]
    with pytest.raises(LimitError, match=r"section three: .* it has no modular controller"):
        generate(mission_net, "modular")  # its rules would be of what the mission never comes to, too
    for seed in range(10):
        walk(mission_net, controllers, random.Random(seed), 30)


@fewer(0.25)
@given(stacked_missions(), st.integers(0, 2**32))
def test_missions_of_stacked_producers(mission: Mission, seed: int) -> None:
    mission_net = composed(mission)
    controllers = either(mission_net)
    event(f"{len(controllers)} controllers")
    if controllers:
        walk(mission_net, controllers, random.Random(seed), 30)


@fewer(0.25)
@given(
    missions(max_objectives=3, max_depth=2, allow_disjoint_branches=True, outputs=3), st.integers(0, 2**32)
)
def test_missions_without_contention(mission: Mission, seed: int) -> None:
    mission_net = composed(mission)
    controllers = either(mission_net)
    event(f"{len(controllers)} controllers")
    if controllers:
        walk(mission_net, controllers, random.Random(seed), 60)


@fewer(0.25)
@given(missions(max_objectives=3, max_depth=2, events=2, early=3, awkward_names=True), st.integers(0, 2**32))
def test_missions_with_declared_events(mission: Mission, seed: int) -> None:
    """An interruption is an event like any other; of a section's machine it is an exit."""
    mission_net = composed(mission)
    controllers = either(mission_net)
    event(f"{len(controllers)} controllers")
    if controllers:
        walk(mission_net, controllers, random.Random(seed), 40)


@fewer(0.5)
@given(
    missions(max_objectives=3, max_depth=2, events=1, aborts=1, timeouts=7),
    st.integers(0, 2**32),
)
def test_missions_with_timeouts(mission: Mission, seed: int) -> None:
    mission_net = composed(mission)
    controllers = either(mission_net)
    event(f"{len(controllers)} controllers")
    if controllers:
        walk(mission_net, controllers, random.Random(seed), 40)
