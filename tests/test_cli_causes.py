"""``mcpn causes`` as other programs and people see it."""

from __future__ import annotations

import csv
import json
import re
import sys
from pathlib import Path

import pytest
from lxml import etree

from tests.answers.test_cutsets import ULYSSE as CUT_SETS
from tests.commands import mcpn, output
from tests.conftest import ROOT, ULYSSE

TIMED = """<mission name="m" xmlns="urn:mcpn:mission:1">
<robot name="r">
<hardware name="H" failure_rate="0.25"/>
<activity name="go" consumes="H"/>
</robot>
<objective name="x" activities="go" duration="2"/>
</mission>
"""


def test_json_of_ulysse() -> None:
    found = output("causes", ULYSSE)
    assert {name: goal["cut_sets"] for name, goal in found["objectives"].items()} == {
        name: [list(names) for names in cut_sets] for name, cut_sets in CUT_SETS.items()
    }
    assert found["mission"]["cut_sets"] == [["thruster_actuator"], ["GPS_sensor", "IMU_sensor"]]
    assert found["mission"]["critical_events"] == [
        "GPS_sensor_EV_OOS",
        "IMU_sensor_EV_OOS",
        "OBJ_transect.going_up_EV_FAIL",
        "thruster_actuator_EV_OOS",
    ]
    assert [s["section"] for s in found["survival"]] == [
        None,
        "coral_head.manual_moving",
        "coral_head.isopheric_observation",
        "transect.diving",
        "transect.census",
        "transect.going_up",
    ]


def test_one_objective_alone() -> None:
    found = output("causes", ULYSSE, "--objective", "transect.diving")
    assert list(found["objectives"]) == ["transect.diving"]
    assert found["objectives"]["transect.diving"]["cut_sets"] == [
        ["thruster_actuator"],
        ["GPS_sensor", "IMU_sensor"],
    ]


@pytest.mark.parametrize("count", [50, 51])
def test_effects_of_many_objectives_are_told_when_asked_for(count: int, tmp_path: Path) -> None:
    """``--help`` says of how many they are told unasked."""
    row = "".join(f'<objective name="o{i}" activities="go"/>' for i in range(count))
    robot = '<robot name="r"><hardware name="H"/><activity name="go" consumes="H"/></robot>'
    file = tmp_path / "row.xml"
    file.write_text(f'<mission name="m" xmlns="urn:mcpn:mission:1">{robot}{row}</mission>')
    assert "more than 50 objectives" in re.sub(r"\s+", " ", mcpn("causes", "--help").stdout)
    effect = "go has no possible alternative"
    assert (effect in mcpn("causes", file).stdout) is (count <= 50)
    assert effect in mcpn("causes", file, "--objective", "o0").stdout


def test_unknown_objectives_are_told_with_the_known_ones() -> None:
    run = mcpn("causes", ULYSSE, "--objective", "dive")
    assert run.returncode == 2
    assert run.stderr.startswith("error: ")
    assert "no objective dive" in run.stderr
    assert "transect.diving" in run.stderr


def test_a_person_reads_conditions(tmp_path: Path) -> None:
    run = mcpn("causes", ULYSSE)
    assert run.returncode == 0, run.stderr
    told = (
        "The loss of thruster_actuator, or of GPS_sensor and IMU_sensor together beforehand, not repaired, "
        "leaves coral_head.manual_moving"
    )
    assert told in run.stdout
    told = "Whatever hardware is lost beforehand, transect.filming and transect.measuring_temperature can "
    assert f"{told}succeed." in run.stdout


def test_a_run_after_which_the_mission_need_not_end_says_so() -> None:
    """The glider's last call is tried again without end: no outcome follows the loss of its radio."""
    run = mcpn("causes", ROOT / "experiments" / "glider" / "mission.xml")
    assert run.returncode == 0, run.stderr
    radio = run.stdout.partition("the loss of satellite_radio to where there is no way to success:")[
        2
    ].partition("a run")[0]
    assert "from here on there is no way without a repair, and the mission need not end" in radio
    pump = run.stdout.partition("the loss of buoyancy_pump to where there is no way to success:")[
        2
    ].partition("a run")[0]
    assert "the mission ends in abort" in pump
    assert "need not end" not in pump


def test_fmeca_and_fault_tree_are_written(tmp_path: Path) -> None:
    table, tree = tmp_path / "fmeca.csv", tmp_path / "tree.xml"
    output("causes", ULYSSE, "--fmeca", table, "--openpsa", tree, "--severity", "mission lost=I")
    with table.open(newline="") as file:
        rows = {(row["hardware"], row["objective"]): row for row in csv.DictReader(file)}
    assert len(rows) == 21
    assert rows["thruster_actuator", "transect.going_up"]["severity"] == "I"
    assert rows["GPS_sensor", "transect.going_up"]["with_others"] == "I with IMU_sensor"
    assert etree.parse(tree).getroot().tag == "opsa-mef"
    output("causes", ULYSSE, "--fmeca", tmp_path / "fmeca.json")
    listed = json.loads((tmp_path / "fmeca.json").read_text())
    assert [(row["hardware"], row["objective"]) for row in listed] == list(rows)


