"""A core mission is played beside its certificate's net, by a program that draws no net."""

from __future__ import annotations

import ast
import json
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.faults.certified_faults import outcome
from experiments.faults.template_faults import FAULTS
from mcpn.certificates import certcheck, corecheck, coregraph, corerobot
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.net_entry import net_entry
from mcpn.certificates.writing import certificate_of
from mcpn.drawing.templates.control import _Control
from mcpn.errors import ConfluenceError, InputError, LimitError
from mcpn.mission.core.objectives_graph import ParallelSection
from mcpn.mission.core.routes import Interrupted
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import elements
from tests.certificates.files import entries_of, rewritten
from tests.conftest import ULYSSE
from tests.draws import fewer
from tests.shares import returns_early

MISSION = """
<mission xmlns="urn:mcpn:mission:1" name="round">
  <robot name="r">
    <hardware name="camera"/><event name="call"/>
    <activity name="look"><alternative name="eye" consumes="camera"/></activity>
    <activity name="rest"><alternative name="on"/></activity>
  </robot>
  <objective name="leave" activities="rest" failure="abort">
    <on event="call" goto="home" once="true"/>
  </objective>
  <parallel name="both" failure="abort">
    <objective name="film" activities="look"/>
    <objective name="wait" activities="rest" mandatory="false"/>
  </parallel>
  <objective name="home" activities="rest" success="leave" failure="succeed"/>
</mission>
"""
EVERYTHING = """
<mission xmlns="urn:mcpn:mission:1" name="everything">
  <robot name="r">
    <hardware name="lidar"/><hardware name="sonar" repairable="false"/>
    <hardware name="camera" detected="late"/>
    <software name="scan"/>
    <fact name="light"/>
    <event name="dusk"><sets fact="light" to="false"/></event>
    <event name="rain"/>
    <activity name="scanner" produces="scan">
      <alternative name="by_lidar" consumes="lidar"/><alternative name="by_sonar" consumes="sonar"/>
    </activity>
    <activity name="drive" switch_back="true">
      <alternative name="mapped" consumes="scan"/><alternative name="blind" faulty="true"/>
    </activity>
    <activity name="film" consumes="camera" requires="light"/>
    <activity name="look" consumes="lidar"/>
    <activity name="rest" detects="camera"/>
  </robot>
  <objective name="go" activities="drive" timeout="10" failure="abort">
    <sets fact="light" to="true" on="start"/>
  </objective>
  <parallel name="both" failure="shelter" success="look">
    <on event="rain" pause="shelter"/>
    <objective name="film" activities="film rest"/>
    <objective name="move" activities="drive" mandatory="false"/>
  </parallel>
  <objective name="look" activities="look" success="succeed" failure="go"/>
  <objective name="shelter" activities="rest"/>
</mission>
"""
FILES = ("certcheck", "coregraph", "corerobot")
WRONG = [
    "it fails, and who holds it is not told",
    "what is lost never returns",
    "its repair is told as a failure",
    "it never tries its first alternative",
    "it never returns to what is better",
    "it waits for ever when its producer refuses",
    "it is lost and its consumer is not told",
    "an objective succeeds whatever runs",
    "it goes on though what it requires is no more",
    "an objective begins and changes nothing",
    "its loss is seen though nobody looks",
    "it is misused and never suspected",
    "it crashes, and runs on",
    "its time is never over",
    "a paused branch is not entered again",
]
"""Faults of templates, each in one kind of transition, which leave the net safe and confluent."""


def played(study: Study) -> tuple[int, int]:
    """The objectives of a mission beside its net."""
    net = certcheck.Net(json.loads(json.dumps(net_entry(study.mission_net))))
    core = json.loads(json.dumps(core_entry(study.mission_net)))
    graph = certcheck.Listing(net, 100_000, float("inf"))
    return corecheck.walked(graph, corecheck.CoreMission(core))


def of_text(text: str, folder: Path) -> Mission:
    """The mission that a text says."""
    path = folder / "mission.xml"
    path.write_text(text.lstrip())
    return read_mission(path)


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Mission:
    """One with a block, a handler that happens once, and an abort."""
    return of_text(MISSION, tmp_path_factory.mktemp("mission"))


@pytest.fixture(scope="module")
def everything(tmp_path_factory: pytest.TempPathFactory) -> Mission:
    """One with a pause, a timeout, facts, a crash, a loss that is noticed late and a return."""
    return of_text(EVERYTHING, tmp_path_factory.mktemp("everything"))


@pytest.mark.parametrize("program", [corecheck, coregraph, corerobot])
def test_it_imports_python_alone(program: ModuleType) -> None:
    nodes = list(ast.walk(ast.parse(Path(str(program.__file__)).read_text())))
    names = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    names |= {str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)}
    own = {f"{before}{name}" for before in ("", "mcpn.certificates.") for name in FILES}
    assert {name.partition(".")[0] for name in names - own - {"mcpn.certificates"}} <= (
        sys.stdlib_module_names
    )


def test_each_state_of_a_net_is_one_of_its_mission(mission: Mission, everything: Mission) -> None:
    for each in (mission, everything, read_mission(ULYSSE)):
        study = Study(each)
        size = direct(study.mission_net.net, max_states=1_000)
        assert played(study) == (size.states, len(size.labels))


