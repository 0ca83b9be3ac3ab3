"""What people read: whole names, bounded lines, colours only where they are wanted, nothing said twice."""

from __future__ import annotations

import fcntl
import logging
import os
import pty
import re
import struct
import subprocess
import sys
import termios
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mcpn.answers.causes.find import find_causes
from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.verdicts.mission import check
from mcpn.answers.verdicts.modes import Mode
from mcpn.composite.composite import CompositeSpace
from mcpn.composite.section_type import SectionType
from mcpn.drawing.compose import MissionNet, compose
from mcpn.findings import findings
from mcpn.mission.model import Mission, Objective
from mcpn.mission.xml import read_mission
from mcpn.report.failures.terminal import print_fmeca
from mcpn.report.progress import exploring, listening
from mcpn.report.terminal import LEAST_WIDTH, Terminal, plain
from mcpn.report.words import modes_in_words, modes_together
from mcpn.spaces.engine_names import SPACE_ENGINES, Engine
from mcpn.steps import Doing, WorkStep, step, tell
from tests.commands import mcpn, output
from tests.conftest import ROOT, ULYSSE
from tests.small import activity, hw, mission, robot

WORDS = st.lists(st.text(st.characters(codec="utf-8"), max_size=30), max_size=20).map(" ".join)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(text=WORDS, width=st.integers(1, 120), indent=st.integers(0, 9))
def test_lines_keep_to_the_width_unless_a_word_is_longer(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, text: str, width: int, indent: int
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    capsys.readouterr()
    Terminal().print(text, indent=indent)
    lines = capsys.readouterr().out.split("\n")[:-1]
    for line in lines:
        assert line.isprintable()
        assert len(line) <= max(width, LEAST_WIDTH) or len(line.split()) == 1
    assert " ".join(lines).split() == plain(text).split()


@pytest.mark.parametrize(
    "arguments", [["check"], ["causes"], ["states"], pytest.param(["compare"], marks=pytest.mark.slow)]
)
def test_reports_fit_80_columns_and_break_no_name(
    arguments: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    narrow = mcpn(*arguments, ULYSSE).stdout
    monkeypatch.delenv("COLUMNS")
    wide = mcpn(*arguments, ULYSSE).stdout
    assert max(map(len, narrow.splitlines())) <= 80
    names = {word.strip("():;,") for word in wide.split() if "_" in word}
    assert names <= {word.strip("():;,") for word in narrow.split()}
    assert "\x1b" not in narrow + wide


def test_modes_that_read_the_same_are_said_once(tmp_path: Path) -> None:
    """The other branch's driver runs or not, which nothing printed shows; a program sees both."""
    text = """<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">
    <hardware name="lidar"/><hardware name="camera"/><software name="scan"/><software name="image"/>
    <activity name="scanning" produces="scan" consumes="lidar"/>
    <activity name="seeing" produces="image" consumes="camera"/>
    <activity name="follow"><alternative name="by_image" consumes="image"/>
    <alternative name="by_scan" consumes="scan"/></activity>
    <activity name="count"><alternative name="on_scan" consumes="scan"/>
    <alternative name="on_image" consumes="image"/></activity>
    </robot>
    <parallel name="both"><objective name="x" activities="follow"/>
    <objective name="y" activities="count"/></parallel>
    </mission>"""
    path = tmp_path / "m.xml"
    path.write_text(text)
    found = check(compose(read_mission(path)))
    assert len(found.modes["x"]) > 2
    assert modes_in_words(found.modes["x"]) == ("follow: by_image", "follow: by_scan")
    printed = mcpn("check", path).stdout
    assert printed.count("follow: by_image") == printed.count("follow: by_scan") == 1


def test_modes_of_objectives_that_are_alike_are_put_in_words_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are one list, which may have 65,536 modes."""
    found, said = check(compose(legs(6)), engine="local"), list[int]()

    def counted(modes: list[Mode]) -> tuple[str, ...]:
        said.append(id(modes))
        return modes_in_words(modes)

    monkeypatch.setattr("mcpn.report.words.modes_in_words", counted)
    (ways,) = modes_together(found).values()
    assert len(ways) == 6
    assert len(said) == len({*said}) <= 2  # the last leads to the end, and is of a type of its own


def legs(number: int) -> Mission:
    """Objectives of one activity, one after the other."""
    doing = activity("go", ("H",), ("G",))
    return mission(
        robot(hw("H", "G"), doing), *(Objective(name=f"o{i}", activities=("go",)) for i in range(number))
    )


def test_the_same_is_not_said_for_each_event() -> None:
    told = mcpn("causes", ULYSSE).stdout
    assert told.count("from any section on") == 1  # what is survived
    assert told.count("at any moment") == 1  # what is critical
    assert told.count("GPS_sensor and IMU_sensor") <= 6


def on_a_terminal(environment: dict[str, str], *arguments: str) -> str:
    """What a command writes on a terminal of 80 columns."""
    leader, follower = pty.openpty()
    fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    command = [sys.executable, "-m", "mcpn.cli", *arguments]
    kept = {key: value for key, value in os.environ.items() if key not in ("COLUMNS", "NO_COLOR")}
    with subprocess.Popen(
        command, stdout=follower, stderr=follower, env={**kept, "TERM": "xterm", **environment}
    ):
        os.close(follower)
        written = b""
        while True:
            try:
                part = os.read(leader, 65536)
            except OSError:  # the last writer has gone
                break
            if not part:
                break
            written += part
    os.close(leader)
    return written.decode()


def test_colours_are_for_terminals_that_want_them() -> None:
    assert "\x1b[32m" in on_a_terminal({}, "check", str(ULYSSE))
    for unwanted in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
        told = on_a_terminal(unwanted, "check", str(ULYSSE))
        assert "The mission can succeed." in told
        assert "\x1b[3" not in told
        # Where it is slow, a line of progress is shown and wiped.
        assert max(len(line) for line in told.replace("\x1b[K", "").splitlines()) <= 80


def test_progress_is_shown_on_a_terminal_and_wiped(tmp_path: Path) -> None:
    # 2^22 states and 22 times as many firings take seconds.
    lines = ["net big", *(f"pl a{i} (1)\ntr t{i} a{i} -> b{i}\ntr u{i} b{i} -> a{i}" for i in range(22))]
    (tmp_path / "big.net").write_text("\n".join(lines) + "\n")
    told = on_a_terminal({}, "states", str(tmp_path / "big.net"), "--engine", "explicit")
    assert "states a second" in told
    assert "\r\x1b[K" in told
    assert "\x1b[K" not in on_a_terminal({"TERM": "dumb"}, "states", str(ULYSSE))


def test_how_far_an_exploration_is() -> None:
    assert exploring(1000, 5000, 2.0) == "1,000 states, 5,000 edges, 500 states a second, 2 s"


def test_the_step_that_is_announced_is_named_and_how_far_it_is() -> None:
    with listening() as heard:
        assert heard.line() == "reading, 0 s; 0 s in all"
        step(Doing.EXPLORING, section="dive", number=1, total=2)
        assert heard.line() == "exploring section dive (type 1 of 2), 0 s; 0 s in all"
        tell(7, 9)
        assert heard.line().startswith("exploring section dive (type 1 of 2): 7 states, 9 edges, ")
        step(Doing.PROVING_SECTION, section="dive")  # of which nothing has been told
        assert heard.line() == "proving section dive confluent, 0 s; 0 s in all"
    tell(8, 10)
    assert heard.explored == (0, 0)


@pytest.mark.parametrize("engine", SPACE_ENGINES)
def test_every_engine_announces_its_steps(
    engine: Engine, ulysse_net: MissionNet, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.INFO, "mcpn.steps"):
        found = check(ulysse_net, engine=engine)
    steps = [record.getMessage() for record in caplog.records]
    announced = [record.args[0] for record in caplog.records if isinstance(record.args, tuple)]
    assert [s.question for s in announced if isinstance(s, WorkStep) and s.doing is Doing.DECIDING] == [
        "nominal_success",
        "deadlock_free",
        "success_reachable",
        "can_always_finish",
        "failure_reachable",
    ]
    assert "finding the functioning modes" in steps
    assert "looking for a run that decides can_always_finish" in steps
    proving = "proving that each event has one outcome"
    making = {
        "explicit": [f"listing the stable states, and {proving}"],
        "symbolic": ["making a diagram of all markings", proving],
    }
    if engine != "local":
        assert steps[: len(making[engine])] == making[engine]
        return
    assert isinstance(found.alternatives, CompositeSpace)
    types: dict[SectionType, str] = {}
    for name, placed in found.alternatives.sections.items():
        types.setdefault(placed.type, name)
    count = len(types)
    numbered = [f"exploring section {name} (type {i} of {count})" for i, name in enumerate(types.values(), 1)]
    assert [s for s in steps if s.startswith("exploring")] == numbered
    proved = {s for s in steps if s.startswith("proving")}
    assert proved == {f"proving section {name} confluent" for name in types.values()}


def test_a_report_tells_what_it_prepares(caplog: pytest.LogCaptureFixture) -> None:
    """Each part is a step, and no local graph is listed past the last."""
    with caplog.at_level(logging.INFO, "mcpn.steps"):
        findings(compose(read_mission(ULYSSE)), engine="local")
    steps = [each for record in caplog.records for each in record.args or () if isinstance(each, WorkStep)]
    assert [each.question for each in steps if each.doing is Doing.PREPARING] == [
        "verdicts",
        "causes",
        "the FMECA table",
        "controller",
        "local graphs",
        "claims",
    ]
    listed = [(each.number, each.total) for each in steps if each.doing is Doing.LISTING_SECTION]
    assert listed == [(1, 2), (2, 2)]


def test_a_width_is_asked_for() -> None:
    """Every command keeps to it, said before it or after it; names are never broken."""
    for command in (["check", str(ULYSSE)], ["simulate", str(ULYSSE), "--random", "3"]):
        narrow, wide = (mcpn("--width", width, *command).stdout for width in ("60", "200"))
        assert any(60 < len(line) <= 200 for line in wide.splitlines())
        after = mcpn(*command, "--width", "60").stdout
        assert re.sub(r"[0-9.]+ s\n", "", after) == re.sub(r"[0-9.]+ s\n", "", narrow)
        names = [line for line in narrow.splitlines() if len(line) > 60]
        assert all(" " not in line.strip() for line in names)
        words = ([w.strip("()") for w in re.sub(r"[0-9.]+ s\n", "", text).split()] for text in (narrow, wide))
        assert next(words) == next(words)
    assert mcpn("--width", "3", "check", ULYSSE).returncode == 2


def test_the_summary_stands_first() -> None:
    lines = mcpn("check", ULYSSE).stdout.splitlines()
    assert lines[:2] == ["mission ulysse", "all required verdicts hold, and 5 of 6 requirements are met"]


def test_rounds_are_folded_in_causes() -> None:
    """Each objective of the drone stands in what is printed, by itself or among its rounds."""
    text = mcpn("causes", ROOT / "experiments" / "drone" / "mission.xml").stdout
    assert "stock.leave (all 3)" in text
    causes, _, effects = text.partition("\nif lidar fails\n")
    assert "stock_A1.leave, stock_A2.leave" not in causes
    assert (
        "during stock_A1.approach_try2, stock_A2.approach_try2, stock_A1.leave, stock_A2.leave\n" in effects
    )
    assert "during stock.film (all 3)" in text


@pytest.mark.parametrize("name", ["glider", "courier"])
def test_what_a_loss_does_is_said_once_for_all_rounds(
    name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each objective stands in one group of each hardware, with the severity of its row of the table."""
    monkeypatch.setenv("COLUMNS", "100000")
    causes = find_causes(compose(read_mission(ROOT / "experiments" / name / "mission.xml")))
    rows = fmeca(causes.prospects)
    capsys.readouterr()
    print_fmeca(rows, causes.mission_net)
    lines, copies = capsys.readouterr().out.splitlines(), causes.mission_net.graph.copies
    said: dict[tuple[str, str], str] = {}
    hardware = ""
    for line, severity in pairwise(lines):
        if match := re.fullmatch(r"if (.*) fails", line):
            hardware = match[1]
        elif (names := line.strip().removeprefix("during ")) != line.strip() and "all others" not in names:
            for whole, left in re.findall(r"([\w.]+)(?: \(all \d+(?: but ([^)]*))?\))?(?:, |$)", names):
                out = {each for one in left.split(", ") if one for each in copies.meant(one)}
                for objective in copies.meant(whole):
                    if objective not in out:
                        assert (hardware, objective) not in said, line
                        said[hardware, objective] = severity.strip().partition(";")[0]
    told = {(row.hardware, row.objective): row.severity.words for row in rows}
    assert {pair: said.get(pair, "no effect") for pair in told} == told
    assert said.keys() <= told.keys()
    assert not any("; in " in line and line.count(part) > 1 for line in lines for part in line.split("; "))


def test_causes_name_no_round_by_itself_that_is_like_the_others() -> None:
    """What a mission of five alike rounds survives, and when: no list of forty names."""
    text = mcpn("causes", ROOT / "experiments" / "glider" / "mission.xml").stdout
    assert "tooth.report (all 15 but tooth_5.report)" in text
    assert max(map(len, text.splitlines())) < 600
    assert text.count("The failure of any one of ") == 2
    assert "at any moment, but not while one of rescue, call and drift runs" in text


def test_hardware_that_is_never_used_is_named() -> None:
    text = mcpn("causes", ROOT / "experiments" / "courier" / "mission.xml").stdout
    assert "odometer is never used, so that its loss costs nothing by itself.\n" in text
    assert "never used" not in mcpn("causes", ULYSSE).stdout


def test_events_are_listed_in_words_with_their_identifiers() -> None:
    lines = mcpn("simulate", ULYSSE, "--random", 0).stdout.splitlines()
    assert any(re.fullmatch(r" +[0-9]  mission ulysse starts  .MISSION_EV_START.", line) for line in lines)
    assert any(re.fullmatch(r" +[0-9]  GPS_sensor fails  .GPS_sensor_EV_OOS.", line) for line in lines)


def test_a_walk_at_random_starts_and_mostly_succeeds() -> None:
    ends = [output("simulate", ULYSSE, "--random", 60, "--seed", seed) for seed in range(5)]
    assert all(end["steps"][0]["event"] == "MISSION_EV_START" or len(end["steps"]) > 1 for end in ends)
    assert sum(end["outcome"] == "success" for end in ends) >= 2


def test_what_defeats_a_mission_that_nothing_helps_comes_first(tmp_path: Path) -> None:
    """Of a mission that a rescue alone saves, that all hardware may fail reassures."""
    (tmp_path / "m.xml").write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="motor"/>'
        '<event name="rescue"/><activity name="drive" consumes="motor"/><activity name="wait"/></robot>'
        '<objective name="go" activities="drive" failure="go" success="succeed">'
        '<on event="rescue" goto="towed"/></objective>'
        '<objective name="towed" activities="wait" failure="towed"/></mission>'
    )
    told = mcpn("causes", tmp_path / "m.xml").stdout.splitlines()
    assert told[:2] == [
        "The loss of motor before the start, not repaired, leaves no way to success without the help of "
        "rescue.",
        "The mission has no abort, so that nothing says which of its failures are safe.",
    ]
    assert "what the mission survives, with the help of rescue" in told
    assert "the help of" not in mcpn("causes", ULYSSE).stdout