RISKY = """<mission name="m" xmlns="urn:mcpn:mission:1">
<robot name="r"><event name="leak" rate="0.01"/>
<hardware name="gps" failure_rate="1e-5 .. 1e-3" demand_probability="0.02" detected="late"/>
<hardware name="radio" initial="oos" repair_rate="1"/>
<activity name="fix" consumes="gps" detects="gps" detection_rate="2"/>
<activity name="call" consumes="radio"/></robot>
<on event="leak" goto="fail"/>
<objective name="go" activities="fix" duration="6" failure_probability="0.1"/>
<objective name="say" activities="call" duration="1"/></mission>"""


def test_a_fault_tree_is_told_with_what_it_lacks(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(RISKY)
    run = mcpn("causes", tmp_path / "m.xml", "--openpsa", tmp_path / "t.xml")
    assert run.returncode == 0, run.stderr
    lacking, means, asked = [line for line in run.stderr.splitlines() if "t.xml: " in line]
    for named in (
        "no demand_probability (gps)",
        "no status at the start (radio)",
        "no rate (leak)",
        "no detection_rate (fix)",
        "no failure_probability (go)",
        "no duration (go, say)",
    ):
        assert named in lacking
    assert means.endswith("geometric means of intervals: failure_rate of gps 0.0001")
    assert "scram --probability true --mission-time HOURS, with the hours" in asked
    label = etree.parse(tmp_path / "t.xml").find("define-fault-tree/label")
    assert label is not None
    assert (label.text or "").startswith("the fault tree holds no")
    run = mcpn("causes", ULYSSE, "--openpsa", tmp_path / "t.xml")
    assert "no hardware has a failure_rate" in run.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--fmeca", "table.txt"], "expected .csv or .json"),
        (["--severity", "mission lst=I"], "mission lost unless repaired=NAME"),
        (["--rates"], "has no duration"),
        (["--engine", "explicit", "--max-states", "100"], "limit on states"),
    ],
)
def test_bad_input_is_told(arguments: list[str], message: str, tmp_path: Path) -> None:
    run = mcpn("causes", ULYSSE, *arguments)
    assert run.returncode == 2
    assert run.stderr.startswith("error: ")
    assert message in run.stderr


def test_rates(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(TIMED)
    found = output("causes", path, "--rates")
    # Closed form: the resource outlives an exponential duration of mean 2 h with 1 / (1 + 0.25 * 2).
    assert found["risk"]["success"] == pytest.approx(1 / 1.5)
    assert found["risk"]["importance"] == {"H": pytest.approx(1.0)}
    assert found["risk"]["unrated"] == []


def test_a_chain_too_large_has_no_numbers_and_the_rest_is_answered(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(TIMED)
    # Before the start, and at each end, hardware is in service or not; or it runs, is out, is back too late.
    why = "numbers of risk: not computed: 9 states, the limit is 5 (--max-chain)"
    limit = ("--rates", "--engine", "explicit", "--max-chain", "5")
    run = mcpn("causes", path, *limit)
    assert run.returncode == 2
    assert why in run.stderr
    assert "The loss of H before the start, not repaired, leaves no way to success." in run.stdout
    run = mcpn("causes", path, *limit, "--json")
    assert run.returncode == 2
    found = json.loads(run.stdout)
    assert (found["no_risk"], found["mission"]["cut_sets"], "risk" in found) == (why, [["H"]], False)
    assert output("causes", path, "--rates", "--engine", "explicit", "--max-chain", "9")["risk"]


def convoy(carts: int) -> str:
    """Carts that drive at the same time, each with a motor that can be repaired and one that cannot."""
    motors = "".join(
        f"""<hardware name="motor{i}" failure_rate="1e-4" repair_rate="0.1"/>
        <hardware name="spare{i}" failure_rate="1e-4"/>
        <activity name="drive{i}"><alternative name="by_motor" consumes="motor{i}"/>
        <alternative name="by_spare" consumes="spare{i}"/></activity>"""
        for i in range(carts)
    )
    driving = "".join(f'<objective name="go{i}" activities="drive{i}" duration="2"/>' for i in range(carts))
    return f"""<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">{motors}</robot>
    <parallel name="convoy">{driving}</parallel></mission>"""


def greenhouse(beds: int) -> str:
    """Beds that are watered and lit at the same time, then a tour, which frost cuts short."""
    each = "".join(
        f"""<hardware name="valve{i}" failure_rate="1e-4" repair_rate="0.2"/>
        <hardware name="lamp{i}" failure_rate="1e-3" repair_rate="0.1"/>
        <activity name="water{i}" consumes="pump valve{i}"/><activity name="light{i}" consumes="lamp{i}"/>"""
        for i in range(beds)
    )
    tended = "".join(
        f"""<objective name="watering{i}" activities="water{i}" duration="2"/>
        <objective name="lighting{i}" activities="light{i}" duration="6" mandatory="false"/>"""
        for i in range(beds)
    )
    return f"""<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><event name="frost" rate="1e-3"/>
    <hardware name="wheels" failure_rate="1e-4"/>
    <hardware name="pump" failure_rate="1e-4" shared="true"/>{each}
    <activity name="drive" consumes="wheels"/></robot>
    <on event="frost" goto="home"/><parallel name="convoy">{tended}</parallel>
    <objective name="tour" activities="drive" duration="1"/>
    <objective name="home" activities="drive" duration="1"/>
    </mission>"""


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(convoy(4), id="convoy"),
        pytest.param(greenhouse(3), id="greenhouse", marks=pytest.mark.slow),
    ],
)
def test_of_a_large_mission_all_but_the_numbers_is_told(text: str, tmp_path: Path) -> None:
    path, page = tmp_path / "m.xml", tmp_path / "page.html"
    path.write_text(text)
    assert mcpn("check", path).returncode == 0

    run = mcpn("causes", path, "--rates", "--json")
    assert run.returncode == 2
    found = json.loads(run.stdout)
    said = re.fullmatch(
        r"numbers of risk: not computed: section convoy has ([0-9,]+) states: "
        r"numbers of risk list every state, the limit is 50,000 \(--max-chain\)",
        found["no_risk"],
    )
    assert said
    assert found["mission"]["cut_sets"]
    assert run.stderr == f"error: {found['no_risk']}\n"

    assert mcpn("report", path, "-o", page).returncode == 0
    assert f"section convoy has {said[1]} states: numbers of risk list every state" in page.read_text()


