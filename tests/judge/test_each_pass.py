"""Each pass by itself: the judge plays a mission that needs it alike before and after, one mission a pass."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.mission.passes import PASSES, core
from mcpn.mission.xml import read_mission
from mcpn.testing.judge.interpreter import Interpreter
from tests.judge.test_passes import alike

ROBOT = """<robot name="r">
  <hardware name="h"/><hardware name="l"/><fault name="water" affects="h l"/>
  <fact name="held"/><event name="grab"><sets fact="held" to="true"/></event><event name="call"/>
  <activity name="a" consumes="h"/><activity name="b" consumes="l" faulty="true" failures="lost"/>
</robot>"""
PROTOCOL = """<protocols><protocol name="p">
  <parameter name="speed" value="1"/>
  <objective name="x" activities="a" failure="y"/><objective name="y" activities="b"/>
</protocol></protocols>"""
SERIES = '<objective name="x" activities="a"/><objective name="y" activities="b"/>'
AFTER = '<objective name="z" activities="a"/>'
CALLED = '<on event="call" pause="z"/>'
LOST = '<route on="failure" reason="lost" goto="z"/>'
NEEDING = {
    "done": f'<objective name="x" activities="a" failure="z"/>{AFTER}<objective name="y" activities="b">'
    '<route when="!done(x)" goto="fail"/></objective>',
    "successors": f"{SERIES}{AFTER}",
    "uses": f'{PROTOCOL}<use name="u" protocol="p" failure="v"/><use name="v" protocol="p"/>',
    "becoming": f'<objective name="w" failure="z"><on when="held" goto="z"/>{SERIES}</objective>{AFTER}',
    "repeat": f'<objective name="w" repeat="3" failure="z">{SERIES}</objective>{AFTER}',
    "retries": f'<objective name="w" retries="2" success="z">{SERIES}</objective>{AFTER}',
    "each": f'<each name="n" in="p q r" failure="z">{SERIES}</each>{AFTER}',
    "timeouts": f'<objective name="w" timeout="9" timeout_goto="z">{SERIES}</objective>{AFTER}',
    "recovery": f'<objective name="w" recover="z" times="2">{SERIES}</objective>{AFTER}',
    "guards": f'{SERIES}<objective name="z" activities="a"><enter when="held" else="fail"/></objective>',
    "early_ends": f'<parallel name="w" success_when="any" impossible="fails">{SERIES}{AFTER}</parallel>',
    "parameters": f'<objective name="w"><parameter name="speed" value="2"/>{SERIES}</objective>',
    "reasons": f'<objective name="w">{SERIES}{LOST}</objective>{AFTER}',
    "faults": SERIES,
    "crashes": SERIES,
    "pauses": f'<objective name="w" success="succeed">{SERIES}{CALLED}</objective>{AFTER}',
    "named_failures": f'<objective name="w">{SERIES}{LOST}</objective>{AFTER}',
}
"""By pass a mission's blocks that it rewrites."""


def test_each_pass_has_a_mission() -> None:
    assert list(NEEDING) == [rewrite.__name__ for rewrite in PASSES]


@pytest.mark.parametrize("name", NEEDING)
def test_the_judge_gives_the_same_before_and_after(name: str, tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    inside = f"{ROBOT}{NEEDING[name]}"
    path.write_text(f'<mission name="m" xmlns="urn:mcpn:mission:1">{inside}</mission>')
    of, names = read_mission(path), list(NEEDING)
    place = names.index(name)
    before = core(of, until=names[place - 1]) if place else of
    after = core(of, until=name)
    assert (before.blocks, before.robots, before.protocols) != (after.blocks, after.robots, after.protocols)
    assert alike(Interpreter(before), Interpreter(after)) > 5
