"""The worked courier: its facts, the routes that they ask for, and what fails with others."""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.testing.judge import lockstep
from mcpn.testing.judge.interpreter import Seen
from mcpn.testing.judge.lockstep import happening
from tests.conftest import ROOT
from tests.judge.lockstep import Judge
from tests.judge.players import graphs

COURIER = ROOT / "experiments" / "courier"
OPEN = '<route when="drawer=open" goto="fail" on="failure"/>'
BEFORE = """<on event="called_back" goto="home" once="true"/>
  <objective name="rounds" failure="home">
    <on event="alarm" goto="clear_the_way"/>
    <each name="ground_floor" parameter="room" in="12 14">
      <use name="ground" protocol="deliver" failure="succeed"/>
    </each>
    <use name="up" protocol="call_at_lift"/>
    <objective name="ride_up" activities="drive"><sets fact="floor" to="1" on="start"/></objective>
    <each name="first_floor" parameter="room" in="112 113">
      <use name="first" protocol="deliver" failure="succeed"/>
    </each>
    <use name="down" protocol="call_at_lift"/>
    <objective name="ride_down" activities="drive"><sets fact="floor" to="0"/></objective>
  </objective>
  <objective name="home" activities="drive" retries="3" success="succeed"/>
  <objective name="clear_the_way" activities="pull_over" success="home"/>
</mission>
"""
"""The routes that it had before it had facts."""


@dataclass
class Files:
    """The courier's files, copied, so that a test may change them."""

    folder: Path

    def sub(self, name: str, pattern: str, by: str) -> None:
        """Changes what a pattern finds in one file, which must be something."""
        file = self.folder / f"{name}.xml"
        text, count = re.subn(pattern, by, file.read_text(), flags=re.DOTALL)
        assert count
        file.write_text(text)

    def small(self) -> Mission:
        """One room on each floor, one try, two resources that fail: all that play it can be compared."""
        self.sub("mission", r'in="12 14"', 'in="12"')
        self.sub("mission", r'in="112 113"', 'in="112"')
        for name in ("mission", "protocols"):
            self.sub(name, r' retries="\d"', "")
        self.sub("robot", r'(<hardware name="(depth_camera|odometer|wheels|radio)")', r'\1 faulty="false"')
        return self.read()

    def read(self) -> Mission:
        return read_mission(self.folder / "mission.xml")


@pytest.fixture
def files(tmp_path: Path) -> Files:
    for path in COURIER.glob("*.xml"):
        shutil.copy(path, tmp_path)
    return Files(tmp_path)


def as_it_was(files: Files) -> None:
    files.sub("mission", r'<on event="called_back".*', BEFORE)
    files.sub("protocols", r' success="succeed" failure="take_back"', "")
    files.sub("protocols", r'<objective name="take_back".*?</objective>', "")


def left_out_open(files: Files) -> None:
    files.sub("mission", OPEN, "")


def without_the_lift(files: Files) -> None:
    files.sub("mission", 'when="floor=0"', 'when="drawer=closed"')


def home_at_once(files: Files) -> None:
    files.sub("mission", 'name="shut"', 'name="shut" failure="down"')


def wrong(seen: Seen) -> set[str]:
    """The requirements on facts that a state violates, from what is seen of it."""
    facts = dict(seen.facts)
    home = any(re.match(r"home(_try\d)?$", name) for name in seen.running)
    arrived = facts["floor"] == "0" and facts["drawer"] == "closed"
    return {
        *({"drawer_closed"} if facts["drawer"] == "open" and "drive" in dict(seen.mode) else ()),
        *({"by_lift"} if home and facts["floor"] != "0" else ()),
        *({"back"} if seen.outcome == "success" and not arrived else ()),
    }


def test_all_that_play_it_agree(files: Files) -> None:
    verdict = Judge(files.small()).judge()
    assert verdict.kind == "agree"
    assert {"explicit", "symbolic", "local", "modular controller"} <= verdict.pairs.keys()


@pytest.mark.slow
def test_the_interpreter_has_the_states_of_the_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    """The stable states in papers/mcpn.md; those between start and end are the flat controller's in docs/."""
    monkeypatch.setattr(lockstep, "MOST_STATES", 10_000)
    mission = read_mission(COURIER / "mission.xml")
    judge = Judge(mission)
    assert judge.explore()
    explicit = next(player for who, player in graphs(compose(mission), 10_000) if who == "explicit")
    assert judge.lockstep("explicit", explicit) == len(judge.states) == 8528
    assert sum(state.begun and state.outcome is None for state in judge.states) == 7824


@pytest.mark.parametrize(
    ("change", "violated"),
    [
        (None, set()),
        (as_it_was, {"drawer_closed", "by_lift", "back"}),
        (left_out_open, {"drawer_closed"}),
        (without_the_lift, {"by_lift", "back"}),
        (home_at_once, {"drawer_closed", "back"}),
    ],
)
def test_the_interpreter_finds_what_the_requirements_find(
    change: object, violated: set[str], files: Files
) -> None:
    if callable(change):
        change(files)
    mission = files.small()
    judge = Judge(mission)
    assert judge.explore()
    interpreter = judge.interpreter
    found = {name for state in judge.states for name in wrong(interpreter.seen(state))}
    assert found == violated
    checked = check(compose(mission), engine="local")
    unmet = {a.asked.name: a for a in checked.requirements if not a.met and a.required}
    assert unmet.keys() == violated
    assert checked.passed is not bool(violated)
    for name, answer in unmet.items():
        state = interpreter.initial
        assert answer.witness is not None
        for edge in answer.witness.steps:
            event = checked.mission_net.net.transitions[edge.transition].event
            state = interpreter.after(state, happening(event))
        assert name in wrong(interpreter.seen(state))
