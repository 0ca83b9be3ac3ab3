"""The FMECA table: what Ulysse's text says, and severities by plain search on the net."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.check.causes.fmeca import Row, Severity, fmeca
from mcpn.check.spaces import Engine
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.flatten import ElementarySection
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.net.compose import MissionNet, compose
from mcpn.net.petri import Marking
from mcpn.space.stable.alternatives import direct
from mcpn.testing import missions
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
    assert_severities(found, rows)


def assert_severities(found: MissionNet, rows: list[Row]) -> None:
    play = Play(found)
    dead = frozenset(play.hardware)
    modes = {section.name: mode_places(found, section) for section in found.graph.walk()}

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
        changed = any(before[p] != after[p] for p in modes[name])
        return Severity.DEGRADED if changed else Severity.NO_EFFECT

    expected: dict[tuple[str, str], dict[Severity, set[frozenset[str]]]] = {}
    forced = play.forced()
    for section in found.graph.walk():
        runs = play.marks(f"OBJ_{section.name}")
        for before in forced:
            for name, after in play.edges(before) if runs(before) else ():
                if name.endswith("_EV_OOS"):
                    costs = severity(before, after, section.name)
                    key = name.removesuffix("_EV_OOS"), section.name
                    expected.setdefault(key, {}).setdefault(costs, set()).add(play.out(before))
    told = {(row.hardware, row.objective): row for row in rows}
    for key, costs_by in expected.items():
        if key not in told:
            assert set(costs_by) == {Severity.NO_EFFECT}
            continue
        row = told.pop(key)
        assert row.severity == max((c for c, sets in costs_by.items() if frozenset() in sets), default=0)
        least = {c: minimal(known) for c, known in costs_by.items() if c > row.severity}
        assert row.with_others == tuple((c, tuple(least[c])) for c in sorted(least))
        assert row.worst == max(costs_by)
    assert not told


def mode_places(found: MissionNet, section: ElementarySection) -> list[int]:
    """What tells the mode of an objective: alternatives, waits, refusals of the activities that serve it."""
    activities = {a.name: a for a in found.mission.activities}
    producers = {s: a.name for a in found.mission.activities for s in a.produces}
    serving, queue = set[str](), list(section.activities)
    while queue:
        name = queue.pop()
        if name not in serving:
            serving.add(name)
            consumed = {k for way in activities[name].alternatives for k in way.consumes}
            queue.extend(producers[k] for k in consumed if k in producers)
    kinds = {"active", "wait", "refused"}
    return [p for p, (kind, name) in found.roles.items() if kind in kinds and name.split(".")[0] in serving]


class Words:
    """What a row may say of one failure, from the markings before and after it and after the repair."""

    def __init__(self, found: MissionNet, play: Play, section: ElementarySection) -> None:
        self.found, self.play, self.section = found, play, section
        self.places = mode_places(found, section)
        self.dead = frozenset(play.hardware)

    def said(self, marking: Marking, kind: str) -> dict[str, str]:
        """Of each activity its alternative, what it waits with, or nothing of one that is refused."""
        names = [self.found.roles[p][1] for p in self.places if marking[p] and self.found.roles[p][0] == kind]
        return {name.partition(".")[0]: name.partition(".")[2] for name in names}

    def lost(self, marking: Marking) -> bool:
        return not self.play.objective_survives(marking, self.section.name, self.dead)

    def mission_lost(self, marking: Marking) -> bool:
        return not self.play.mission_survives(marking, self.dead)

    def of(self, hardware: str, before: Marking, after: Marking) -> dict[str, str]:
        """By column, for one failure."""
        back = next((m for e, m in self.play.edges(after) if e == f"{hardware}_EV_RD"), after)
        modes = [self.said(m, "active") for m in (before, after, back)]
        was, now, then = modes
        switched = {
            a: alternative for a, alternative in now.items() if was.get(a, alternative) != alternative
        }
        changes = [f"{a}: {was[a]} -> {switched[a]}" for a in was if a in switched]
        for kind, words in (("refused", "has no possible alternative"), ("wait", "waits")):
            changes += [f"{a} {words}" for a in self.said(after, kind) if a not in self.said(before, kind)]
        stopped = [f"{a} stops" for a in was if a not in now]
        ways = {(a.name, w.name): w.consumes for a in self.found.mission.activities for w in a.alternatives}
        users = [a for a in was if hardware in ways[a, was[a]]]
        told = {
            "local_effect": ", ".join(changes or stopped or ["none"]),
            "detection": f"at once, by the error to {' and '.join(users)}"
            if users
            else "by its event alone: not in use here",
        }
        if not self.play.mission_survives(after, frozenset()):
            told["mission_effect"] = "cannot succeed any more"
        elif self.mission_lost(after):
            told["mission_effect"] = "can succeed only if repaired"
        else:
            told["mission_effect"] = "can still succeed"
        if self.lost(after):
            told["objective_effect"] = "cannot succeed any more"
            told["recovery"] = "none before the objective has failed"
            if not self.lost(back):
                told["recovery"] = "the objective can succeed again"
            if self.mission_lost(after) and not self.mission_lost(back):
                told["recovery"] += ", then the mission can succeed"
            return told
        told["objective_effect"] = "none" if was == now else "goes on in another mode"
        told["compensation"] = f"{', '.join(switched[a] for a in was if a in switched)} instead"
        if not switched:
            told["compensation"] = "none needed"
        told["recovery"] = {
            (True, True): "none needed",
            (True, False): "at the next start of the activity",
            (False, True): "the former mode",
            (False, False): "another mode",
        }[then == now, then == was]
        return told


@fewer(0.25)
@given(
    # The second kind contends: activities wait for what others hold, and stop where it fails.
    fragile_missions(max_hardware=3, max_objectives=2, max_sections=4)
    | missions(max_hardware=2, max_objectives=2, max_sections=3, alternatives=2),
    st.sampled_from(ENGINES),
)
def test_words_are_those_of_plain_search(mission: Mission, engine: Engine) -> None:
    found = compose(mission)
    try:
        direct(found.net, max_states=300)
        rows = fmeca(Asked(found, engine).prospects)
    except (LimitError, ConfluenceError) as error:
        returns_early(type(error).__name__)
        return
    assert_words(found, rows)


def assert_words(found: MissionNet, rows: list[Row]) -> None:
    by_pair = {(row.hardware, row.objective): row for row in rows}
    play = Play(found)
    forced = play.forced()
    for section in found.graph.walk():
        words, runs = Words(found, play, section), play.marks(f"OBJ_{section.name}")
        for hardware in play.hardware:
            row = by_pair.get((hardware, section.name))
            if row is None:
                continue
            edges = [
                (m, after)
                for m in forced
                if runs(m)
                for e, after in play.edges(m)
                if e == f"{hardware}_EV_OOS"
            ]
            fewest = min(len(play.out(m)) for m, _ in edges)
            told = [words.of(hardware, m, after) for m, after in edges if len(play.out(m)) == fewest]
            assert set(row.local_effect.split("; or ")) == {each["local_effect"] for each in told}
            for column in ("objective_effect", "mission_effect", "detection", "recovery", "compensation"):
                possible = {each.get(column, "") for each in told}
                said = set(getattr(row, column).split("; or "))
                if "" in possible:  # where a failed objective leads
                    said = {text for text in said if not text.startswith(("its failure", "fails"))}
                assert said <= possible, column


WAITING = {
    # Where h fails while `b` holds g, `a` waits for what its supplier cannot give; where k2 fails, b lets go.
    "a waits": """
        <software name="s"/><activity name="p" produces="s" consumes="g"/>
        <activity name="a"><alternative name="a1" consumes="h"/>
          <alternative name="a2" consumes="s"/></activity>
        """,
    # The same, but `a` takes g itself: no alternative of it is selected.
    "a stops": """
        <activity name="a"><alternative name="a1" consumes="h"/>
          <alternative name="a2" consumes="g"/></activity>
        """,
    # `a` waits for g in the first place; where h fails it need not wait any more.
    "none": """
        <activity name="a"><alternative name="a1" consumes="g h"/>
          <alternative name="a2" consumes="k3"/></activity>
        """,
}


@pytest.mark.parametrize("effect", WAITING)
def test_an_activity_waits_for_what_another_holds(effect: str, tmp_path: Path) -> None:
    hardware = '<hardware name="h"/><hardware name="k2"/>' + "".join(
        f'<hardware name="{name}" faulty="false"/>' for name in ("g", "k", "k3")
    )
    (tmp_path / "m.xml").write_text(
        f"""<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">{hardware}{WAITING[effect]}
        <activity name="b">
          <alternative name="b1" consumes="g k2"/><alternative name="b2" consumes="k"/>
        </activity><activity name="idle"/></robot>
        <parallel name="both">
          <objective name="hold" activities="b"/>
          <objective name="later">
            <objective name="first" activities="idle"/><objective name="x" activities="a"/>
          </objective>
        </parallel></mission>"""
    )
    found = compose(read_mission(tmp_path / "m.xml"))
    for engine in ENGINES:
        rows = fmeca(Asked(found, engine).prospects)
        (row,) = [row for row in rows if (row.hardware, row.objective) == ("h", "x")]
        # Where `b` has ended, `a` is free to change.
        assert set(row.local_effect.split("; or ")) == {effect, "a: a1 -> a2"}
        assert row.severity is Severity.DEGRADED
        assert_severities(found, rows)
        assert_words(found, rows)


def test_where_the_failure_of_an_objective_leads(tmp_path: Path) -> None:
    names = ("first", "inner", "last", "needed", "spare", "end")
    robot = (f'<hardware name="h_{n}"/><activity name="{n}" consumes="h_{n}"/>' for n in names)
    (tmp_path / "m.xml").write_text(
        f"""<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">{"".join(robot)}</robot>
        <objective name="first" activities="first" failure="end"/>
        <parallel name="both">
          <objective name="branch">
            <objective name="inner" activities="inner" failure="succeed"/>
            <objective name="last" activities="last"/>
          </objective>
          <objective name="needed" activities="needed"/>
          <objective name="spare" activities="spare" mandatory="false"/>
        </parallel>
        <objective name="end" activities="end" failure="succeed"/>
        </mission>"""
    )
    found = compose(read_mission(tmp_path / "m.xml"))
    for engine in ENGINES:
        rows = fmeca(Asked(found, engine).prospects)
        # Each objective has hardware of its own.
        told = {row.objective: row for row in rows if row.hardware == f"h_{row.objective}"}
        assert {name: row.compensation for name, row in told.items()} == {
            "first": "its failure leads to end",
            "inner": "its failure is a success of branch",
            "last": "its failure fails both",
            "needed": "its failure fails both",
            "spare": "both does not need it",
            "end": "its failure ends the mission in success",
        }
        assert [told[name].section for name in names] == ["first", "both", "both", "both", "both", "end"]
