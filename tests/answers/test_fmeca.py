"""The FMECA table: what Ulysse's text says, and severities by plain search on the net."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.causes.effects import Severity, changes, in_words
from mcpn.answers.causes.fmeca import Others, Row, fmeca
from mcpn.answers.verdicts.modes import Situation
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.core.objectives_graph import Branch, ElementarySection, ObjectivesGraph, ParallelSection
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import Marking
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from tests.draws import fewer
from tests.logic.asked import ENGINES, Asked
from tests.logic.oracle import Play, coming_home, fragile_missions, minimal
from tests.shares import returns_early


@pytest.fixture(scope="module", params=ENGINES)
def ulysse_rows(ulysse_net: MissionNet, request: pytest.FixtureRequest) -> dict[tuple[str, str], Row]:
    rows = fmeca(Asked(ulysse_net, request.param).prospects)
    return {(row.hardware, row.objective): row for row in rows}


def test_every_resource_of_ulysse_has_a_row_for_every_objective(
    ulysse_net: MissionNet, ulysse_rows: dict[tuple[str, str], Row]
) -> None:
    assert list(ulysse_rows) == [
        (h.name, s.name) for h in ulysse_net.core.hardware for s in ulysse_net.graph.walk()
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
    assert row.compensation == "the objective's failure ends the mission in failure"
    assert row.severity is Severity.MISSION_LOST
    row = ulysse_rows["thruster_actuator", "transect.diving"]
    assert row.compensation == "the objective's failure leads to transect.going_up"
    assert row.recovery == "none before the objective has failed, then the mission can succeed"
    assert row.severity is Severity.MISSION_LOST_UNLESS_REPAIRED
    assert ulysse_rows["thruster_actuator", "transect.advancing"].compensation == (
        "the objective's failure fails transect.census"
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
    assert retried["coupling", "refill_try2"].compensation == "the objective's failure leads to go_home_try1"


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
    producers = {r: a.name for a in found.core.activities for r in a.produces}
    consumed = {f"{a.name}.{way.name}": way.consumes for a in found.core.activities for way in a.alternatives}
    said = [role for place, role in found.roles.items() if marking[place]]
    using, stack = set[tuple[str, str]](), list(activities)
    seen = set(stack)
    while stack:
        activity = stack.pop()
        for kind, name in said:
            if kind == "refused" and name == activity:
                using.add((kind, name))
            elif kind == "want" and name.split(".", 1)[0] == activity:
                using.add((kind, name))  # it has asked nobody yet
            elif kind in ("active", "wait") and name.split(".", 1)[0] == activity:
                using.add((kind, name))
                serving = {producers[r] for r in consumed[name] if r in producers} - seen
                seen |= serving
                stack.extend(serving)
    return frozenset(using)


class Costs:
    """What the failure of a resource costs, by plain search."""

    def __init__(self, found: MissionNet) -> None:
        self.found, self.play = found, Play(found)
        self.dead = frozenset(self.play.hardware)
        self.mission_survives = cache(self.play.mission_survives)
        self.objective_survives = cache(self.play.objective_survives)

    def ends_safely(self, marking: Marking, dead: frozenset[str]) -> bool:
        """Whether the mission may still succeed or be aborted."""
        return self.play.ends_safely(marking, dead)

    def used(self, marking: Marking, section: ElementarySection) -> frozenset[tuple[str, str]]:
        return used_by(self.found, marking, section.activities)

    def severity(self, before: Marking, after: Marking, section: ElementarySection) -> Severity:
        def crosses(survives: Callable[[Marking], bool]) -> bool:
            return survives(before) and not survives(after)

        if self.found.abort is not None:
            if crosses(lambda m: self.ends_safely(m, frozenset())):
                return Severity.ROBOT_LOST
            if crosses(lambda m: self.ends_safely(m, self.dead)):
                return Severity.ROBOT_LOST_UNLESS_REPAIRED
        if crosses(lambda m: self.mission_survives(m, frozenset())):
            return Severity.MISSION_LOST
        if crosses(lambda m: self.mission_survives(m, self.dead)):
            return Severity.MISSION_LOST_UNLESS_REPAIRED
        if crosses(lambda m: self.objective_survives(m, section.name, self.dead)):
            return Severity.OBJECTIVE_LOST
        changed = self.used(before, section) != self.used(after, section)
        return Severity.DEGRADED if changed else Severity.NO_EFFECT

    def failures(self, section: ElementarySection) -> Iterator[tuple[str, Marking, Marking]]:
        """Every edge by which a resource fails while an objective runs."""
        runs = self.play.marks(f"OBJ_{section.name}")
        for before in self.play.reach([self.play.initial]):
            for happens, after in self.play.edges(before) if runs(before) else ():
                if happens.endswith("_EV_OOS"):
                    yield happens.removesuffix("_EV_OOS"), before, after


def severities(found: MissionNet) -> dict[tuple[str, str], dict[Severity, set[frozenset[str]]]]:
    """By hardware and objective, what its failure costs, each with the other hardware out of service."""
    costs = Costs(found)
    expected: dict[tuple[str, str], dict[Severity, set[frozenset[str]]]] = {}
    for section in found.graph.walk():
        for hardware, before, after in costs.failures(section):
            of = expected.setdefault((hardware, section.name), {})
            of.setdefault(costs.severity(before, after, section), set()).add(costs.play.out(before))
    return expected


@fewer(0.2)
@given(
    fragile_missions(max_hardware=3, max_objectives=2, max_sections=5)
    | fragile_missions(max_hardware=3, max_objectives=2, max_sections=5, events=2)
    | fragile_missions(max_hardware=2, max_objectives=2, max_sections=4, faults=1)
    | fragile_missions(max_hardware=3, max_objectives=2, max_sections=5, lasting=True)
    | fragile_missions(max_hardware=2, max_objectives=2, max_sections=4, crashes=True)
    | coming_home(),
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
    event(max((row.worst for row in rows), default=Severity.NO_EFFECT).words)
    assert_severities(found, rows)


def told_once(severity: Severity, costs: Mapping[Severity, Collection[frozenset[str]]]) -> list[Others]:
    """The minimal sets of a class without those with which it may be worse."""
    worse = {tuple(sorted(others)) for cost, sets in costs.items() if cost > severity for others in sets}
    return [others for others in minimal(costs[severity]) if others not in worse]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_set_of_losses_is_told_in_its_worst_class(engine: Engine, tmp_path: Path) -> None:
    """Where its sibling has failed too the mission is lost with a spare, and else the objective alone."""
    (tmp_path / "m.xml").write_text("""<mission name="m" xmlns="urn:mcpn:mission:1">
      <robot name="r"><hardware name="h"/><hardware name="g"/><activity name="free"/>
        <activity name="go">
          <alternative name="one" consumes="h"/><alternative name="two" consumes="g"/>
        </activity>
      </robot>
      <parallel name="p" success_when="1">
        <objective name="x" activities="free"/><objective name="y" activities="go"/>
      </parallel></mission>""")
    rows = fmeca(Asked(compose(read_mission(tmp_path / "m.xml")), engine).prospects)
    (row,) = (row for row in rows if (row.hardware, row.objective) == ("h", "y"))
    assert row.with_others == ((Severity.MISSION_LOST, (("g",),)),)


@pytest.mark.parametrize("engine", ENGINES)
def test_one_class_for_each_set_of_a_file(faults: Path, engine: Engine) -> None:
    found = compose(read_mission(faults / "fmeca_two_classes.xml"))
    assert_severities(found, fmeca(Asked(found, engine).prospects))


def assert_severities(found: MissionNet, rows: list[Row]) -> None:
    expected = severities(found)
    assert {(row.hardware, row.objective) for row in rows} == set(expected)
    for row in rows:
        costs = expected[row.hardware, row.objective]
        every = [severity for severity, sets in costs.items() if frozenset() in sets]
        alone = max(every, default=Severity.NO_EFFECT)  # what is never repaired may be out all the time
        worse = {
            severity: only
            for severity, sets in costs.items()
            if severity > alone and (only := told_once(severity, costs))
        }
        assert row.severity == alone
        assert {severity: list(sets) for severity, sets in row.with_others} == worse
        told = [others for _, sets in row.with_others for others in sets]
        assert len(told) == len(set(told))


class Words:
    """What a row may say of one failure, from the markings before and after it and after the repair."""

    def __init__(self, costs: Costs, section: ElementarySection) -> None:
        self.costs, self.play, self.section = costs, costs.play, section

    def said(self, marking: Marking, *kinds: str) -> dict[str, str]:
        """Of each activity that serves the objective its alternative, what it waits with, or nothing."""
        used, roles = self.costs.used(marking, self.section), self.costs.found.roles.values()
        return {n.partition(".")[0]: n.partition(".")[2] for k, n in roles if k in kinds and (k, n) in used}

    def lost(self, marking: Marking) -> bool:
        return not self.costs.objective_survives(marking, self.section.name, self.costs.dead)

    def mission_lost(self, marking: Marking) -> bool:
        return not self.costs.mission_survives(marking, self.costs.dead)

    def unsafe(self, marking: Marking) -> bool:
        """Whether only repairs may lead to a safe end, of a mission that can abort."""
        return self.costs.found.abort is not None and not self.costs.ends_safely(marking, self.costs.dead)

    def mission_effect(self, before: Marking, after: Marking) -> str:
        """What a failure means for a mission, and whether it was so before."""
        was, now = self.left_to(before), self.left_to(after)
        return f"{now}, as before it" if was == now != "can still succeed" else now

    def left_to(self, after: Marking) -> str:
        """What is left to a mission."""
        if self.costs.found.abort is None:
            if not self.costs.mission_survives(after, frozenset()):
                return "cannot succeed any more"
            return "can succeed only if repaired" if self.mission_lost(after) else "can still succeed"
        if not self.costs.ends_safely(after, frozenset()):
            return "can no longer end safely"
        without_hope = not self.costs.mission_survives(after, frozenset())
        if self.unsafe(after) and without_hope:
            return "can end safely only if repaired, and no longer succeed"
        if self.unsafe(after):
            return "can end safely only if repaired"
        if without_hope:
            return "can end safely, but no longer succeed"
        return (
            "can succeed only if repaired, or end safely" if self.mission_lost(after) else "can still succeed"
        )

    def regained(self, after: Marking, back: Marking) -> str:
        """What the mission can do again when the resource is ready again."""
        if self.mission_lost(after) and not self.mission_lost(back):
            return "succeed"
        return "end safely" if self.unsafe(after) and not self.unsafe(back) else ""

    def leads(self) -> str:
        """Where the failure of the objective leads, as the graph has it."""
        to = self.section.failure
        graphs: list[tuple[ObjectivesGraph, ParallelSection | None, Branch | None]]
        graphs = [(self.costs.found.graph, None, None)]
        for graph, block, branch in graphs:
            for other in graph.sections:
                if other.name == self.section.name:
                    return self.leading(to, block, branch)
                if isinstance(other, ParallelSection):
                    graphs += [(each.graph, other, each) for each in other.branches]
        raise AssertionError(self.section.name)

    def leading(self, to: str, block: ParallelSection | None, branch: Branch | None) -> str:
        """The same, in the branch of a block, or in none."""
        if to not in ("succeed", "fail", "abort"):
            here, there = (re.sub("_try[0-9]+", "_try", name) for name in (self.section.name, to))
            then = "its next try" if here == there and "_try" in here else to
            return f"the objective's failure leads to {then}"
        if block is None or branch is None:
            ends = {"succeed": "success", "fail": "failure", "abort": "abort"}
            return f"the objective's failure ends the mission in {ends[to]}"
        if to == "abort":
            return f"the objective's failure aborts {block.name}"
        if to == "succeed":
            return f"the objective's failure is a success of {branch.name}"
        if branch.mandatory and (block.needed is None or block.hasty):
            return f"the objective's failure fails {block.name}"
        if block.failing == 1:
            last = " while another child runs" if block.needed is None and not branch.mandatory else ""
            return f"the objective's failure fails {block.name}{last}"
        spared = len(block.branches) - (block.needed or 0)
        alike = block.failing is None or block.failing > spared  # by success that cannot be reached any more
        last = " while another child runs" if block.needed is None else ""
        failures = "" if alike else f"{block.failing} failures fail {block.name}{last}"
        if block.needed is None:
            return failures or f"{block.name} does not need it"
        counted = f"{block.name} needs {block.needed} of {len(block.branches)}"
        return f"{counted}, {failures}" if failures else counted

    def of(self, hardware: str, before: Marking, after: Marking) -> dict[str, str]:
        """By column, for one failure."""
        back = next((m for e, m in self.play.edges(after) if e == f"{hardware}_EV_RD"), after)
        modes = [self.said(m, "active") for m in (before, after, back)]
        was, now, then = modes
        switched = {
            a: alternative for a, alternative in now.items() if was.get(a, alternative) != alternative
        }
        changes = [f"{a}: {was[a]} -> {switched[a]}" for a in was if a in switched]
        for kinds, words in ((["refused"], "has no possible alternative"), (["wait", "want"], "waits")):
            changes += [
                f"{a} {words}" for a in self.said(after, *kinds) if a not in self.said(before, *kinds)
            ]
        stopped = [f"{a} stops" for a in was if a not in now]
        ways = {
            (a.name, w.name): w.consumes for a in self.costs.found.core.activities for w in a.alternatives
        }
        users = [a for a in was if hardware in ways[a, was[a]]]
        started = [f"{a} runs" for a in now if a not in was]
        told = {
            "local_effect": ", ".join(changes or stopped or started),
            "detection": f"at once, by the error to {' and '.join(users)}"
            if users
            else "by its event alone: not in use here",
        }
        told["mission_effect"] = self.mission_effect(before, after)
        if self.lost(after):
            told["objective_effect"] = f"cannot succeed any more{', as before it' * self.lost(before)}"
            told["compensation"] = self.leads()
            told["recovery"] = "none before the objective has failed"
            if not self.lost(back):
                told["recovery"] = "the objective can succeed again"
            if regained := self.regained(after, back):
                told["recovery"] += f", then the mission can {regained}"
            return told
        same = self.costs.used(before, self.section) == self.costs.used(after, self.section)
        told["objective_effect"] = "none" if same else "goes on in another mode"
        told["compensation"] = f"{', '.join(switched[a] for a in was if a in switched)} instead"
        if not switched:
            told["compensation"] = "none" if self.mission_lost(after) else "none needed"
        if same and self.mission_lost(after):
            regained = self.regained(after, back)
            told["recovery"] = f"the mission can {regained} again" if regained else "none"
            return told
        told["recovery"] = {
            (True, True): "none needed",
            (True, False): "at the next start of the activity",
            (False, True): "the former mode",
            (False, False): "another mode",
        }[then == now, then == was]
        return told


@fewer(0.2)
@given(
    # The second kind contends: activities wait for what others hold, and stop where it fails.
    fragile_missions(max_hardware=3, max_objectives=2, max_sections=4)
    | missions(max_hardware=2, max_objectives=2, max_sections=3, alternatives=2)
    | coming_home(),
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
    costs = Costs(found)
    for section in found.graph.walk():
        words = Words(costs, section)
        cases: dict[str, list[tuple[Severity, bool, dict[str, str]]]] = {}
        for hardware, before, after in costs.failures(section):
            if not costs.play.out(before):
                cost = costs.severity(before, after, section)
                case = cost, words.lost(before), words.of(hardware, before, after)
                cases.setdefault(hardware, []).append(case)
        for hardware, alone in cases.items():
            row = by_pair[hardware, section.name]
            open_to = {cost for cost, lost, _ in alone if not lost}
            of = [(cost, told) for cost, lost, told in alone if not (lost and cost in open_to)]
            # Where the failure does something, nothing is said of where it does nothing.
            told = [each for cost, each in of if cost] or [each for _, each in of]
            effects = {each["local_effect"] for each in told} - {""}
            if effects:
                assert set(row.local_effect.split("; or ")) == effects
            else:
                assert row.local_effect.startswith("none")
                assert (row.local_effect == "none") == (not row.severity)
            for column in ("objective_effect", "mission_effect", "detection", "recovery", "compensation"):
                possible = {each[column] for each in told}
                assert set(getattr(row, column).split("; or ")) <= possible, column


WAITING = {
    # Where h fails while `b` holds g, `a` waits for what its supplier cannot give; where k2 fails, b lets go.
    "p waits, a waits": """
        <software name="s"/><activity name="p" produces="s" consumes="g"/>
        <activity name="a"><alternative name="a1" consumes="h"/>
          <alternative name="a2" consumes="s"/></activity>
        """,
    # The same, but `a` takes g itself: it waits with no alternative selected.
    "a waits": """
        <activity name="a"><alternative name="a1" consumes="h"/>
          <alternative name="a2" consumes="g"/></activity>
        """,
    # `a` waits for g in the first place; where h fails it need not wait any more.
    "a runs": """
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
            "first": "the objective's failure leads to end",
            "inner": "the objective's failure is a success of branch",
            "last": "the objective's failure fails both",
            "needed": "the objective's failure fails both",
            "spare": "both does not need it",
            "end": "the objective's failure ends the mission in success",
        }
        assert [told[name].section for name in names] == ["first", "both", "both", "both", "both", "end"]


