"""Producers that one branch gives up while another begins to use them: all that play such missions agree."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mcpn.drawing.compose import compose
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.mission.model import Block, Handler, Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Activity, Alternative, Fact, FactChange
from mcpn.testing.judge.interpreter import FAILURE, Happening
from tests.judge.lockstep import Judge
from tests.judge.test_abort import BEGIN
from tests.judge.test_interpreter import back, mode, ok, out
from tests.small import activity, hw, mission, robot

DARK = FactChange(fact="dark", to="true")


def requiring(name: str, *ways: tuple[str, tuple[str, ...], tuple[str, ...]]) -> Activity:
    """An activity with alternatives by name, what each consumes, and what it requires."""
    drawn = (Alternative(name=way, consumes=consumes, requires=words) for way, consumes, words in ways)
    return Activity(name=name, alternatives=tuple(drawn))


def over(*activities: Activity, blocks: tuple[Block, ...]) -> Mission:
    """A parallel block whose branches share the position; it may be dark."""
    position = activity("locate", ("gps",), ("imu",), produces=("position",))
    of = robot(hw("gps", "imu"), position, *activities, events=("leak",))
    return mission(replace(of, facts=(Fact(name="dark"),)), Parallel(name="both", blocks=blocks))


def series(*blocks: Block) -> Recursive:
    return Recursive(name="way", blocks=blocks)


FILM = requiring("film", ("by_day", ("position",), ("!dark",)))
FIRST = Objective(name="first", activities=("drive",), sets=(DARK,))
SECOND = Objective(name="second", activities=("drive",))
WATCH = Objective(name="watch", activities=("film",))
DRIVE = activity("drive", ("position",))

GIVEN_UP = over(DRIVE, FILM, blocks=(series(FIRST, SECOND), WATCH))
ANOTHER = over(
    DRIVE,
    FILM,
    activity("return", ("position",)),
    blocks=(series(FIRST, replace(SECOND, activities=("return",))), WATCH),
)
LEFT = over(
    DRIVE,
    requiring("film", ("by_day", ("position",), ("!dark",)), ("blind", (), ())),
    blocks=(series(FIRST, SECOND), WATCH),
)
NOT_NEEDED = over(
    DRIVE, FILM, activity("rest", ()), blocks=(series(FIRST, replace(SECOND, activities=("rest",))), WATCH)
)
ON_START = over(
    DRIVE,
    FILM,
    blocks=(series(replace(FIRST, sets=()), replace(SECOND, sets=(replace(DARK, on="start"),))), WATCH),
)
ON_A_LEAK = over(
    DRIVE,
    FILM,
    blocks=(
        series(
            replace(FIRST, handlers=(Handler(event="leak", goto="second"),)),
            replace(SECOND, sets=(replace(DARK, on="start"),)),
        ),
        WATCH,
    ),
)
ALONE = over(DRIVE, activity("film", ()), blocks=(series(FIRST, SECOND), WATCH))
MISSIONS = {
    "given up": GIVEN_UP,
    "another activity": ANOTHER,
    "left for another alternative": LEFT,
    "not needed": NOT_NEEDED,
    "on start": ON_START,
    "on a leak": ON_A_LEAK,
    "alone": ALONE,
}
SPARE: tuple[Happening, ...] = (out("gps"), BEGIN, back("gps"))
"""The position comes from the IMU, though the GPS is in service again."""


@pytest.mark.parametrize("name", MISSIONS)
def test_everybody_plays_it_alike(name: str) -> None:
    assert Judge(MISSIONS[name]).judge().kind == "agree"


@pytest.mark.parametrize("name", MISSIONS)
def test_the_compact_set_draws_the_same(name: str) -> None:
    of = MISSIONS[name]
    assert Judge(of).judge(compose(of, CompactTemplates())).kind == "agree"


@pytest.mark.parametrize("name", ["given up", "another activity", "left for another alternative", "on start"])
def test_it_goes_on_for_what_begins(name: str) -> None:
    assert mode(MISSIONS[name], *SPARE, ok("first"))["locate"] == "locate_1"


def test_it_stops_where_nobody_needs_it() -> None:
    assert "locate" not in mode(NOT_NEEDED, *SPARE, ok("first"))


def test_it_begins_anew_where_nobody_beside_needed_it() -> None:
    assert mode(ALONE, *SPARE, ok("first"))["locate"] == "locate_0"
    ended = (*SPARE, (FAILURE, "watch"))
    assert mode(GIVEN_UP, *ended, ok("first"))["locate"] == "locate_0"


@pytest.mark.parametrize("name", MISSIONS)
def test_only_where_a_branch_may_give_it_up_is_it_kept(name: str) -> None:
    of = compose(MISSIONS[name])
    assert of.usage.sharing.kept("locate") is (name != "alone")
    assert ("MISSION_resting" in of.net.place_index) is (name != "alone")