def test_the_states_that_are_too_many_are_counted(tmp_path: Path) -> None:
    """The mission is one section: its states are those that another engine counts of the whole net."""
    path = tmp_path / "m.xml"
    path.write_text(convoy(4))
    run = mcpn("causes", path, "--rates", "--max-chain", "1000", "--engine", "local")
    states = output("alternatives", path, "--engine", "symbolic")["states"]
    assert f"not computed: section convoy has {states:,} states" in run.stderr


def test_without_scipy_what_needs_it_names_its_extra_and_the_rest_is_answered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "m.xml"
    path.write_text(TIMED)
    known = output("causes", path, "--rates")["risk"]
    for name in ("factors", "ends_by_time", "linear_systems", "risk"):
        monkeypatch.delitem(sys.modules, f"mcpn.answers.causes.{name}", raising=False)
    for name in ("scipy", "scipy.linalg", "scipy.sparse", "scipy.sparse.linalg"):
        monkeypatch.setitem(sys.modules, name, None)
    assert output("causes", path, "--rates")["risk"] == known
    run = mcpn("causes", path, "--rates", "--within", "PT1H")
    said = "numbers of risk: not computed: this needs scipy: pip install 'mcpn[risk]'"
    assert (run.returncode, run.stderr) == (2, f"error: {said}\n")
    monkeypatch.setattr("mcpn.answers.causes.linear_systems.MOST_TOGETHER", 0)
    page = tmp_path / "page.html"
    assert mcpn("report", path, "-o", page).returncode == 0
    assert "No numbers of risk: this needs scipy" in page.read_text()


def test_events_without_a_rate_are_named(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    event, handler = '<event name="leak"/></robot>', '<on event="leak" goto="fail"/><objective'
    path.write_text(TIMED.replace("</robot>", event).replace("<objective", handler, 1))
    assert output("causes", path, "--rates")["risk"]["unrated"] == ["leak"]
    assert "leak has no rate, and never happens in these numbers." in mcpn("causes", path, "--rates").stdout
    path.write_text(path.read_text().replace('"leak"/>', '"leak" rate="0.5"/>', 1))
    found = output("causes", path, "--rates")["risk"]
    # It ends at 0.5 per hour, the resource fails at 0.25, it leaks at 0.5.
    assert (found["success"], found["unrated"]) == (pytest.approx(0.4), [])
    assert "no rate" not in mcpn("causes", path, "--rates").stdout


def test_moments_of_events_are_named_where_one_objective_is_asked(tmp_path: Path) -> None:
    """The event is critical while another objective runs, too: that one is named though it is not asked."""
    (tmp_path / "m.xml").write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="h"/>'
        '<event name="storm"/><activity name="go" consumes="h"/><activity name="rest"/></robot>'
        '<objective name="a" activities="rest"><on event="storm" goto="fail"/></objective>'
        '<objective name="b" activities="go"/></mission>'
    )
    lines = mcpn("causes", tmp_path / "m.xml", "--objective", "b").stdout.splitlines()
    assert "  storm can leave no way to success without a repair, while a runs." in lines