@pytest.mark.parametrize(
    ("ends", "told"),
    [
        ('failure_when="1"', "the objective's failure fails both while another child runs"),
        ('failure_when="1" success_when="1"', "the objective's failure fails both"),
    ],
)
def test_a_failure_fails_a_block_unless_it_is_the_last(tmp_path: Path, ends: str, told: str) -> None:
    (tmp_path / "m.xml").write_text(
        f"""<mission name="m" xmlns="urn:mcpn:mission:1">
        <robot name="r"><hardware name="h"/><activity name="a"/><activity name="b" consumes="h"/></robot>
        <parallel name="both" {ends}>
          <objective name="x" activities="a"/>
          <objective name="y" activities="b" mandatory="false"/>
        </parallel>
        </mission>"""
    )
    found = compose(read_mission(tmp_path / "m.xml"))
    for engine in ENGINES:
        rows = fmeca(Asked(found, engine).prospects)
        assert {row.compensation for row in rows if row.objective == "y"} == {told}


def test_of_a_mode_only_what_changes_is_told() -> None:
    before = Situation(mode={"b": "b1", "c": "c1"}, waiting={"a": "a1"}, refused=("r",))
    after = Situation(mode={"b": "b2", "e": "e1"}, waiting={"a": "a1", "d": "d1"}, refused=("r", "s"))
    assert in_words((changes(before, after),)) == "b: b1 -> b2, s has no possible alternative, d waits"
    assert changes(after, after) == ()
    # That something stops or runs is told where nothing else is.
    stopped = changes(Situation(mode={"b": "b1", "c": "c1"}), Situation(mode={"b": "b1"}))
    assert in_words((stopped,)) == "c stops"
    assert in_words((changes(Situation(), Situation(mode={"b": "b1"})),)) == "b runs"


