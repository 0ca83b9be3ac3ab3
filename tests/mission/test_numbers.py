"""Rates, durations and probabilities of the mission language."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given

from mcpn.errors import InputError
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot
from mcpn.mission.validate import find_errors
from mcpn.mission.writer import save_mission
from mcpn.mission.xml import read_mission
from mcpn.testing import missions

TEXT = """<mission name="m" xmlns="urn:mcpn:mission:1">
<robot name="r">
<hardware name="H" failure_rate="2.5e-4" repair_rate="1"/>
<hardware name="free" faulty="false"/>
<activity name="go" consumes="H"/>
<event name="leak" rate="0.01"/>
<event name="call"/>
</robot>
<objective name="x" activities="go" duration="0.5" failure_probability="0.125"/>
<objective name="y" activities="go"/>
</mission>
"""


def read(tmp_path: Path, text: str) -> Mission:
    (tmp_path / "m.xml").write_text(text)
    return read_mission(tmp_path / "m.xml")


def test_numbers_are_read(tmp_path: Path) -> None:
    mission = read(tmp_path, TEXT)
    known, free = mission.hardware
    assert (known.failure_rate, known.repair_rate) == (0.00025, 1.0)
    assert (free.failure_rate, free.repair_rate) == (None, None)
    assert [(e.name, e.rate) for e in mission.events] == [("leak", 0.01), ("call", None)]
    x, y = flatten(mission).walk()
    assert (x.duration, x.failure_probability) == (0.5, 0.125)
    assert (y.duration, y.failure_probability) == (None, 0.0)


@given(missions(numbers=True, text=True))
def test_numbers_survive_the_round_trip(tmp_path_factory: pytest.TempPathFactory, written: Mission) -> None:
    assert find_errors(written) == []
    path = tmp_path_factory.mktemp("round") / "mission.xml"
    save_mission(written, path)
    assert read_mission(path) == written


@pytest.mark.parametrize(
    ("found", "instead", "line", "message"),
    [
        ('"2.5e-4"', '"-1"', 3, "failure_rate of <hardware> is '-1', expected a decimal number"),
        ('"2.5e-4"', '"nan"', 3, "expected a decimal number"),
        ('"2.5e-4"', '"1e999"', 3, "failure_rate of H is inf, expected a finite number per hour"),
        ('faulty="false"', 'faulty="false" failure_rate="1"', 4, "though it cannot fail"),
        ('"0.01"', '"-1"', 6, "rate of <event> is '-1', expected a decimal number"),
        ('"0.01"', '"1e999"', 6, "rate of leak is inf, expected a finite number per hour, at least 0"),
        ('"0.5"', '"0"', 9, "duration of x is 0, expected a finite number of hours above 0"),
        ('"0.5"', '"half an hour"', 9, "expected a decimal number"),
        ('"0.125"', '"1.5"', 9, "failure_probability of x is 1.5, expected a number from 0 to 1"),
        (
            'activities="go"/>',
            'duration="1"><objective name="z" activities="go"/></objective>',
            10,
            "elementary",
        ),
    ],
)
def test_broken_numbers_are_told_with_their_line(
    tmp_path: Path, found: str, instead: str, line: int, message: str
) -> None:
    assert found in TEXT
    with pytest.raises(InputError) as caught:
        read(tmp_path, TEXT.replace(found, instead))
    told = [(p.source.line, p.message) for p in caught.value.problems if p.source]
    assert [m for where, m in told if where == line and message in m], caught.value


@pytest.mark.parametrize("wrong", [-1.0, math.inf, math.nan])
def test_numbers_of_missions_built_in_python_are_checked(wrong: float) -> None:
    hardware = Hardware(name="H", failure_rate=1.0, repair_rate=2.0)
    go = Activity(name="go", alternatives=(Alternative(name="go", consumes=("H",)),))
    objective = Objective(name="x", activities=("go",), duration=1.0, failure_probability=0.5)

    def problems(h: Hardware, o: Objective) -> list[str]:
        robot = Robot(name="r", hardware=(h,), activities=(go,))
        return [p.message for p in find_errors(Mission(name="m", robots=(robot,), blocks=(o,)))]

    assert problems(hardware, objective) == []
    for h in (replace(hardware, failure_rate=wrong), replace(hardware, repair_rate=wrong)):
        assert len(problems(h, objective)) == 1
    for o in (replace(objective, duration=wrong), replace(objective, failure_probability=wrong)):
        assert len(problems(hardware, o)) == 1


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("90", 90.0),
        (" 0.5 ", 0.5),
        ("1e3", 1_000.0),
        ("PT1M30S", 90.0),
        ("PT0.25S", 0.25),
        ("PT2H", 7_200.0),
        ("PT1H1M1S", 3_661.0),
        ("P1DT12H", 129_600.0),
        ("P2W", 1_209_600.0),
    ],
)
def test_timeouts_are_seconds_or_durations_of_iso_8601(tmp_path: Path, text: str, seconds: float) -> None:
    timed = f'<objective name="y" activities="go" timeout="{text}" timeout_goto="succeed"/>'
    mission = read(tmp_path, TEXT.replace('<objective name="y" activities="go"/>', timed))
    y = mission.blocks[1]
    assert isinstance(y, Objective)
    assert (y.timeout, y.timeout_goto) == (seconds, "succeed")
    save_mission(mission, tmp_path / "again.xml")
    assert read_mission(tmp_path / "again.xml") == mission


@pytest.mark.parametrize("text", ["P", "PT", "P1M", "P1Y", "PT1M1H", "P1DT", "PT1.5M", "-5", "p1d", "1 m"])
def test_other_texts_are_no_timeout(tmp_path: Path, text: str) -> None:
    timed = f'<objective name="y" activities="go" timeout="{text}"/>'
    with pytest.raises(InputError, match=r"m\.xml:10: timeout of <objective> is"):
        read(tmp_path, TEXT.replace('<objective name="y" activities="go"/>', timed))
