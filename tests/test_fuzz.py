"""Whatever files and options the command line is given, it answers in the form of its contract."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from mcpn.drawing.compose import compose
from mcpn.mission.xml import read_mission
from mcpn.nets.formats import READABLE, save_net
from mcpn.robot.runtime import Controller
from tests.commands import mcpn
from tests.mutation import READ, SECONDS, Seeds, a_case, answer, at_most, complaint

MISSION = b"""<mission name="m" description="a &lt;small> mission" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <hardware name="GPS" failure_rate="1e-3" repair_rate="0.5"/><hardware name="IMU" failure_rate="0.01"/>
    <hardware name="arm" faulty="false"/>
    <software name="place"/>
    <activity name="locate" produces="place">
      <alternative name="by_gps" consumes="GPS"/><alternative name="by_imu" consumes="IMU"/>
    </activity>
    <activity name="dive" consumes="place"><parameter name="depth" value="12" unit="m"/></activity>
    <activity name="grasp" consumes="arm"/>
  </robot>
  <protocols><protocol name="look">
    <objective name="down" activities="dive" duration="0.5"/>
  </protocol></protocols>
  <requirement name="deep" formula="G (objective(both.a) -> activity(dive))"/>
  <requirement name="first"><precedence of="objective(both.b)" by="happens(MISSION_EV_START)"/></requirement>
  <use protocol="look" name="first" failure="both"/>
  <parallel name="both" failure="fail">
    <objective name="a" activities="dive" duration="1"/>
    <objective name="b" activities="grasp" mandatory="false" duration="0.1" failure_probability="0.1"/>
  </parallel>
