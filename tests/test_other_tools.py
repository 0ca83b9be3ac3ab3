"""The page on other tools: each row is a test that there is, and what is asked of Storm alone."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mcpn.drawing.compose import compose
from mcpn.mission.xml import read_mission
from tests.commands import mcpn, output
from tests.conftest import ROOT

PAGE = (ROOT / "docs" / "other-tools.md").read_text()
ROWS = re.findall(r"^\|.*\| `(tests/[\w/]+\.py)::(\w+)` \|$", PAGE, re.MULTILINE)
LAMP = "pl on (1)\ntr t on -> off\ntr u off -> on\n"
CHAIN = """@type: DTMC
@parameters

@reward_models

@nr_states
3
@nr_choices
3
@model
state 0 init on
\taction 0
\t\t1 : 1/4
\t\t2 : 3/4
state 1 off
\taction 0
\t\t1 : 1
state 2
\taction 0
\t\t2 : 1
"""


@pytest.mark.parametrize(("file", "test"), ROWS)
def test_each_row_is_a_test(file: str, test: str) -> None:
    assert re.search(rf"^def {test}\(", (ROOT / file).read_text(), re.MULTILINE)


def test_every_row_is_read() -> None:
    table = [line for line in PAGE.splitlines() if line.startswith("|")]
    assert len(ROWS) == len(table) - 2
    assert len(ROWS) > 8


def test_storm_reads_an_automaton(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Storm reads all headers of the automaton that ask writes, and wants a deterministic one to ask it."""
    stormpy = pytest.importorskip("stormpy", reason="needs stormpy: the extra storm")
    monkeypatch.chdir(tmp_path)
    Path("lamp.net").write_text(LAMP)
    found = mcpn("ask", "lamp.net", "on U off", "--hoa")
    assert "mcpn-classes: " in found.stdout
    Path("until.hoa").write_text(found.stdout)
    Path("chain.drn").write_text(CHAIN)
    model = stormpy.build_model_from_drn[float]("chain.drn")
    (asked,) = stormpy.parse_properties('P=? [HOA: {"until.hoa", "on" -> "on", "off" -> "off"}]')
    with pytest.raises(RuntimeError, match="multiple definitions of successor"):
        stormpy.model_checking(model, asked)
    changes = {
        "[1] 0": "[1&!0] 0\n  [!0&!1] 2",
        "State: 1\n  [t] 1 {0}": "State: 1 {0}\n  [t] 1\nState: 2\n  [t] 2",
        "States: 2": "States: 3",
        "trans-acc": "state-acc",
    }
    deterministic = found.stdout
    for ours, theirs in changes.items():
        assert ours in deterministic
        deterministic = deterministic.replace(ours, theirs)
    Path("until.hoa").write_text(deterministic)
    assert stormpy.model_checking(model, asked).get_value(0) == pytest.approx(0.25)


def test_every_label_can_be_asked(tmp_path: Path) -> None:
    """Labels of a chain are identifiers, and Storm takes each in a property."""
    stormpy = pytest.importorskip("stormpy", reason="needs stormpy: the extra storm")
    path = ROOT / "experiments" / "rover" / "mission.xml"
    output("convert", path, tmp_path / "rover.drn", "--rates")
    model = stormpy.build_model_from_drn[float](str(tmp_path / "rover.drn"))
    labels = set(model.labeling.get_labels())
    assert {"init", "success", "failure"} <= labels
    for label in labels:
        stormpy.parse_properties(f'Pmax=? [F "{label}"]')
    names = [section.name for section in compose(read_mission(path)).graph.walk()]
    assert any("." in name for name in names)
    expected = {f"objective_{name.replace('.', '_')}" for name in names}
    assert expected >= {label for label in labels if label.startswith("objective_")}
    assert len(expected & labels) > len(names) / 2  # a label that no state has is not written
