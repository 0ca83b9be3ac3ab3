"""The FMECA table: what Ulysse's text says, and severities by plain search on the net."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.check.causes.effects import Severity
from mcpn.check.causes.fmeca import Row, fmeca
from mcpn.check.spaces import Engine
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.flatten import ElementarySection
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.net.compose import MissionNet, compose
from mcpn.net.petri import Marking
from mcpn.space.stable.alternatives import direct
from tests.check.asked import ENGINES, Asked
from tests.check.oracle import Play, fragile_missions, minimal
from tests.draws import fewer
from tests.shares import returns_early


@pytest.fixture(scope="module", params=ENGINES)
def ulysse_rows(ulysse_net: MissionNet, request: pytest.FixtureRequest) -> dict[tuple[str, str], Row]:
    rows = fmeca(Asked(ulysse_net, request.param).prospects)
    return {(row.hardware, row.objective): row for row in rows}


def test_every_resource_of_ulysse_has_a_row_for_every_objective(
    ulysse_net: MissionNet, ulysse_rows: dict[tuple[str, str], Row]
) -> None:
    assert list(ulysse_rows) == [
        (h.name, s.name) for h in ulysse_net.mission.hardware for s in ulysse_net.graph.walk()
    ]


def test_the_gps_is_replaced_by_the_imu(ulysse_rows: dict[tuple[str, str], Row]) -> None:
    row = ulysse_rows["GPS_sensor", "transect.advancing"]
    assert row.section == "transect.census"
    assert row.local_effect == "localisation: gps_localisation -> imu_localisation"
    assert row.compensation == "imu_localisation instead"
    assert row.detection == "at once, by the error to gps_driver"
    # The paper, 6.2: there is no switch back before the activity is stopped.
    assert row.recovery == "at the next start of the activity"
    assert row.severity is Severity.DEGRADED
    assert row.with_others == ((Severity.MISSION_LOST_UNLESS_REPAIRED, (("IMU_sensor",),)),)


def test_a_spare_matters_where_it_runs_and_in_company(ulysse_rows: dict[tuple[str, str], Row]) -> None:
    # After a repair of the GPS localisation still runs by the IMU, with all other hardware in service.
    row = ulysse_rows["IMU_sensor", "transect.diving"]
    assert (row.severity, row.worst) == (Severity.DEGRADED, Severity.MISSION_LOST_UNLESS_REPAIRED)
    assert row.local_effect == "localisation: imu_localisation -> gps_localisation"
    row = ulysse_rows["IMU_sensor", "transect.filming"]
    assert (row.severity, row.worst) == (Severity.NO_EFFECT, Severity.MISSION_LOST_UNLESS_REPAIRED)
    assert row.local_effect == "none"
    assert row.detection == "by its event alone: not in use here"


def test_the_thruster_ends_the_mission(ulysse_rows: dict[tuple[str, str], Row]) -> None:
    row = ulysse_rows["thruster_actuator", "transect.going_up"]
    assert row.local_effect == "go_surface has no possible alternative"
    assert row.compensation == "its failure ends the mission in failure"
    assert row.severity is Severity.MISSION_LOST
    row = ulysse_rows["thruster_actuator", "transect.diving"]
    assert row.compensation == "its failure leads to transect.going_up"
    assert row.recovery == "none before the objective has failed, then the mission can succeed"
    assert row.severity is Severity.MISSION_LOST_UNLESS_REPAIRED
    assert ulysse_rows["thruster_actuator", "transect.advancing"].compensation == (
        "its failure fails transect.census"
    )
    row = ulysse_rows["thruster_actuator", "transect.filming"]
    assert row.local_effect == (
        "none here; in transect.advancing, advancing has no possible alternative; needed later"
    )
    assert (row.objective_effect, row.compensation) == ("none", "none")
    assert row.recovery == "the mission can succeed again"
    assert row.severity is Severity.MISSION_LOST_UNLESS_REPAIRED


RETRIED = """<mission name="sprayer" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <hardware name="wheels"/><hardware name="coupling"/><hardware name="pump"/><hardware name="camera"/>
    <software name="image"/>
    <activity name="camera_driver" produces="image" consumes="camera"/>
    <activity name="drive" consumes="wheels"/>
    <activity name="fill" consumes="coupling"/>
    <activity name="look"><alternative name="by_eye" consumes="image"/><alternative name="blind"/></activity>
    <activity name="spray"><alternative name="aimed" consumes="image pump"/></activity>
  </robot>
  <objective name="refill" activities="fill" retries="1" failure="go_home"/>
  <parallel name="treat" failure="go_home">
    <objective name="watching" activities="look"/>
    <objective name="spraying" activities="spray"/>
  </parallel>
  <objective name="go_home" activities="drive" retries="1"/>
