"""What the script of golden answers finds: a verdict or a controller that is another one, and no more."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from experiments.faults import golden
from experiments.faults.golden_meaning import PURPOSE, expected
from experiments.faults.golden_trees import fault_tree
from mcpn.robot.runtime.file_schema import digest_of
from tests.conftest import ROOT

MISSION = """<mission xmlns="urn:mcpn:mission:1" name="m">
  <robot name="r"><hardware name="h"/><activity name="go" consumes="h"/></robot>
  <objective name="first" activities="go"/><objective name="then" activities="go"/>
</mission>"""
MACHINES = "controller_--form_hierarchical_--target_{}_-o_controller_--json"


@pytest.fixture(scope="module")
def answered(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A mission, and what some commands answer about it."""
    source, answers = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("answers")
    (source / "m.xml").write_text(MISSION)
    with pytest.MonkeyPatch.context() as patched:
        asked = [
            command
            for command in golden.OF_MISSIONS
            if command[:2] in (("check", "--json"), ("check", "--engine"))
            or (command[0] == "controller" and command[4] in ("json", "scxml"))
        ]
        patched.setattr(golden, "OF_MISSIONS", [c for c in asked if "symbolic" not in c and "flat" not in c])
        golden.asked(source, answers, 30, source / "m.xml")
    return source, answers


def machine(answers: Path, old: str, new: str) -> None:
    file = answers / "m" / MACHINES.format("json") / "controller" / "controller.json"
    changed(file, old, new)
    document = json.loads(file.read_text())
    document["digest"] = digest_of(document)
    file.write_text(json.dumps(document))


def changed(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))


def chart(answers: Path, old: str, new: str) -> None:
    changed(answers / "m" / MACHINES.format("scxml") / "controller" / "m.scxml", old, new)


def verdict(answers: Path, old: str, new: str) -> None:
    changed(answers / "m" / "check_--engine_auto_--json" / "printed", old, new)


CHANGED: dict[str, tuple[Callable[[Path], None], str]] = {
    "nothing": (lambda answers: None, ""),
    "seconds": (lambda answers: verdict(answers, '"seconds": ', '"seconds": 1'), ""),
    "a verdict": (
        lambda answers: verdict(answers, '"deadlock_free": true', '"deadlock_free": false'),
        "verdicts.deadlock_free: 'True' -> 'False'",
    ),
    "a route": (
        lambda answers: machine(answers, '"success": "then"', '"success": "succeed"'),
        "-> 'taken: stop go; release h |  | h_EV_OOS | success'",
    ),
    "a label": (
        lambda answers: chart(answers, 'label="release h"', 'label="release g"'),
        "controller/m.scxml",
    ),
}


@pytest.mark.parametrize("what", CHANGED)
def test_what_is_another_answer(
    what: str, answered: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change, told = CHANGED[what]
    source, answers = answered
    shutil.copytree(answers, tmp_path / "new")
    change(tmp_path / "new")
    assert golden.compare(source, answers, tmp_path / "new") is bool(told)
    printed = capsys.readouterr().out
    assert told in printed
    assert "equal" in printed
    assert "controllers alike" in printed


def test_what_differs_on_purpose_is_in_the_changelog() -> None:
    pages = [ROOT / "CHANGELOG.md", *sorted((ROOT / "changelog.d").glob("*.md"))]
    told = " ".join(" ".join(page.read_text().split()) for page in pages)
    renamed, purposes = expected()
    assert len(renamed) + len(purposes) == PURPOSE.read_text().count("\npage = ")
    for page in (*(each.page for each in renamed), *(each.page for each in purposes)):
        assert " ".join(page.split()) in told


TREE = """<opsa-mef><define-fault-tree name="t">
<define-gate name="lost"><or><gate name="one"/>
  <and><basic-event name="b"/><basic-event name="c"/></and></or></define-gate>
<define-gate name="one"><atleast min="2">
  <basic-event name="a"/><basic-event name="b"/><constant value="true"/></atleast></define-gate>
</define-fault-tree><model-data>
<define-basic-event name="a"><label>x</label><float value="0.5"/></define-basic-event>
</model-data></opsa-mef>"""


def test_fault_trees_are_compared_by_their_minimal_sets(tmp_path: Path) -> None:
    """A set that holds another is none, and how gates are cut up does not count."""
    (tmp_path / "openpsa.xml").write_text(TREE)
    told = {"gate one": [["a"], ["b"]], "gate lost": [["a"], ["b"]], "event a": "float 0.5"}
    assert fault_tree(tmp_path / "openpsa.xml") == told
    (tmp_path / "openpsa.xml").write_text(TREE.replace('min="2"', 'min="3"').replace("0.5", "0.6"))
    told = {"gate one": [["a", "b"]], "gate lost": [["a", "b"], ["b", "c"]], "event a": "float 0.6"}
    assert fault_tree(tmp_path / "openpsa.xml") == told
