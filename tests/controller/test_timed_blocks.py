"""Timers of blocks: which run, and since when, against the interpreter that draws no net."""

from __future__ import annotations

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.robot.runtime import Controller
from mcpn.testing import elements as drawn
from mcpn.testing.judge.blocks import WrittenBlock
from mcpn.testing.judge.interpreter import Interpreter, State, Undetermined
from mcpn.testing.judge.lockstep import happening
from tests.controller.test_timers import BLOCKS, FORMS, Clock
from tests.draws import composed, fewer

MOST_STEPS = 40


class Timing(Interpreter):
    """Notes which blocks an event leaves, so that their time starts anew where it enters them again."""

    def __init__(self, of: Mission) -> None:
        super().__init__(of)
        self.gone = set[str]()

    def left(self, state: State, node: WrittenBlock) -> State:
        self._note(node)
        return super().left(state, node)

    def stopped(self, state: State, node: WrittenBlock) -> State:
        self._note(node)
        return super().stopped(state, node)

    def end(self, state: State, node: WrittenBlock, by: str, aborted: list[WrittenBlock]) -> State:
        self._note(node)
        return super().end(state, node, by, aborted)

    def _note(self, node: WrittenBlock) -> None:
        self.gone |= {name for name, timed in self.timed.items() if timed.within(node)}

    def running(self, state: State) -> set[str]:
        """The objectives and blocks whose time runs."""
        return {name for name, node in self.timed.items() if self.under_way(node, state)}


@fewer(0.5)
@given(
    drawn.IN_TIME | drawn.PAUSING_IN_TIME | drawn.LEFT_BY_FACTS,
    st.sampled_from(FORMS),
    st.randoms(use_true_random=False),
)
def test_timers_are_those_of_what_runs(of: Mission, form: Form, rng: object) -> None:
    clock, told, began = Clock(), Timing(of), dict[str, int]()
    try:
        net = composed(of)
        controller = Controller.from_document(document(generate(net, form), net), clock=clock)
    except (LimitError, SemanticsError):
        return
    state, restored = told.initial, 0
    events = {happening(t.event): str(t.event) for t in net.net.transitions if t.event}
    for _ in range(MOST_STEPS):
        possible = sorted(told.possible(state))
        if not possible or state.outcome:
            break
        happened = rng.choice(possible)  # type: ignore[attr-defined]
        told.gone, before = set(), told.running(state)
        try:
            state = told.after(state, happened)
        except Undetermined:
            break
        clock.time += 1
        controller.handle(events[happened])
        now = told.running(state)
        for name in now:
            if name not in before or name in told.gone:
                began[name] = clock.time
        ends = {name: told.timed[name].timeout for name in now}
        expected = {name: s - (clock.time - began[name]) / 1000 for name, s in ends.items() if s is not None}
        assert controller.timers == pytest.approx(expected)
        restored += len(expected)
        controller.restore(controller.snapshot())
        assert controller.timers == pytest.approx(expected)
    blocks = [name for name, node in told.timed.items() if node.children]
    event(f"timed blocks: {min(len(blocks), 3)}, timers: {min(restored, 10)}")


@pytest.mark.parametrize("form", FORMS)
def test_a_block_that_is_entered_again_has_all_its_time(form: Form) -> None:
    net, clock = compose(BLOCKS), Clock()
    controller = Controller.from_document(document(generate(net, form), net), clock=clock)
    assert str(controller.handle("MISSION_EV_START")[-1]) == "arm whole"
    assert controller.timers == pytest.approx({"whole": 2.137})
    clock.time = 1000
    controller.handle("OBJ_a_EV_OK")
    controller.handle("OBJ_b_EV_OK")
    assert controller.timers == pytest.approx({"whole": 1.137})  # a route inside leads back to its first
    assert [str(a) for a in controller.handle("leak")][-1] == "arm whole"
    assert controller.timers == pytest.approx({"whole": 2.137})  # it has been left, and entered again
    controller.handle("OBJ_a_EV_FAIL")
    prefix = "both_try1."
    assert controller.timers == pytest.approx({"whole": 2.137, "both_try1": 0.509, f"{prefix}r": 0.311})
    clock.time = 1311
    ((over, actions),) = controller.tick()
    assert over == f"OBJ_{prefix}r_EV_TIMEOUT"
    assert "stop d" in [str(a) for a in actions]
    assert controller.timers == pytest.approx({"whole": 1.826, "both_try1": 0.198})
    clock.time = 1509
    ((over, actions),) = controller.tick()
    assert over == "OBJ_both_try1_EV_TIMEOUT"
    assert controller.timers == pytest.approx({"whole": 1.628, "both_try2": 0.509, "both_try2.r": 0.311})
    clock.time = 10_000
    controller.handle("OBJ_both_try2.r_EV_TIMEOUT")
    controller.handle("OBJ_both_try2_EV_TIMEOUT")
    assert controller.where.inside.objectives == ("e",)
    assert controller.timers == {}
