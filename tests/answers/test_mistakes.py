"""Mistakes in formulas of missions that are not valid: told with the others, and none of what is right."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import event, given

import mcpn
from mcpn.answers.formula_errors import mistakes
from mcpn.answers.vocabulary import Vocabulary, vocabulary
from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.mission.model import Mission
from mcpn.mission.requirement import Requirement
from mcpn.mission.xml import read_mission
from mcpn.testing import missions
from tests.conftest import ROOT

MISSION = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="camera"/><event name="leak"/>
    <activity name="swim" consumes="{0}"/></robot>
  <requirement name="bare" formula="G (leak -> F objective(surface))"/>
  <requirement name="word" formula="G !(running(swim))"/>
  <requirement name="open" formula="G (happens(leak) | oos(camera"/>
  <requirement name="pattern"><absence of="oos(camra)"/></requirement>
  <requirement name="event" formula="G !happens(OBJ_divr_EV_OK)"/>
  <requirement name="right" formula="G (happens(OBJ_dive_try1_EV_OK) -> X (objective(surface) | failure))"/>
  <on event="leak" goto="surface"/>
  <objective name="dive" activities="swim" retries="1"/>
  <objective name="surface" activities="swim"/>
</mission>"""
TOLD = {
    4: "requirement bare: formula, column 4: leak alone says nothing: expected happens(leak)",
    5: "requirement word: formula, column 5: no word is named running; did you mean objective or activity?",
    6: "requirement open: formula, column 30: found the end, expected ')'",
    7: "requirement pattern: of of <absence>: formula, column 5: no resource is named camra; "
    "did you mean camera?",
}


@pytest.mark.parametrize("declared", [True, False])
def test_formulas_are_told_with_the_other_mistakes(declared: bool, tmp_path: Path) -> None:
    """Of a valid mission and of one that consumes what is not declared the same is said of formulas."""
    path = tmp_path / "m.xml"
    path.write_text(MISSION.format("camera" if declared else "camra"))
    with pytest.raises(InputError) as caught:
        mcpn.open(path).check()
    told = {p.source.line: p.message for p in caught.value.problems if p.source is not None and p.source.line}
    assert told.keys() == {*TOLD, 8} | ({3} if not declared else set())
    for line, message in TOLD.items():
        assert told[line].startswith(message)
    assert "requirement event: formula, column 12: no event is named OBJ_divr_EV_OK" in told[8]


@pytest.mark.parametrize("valid", [True, False])
def test_every_name_of_a_formula_that_is_unknown_is_told(valid: bool, tmp_path: Path) -> None:
    """Not the first alone: of a formula, and of all attributes of a pattern."""
    path = tmp_path / "m.xml"
    path.write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><event name="stop"/>'
        f'<activity name="a"/></robot><on event="stop" goto="{"home" if valid else "hom"}"/>\n'
        '<requirement name="x" formula="G (happens(stp) -> X !activity(b)) | objective(gi)"/>\n'
        '<requirement name="y"><response to="happens(stp)" gives="objective(gi) | block(q)"/></requirement>\n'
        '<objective name="go" activities="a"/><objective name="home" activities="a"/></mission>'
    )
    with pytest.raises(InputError) as caught:
        mcpn.open(path).check()
    found = [
        (line, problem.message.split("; ")[0].partition("formula, ")[2])
        for problem in caught.value.problems
        if problem.source is not None and (line := problem.source.line) in (2, 3)
    ]
    assert sorted(found) == [
        (2, "column 12: no event is named stp"),
        (2, "column 32: no activity is named b"),
        (2, "column 48: no objective is named gi"),
        (3, "column 11: no objective is named gi"),
        (3, "column 23: no block is named q"),
        (3, "column 9: no event is named stp"),
    ]


def test_done_of_one_copy_is_not_taken_for_done_of_any(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><activity name="a"/></robot>'
        '<each name="visit" in="x y"><objective name="see" activities="a"/></each>'
        '<objective name="home" activities="a"><route when="done(visit_x.see)" goto="fail"/></objective>'
        "</mission>"
    )
    with pytest.raises(
        InputError, match=r"named visit_x\.see; done\(see\) is of any copy of it: to tell copies"
    ):
        mcpn.open(path).check()


def formulas(words: Vocabulary) -> list[str]:
    """A formula of each word that a mission has, of all its copies and of each."""

    def each(of: tuple[object, ...]) -> list[str]:
        return [name for word in of for name in (word.name, *word.copies)]  # type: ignore[attr-defined]

    return [
        *(f"{kind}({name})" for name in each(words.objectives) for kind in ("objective", "pending")),
        *(f"block({name})" for name in each(words.blocks)),
        *(f"{kind}({a.name})" for a in words.activities for kind in ("activity", "waiting", "refused")),
        *(f"alternative({a.name})={way}" for a in words.activities for way in a.alternatives),
        *(f"{kind}({h.name})" for h in words.hardware for kind in ("oos", "available")),
        *(f"available({s.name})" for s in words.software),
        *(f"fact({f.name})={value}" for f in words.facts for value in f.values),
        *(f"{kind}({name})" for name in each(words.events) for kind in ("happens", "event")),
        *words.ends,
    ]


@given(missions())
def test_what_a_valid_mission_may_say_is_no_mistake(mission: Mission) -> None:
    words = [word for word in formulas(vocabulary(compose(mission))) if not word.startswith("fact(done(")]
    event(f"formulas: {len(words) // 20 * 20} and more")
    asked = tuple(Requirement(name=f"r{n}", formula=f"EF {word}") for n, word in enumerate(words))
    assert [*mistakes(replace(mission, requirements=asked))] == []


@pytest.mark.parametrize("path", sorted(ROOT.glob("experiments/*/mission.xml")), ids=lambda p: p.parent.name)
def test_requirements_of_worked_missions_are_no_mistakes(path: Path) -> None:
    assert [*mistakes(read_mission(path))] == []
