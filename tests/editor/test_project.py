"""Problems as they are typed: those of check, in the same words and places."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.editor.project import Memory, Project
from mcpn.editor.scan import scan
from mcpn.errors import InputError
from mcpn.mission.core.flattening import flatten
from mcpn.mission.core.objectives_graph import ObjectivesGraph
from mcpn.mission.model import Mission
from mcpn.mission.static.resource_use import Usage
from mcpn.mission.static.warnings import static_warnings
from mcpn.mission.xml import read_mission
from tests.conftest import ROOT
from tests.mission.test_broken import BROKEN

ULYSSE = ROOT / "experiments" / "ulysse"


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_typed_has_the_problems_of_what_is_saved(name: str, tmp_path: Path) -> None:
    text = BROKEN[name][0]
    path = (tmp_path / "mission.xml").resolve()
    path.write_text(text)
    try:
        read_mission(path)
        expected = []
    except InputError as error:
        expected = list(error.problems)
    path.write_text("<mission/>")
    errors, _ = Project({path: text}).problems(path)
    root = next((element.tag for element in scan(text)), "")
    if root == "mission":
        assert errors == expected
    elif root not in ("robot", "protocols"):  # which are files of their own
        assert [problem.source for problem in errors] == [problem.source for problem in expected]


def test_a_file_that_is_imported_has_the_problems_of_its_mission() -> None:
    robot = (ULYSSE / "robot.xml").resolve()
    assert Project({}).missions(robot) == [ULYSSE / "mission.xml"]
    assert set(Project({}).together(robot)) == {path.resolve() for path in ULYSSE.glob("*.xml")}
    typed = robot.read_text().replace('consumes="GPS_position"', 'consumes="GPS_psition"')
    errors, _ = Project({robot: typed}).problems(robot)
    assert [problem.message for problem in errors if "GPS_psition" in problem.message]
    assert {Path(problem.source.file).resolve() for problem in errors if problem.source} == {robot}


def test_warnings_are_those_of_check(tmp_path: Path) -> None:
    mission = ROOT / "experiments" / "ulysse" / "mission.xml"
    text = (ROOT / "experiments" / "ulysse" / "robot.xml").read_text()
    unused = text.replace("</robot>", '<hardware name="spare"/></robot>')
    robot = (ROOT / "experiments" / "ulysse" / "robot.xml").resolve()
    errors, warnings = Project({robot: unused}).problems(mission)
    assert errors == []
    assert [problem.message for problem in warnings] == ["resource spare is never used"]
    valid = read_mission(mission)
    assert Project({}).problems(mission) == ([], static_warnings(Usage(valid, flatten(valid))))


def test_an_objectives_graph_is_made_once_for_formulas_and_warnings(monkeypatch: pytest.MonkeyPatch) -> None:
    made = list[str]()

    def counted(mission: Mission) -> ObjectivesGraph:
        made.append(mission.name)
        return flatten(mission)

    for module in ("mcpn.editor.project", "mcpn.drawing.compose"):
        monkeypatch.setattr(f"{module}.flatten", counted)
    memory = Memory()
    for _ in range(2):  # the second time the net is known, and only the formulas are looked at
        assert Project({}, memory).problems(ULYSSE / "mission.xml") == ([], [])
        assert made.pop() == "ulysse"
        assert made == []


def test_a_file_of_no_mission_is_held_to_the_language(tmp_path: Path) -> None:
    path = (tmp_path / "robot.xml").resolve()
    path.write_text('<robot xmlns="urn:mcpn:mission:1" name="r"><hardwear name="h"/></robot>')
    errors, warnings = Project({}).problems(path)
    assert warnings == []
    (problem,) = errors
    assert "hardwear" in problem.message