def rows_of(text: str, tmp_path: Path, engine: Engine = "explicit") -> dict[tuple[str, str], Row]:
    (tmp_path / "m.xml").write_text(f'<mission name="m" xmlns="urn:mcpn:mission:1">{text}</mission>')
    rows = fmeca(Asked(compose(read_mission(tmp_path / "m.xml")), engine).prospects)
    return {(row.hardware, row.objective): row for row in rows}


@pytest.mark.parametrize("engine", ENGINES)
def test_what_is_never_repaired_is_never_regained(engine: Engine, tmp_path: Path) -> None:
    """No repair leads anywhere: that is no way back, neither to success nor to another mode."""
    robot = (
        '<robot name="r"><hardware name="motor" repairable="false"/>'
        '<hardware name="camera" repairable="false"/><activity name="drive" consumes="motor"/>'
        '<activity name="look" switch_back="true"><alternative name="eye" consumes="camera"/>'
        '<alternative name="ear"/></activity></robot>'
    )
    rows = rows_of(f'{robot}<objective name="go" activities="drive look"/>', tmp_path, engine)
    assert rows["motor", "go"].severity is Severity.MISSION_LOST
    assert rows["motor", "go"].recovery == "none: it is not repaired"
    assert rows["camera", "go"].recovery == "none: it is not repaired"


