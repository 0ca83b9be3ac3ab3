"""The page on other tools: each row is held by a test, and what is asked of Storm alone."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mcpn.drawing.compose import compose
from mcpn.mission.xml import read_mission
from tests.commands import mcpn, output
from tests.conftest import ROOT
from tests.other_tools import ROWS, Row

PAGE = (ROOT / "docs" / "other-tools.md").read_text()
TABLE = PAGE.partition("<!-- measured: tools -->\n")[2].partition("<!-- end -->")[0]
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


DRAWN = [name for name, row in ROWS.items() if row.draws is not None]


@pytest.mark.parametrize("row", [row for row in ROWS.values() if row.test])
def test_each_row_is_a_test(row: Row) -> None:
    file, _, test = row.test.partition("::")
    assert re.search(rf"^def {test}\(", (ROOT / file).read_text(), re.MULTILINE)


@pytest.mark.parametrize("number", [2, pytest.param(50, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.filterwarnings("ignore:the Petri net has been imported without")
def test_drawn(name: str, number: int) -> None:
    """Missions and trees that hypothesis draws, judged by the tool of a row."""
    row = ROWS[name]
    if not row.here:
        pytest.skip(f"needs {', '.join(row.tools)}")
    found = row.compared(number, strict=True)["judged"]
    assert found == number if number > 10 else found  # of few draws all may be of those that cannot be asked


def test_the_page_has_the_rows_as_they_are_written() -> None:
    """All but versions and figures, which are those of one machine and one day."""
    told = [[cell.strip() for cell in line.split("|")[1:-1]] for line in TABLE.splitlines()[2:]]
    rows = [(row.file, row.direction, row.held, row.differs) for row in ROWS.values()]
    assert [(cells[1], cells[2], cells[3], cells[5]) for cells in told] == rows
    for cells, row in zip(told, ROWS.values(), strict=True):
        assert re.fullmatch(", ".join(rf"{re.escape(tool)} [\d.]+" for tool in row.tools), cells[0])
        figures = cells[4]
        if row.draws is None:
            assert re.fullmatch(r"1 test passes|\d+ tests pass", figures), figures
        else:
            assert re.fullmatch(rf"50 {row.of}: \d.*; 0 differ", figures), figures


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
