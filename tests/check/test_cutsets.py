"""Losing regions and minimal cut sets against brute force over all subsets, by plain search on the net."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings

from mcpn.check.cutsets import CutSet, Losses, Moment
from mcpn.check.logic.evaluate import Evaluation
from mcpn.check.logic.language import parse
from mcpn.check.logic.resolve import resolve
from mcpn.check.losing import Outlook
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.flatten import ElementarySection
from mcpn.mission.model import Activity, Alternative, Hardware, Mission, Objective, Robot
from mcpn.net.compose import MissionNet, compose
from mcpn.space.alternatives import direct
from mcpn.space.diagrams import DiagramMarkings
from mcpn.space.graph import StateGraph
from mcpn.space.symbolic import reach
from mcpn.testing import missions
from tests.check.oracle import Play, fragile_missions, minimal
from tests.shares import returns_early

NAVIGATION: list[CutSet] = [("thruster_actuator",), ("GPS_sensor", "IMU_sensor")]
ULYSSE: dict[str, list[CutSet]] = {
    # From the text of the paper, section 8: what consumes location and thruster needs the thruster and one of
    # the two sensors of the localisation; filming and temperature consume nothing.
    "coral_head.manual_moving": NAVIGATION,
    "coral_head.isopheric_observation": NAVIGATION,
    "transect.diving": NAVIGATION,
    "transect.filming": [],
    "transect.advancing": NAVIGATION,
    "transect.measuring_temperature": [],
    "transect.going_up": NAVIGATION,
}


@pytest.fixture(scope="module")
def ulysse_losses(ulysse_net: MissionNet) -> Losses:
    return Losses(Outlook(ulysse_net, direct(ulysse_net.net)))


def test_ulysse_cut_sets(ulysse_losses: Losses) -> None:
    losses, outlook = ulysse_losses, ulysse_losses.outlook
    for name, goal in outlook.objectives.items():
        assert losses.listed(losses.cut_sets(goal, Moment.ENTRY, name)) == ULYSSE[name]
        assert losses.listed(losses.cut_sets(goal, Moment.WHENEVER)) == ULYSSE[name]
        assert losses.listed(losses.cut_sets(goal, Moment.SOMETIME)) == ULYSSE[name]
    for moment in (Moment.START, Moment.WHENEVER, Moment.SOMETIME):
        assert losses.listed(losses.cut_sets(outlook.mission, moment)) == NAVIGATION
    # Without navigation diving fails, so that the census is never entered.
    filming = outlook.objectives["transect.filming"]
    assert losses.listed(losses.cut_sets(filming, Moment.START)) == NAVIGATION


def test_ulysse_cut_sets_by_brute_force(ulysse_net: MissionNet, ulysse_losses: Losses) -> None:
    confirm(ulysse_net, ulysse_losses)


def test_regions_on_markings_and_on_stable_markings_agree(
    ulysse_net: MissionNet, ulysse_markings: StateGraph, ulysse_losses: Losses
) -> None:
    alternatives, markings = ulysse_losses.outlook, Outlook(ulysse_net, ulysse_markings)
    rows = {row.tobytes(): s for s, row in enumerate(ulysse_markings.markings)}
    stable = np.array([rows[row.tobytes()] for row in alternatives.graph.markings])
    pairs = [(alternatives.mission, markings.mission)]
    pairs += [(goal, markings.objectives[name]) for name, goal in alternatives.objectives.items()]
    for on_stable, on_all in pairs:
        for repairs in (True, False):
            one, other = alternatives.losing(on_stable, repairs), markings.losing(on_all, repairs)
            assert np.array_equal(one, other[stable])


def confirm(found: MissionNet, losses: Losses) -> None:
    """Every cut set at every moment is that of brute force over all subsets of hardware."""
    play, outlook = Play(found), losses.outlook
    everything = play.reach([play.initial])
    begin = play.marks("MISSION_begin")
    forced = play.forced()
    success = play.marks("MISSION_success")
    subsets = play.subsets()

    def check(computed: list[CutSet], lost: list[frozenset[str]]) -> None:
        assert computed == minimal(lost)

    mission = outlook.mission
    at_start = {d: play.after(play.initial, [f"{h}_EV_OOS" for h in sorted(d)]) for d in subsets}
    check(
        losses.listed(losses.cut_sets(mission, Moment.START)),
        [d for d in subsets if not play.mission_survives(at_start[d], d)],
    )
    check(
        losses.listed(losses.cut_sets(mission, Moment.WHENEVER)),
        [
            d
            for d in subsets
            if not any(
                d <= play.out(m) and play.mission_survives(m, d)
                for m in everything
                if not begin(m) and not success(m)
            )
        ],
    )
    check(
        losses.listed(losses.cut_sets(mission, Moment.SOMETIME)),
        [
            d
            for d in subsets
            if any(
                d == play.out(m) and not play.mission_survives(m, d)
                for m in forced
                if not begin(m) and not success(m)
            )
        ],
    )
    for section in found.graph.walk():
        name, goal = section.name, outlook.objectives[section.name]
        runs = play.marks(f"OBJ_{name}")
        running = [m for m in everything if runs(m)]
        check(
            losses.listed(losses.cut_sets(goal, Moment.WHENEVER)),
            [
                d
                for d in subsets
                if not any(d <= play.out(m) and play.objective_survives(m, name, d) for m in running)
            ],
        )
        check(
            losses.listed(losses.cut_sets(goal, Moment.SOMETIME)),
            [
                d
                for d in subsets
                if any(
                    d == play.out(m) and not play.objective_survives(m, name, d) for m in forced if runs(m)
                )
            ],
        )
        check(
            losses.listed(losses.cut_sets(goal, Moment.START)),
            [d for d in subsets if not play.ever_succeeds(at_start[d], name, d)],
        )
        entered = {
            m
            for before in everything
            for event, m in play.edges(before)
            if runs(m) and (not runs(before) or event in (f"OBJ_{name}_EV_OK", f"OBJ_{name}_EV_FAIL"))
        }
        if entered and isinstance(section, ElementarySection) and not pending(found, name):
            events = {str(t.event) for t in found.net.transitions if t.event is not None}
            others = [event for event in events if not event.endswith("_EV_OOS")]
            dying = play.reach(
                entered,
                others,
            )
            check(
                losses.listed(losses.cut_sets(goal, Moment.ENTRY, name)),
                [
                    d
                    for d in subsets
                    if not any(d <= play.out(m) and play.objective_survives(m, name, d) for m in dying)
                ],
            )
            check(
                losses.listed(losses.cut_sets(mission, Moment.ENTRY, name)),
                [
                    d
                    for d in subsets
                    if not any(d <= play.out(m) and play.mission_survives(m, d) for m in dying)
                ],
            )


def pending(found: MissionNet, name: str) -> bool:
    return ("pending", name) in found.by_role


@settings(max_examples=100)
@given(
    missions(max_objectives=2, max_sections=5, max_hardware=3, max_producers=2)
    | fragile_missions(max_objectives=2, max_sections=5, max_hardware=3)
)
def test_cut_sets_are_those_of_brute_force(mission: Mission) -> None:
    found = compose(mission)
    try:
        graph = direct(found.net, max_states=400)
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    confirm(found, Losses(Outlook(found, graph)))


@settings(max_examples=100)
@given(fragile_missions(max_hardware=4, max_alternatives=2))
def test_a_cut_set_makes_success_unreachable_and_no_proper_subset_does(mission: Mission) -> None:
    found = compose(mission)
    try:
        graph = direct(found.net, max_states=2000)
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    losses = Losses(Outlook(found, graph))
    for names in losses.listed(losses.cut_sets(losses.outlook.mission, Moment.START)):
        assert not success_reachable(found, names)
        for back in names:
            assert success_reachable(found, [h for h in names if h != back])


def success_reachable(found: MissionNet, dead: Collection[str]) -> bool:
    """CTL on the net, with some hardware out of service from the initial marking on and never repaired."""
    net = found.net
    tokens = {f"{h}_{place}": int(place == "OOS") for h in dead for place in ("free", "available", "OOS")}
    places = [replace(p, initial=tokens.get(p.name, p.initial)) for p in net.places]
    repairs = [f"{h}_EV_RD" for h in dead]
    kept = [t for t in net.transitions if str(t.event) not in repairs]
    crippled = replace(net, places=tuple(places), transitions=tuple(kept))
    formula = resolve(parse("EF success"), crippled, found)
    return Evaluation(DiagramMarkings(reach(crippled))).holds(formula)


def test_ulysse_cut_sets_by_ctl_on_the_net(ulysse_net: MissionNet) -> None:
    for size in range(4):
        for dead in combinations(("GPS_sensor", "IMU_sensor", "thruster_actuator"), size):
            lost = any(set(names) <= set(dead) for names in NAVIGATION)
            assert success_reachable(ulysse_net, dead) is not lost


def test_hardware_that_cannot_always_fail_is_reported(ulysse_net: MissionNet) -> None:
    graph = direct(ulysse_net.net)
    outlook = Outlook(ulysse_net, graph)
    assert all(Losses(outlook).nonmonotone(goal) is None for goal in outlook.objectives.values())
    # A robot whose GPS never fails once the thruster has, nor the thruster once the GPS has.
    gps, thruster = outlook.index["GPS_sensor"], outlook.index["thruster_actuator"]
    out = outlook.out[graph.sources]
    spared = (outlook.failing == gps) & out[:, thruster] | (outlook.failing == thruster) & out[:, gps]
    offsets = np.concatenate(([0], np.cumsum(np.bincount(graph.sources[~spared], minlength=graph.states))))
    fewer = replace(graph, offsets=offsets, targets=graph.targets[~spared], labels=graph.labels[~spared])
    losses = Losses(Outlook(ulysse_net, fewer))
    found = losses.nonmonotone(losses.outlook.objectives["transect.diving"])
    assert found is not None
    assert found.lost == ("thruster_actuator",)
    assert found.larger == ("GPS_sensor", "thruster_actuator")


def test_a_retry_is_another_run() -> None:
    use = Activity(name="use", alternatives=(Alternative(name="use", consumes=("H",)),))
    robot = Robot(name="r", hardware=(Hardware(name="H"),), activities=(use,))
    again = Objective(name="x", activities=("use",), failure="x")
    found = compose(Mission(name="m", robots=(robot,), blocks=(again,)))
    outlook = Outlook(found, direct(found.net))
    (goal,) = outlook.objectives.values()
    # Once refused, the present run is lost whatever is repaired; the mission is not, for x is tried again.
    lost = outlook.losing(goal, repairs=True)
    assert lost.any()
    play = Play(found)
    assert {outlook.graph.marking(s) for s in np.flatnonzero(lost).tolist()} == {
        m
        for m in play.reach([play.initial])
        if play.marks("OBJ_x")(m) and not play.objective_survives(m, "x", frozenset())
    }
    assert not outlook.losing(outlook.mission, repairs=True).any()
