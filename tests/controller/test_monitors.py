"""Monitors: their verdicts against LTL3 by its definition, in Python, in C, beside a controller, on logs."""

from __future__ import annotations

import json
import random
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from hypothesis import event, example, given
from hypothesis import strategies as st

from mcpn.controller.monitors.merging import merged
from mcpn.controller.monitors.writing import files, monitors_of
from mcpn.robot.runtime import Controller, ControllerFileError, Decision, Journal, Monitors, Refused
from mcpn.robot.runtime.__main__ import main
from mcpn.robot.runtime.file_schema import digest_of
from mcpn.study import open_study
from tests.commands import mcpn, output
from tests.conftest import ROOT
from tests.controller import ltl3

COURIER = ROOT / "experiments" / "courier" / "mission.xml"
SURVEY = """<mission xmlns="urn:mcpn:mission:1" name="survey">
  <robot name="boat">
    <hardware name="camera"/>
    <activity name="film"><alternative name="film" consumes="camera"/></activity>
    <activity name="move"/>
  </robot>
  <requirement name="sees" severity="advice"><absence of="oos(camera)" after="objective(see)"/></requirement>
  <requirement name="comes" severity="advice"><visit in="come see"/></requirement>
  <requirement name="works" severity="advice" fair="true" formula="G F available(camera)"/>
  <requirement name="after" severity="advice"
    formula="G (happens(camera_EV_OOS) -> X !happens(camera_EV_RD))"/>
  <requirement name="could" severity="advice" formula="EF failure"/>
  <requirement name="ends" expected="fails" formula="G !success"/>
  <objective name="come" activities="move"/>
  <objective name="see" activities="film"/>
</mission>
"""
START, LOST, BACK = "MISSION_EV_START", "camera_EV_OOS", "camera_EV_RD"
COME, SEE = "OBJ_come_EV_OK", "OBJ_see_EV_OK"


@given(ltl3.formulas())
@example("(G (p | !p))")  # what cannot be violated is known at once
def test_verdicts_are_those_of_ltl3(text: str) -> None:
    expected = ltl3.by_definition(text)
    for word, value in ltl3.by_monitor(text):
        assert value == expected[word], (text, word)
    event(", ".join(sorted(set(expected.values()))))


@given(st.data())
def test_merged_machines_say_the_same_after_each_run_that_may_be(data: st.DataObject) -> None:
    states = data.draw(st.integers(1, 8))
    values = data.draw(st.lists(st.sampled_from("vso"), min_size=states, max_size=states))
    move = st.dictionaries(st.sampled_from("abc"), st.integers(0, states - 1))
    moves = data.draw(st.lists(move, min_size=states, max_size=states))
    fewer, short = merged(values, moves)
    assert len(fewer) == len(short) <= states
    seen, queue = {(0, 0)}, [(0, 0)]
    for one, other in queue:
        assert values[one] == fewer[other]
        for event_, target in moves[one].items():
            if (pair := (target, short[other].get(event_, other))) not in seen:
                seen.add(pair)
                queue.append(pair)
    event(f"smaller by {states - len(fewer)}")


def test_states_that_only_impossible_events_tell_apart_are_one() -> None:
    # s says yes behind b alone; where b may not be, nobody has to know.
    chain = ["no"] * 5 + ["yes"]
    moves = [{"a": 1}, {"a": 2}, {"a": 3}, {"a": 4}, {"b": 5}, {}]
    assert merged(chain, moves) == (["no", "yes"], [{"b": 1}, {}])
    # a after a says yes: how many there were is to be known.
    assert len(merged(["no", "no", "yes"], [{"a": 1}, {"a": 2}, {}])[0]) == 3


