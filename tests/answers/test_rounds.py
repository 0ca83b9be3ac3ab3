"""Rounds of a mission that differ in names alone: what is found once for them is what each says by itself."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.answers.causes.find import GoalCauses
from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.causes.risk import risk
from mcpn.drawing.compose import compose
from mcpn.mission.model import FAIL, SUCCEED, Block, Mission, Objective, Parallel
from tests.draws import fewer
from tests.logic.asked import Asked
from tests.small import activity, hw, mission, robot

SENSE = activity("sense", ("camera",), ("radar",), produces=("position",))
GO = activity("go", ("wheels", "position"), ("wheels",))
LOOK = activity("look", ("position",))
HOME = activity("dock", ("radar",))


@st.composite
def rounds(draw: st.DrawFn) -> Mission:
    """Equal rounds one after the other, with routes of their own on failure; what comes last differs."""
    count = draw(st.integers(2, 4))
    wide = draw(st.booleans())
    blocks: list[Block] = []
    for number in range(count):
        name, onward = f"round{number}", f"round{number + 1}" if number + 1 < count else "last"
        failure = draw(st.sampled_from([onward, name, "round0", FAIL, "last"]))
        timed = {"duration": 0.5, "failure_probability": 0.125}
        if wide:
            parts = tuple(
                Objective(name=f"{what}{number}", activities=(what,), **timed)  # type: ignore[arg-type]
                for what in ("go", "look")
            )
            blocks.append(Parallel(name=name, blocks=parts, success=onward, failure=failure))
        else:
            blocks.append(
                Objective(name=name, activities=("go",), success=onward, failure=failure, **timed)  # type: ignore[arg-type]
            )
    last = Objective(name="last", activities=("dock",), success=SUCCEED, duration=1.0)
    hardware = tuple(
        replace(h, failure_rate=0.25, repair_rate=rate)
        for h, rate in zip(hw("wheels", "camera", "radar"), (None, 0.5, 0.125), strict=True)
    )
    return mission(robot(hardware, SENSE, GO, LOOK, HOME), *blocks, last)


def said(causes: GoalCauses) -> object:
    """What an answer says, whatever the order in which events are told."""
    critical = (
        Counter({(c.event, c.objectives, tuple(sorted(c.mode.items()))): c.edges for c in told})
        for told in (causes.critical, causes.critical_with_repairs)
    )
    return causes.name, causes.moments, causes.nonmonotone is None, *critical


@fewer(0.2)
@given(rounds())
def test_each_round_has_its_own_answers(mission: Mission) -> None:
    mission_net = compose(mission)
    whole, local = (Asked(mission_net, engine) for engine in ("explicit", "local"))
    for name, causes in whole.all.objectives.items():
        assert said(local.all.objectives[name]) == said(causes)
    assert said(local.all.mission) == said(whole.all.mission)
    assert fmeca(local.prospects) == fmeca(whole.prospects)
    numbers, exact = risk(local.prospects), risk(whole.prospects)
    assert numbers.success == pytest.approx(exact.success, abs=1e-9)
    assert numbers.failure == pytest.approx(exact.failure, abs=1e-9)
    assert numbers.degraded_modes == pytest.approx(exact.degraded_modes)
    assert numbers.importance == pytest.approx(dict(exact.importance), abs=1e-9)
