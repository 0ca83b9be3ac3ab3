"""Sequences of events take every edge of a controller; as tests in C and Python they find a wrong robot."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import MissionNet
from mcpn.robot.bench.sequences import sequences
from mcpn.robot.runtime import Controller
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.robot.runtime.machines import TypeTables
from mcpn.robot.targets import files
from tests.commands import mcpn
from tests.conftest import ROOT, ULYSSE
from tests.controller.test_c import build, run_lines

WATCH = ROOT / "tests" / "controller" / "watch.xml"


def test_sequences_take_every_edge_and_the_c_program_follows(ulysse_net: MissionNet, tmp_path: Path) -> None:
    controller = generate(ulysse_net)
    tables = Tables(document(controller, ulysse_net))
    machines = [section.machine for section in tables.sections.values()]
    edges = sum(len(moves) for m in machines if isinstance(m, TypeTables) for moves in m.moves)
    assert sequences(tables).edges == edges
    assert mcpn("tests", str(ULYSSE), "-o", str(tmp_path / "out")).returncode == 0
    replayed, taken = Controller(tables), set[tuple[str | None, int, str]]()
    for event in (tmp_path / "out" / "events.txt").read_text().splitlines():
        if event:
            section = replayed.section
            if section is not None and event in tables.sections[section].number:
                taken.add((section, replayed.where.state, event))
            replayed.handle(event)
        else:
            replayed = Controller(tables)
    assert len(taken) == edges
    program = build(files(document(controller, ulysse_net), "c"), tmp_path / "c")
    events = (tmp_path / "out" / "events.txt").read_text().splitlines()
    expected = (tmp_path / "out" / "expected.txt").read_text().splitlines()
    assert [line.split(" |")[0] for line in run_lines(program, events)] == expected


def test_the_written_tests_pass_and_find_a_wrong_robot(tmp_path: Path) -> None:
    assert mcpn("tests", str(WATCH), "-o", str(tmp_path)).returncode == 0
    written = runpy.run_path(str(tmp_path / "test_controller.py"))
    controller = Controller.load(tmp_path / "controller.json")
    before = controller.snapshot()
    check, make, each = written["test_sequence"], written["Runtime"], written["SEQUENCES"]
    for sequence in each:
        controller.restore(before)
        check(make(controller), sequence)

    class Wrong(make):  # type: ignore[misc, valid-type]
        def handle(self, event: str) -> list[str]:
            found: list[str] = super().handle(event)
            return found[::-1]

    controller.restore(before)
    with pytest.raises(AssertionError, match="step 1: MISSION_EV_START"):
        check(Wrong(controller), each[0])
