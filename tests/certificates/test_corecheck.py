"""The objectives of a mission are played beside its certificate's net, by a program that draws no net."""

from __future__ import annotations

import ast
import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given

from mcpn.certificates import certcheck, core_entry, corecheck
from mcpn.certificates.net_entry import net_entry
from mcpn.certificates.writing import certificate_of
from mcpn.drawing.templates.control import _Control
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.expansion.routes import Interrupted
from mcpn.mission.graph import ParallelSection
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.certificates.files import rewritten
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


def played(study: Study) -> tuple[int, int]:
    """The objectives of a mission beside its net."""
    net = certcheck.Net(json.loads(json.dumps(net_entry(study.mission_net))))
    core = json.loads(json.dumps(core_entry.core_entry(study.mission_net.graph)))
    graph = certcheck.Listing(net, 100_000, float("inf"))
    return corecheck.walked(graph, corecheck.CoreGraph(core["graph"], "core.json: graph"))


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Mission:
    """One with a block, a handler that happens once, and an abort."""
    path = tmp_path_factory.mktemp("mission") / "mission.xml"
    path.write_text(MISSION.lstrip())
    return read_mission(path)


def test_it_imports_python_alone() -> None:
    nodes = list(ast.walk(ast.parse(Path(str(corecheck.__file__)).read_text())))
    names = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    names |= {str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)}
    assert {name.partition(".")[0] for name in names - {"mcpn.certificates", "certcheck"}} <= (
        sys.stdlib_module_names
    )


def test_each_state_of_a_net_is_one_of_its_mission(mission: Mission) -> None:
    for each in (mission, read_mission(ULYSSE)):
        study = Study(each)
        size = direct(study.mission_net.net, max_states=1_000)
        assert played(study) == (size.states, len(size.labels))


@fewer(0.1)
@given(
    missions(max_hardware=3, max_objectives=3, max_sections=4, events=2, timeouts=2, early=1)
    | missions(max_hardware=2, max_objectives=2, max_sections=3, events=2, facts=1)
)
def test_drawn_missions(mission: Mission) -> None:
    study = Study(mission)
    try:
        graph = direct(study.mission_net.net, max_states=400)
        pairs, events = played(study)
    except (LimitError, ConfluenceError, core_entry.Unplayed) as error:
        return returns_early(type(error).__name__)
    assert pairs >= graph.states
    assert events >= len(graph.labels)
    return None


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
        with pytest.raises(certcheck.Refuted):
            corecheck.checked(path)


def test_both_files_alone_play_a_mission(mission: Mission, tmp_path: Path) -> None:
    for program in (certcheck, corecheck):
        shutil.copy(str(program.__file__), tmp_path)
    whole = certificate_of(Study(mission).verdicts())
    (tmp_path / "cert").write_bytes(whole.to_bytes())
    (tmp_path / "without").write_bytes(whole._replace(core=None).to_bytes())
    assert whole.core is not None
    wrong = json.loads(json.dumps(whole.core).replace('"home"', '"nowhere"', 1))
    (tmp_path / "wrong").write_bytes(whole._replace(core=wrong).to_bytes())
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
    assert ran[0].stdout.startswith("objectives  proved: ")
    assert "there is no entry core.json" in ran[1].stdout
    assert "nowhere" in ran[2].stdout
    assert all(run.stderr == "" for run in ran)
