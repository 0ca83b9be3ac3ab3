"""The FMECA table: what Ulysse's text says, and severities by plain search on the net."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.check.causes.fmeca import Row, Severity, fmeca
from mcpn.check.spaces import Engine
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.net.compose import MissionNet, compose
from mcpn.net.petri import Marking
from mcpn.space.stable.alternatives import direct
from tests.check.asked import ENGINES, Asked
from tests.check.oracle import Play, fragile_missions
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


def test_a_spare_in_reserve_makes_a_difference_in_company_only(
    ulysse_rows: dict[tuple[str, str], Row],
) -> None:
    row = ulysse_rows["IMU_sensor", "transect.diving"]
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
    play = Play(found)
    dead = frozenset(play.hardware)
    modes = [
        found.net.place_index[p.name] for i, p in enumerate(found.net.places) if i in found.saying("active")
    ]

    def severity(before: Marking, after: Marking, name: str) -> Severity:
        def crosses(survives: list[bool]) -> bool:
            return survives[0] and not survives[1]

        ends = (before, after)
        if crosses([play.mission_survives(m, frozenset()) for m in ends]):
            return Severity.MISSION_LOST
        if crosses([play.mission_survives(m, dead) for m in ends]):
            return Severity.MISSION_LOST_UNLESS_REPAIRED
        if crosses([play.objective_survives(m, name, dead) for m in ends]):
            return Severity.OBJECTIVE_LOST
        changed = any(before[p] != after[p] for p in modes)
        return Severity.DEGRADED if changed else Severity.NO_EFFECT

    expected: dict[tuple[str, str], dict[Severity, set[frozenset[str]]]] = {}
    forced = play.forced()
    for section in found.graph.walk():
        runs = play.marks(f"OBJ_{section.name}")
        for before in forced:
            for event, after in play.edges(before) if runs(before) else ():
                if event.endswith("_EV_OOS"):
                    costs = severity(before, after, section.name)
                    key = event.removesuffix("_EV_OOS"), section.name
                    expected.setdefault(key, {}).setdefault(costs, set()).add(play.out(before))
    told = {(row.hardware, row.objective): row for row in rows}
    for key, costs_by in expected.items():
        serious = {c for c in costs_by if c > Severity.DEGRADED}
        if key not in told:
            assert not serious
            continue
        row = told[key]
        alone = [c for c, sets in costs_by.items() if frozenset() in sets]
        assert max(row.severity, Severity.DEGRADED) == max([*alone, Severity.DEGRADED])
        for severity_told, sets in row.with_others:
            if severity_told > Severity.DEGRADED:
                known = costs_by[severity_told]
                assert {frozenset(s) for s in sets} == {s for s in known if not any(t < s for t in known)}
        assert {s for s, _ in row.with_others} >= {c for c in serious if c > row.severity}