</mission>
"""
IMPORTING = b"""<mission name="m" xmlns="urn:mcpn:mission:1"><import href="robot.xml"/>
<objective name="o" activities="dive"/></mission>
"""
UNUSED = b"""<mission name="m" xmlns="urn:mcpn:mission:1">
<robot name="r"><hardware name="H" failure_rate="1"/><hardware name="unused"/>
<activity name="a" consumes="H"/><activity name="idle" consumes="H"/></robot>
<objective name="x" activities="a" success="y"/><objective name="never" activities="a"/>
<objective name="y" activities="a"/></mission>"""
CONTENTION = b"""<mission name="m" xmlns="urn:mcpn:mission:1">
<robot name="r"><hardware name="H"/><activity name="a" consumes="H"/><activity name="b" consumes="H"/></robot>
<parallel name="p"><objective name="x" activities="a"/><objective name="y" activities="b"/></parallel>
</mission>"""
NEWER = b"""<mission name="m" xmlns="urn:mcpn:mission:1">
<robot name="r"><event name="leak"/><hardware name="H" shared="true"/><hardware name="G"/>
<software name="map" exclusive="true"/><software name="scan"/>
<activity name="mapping" produces="map"><alternative name="h" consumes="H"/>
<alternative name="g" consumes="G"/></activity>
<activity name="scanning" produces="scan" consumes="H"/>
<activity name="drive" switch_back="true"><alternative name="fast" consumes="map scan"/>
<alternative name="slow" consumes="scan"/></activity></robot>
<on event="leak" goto="home" once="true"/>
<each name="room" in="12 14"><objective name="visit" activities="drive" retries="2">
<parameter name="to" value="room"/></objective></each>
<objective name="tour" repeat="2"><on event="leak" goto="fail"/>
<objective name="x" activities="drive"/></objective>
<objective name="home" activities="drive"/>
</mission>"""
LAMP = b"""net lamp
pl off (1)
pl broken (0)
tr press : on_event off -> on
tr again on -> off
tr burn on -> broken
pr press again > burn
"""
WELL = b"""net well
pl p (2)
tr t p*2 -> p q
tr u q -> p
"""
PROPERTIES = b"""<?xml version="1.0"?>
<property-set xmlns="http://mcc.lip6.fr/">
<property><id>x-0</id><description>one</description><formula><all-paths><globally><exists-path><finally>
<negation><is-fireable><transition>press</transition></is-fireable></negation>
</finally></exists-path></globally></all-paths></formula></property>
<property><id>x-1</id><formula><exists-path><until><before><integer-le><tokens-count><place>on</place>
<place>off</place></tokens-count><integer-constant>1</integer-constant></integer-le></before>
<reach><deadlock/></reach></until></exists-path></formula></property>
<property><id>x-2</id><formula><place-bound><place>on</place><place>off</place></place-bound></formula></property>
</property-set>
"""
FORMULAS = (
    "AG EF (success | failure)",
    "E [ ! oos(GPS) U objective(both.a) & alternative(locate)=by_imu ]",
    "A[true U failure] -> EX deadlock",
    "EG (stable & success + failure <= 1)",
    "AF (enabled(MISSION_EV_START) <-> EX true)",
)


@pytest.fixture(scope="module")
def seeds(tmp_path_factory: pytest.TempPathFactory) -> Seeds:
    folder = tmp_path_factory.mktemp("seeds")
    (folder / "m.xml").write_bytes(MISSION)
    net = compose(read_mission(folder / "m.xml")).net
    written: dict[str, tuple[bytes, ...]] = {".net": (LAMP, WELL)}
    for suffix in READABLE:
        save_net(net, folder / f"n{suffix}")
        written[suffix] = (*written.get(suffix, ()), (folder / f"n{suffix}").read_bytes())
    assert mcpn("controller", folder / "m.xml", "-o", folder / "made", "--unverified").returncode == 0
    assert mcpn("monitor", folder / "m.xml", "-o", folder / "made").returncode == 0
    made = {name: (folder / "made" / name).read_bytes() for name in ("controller.json", "monitors.json")}
    controller = Controller.load(folder / "made" / "controller.json")
    controller.handle("MISSION_EV_START")
    made["snapshot"] = controller.snapshot().encode()
    missions = (MISSION, IMPORTING, UNUSED, CONTENTION, NEWER)
    return Seeds(missions, written, (PROPERTIES,), FORMULAS, made)


def test_what_is_mutated_is_read_as_it_is(
    seeds: Seeds, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """Unchanged, every kind of file is accepted: what is drawn is near what is read."""
    request.getfixturevalue("monkeypatch").setattr("tests.mutation.mutated", lambda data, _draw: data)
    (tmp_path / "case").mkdir()
    for kind in READ:
        for case in range(12):
            arguments = kind(seeds, tmp_path / "case", random.Random(case))
            found = answer(arguments)
            assert found.returncode == 0, f"{arguments}: {found.stderr}"


def check_cases(seeds: Seeds, folder: Path, cases: range, request: pytest.FixtureRequest) -> None:
    monkeypatch = request.getfixturevalue("monkeypatch")
    monkeypatch.chdir(folder)
    wrong = []
    for case in cases:
        arguments = a_case(seeds, folder, random.Random(case))
        try:
            with at_most(SECONDS):
                found = complaint(arguments)
        except TimeoutError as error:
            found = str(error)
        if found is not None:
            wrong.append(f"case {case}: {' '.join(map(str, arguments))[:300]}\n{found}")
    assert not wrong, f"{len(wrong)} of {len(cases)} cases\n" + "\n\n".join(wrong[:20])


def test_a_fixed_set_of_cases(seeds: Seeds, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    check_cases(seeds, tmp_path, range(150), request)


def test_cases_drawn_afresh(
    seeds: Seeds, tmp_path: Path, request: pytest.FixtureRequest, fresh_seed: int
) -> None:
    check_cases(seeds, tmp_path, range(fresh_seed, fresh_seed + 150), request)


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_ten_thousand_cases(
    seeds: Seeds, tmp_path: Path, request: pytest.FixtureRequest, fresh_seed: int
) -> None:
    """Another number of them by ``--cases``."""
    cases = int(request.config.getoption("--cases"))
    check_cases(seeds, tmp_path, range(fresh_seed, fresh_seed + cases), request)
