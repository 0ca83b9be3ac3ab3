"""Runs to failure and robust runs, replayed on the net and compared with plain search."""

from __future__ import annotations

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.causes.cutsets import Moment
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.nets.petri import Marking
from mcpn.spaces.engines import Engine
from mcpn.spaces.run import Run
from mcpn.spaces.stable.alternatives import direct
from tests.draws import fewer
from tests.logic.asked import ENGINES, Asked
from tests.logic.oracle import Play, fragile_missions
from tests.shares import returns_early


def events(run: Run) -> list[str]:
    return [str(event) for event in run.events]


@pytest.mark.parametrize("engine", ENGINES)
def test_ulysse_runs_to_failure(ulysse_net: MissionNet, engine: Engine) -> None:
    asked = Asked(ulysse_net, engine)
    run = asked.prospects.to_failure(asked.goal("transect.going_up"), ["thruster_actuator"])
    assert run is not None
    # The way through the failures of moving and of diving is the shortest, and the lost thruster forces both.
    assert sorted(events(run)) == [
        "MISSION_EV_START",
        "OBJ_coral_head.manual_moving_EV_FAIL",
        "OBJ_transect.diving_EV_FAIL",
        "OBJ_transect.going_up_EV_FAIL",
        "thruster_actuator_EV_OOS",
    ]


@pytest.mark.parametrize("engine", ENGINES)
def test_ulysse_survives_one_failure_at_most(ulysse_net: MissionNet, engine: Engine) -> None:
    asked = Asked(ulysse_net, engine)
    for section in (None, "coral_head.manual_moving", "transect.census", "transect.going_up"):
        run = asked.prospects.most_failures(
            asked.prospects.mission, None if section is None else asked.sections[section]
        )
        assert run is not None
        # The thruster is in use to the end; of the two sensors one may be lost.
        (failure,) = [e for e in events(run) if e.endswith("_EV_OOS")]
        assert failure in ("GPS_sensor_EV_OOS", "IMU_sensor_EV_OOS")


@fewer(0.4)
@given(
    fragile_missions(max_hardware=3, max_objectives=2, max_sections=5)
    | fragile_missions(max_hardware=3, max_objectives=2, max_sections=5, events=2)
    | fragile_missions(max_hardware=2, max_objectives=2, max_sections=4, late=True),
    st.sampled_from(ENGINES),
)
def test_runs_show_what_they_say(mission: Mission, engine: Engine) -> None:
    found = compose(mission)
    try:
        direct(found.net, max_states=600)
    except (LimitError, ConfluenceError) as error:
        returns_early(type(error).__name__)
        return
    asked, play = Asked(found, engine), Play(found)

    def replayed(run: Run) -> list[str]:
        names = events(run)
        play.after(play.initial, names)  # each event is possible where it happens
        return names

    def shown(name: str | None, last: str | None) -> None:
        for names in asked.cut_sets(name, Moment.SOMETIME):
            run = asked.prospects.to_failure(asked.goal(name), names)
            assert run is not None
            told = replayed(run)
            assert {e for e in told if e.endswith("_EV_OOS")} == {f"{h}_EV_OOS" for h in names}
            assert not any(e.endswith("_EV_RD") for e in told)
            if last is not None:
                assert told[-1] == last
            else:
                assert not play.mission_survives(play.after(play.initial, told), frozenset(names))

    shown(None, None)
    for name in asked.prospects.objectives:
        shown(name, f"OBJ_{name}_EV_FAIL")
    success = play.marks("MISSION_success")
    robust = asked.prospects.most_failures(asked.prospects.mission)
    # The most failures before success, by plain search.
    ends = [m for m in play.forced(stop=success) if success(m)]
    if robust is None:
        assert not ends
    else:
        assert success(play.after(play.initial, replayed(robust)))
        failures = [e for e in events(robust) if e.endswith("_EV_OOS")]
        assert len(failures) == max(len(play.out(m)) for m in ends)
    willing = gives_up_to_succeed(play)
    event(f"an objective that could succeed fails, and the mission succeeds: {willing}")
    for survival in asked.all.survival:
        # From the start or the entry of a section: what may be lost there at most may also fail on the way,
        # but where it is survived only since an objective fails that could succeed, which no run shows.
        run = survival.run
        assert (run is None) == (survival.at_most is None)
        if run is not None and survival.at_most is not None:
            end = play.after(play.initial, replayed(run))
            assert success(end)
            assert willing or len(play.out(end)) >= survival.at_most
    start = asked.all.survival[0]
    survived = [d for d in play.subsets() if play.mission_survives(dead_from_the_start(play, d), d)]
    assert start.at_most == max(map(len, survived), default=None)
    sizes = range(len(play.hardware) + 1)
    safe = [k for k in sizes if all(d in survived for d in play.subsets() if len(d) <= k)]
    assert start.always == max(safe, default=None)


def gives_up_to_succeed(play: Play) -> bool:
    """Whether an objective may fail that could succeed, and the mission succeed after that."""
    success, all_hardware = play.marks("MISSION_success"), frozenset(play.hardware)
    before = dict[Marking, list[Marking]]()
    reached = play.reach([play.initial])
    for m in reached:
        for _, after in play.edges(m):
            before.setdefault(after, []).append(m)
    stack = [m for m in reached if success(m)]
    hopeful = set(stack)
    while stack:
        new = {*before.get(stack.pop(), ())} - hopeful
        hopeful |= new
        stack.extend(new)
    return any(
        after in hopeful and play.objective_survives(m, event_[4:].rpartition("_EV_")[0], all_hardware)
        for m in reached
        for event_, after in play.edges(m)
        if event_.startswith("OBJ_") and event_.endswith(("_EV_FAIL", "_EV_TIMEOUT"))
    )


def dead_from_the_start(play: Play, dead: frozenset[str]) -> Marking:
    return play.after(play.initial, [f"{h}_EV_OOS" for h in sorted(dead)])
