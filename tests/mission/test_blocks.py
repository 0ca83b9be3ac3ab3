"""Blocks of a mission with the objectives that they hold, against the judge, which writes blocks out."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given

from mcpn.answers.mission_names import MissionNames
from mcpn.drawing.compose import compose
from mcpn.errors import InputError, LimitError
from mcpn.logic.syntax import parse
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Mission
from mcpn.spaces.search.goal import FALSE, marked
from mcpn.study import open_study
from mcpn.testing import missions
from mcpn.testing.judge.blocks import WrittenBlock, written_out
from tests.shares import returns_early

TEXT = """<mission xmlns="urn:mcpn:mission:1" name="survey">
  <robot name="boat">
    <hardware name="camera"/>
    <hardware name="motor" faulty="false"/>
    <activity name="film"><alternative name="film" consumes="camera"/></activity>
    <activity name="move"><alternative name="move" consumes="motor"/></activity>
  </robot>
  <protocols>
    <protocol name="look">
      <objective name="transect" repeat="2">
        <objective name="come" activities="move"/>
        <objective name="see" activities="film" retries="1"/>
      </objective>
    </protocol>
  </protocols>
  <use protocol="look" name="north"/>
  <parallel name="both">
    <objective name="watch" activities="film"/>
    <objective name="home" activities="move"/>
  </parallel>
</mission>
"""


def named(node: WrittenBlock) -> dict[str, set[str]]:
    """By name of a node in it the objectives that it holds.

    One that stands for several has them all, also by its name as it is written, which no node has where the
    copies are those of blocks around it.
    """
    found: dict[str, set[str]] = {}
    stack = [node]
    while stack:
        here = stack.pop()
        above: WrittenBlock | None = here
        while above is not None and not here.children:
            around, dot, _ = above.name.rpartition(".")
            for name in {above.name, f"{around}{dot}{above.written}"} if above.written else {above.name}:
                found.setdefault(name, set()).add(here.name)
            above = above.parent
        stack.extend(here.children.values())
    return found


@given(missions())
def test_blocks_hold_what_the_page_says(mission: Mission) -> None:
    try:
        graph = flatten(mission)
    except LimitError:
        returns_early("too many objectives")
        return
    reached = {objective.name for objective in graph.walk()}
    expected = {name: held & reached for name, held in named(written_out(mission)).items()}
    del expected[written_out(mission).name]
    unreached = {name for name, held in expected.items() if not held}
    held = {name: set(objectives) & reached for name, objectives in flatten(mission).copies.held.items()}
    assert {name: these for name, these in held.items() if name not in unreached} == {
        name: these for name, these in expected.items() if name not in unreached
    }


@pytest.fixture
def survey(tmp_path: Path) -> Path:
    path = tmp_path / "survey.xml"
    path.write_text(TEXT)
    return path


def test_a_block_runs_while_one_of_its_objectives_does(survey: Path) -> None:
    study = open_study(survey)
    of = compose(study.mission_net.mission)
    names = MissionNames(of)

    def running(*objectives: str) -> object:
        return marked(
            *(p for p, role in of.roles.items() if role[0] == "objective" and role[1] in objectives)
        )

    rounds = [f"north.transect_{n}.{what}" for n in (1, 2) for what in ("come", "see_try1", "see_try2")]
    assert names.word("block", "north") == names.word("block", "transect") == running(*rounds)
    assert names.word("block", "north.transect_2") == running(*rounds[3:])
    assert names.word("block", "both") == running("watch", "home") != FALSE
    assert names.word("block", "watch") == names.word("objective", "watch")
    assert parse("block(see)", names) == running(*(r for r in rounds if "see" in r))
    assert study.ctl("AG (block(transect) -> block(north))").holds
    assert study.ctl("EF (block(both) & EF block(north))").holds is False


def test_no_block_of_this_name(survey: Path) -> None:
    with pytest.raises(InputError, match=r"no block is named transekt; did you mean .*transect"):
        open_study(survey).ctl("EF block(transekt)")