@pytest.fixture(scope="module")
def survey(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a mission, its monitors and its controller."""
    folder = tmp_path_factory.mktemp("survey")
    (folder / "survey.xml").write_text(SURVEY)
    assert mcpn("monitor", folder / "survey.xml", "-o", folder).returncode == 0
    assert mcpn("controller", folder / "survey.xml", "-o", folder).returncode == 0
    return folder


def test_the_event_that_violates_is_named(survey: Path) -> None:
    found: list[Decision] = []
    monitors = Monitors.load(survey / "monitors.json", on_found=found.append)
    assert set(monitors.values.values()) == {"open"}
    assert "could" not in monitors.values
    assert monitors.take(START) == ()
    assert [f.requirement for f in monitors.take(COME)] == ["comes"]
    (finding,) = monitors.take(LOST)
    assert (finding.requirement, finding.value, finding.number, finding.event) == (
        "sees",
        "violated",
        3,
        LOST,
    )
    assert "From the first moment on at which see runs" in finding.words
    assert [f.requirement for f in monitors.take(BACK)] == ["after"]
    assert monitors.violated == ("sees", "after")
    assert monitors.findings == found
    assert monitors.take("nonsense") == ()
    assert monitors.unknown == [(5, "nonsense")]
    monitors.restart()
    assert [f.requirement for e in (START, COME, SEE) for f in monitors.take(e)] == ["comes", "ends"]
    assert monitors.values["ends"] == "satisfied"  # it is to fail: its negation is watched


def test_a_controller_says_what_its_mission_requires(survey: Path) -> None:
    document = json.loads((survey / "controller.json").read_text())
    said = {each.pop("name"): each for each in document["requirements"]}
    assert said["ends"] == {
        "formula": "G !success",
        "sentence": None,
        "description": None,
        "expected": "fails",
        "severity": "required",
    }
    assert said["comes"]["sentence"] == "The robot visits come and see."
    checked = {each["name"]: each for each in output("check", survey / "survey.xml")["requirements"]}
    assert {name: {key: checked[name][key] for key in of} for name, of in said.items()} == said


def test_a_controller_has_its_events_watched(survey: Path) -> None:
    monitors = Monitors.load(survey / "monitors.json")
    controller = Controller.load(survey / "controller.json", monitors=monitors)
    controller.handle(START)
    controller.handle(COME)
    state = monitors.state
    with pytest.raises(Refused):
        controller.handle(COME)  # is refused, and not watched
    assert monitors.count == 2
    controller.handle(LOST)
    assert monitors.violated == ("sees",)

    again = Monitors.load(survey / "monitors.json")
    again.resume(json.loads(json.dumps(state)))
    assert [(f.requirement, f.number) for f in again.take(LOST)] == [("sees", 3)]
    for broken in ({}, {**state, "sees": 99}, {**state, "": -1}, {**state, "sees": True}):
        with pytest.raises(ValueError, match="state"):
            again.resume(broken)


def test_logs_are_read(survey: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = survey / "robot.log"
    log.write_text(f"# dive 7\n12:00:01 {START}\n2. objective come succeeds  [{COME}]\n\n{LOST}\n")
    told = mcpn("monitor", survey / "survey.xml", "--log", log)
    assert told.returncode == 1
    assert "violated by event 3, camera_EV_OOS: sees: From the first moment" in told.stdout
    assert "could: not watched" in told.stdout
    found = output("monitor", survey / "survey.xml", "--log", log, code=1)
    assert found["log"]["values"]["sees"] == "violated"
    assert found["log"]["findings"][-1] == {
        "requirement": "sees",
        "value": "violated",
        "number": 3,
        "event": LOST,
    }
    assert main([str(survey / "monitors.json"), str(log)]) == 1
    assert "violated by event 3, camera_EV_OOS: sees" in capsys.readouterr().out
    log.write_text(f"{START}\nodd\n")
    told = mcpn("monitor", survey / "survey.xml", "--log", log)
    assert (told.returncode, told.stdout) == (2, "")
    assert f"{log}:2: 'odd' is no event of the mission" in told.stderr
    assert main([str(survey / "monitors.json"), str(log)]) == 2
    log.write_text(START)
    assert main([str(survey / "monitors.json"), str(log)]) == 0
    assert main([str(survey / "none.json")]) == 2
    assert main([]) == 2
    assert mcpn("monitor", survey / "survey.xml", "--log", survey / "none.log").returncode == 2
    assert mcpn("monitor", survey / "survey.xml").returncode == 2


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
@pytest.mark.parametrize("path", ["survey", pytest.param("courier", marks=pytest.mark.slow)])
def test_c_says_what_python_says(path: str, survey: Path, tmp_path: Path) -> None:
    texts = files(
        monitors_of(open_study(COURIER if path == "courier" else survey / "survey.xml").mission_spaces())
    )
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    (source,) = tmp_path.glob("*.c")
    prefix = source.stem.removesuffix("_monitors").upper()
    strict = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
    program = tmp_path / "program"
    subprocess.run(["gcc", *strict, f"-D{prefix}_READS_A_LOG", "-o", program, source], check=True)
    monitors = Monitors(json.loads(texts["monitors.json"]))
    chosen = random.Random(7)
    for _ in range(20):
        events = chosen.choices([*json.loads(texts["monitors.json"])["events"], "nonsense"], k=60)
        monitors.restart()
        expected = [list(monitors.values.values())]
        for each in events:
            monitors.take(each)
            expected.append(list(monitors.values.values()))
        run = subprocess.run([program], input="\n".join(events), capture_output=True, text=True, check=False)
        assert [line.split() for line in run.stdout.splitlines()] == expected
        assert run.returncode == bool(monitors.violated)
        assert len(run.stderr.splitlines()) <= sum(f.value == "violated" for f in monitors.findings)


@pytest.mark.parametrize(
    "change",
    [
        {"format": "other"},
        {"version": 1},
        {"monitors": [{"name": "r", "words": "", "values": [], "moves": []}]},
        {"monitors": [{"name": "r", "words": "", "values": [2], "moves": [[[99, 0]]]}]},
        {"monitors": [{"name": "r", "words": "", "values": [2], "moves": [[[0, 1]]]}]},
        {"monitors": [{"name": "r", "words": "", "values": [5], "moves": [[]]}]},
        {"monitors": 3},
        {"events": None},
    ],
)
def test_a_broken_file_is_an_error(change: dict[str, Any], survey: Path) -> None:
    document = json.loads((survey / "monitors.json").read_text())
    changed = {**document, **change}
    with pytest.raises(ControllerFileError):
        Monitors({**changed, "digest": digest_of(changed)})
    with pytest.raises(ControllerFileError, match="digest"):
        Monitors({**document, "mission": "other"})


def test_a_journal_is_a_log(survey: Path) -> None:
    """What the robot's own controller has written is read as it happened, refused events aside."""
    log = survey / "log.jsonl"
    controller = Controller.load(survey / "controller.json", on_refused=lambda refused: None)
    with log.open("w") as stream:
        journal = Journal(stream)
        controller.observe(journal)
        controller.handle(START)
        controller.handle(COME)
        controller.handle(COME)
        journal.resumed(controller.count)
        controller.handle(LOST)
    found = output("monitor", survey / "survey.xml", "--log", log, code=1)["log"]
    assert (found["events"], found["values"]["sees"]) == (3, "violated")
    log.write_text(log.read_text().replace(COME, LOST))
    told = mcpn("monitor", survey / "survey.xml", "--log", log)
    assert (told.returncode, told.stdout) == (2, "")
    assert f"{log}:2: the line has been changed" in told.stderr


def test_there_must_be_something_to_watch(tmp_path: Path) -> None:
    path = tmp_path / "survey.xml"
    begin, _, rest = SURVEY.partition("  <requirement")
    blocks = rest[rest.index("  <objective") :]
    path.write_text(begin + blocks)
    assert "has no requirements to watch" in mcpn("monitor", path, "-o", tmp_path).stderr
    path.write_text(f'{begin}  <requirement name="r" formula="EF success"/>\n{blocks}')
    assert "there is nothing to watch" in mcpn("monitor", path, "-o", tmp_path).stderr