@pytest.mark.parametrize("engine", ENGINES)
def test_a_loss_that_nobody_notices_is_not_repaired(engine: Engine, tmp_path: Path) -> None:
    robot = (
        '<robot name="r"><hardware name="camera" detected="late"/><activity name="film" consumes="camera"/>'
        '<activity name="test" detects="camera"/></robot>'
    )
    blocks = '<objective name="survey" activities="film"/><objective name="end" activities="test film"/>'
    rows = rows_of(robot + blocks, tmp_path, engine)
    assert rows["camera", "survey"].recovery == "none before its loss is noticed"
    assert rows["camera", "survey"].severity is Severity.MISSION_LOST


def test_copies_of_a_timed_block_have_rows_of_their_own(tmp_path: Path) -> None:
    """Behind the last try there is none: its loss is worse than that of the first."""
    text = (
        '<robot name="r"><hardware name="h"/><activity name="a" consumes="h"/></robot>'
        '<objective name="p" timeout="60" retries="1"><objective name="o" activities="a"/></objective>'
    )
    explicit, local = (rows_of(text, tmp_path, engine) for engine in ("explicit", "local"))
    assert local == explicit
    assert local["h", "p_try1.o"].severity is Severity.MISSION_LOST_UNLESS_REPAIRED
    assert local["h", "p_try2.o"].severity is Severity.MISSION_LOST
