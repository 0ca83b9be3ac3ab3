"""Verdicts by composition are those of the whole mission, and so are their runs."""

from __future__ import annotations

import pytest
from hypothesis import event, given, reject

from mcpn.answers.verdicts.mission import MissionCheck, Verdict, check
from mcpn.answers.verdicts.modes import Mode
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError
from mcpn.mission.model import Block, Mission, Objective, Parallel
from mcpn.nets.petri import Marking
from mcpn.testing import missions
from tests.logic.test_properties import play
from tests.small import activity, hw, mission, robot


def events(verdict: Verdict) -> list[str]:
    """The events of a verdict's one run."""
    (run,) = verdict.runs
    return [str(event) for event in run.events]


def modes_of(checked: MissionCheck) -> dict[str, set[tuple[tuple[str, str], ...]]]:
    """Functioning modes by objective, in no order; an objective never entered has none."""

    def as_pairs(mode: Mode) -> tuple[tuple[str, str], ...]:
        return tuple(sorted(mode.items()))

    return {name: set(map(as_pairs, modes)) for name, modes in checked.modes.items() if modes}


def check_run(whole: Verdict, local: Verdict, mission_net: MissionNet) -> None:
    """A run that the rule of the whole net can follow to the same end, and no shorter than the shortest."""
    assert len(local.runs) == len(whole.runs)
    if not whole.runs:
        return
    found = events(local)
    assert len(found) >= len(events(whole))
    marking = play(mission_net, found)
    if local.name == "success_reachable":
        assert marking[mission_net.success]
    elif local.name == "failure_reachable":
        assert marking[mission_net.failure]
    elif local.name == "deadlock_free":
        assert is_dead(mission_net, marking)


def is_dead(mission_net: MissionNet, marking: Marking) -> bool:
    ended = marking[mission_net.success] or marking[mission_net.failure]
    return not ended and not list(mission_net.net.enabled(marking))


def check_equal(mission_net: MissionNet, whole: MissionCheck, local: MissionCheck) -> None:
    holds = {name: verdict.holds for name, verdict in whole.verdicts.items()}
    assert {name: verdict.holds for name, verdict in local.verdicts.items()} == holds
    assert local.stable_sizes == whole.stable_sizes
    assert sorted(map(str, local.unselectable)) == sorted(map(str, whole.unselectable))
    assert modes_of(local) == modes_of(whole)
    for name in ("success_reachable", "failure_reachable", "deadlock_free", "can_always_finish"):
        check_run(whole.verdicts[name], local.verdicts[name], mission_net)


def test_ulysse_gets_the_same_verdicts_by_composition(ulysse_net: MissionNet) -> None:
    check_equal(ulysse_net, check(ulysse_net), check(ulysse_net, engine="local"))


@given(missions() | missions(late=True))
def test_verdicts_are_those_of_the_whole(mission: Mission) -> None:
    mission_net = compose(mission)
    try:
        whole = check(mission_net, max_states=5_000)
    except LimitError:
        reject()
    local = check(mission_net, engine="local")
    if not whole.verdicts["confluent"].holds:
        event("not confluent")
        assert mission_net.usage.contentions
        refused = local.verdicts["confluent"]
        assert refused.holds is False
        assert len(set(refused.runs)) == len(refused.runs) > 0
        for run in refused.runs:  # up to the event after which internal firings part, the whole net follows
            play(mission_net, list(map(str, run.events)))
        return
    event(f"always ends: {whole.verdicts['can_always_finish'].holds}")
    check_equal(mission_net, whole, local)


def objective(name: str, activity: str, failure: str | None = None) -> Objective:
    return Objective(name=name, activities=(activity,), failure=failure)


UNREACHED = (objective("a", "use", "a"), objective("b", "free", "b"))
LOOPS = (objective("a", "use"), objective("b", "free", "a"), objective("c", "use", "b"))
NESTED = (
    Parallel(name="p", blocks=(objective("a", "use"), objective("b", "free")), failure="c"),
    objective("c", "use", "p"),
)


@pytest.mark.parametrize("blocks", [UNREACHED, LOOPS, NESTED], ids=["retry", "loops", "nested"])
@pytest.mark.parametrize("faulty", [True, False])
def test_runs_through_several_sections(blocks: tuple[Block, ...], faulty: bool) -> None:
    hardware = (*hw("H", faulty=faulty), *hw("unused"))
    of = robot(hardware, activity("use", ("H",)), activity("free", ()))
    mission_net = compose(mission(of, *blocks))
    whole, local = check(mission_net), check(mission_net, engine="local")
    assert len(events(local.verdicts["success_reachable"])) > 2  # the start, then each section
    check_equal(mission_net, whole, local)


def test_a_mission_that_never_ends_is_lost_before_any_event() -> None:
    forever = Objective(name="a", activities=("use",), success="a", failure="a")
    mission_net = compose(mission(robot(hw("H"), activity("use", ("H",))), forever))
    local = check(mission_net, engine="local")
    assert [run.events for run in local.verdicts["can_always_finish"].runs] == [[]]
    check_equal(mission_net, check(mission_net), local)