@fewer(0.2)
@given(
    st.one_of(
        elements.ANY,
        elements.EARLY,
        elements.PAUSING_FACTS,
        elements.LEFT_BY_FACTS,
        elements.LATE,
        elements.CRASHING,
        elements.SHARING_FACTS,
        elements.IN_TIME,
        elements.LED,
    )
)
def test_drawn_missions(mission: Mission) -> None:
    study = Study(mission)
    try:
        graph = direct(study.mission_net.net, max_states=200)
        pairs, events = played(study)
    except (LimitError, ConfluenceError, InputError) as error:
        return returns_early(type(error).__name__)
    assert pairs >= graph.states
    assert events >= len(graph.labels)
    return None


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_transition_is_refuted_where_certcheck_accepts_it(everything: Mission, name: str) -> None:
    assert outcome(everything, FAULTS[name]) == "refuted"


def _failures_are_successes(patch: pytest.MonkeyPatch) -> None:
    drawn = _Control.led
    patch.setattr(
        _Control, "led", lambda self, section, outcome, *more: drawn(self, section, "success", *more)
    )


def _optional_branches_count(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(
        ParallelSection, "succeeds", lambda self, well: {branch.name for branch in well} == {*self.held}
    )


def _no_branch_counts(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(ParallelSection, "succeeds", lambda self, well: True)


def _handlers_happen_again(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(_Control, "of_handlers", lambda self, handlers, part: [])


def _every_event_is_ignored(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Interrupted, "handlers", lambda self, event: iter([(None, ())]))


def _the_first_section_comes_again(patch: pytest.MonkeyPatch) -> None:
    drawn = _Control.enter
    patch.setattr(
        _Control,
        "enter",
        lambda self, name: drawn(self, self.graph.entry if name in {"both"} else name),
    )


@pytest.mark.parametrize(
    "fault",
    [
        _failures_are_successes,
        _optional_branches_count,
        _no_branch_counts,
        _handlers_happen_again,
        _every_event_is_ignored,
        _the_first_section_comes_again,
    ],
)
def test_a_fault_in_templates_is_refuted(
    mission: Mission, monkeypatch: pytest.MonkeyPatch, fault: Callable[[pytest.MonkeyPatch], None]
) -> None:
    fault(monkeypatch)
    study = Study(mission)
    certificate = certificate_of(study.verdicts(engine="explicit"))
    with rewritten(certificate.to_bytes()) as path:
        assert {how for how, _, _ in certcheck.checked(path)} == {"proved"}  # of the wrong net
        assert [how for how, _, _ in corecheck.checked(path)] == ["refuted"]


def test_the_files_alone_play_a_mission(mission: Mission, tmp_path: Path) -> None:
    for program in (certcheck, corecheck, coregraph, corerobot):
        shutil.copy(str(program.__file__), tmp_path)
    whole = certificate_of(Study(mission).verdicts())
    data, wrong = whole.to_bytes(), json.loads(json.dumps(whole.core).replace('"home"', '"nowhere"', 1))
    (tmp_path / "cert").write_bytes(data)
    (tmp_path / "wrong").write_bytes(whole._replace(core=wrong).to_bytes())
    with zipfile.ZipFile(tmp_path / "without", "w") as archive:
        for name in ("net.json", "claims.json"):
            archive.writestr(name, json.dumps(entries_of(data)[name]))
    ran = [
        subprocess.run(
            [sys.executable, "-E", "-S", str(tmp_path / "corecheck.py"), name],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        for name in ("cert", "without", "wrong")
    ]
    assert [run.returncode for run in ran] == [0, 2, 2], ran
    assert ran[0].stdout.startswith("proved       net: ")
    assert "there is no entry core.json" in ran[1].stdout
    assert "nowhere" in ran[2].stdout
    assert all(run.stderr == "" for run in ran)


CHANGES: list[tuple[str, Callable[[Any], Any]]] = [
    ("no section", lambda core: core["graph"].update(entry="nowhere")),
    ("is there twice", lambda core: core["graph"]["sections"].append(core["graph"]["sections"][0])),
    ("expected where it leads", lambda core: core["graph"]["sections"][0]["routes"].update(success=[])),
    ("a name is there twice", lambda core: core["robot"]["hardware"].append(core["robot"]["hardware"][0])),
    ("is consumed, but neither", lambda core: core["robot"]["hardware"].clear()),
    ("no activity", lambda core: core["graph"]["sections"][0]["activities"].append("dance")),
    ("a fact has no value", lambda core: core["robot"]["events"].append({"name": "e", "changes": [["x"]]})),
]


@pytest.mark.parametrize(("why", "change"), CHANGES, ids=[why for why, _ in CHANGES])
def test_what_is_malformed_is_not_checked(mission: Mission, why: str, change: Callable[[Any], Any]) -> None:
    core = json.loads(json.dumps(core_entry(Study(mission).mission_net)))
    change(core)
    with pytest.raises(certcheck.Malformed, match=why):
        corecheck.CoreMission(core)