</mission>
"""


@pytest.fixture(scope="module", params=ENGINES)
def retried(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> dict[tuple[str, str], Row]:
    path = tmp_path_factory.mktemp("retried") / "mission.xml"
    path.write_text(RETRIED)
    rows = fmeca(Asked(compose(read_mission(path)), request.param).prospects)
    return {(row.hardware, row.objective): row for row in rows}


def test_a_retry_may_run_with_all_hardware_in_service(retried: dict[tuple[str, str], Row]) -> None:
    for name in ("refill_try1", "refill_try2", "watching", "go_home_try1", "go_home_try2"):
        row = retried["wheels", name]
        worst = Severity.MISSION_LOST if name == "go_home_try2" else Severity.MISSION_LOST_UNLESS_REPAIRED
        assert (row.severity, row.with_others) == (worst, ()), name
    assert retried["coupling", "refill_try2"].severity is Severity.OBJECTIVE_LOST
    assert retried["coupling", "refill_try2"].compensation == "its failure leads to go_home_try1"


def test_no_pair_is_missing(retried: dict[tuple[str, str], Row]) -> None:
    objectives = ["refill_try1", "refill_try2", "watching", "spraying"]
    objectives += ["go_home_try1", "go_home_try2"]
    hardware = ["wheels", "coupling", "pump", "camera"]
    assert list(retried) == [(h, o) for h in hardware for o in objectives]
    assert retried["camera", "go_home_try1"].severity is Severity.NO_EFFECT


def test_what_happens_in_another_branch_is_no_effect_on_this_one(
    retried: dict[tuple[str, str], Row],
) -> None:
    row = retried["pump", "watching"]
    assert (row.severity, row.local_effect, row.compensation) == (Severity.NO_EFFECT, "none", "none needed")
    row = retried["wheels", "watching"]
    assert row.local_effect == "none here; needed later"


def used_by(found: MissionNet, marking: Marking, activities: Iterable[str]) -> frozenset[tuple[str, str]]:
    """What activities and those that serve them do: alternatives that run or are awaited, and refusals."""
    producers = {r: a.name for a in found.mission.activities for r in a.produces}
    consumed = {
        f"{a.name}.{way.name}": way.consumes for a in found.mission.activities for way in a.alternatives
    }
    said = [role for place, role in found.roles.items() if marking[place]]
    using, stack = set[tuple[str, str]](), list(activities)
    seen = set(stack)
    while stack:
        activity = stack.pop()
        for kind, name in said:
            if kind == "refused" and name == activity:
                using.add((kind, name))
            elif kind in ("active", "wait") and name.split(".", 1)[0] == activity:
                using.add((kind, name))
                serving = {producers[r] for r in consumed[name] if r in producers} - seen
                seen |= serving
                stack.extend(serving)
    return frozenset(using)


def severities(found: MissionNet) -> dict[tuple[str, str], dict[Severity, set[frozenset[str]]]]:
    """By hardware and objective, what its failure does, each with the other hardware out of service."""
    play = Play(found)
    dead = frozenset(play.hardware)

    @cache
    def mission_survives(marking: Marking, lost: frozenset[str]) -> bool:
        return play.mission_survives(marking, lost)

    def severity(before: Marking, after: Marking, section: ElementarySection) -> Severity:
        def crosses(survives: Callable[[Marking], bool]) -> bool:
            return survives(before) and not survives(after)

        if crosses(lambda m: mission_survives(m, frozenset())):
            return Severity.MISSION_LOST
        if crosses(lambda m: mission_survives(m, dead)):
            return Severity.MISSION_LOST_UNLESS_REPAIRED
        if crosses(lambda m: play.objective_survives(m, section.name, dead)):
            return Severity.OBJECTIVE_LOST
        changed = used_by(found, before, section.activities) != used_by(found, after, section.activities)
        return Severity.DEGRADED if changed else Severity.NO_EFFECT

    expected: dict[tuple[str, str], dict[Severity, set[frozenset[str]]]] = {}
    every = play.reach([play.initial])
    for section in found.graph.walk():
        runs = play.marks(f"OBJ_{section.name}")
        for before in every:
            for event, after in play.edges(before) if runs(before) else ():
                if event.endswith("_EV_OOS"):
                    key = event.removesuffix("_EV_OOS"), section.name
                    costs = severity(before, after, section)
                    expected.setdefault(key, {}).setdefault(costs, set()).add(play.out(before))
    return expected


@fewer(0.3)
@given(
    fragile_missions(max_hardware=3, max_objectives=2, max_sections=5)
    | fragile_missions(max_hardware=3, max_objectives=2, max_sections=5, events=2),
    st.sampled_from(ENGINES),
)
def test_severities_are_those_of_plain_search(mission: Mission, engine: Engine) -> None:
    found = compose(mission)
    try:
        direct(found.net, max_states=500)
        rows = fmeca(Asked(found, engine).prospects)
    except (LimitError, ConfluenceError) as error:
        returns_early(type(error).__name__)
        return
    expected = severities(found)
    assert {(row.hardware, row.objective) for row in rows} == set(expected)
    for row in rows:
        costs = expected[row.hardware, row.objective]
        alone = max(severity for severity, sets in costs.items() if frozenset() in sets)
        worse = {severity: minimal(sets) for severity, sets in costs.items() if severity > alone}
        assert row.severity == alone
        assert {severity: list(sets) for severity, sets in row.with_others} == worse
