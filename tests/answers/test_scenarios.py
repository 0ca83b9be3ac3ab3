"""Runs to failure and robust runs, replayed on the net and compared with plain search."""

from __future__ import annotations

import tracemalloc
from random import Random

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.causes.find import find_causes
from mcpn.answers.causes.minimal_cut_sets import Moment
from mcpn.answers.causes.prospects import Striking
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, LimitError
from mcpn.events import What
from mcpn.mission.model import Mission, Objective, Parallel
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import Marking
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.run import Completion, Run
from mcpn.spaces.stable.alternatives import direct
from tests.conftest import ROOT
from tests.draws import fewer
from tests.logic.asked import ENGINES, Asked
from tests.logic.oracle import Play, fragile_missions
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot


def events(run: Run) -> list[str]:
    return [str(event) for event in run.events]


@pytest.mark.parametrize("engine", ENGINES)
def test_ulysse_runs_to_failure(ulysse_net: MissionNet, engine: Engine) -> None:
    asked = Asked(ulysse_net, engine)
    run = asked.prospects.to_failure(asked.goal("transect.going_up"), ["thruster_actuator"])
    assert run is not None
    # The way through the failures of moving and of diving is the shortest, and the lost thruster forces both.
    assert events(run) == [
        "MISSION_EV_START",
        "thruster_actuator_EV_OOS",
        "OBJ_coral_head.manual_moving_EV_FAIL",
        "OBJ_transect.diving_EV_FAIL",
        "OBJ_transect.going_up_EV_FAIL",
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


@pytest.mark.parametrize(
    "engine", [e if e == "local" else pytest.param(e, marks=pytest.mark.slow) for e in ENGINES]
)
def test_the_glider_is_defeated_by_its_losses_and_by_no_leak(engine: Engine) -> None:
    """A leak aborts the mission by itself: a run to failure that it is on would explain no loss."""
    causes = find_causes(
        compose(read_mission(ROOT / "experiments" / "glider" / "mission.xml")), engine=engine
    )
    lone = ("compass", "buoyancy_pump", "depth_gauge", "rudder", "satellite_radio")
    assert set(causes.mission.runs) == {(name,) for name in lone}
    for (name,), run in causes.mission.runs.items():
        assert run is not None
        told = events(run)
        assert told.count(f"{name}_EV_OOS") == 1
        assert "leak" not in told
        assert f"{name}_EV_OOS" != told[-1] or name == "satellite_radio"  # its call is tried without end


@pytest.mark.parametrize("engine", ENGINES)
def test_a_loss_after_the_end_is_on_no_run_to_failure(engine: Engine) -> None:
    """Hardware that no section uses any more fails beside it, in the composite too."""
    last = Parallel(name="last", success_when="1", blocks=(Objective(name="y", activities=("work",)),))
    of = mission(
        robot(hw("h"), activity("work", ("h",))),
        Objective(name="x", activities=("work",), success="fail", failure="last"),
        last,
    )
    run = find_causes(compose(of), engine=engine).mission.runs["h",]
    assert run is not None
    assert events(run)[-1] == "OBJ_y_EV_FAIL"


@pytest.mark.parametrize("engine", ENGINES)
def test_losses_come_where_they_strike(engine: Engine) -> None:
    """The drone starts without its lidar; that is missed as it first flies, which a reader sees there."""
    drone = compose(read_mission(ROOT / "experiments" / "drone" / "mission.xml"))
    run = find_causes(drone, engine=engine).mission.runs["lidar",]
    assert run is not None
    told = events(run)
    lost = told.index("lidar_EV_OOS")
    assert told[:2] == ["MISSION_EV_START", "OBJ_start_EV_OK"]
    assert lost >= 2
    assert told[lost + 1] in ("OBJ_stock_A1.approach_try1_EV_FAIL", "OBJ_stock_A1.follow_EV_FAIL")


@pytest.mark.parametrize("engine", ENGINES)
def test_a_loss_that_changes_nothing_comes_after_the_start(engine: Engine) -> None:
    """Nobody uses the radio before the last objective, which is tried again for ever."""
    of = mission(
        robot(hw("radio"), activity("swim", ()), activity("call", ("radio",))),
        Objective(name="dive", activities=("swim",)),
        Objective(name="report", activities=("call",), failure="report"),
    )
    run = find_causes(compose(of), engine=engine).mission.runs["radio",]
    assert run is not None
    assert events(run) == ["MISSION_EV_START", "radio_EV_OOS"]


@fewer(0.5)
@given(
    fragile_missions(max_hardware=3, max_objectives=2, max_sections=4)
    | fragile_missions(max_hardware=3, max_objectives=2, max_sections=4, late=True),
    st.randoms(use_true_random=False),
)
def test_losses_that_are_put_off_change_nothing_else(mission: Mission, random: Random) -> None:
    """Walks at random: the other events keep their order, and the same marking follows."""
    found = compose(mission)
    net, play, fired = found.net, Play(found), list[int]()
    completion, here = Completion(net), net.initial
    for _ in range(8):
        carrying = (
            t for t, each in enumerate(net.transitions) if each.event and each.event.what is not What.REPAIRED
        )
        enabled = [t for t in carrying if net.covers(here, t)]
        if not enabled or any(here[place] for place in found.ends.values()):
            break
        fired.append(random.choice(enabled))
        _, here = completion.after(here, fired[-1])
    walked = Run(net, tuple(fired), settles=True)
    taken, put_off = events(walked), events(Striking(found).on(walked))
    event(f"a loss is put off: {put_off != taken}")
    assert play.after(play.initial, put_off) == play.after(play.initial, taken)

    def others(told: list[str]) -> list[str]:
        return [happens for happens in told if not happens.endswith("_EV_OOS")]

    assert others(put_off) == others(taken)
    assert sorted(put_off) == sorted(taken)


@fewer(0.4, least=6)
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
    declared = {each.name for each in mission.events}
    success = play.marks("MISSION_success")

    def ended(marking: Marking) -> bool:
        return any(play.marks(f"MISSION_{end}")(marking) for end in found.ends)

    def needed(happens: str) -> bool:
        return not (happens.endswith("_EV_TIMEOUT") or happens in declared)

    def defeated(names: tuple[str, ...]) -> bool:
        """Whether these losses end the mission otherwise than in success, by forced failures and no event."""
        stack, seen = [play.initial], {play.initial}
        while stack:
            before = stack.pop()
            if ended(before):
                if play.out(before) == set(names) and not success(before):
                    return True
                continue
            for happens, after in play.edges(before):
                lost, fails = happens.removesuffix("_EV_OOS"), happens.endswith("_EV_FAIL")
                one = happens.removeprefix("OBJ_").removesuffix("_EV_FAIL")
                if (
                    after in seen
                    or not needed(happens)
                    or happens.endswith("_EV_RD")
                    or (lost != happens and lost not in names)
                    or (fails and play.objective_survives(before, one, frozenset(play.hardware)))
                ):
                    continue
                seen.add(after)
                stack.append(after)
        return False

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
                losses = (before for before, happens, _ in play.walked(told) if happens.endswith("_EV_OOS"))
                assert not any(ended(before) for before in losses), (
                    "lost after the end, which defeats nothing"
                )
                helped = any(not needed(happens) for happens in told)
                event(f"a run to failure needs an event or a timeout: {helped}")
                assert not (helped and defeated(names)), "the losses alone defeat it"

    shown(None, None)
    for name in asked.prospects.objectives:
        shown(name, f"OBJ_{name}_EV_FAIL")
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


@pytest.mark.parametrize("engine", ENGINES)
def test_a_run_to_where_nothing_can_succeed_any_more_has_begun(engine: Engine) -> None:
    """The mission goes on in y for ever. Without h it is lost, but it has not failed before it begins."""
    of = robot(hw("h"), activity("a", ("h",)), activity("b", ()))
    found = mission(
        of,
        Objective(name="x", activities=("a",), success="succeed", failure="y"),
        Objective(name="y", activities=("b",), success="y", failure="y"),
    )
    asked = Asked(compose(found), engine)
    run = asked.prospects.to_failure(asked.prospects.mission, ["h"])
    assert run is not None
    assert {"MISSION_EV_START", "h_EV_OOS"} <= {*events(run)}


def test_putting_losses_off_keeps_no_marking_for_each_event() -> None:
    """Of a run through 1,000 sites these took a third of all memory, and of 3,000 nine times as much."""
    blocks = [Objective(name=f"o{i}", activities=("a",)) for i in range(300)]
    found = compose(mission(robot(hw("h"), activity("a", ())), *blocks))
    of = [found.start, *(t for t, each in enumerate(found.net.transitions) if "EV_OK" in each.name)]
    striking, walked = Striking(found), Run(found.net, tuple(of), settles=True)
    striking.on(walked)  # what is found once for the net is there
    tracemalloc.start()
    try:
        assert striking.on(walked) == walked
        assert tracemalloc.get_traced_memory()[1] < len(of) * len(found.net.places)
    finally:
        tracemalloc.stop()
