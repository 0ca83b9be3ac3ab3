"""The C target on small boards, where their compilers and simulators are: it does what it does here."""

from __future__ import annotations

import re
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import get_args
from unittest.mock import patch

import pytest

from experiments.robots.boards import (
    BOARDS,
    EVENTS,
    LARGE,
    MARKED,
    MISSIONS,
    PAGE,
    SIZED,
    STRICT,
    Board,
    InC,
    called_m,
    page,
    read,
    versions,
    walk,
)
from mcpn.controller.generate import Form
from mcpn.drawing.compose import MissionNet
from mcpn.robot.targets import c
from tests.controller.test_small_boards import figure, frames
from tests.controller.test_timers import BLOCKS, TIES

FORMS: tuple[Form, ...] = get_args(Form)
TIMED = {"ties": (TIES, "-DSTEP=100"), "blocks": (BLOCKS, "-DSTEP=103")}
"""Missions with timers, of which many are over at one moment of a step."""
INT_32 = [board for board in BOARDS if board.compiler in {"riscv64-unknown-elf", "mips-linux-gnu"}]
"""Where integers have 32 bits, and enumerations, which on ARM without a system have 8."""
each_board = pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.name)


def needs(*programs: str) -> None:
    if missing := [program for program in programs if shutil.which(program) is None]:
        pytest.skip(f"needs {', '.join(missing)}")


def found(name: str) -> tuple[MissionNet, tuple[str, ...]]:
    """The net of a mission, and options for its walk."""
    if name in TIMED:
        return called_m(TIMED[name][0]), (TIMED[name][1],)
    return called_m(read(name)), ()


@cache
def in_c(name: str, form: Form) -> InC:
    return InC.of(found(name)[0], form)


@pytest.mark.slow
@pytest.mark.timeout(900)
@each_board
@pytest.mark.parametrize("name", [*MISSIONS, *TIMED])
def test_each_form_that_fits_walks_as_on_the_host(name: str, board: Board, tmp_path: Path) -> None:
    needs("gcc", *board.missing)
    net, options = found(name)
    made = {form: InC.of(net, form) for form in FORMS}
    fitting = {form: of for form, of in made.items() if of.fits(board)}
    assert {"hierarchical", "modular"} <= fitting.keys()
    expected = walk(made["hierarchical"], tmp_path, None, *options)
    assert (len(expected), len(set(expected)) > 20) == (EVENTS, True)
    for form, of in fitting.items():
        assert walk(of, tmp_path, board, *options) == expected, form


@pytest.mark.parametrize("name", TIMED)
def test_all_forms_walk_alike_on_the_host(name: str, tmp_path: Path) -> None:
    needs("gcc")
    net, options = found(name)
    first, *others = (walk(InC.of(net, form), tmp_path, None, *options) for form in FORMS)
    assert len(first) == EVENTS
    assert all(other == first for other in others)


@each_board
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["ulysse", *TIMED])
def test_the_header_s_figures_are_the_compiler_s(name: str, form: Form, board: Board, tmp_path: Path) -> None:
    needs(f"{board.compiler}-gcc")
    made = in_c(name, form)
    made.write(tmp_path)
    header = made.texts["m.h"]
    same = "==" if board in INT_32 else "<="
    asked = {
        "sizeof(m_controller)": figure(header, "bytes of a controller"),
        "(M_MAX_ACTIONS * sizeof(m_action))": figure(header, "bytes of a buffer for actions"),
    }
    lines = [
        f"typedef char a{at}[({of} {same} {size}) ? 1 : -1];" for at, (of, size) in enumerate(asked.items())
    ]
    (tmp_path / "sizes.c").write_text("\n".join(['#include "m.h"', *lines, ""]))
    own = [option for option in board.options if not option.startswith(("-Wl", "-nost", "-static"))]
    command = [f"{board.compiler}-gcc", *STRICT, *own, *made.where(board), "-Os", "-ffreestanding", "-c"]
    subprocess.run([*command, "sizes.c"], cwd=tmp_path, check=True)
    subprocess.run([*command, "-fstack-usage", "m.c"], cwd=tmp_path, check=True)
    stack = frames(tmp_path / "m.o")
    inside = sum(size for of, size in stack.items() if not of.startswith("m_"))
    assert 0 < inside + stack["m_handle"] <= figure(header, "bytes of stack in a call")


@pytest.mark.parametrize(("size", "taken"), [(c.LARGEST_TABLE, True), (c.LARGEST_TABLE + 1, False)])
def test_the_largest_table_is_that_of_avr_gcc(size: int, taken: bool, tmp_path: Path) -> None:
    needs("avr-gcc")
    (tmp_path / "t.c").write_text(f"const unsigned char t[{size}] = {{1U}};\n")
    run = subprocess.run(["avr-gcc", "-mmcu=atmega2560", "-c", "t.c"], cwd=tmp_path, capture_output=True)
    assert (run.returncode == 0) == taken


def test_tables_that_flash_cannot_reach_are_said_to_need_another_word() -> None:
    """``__flash`` of avr-gcc takes 16 bits of an address: what is further away it reads wrongly."""
    net = called_m(TIES)
    near = InC.of(net, "hierarchical")
    with patch.object(c, "NEAR_FLASH", near.tables - 1):
        far = InC.of(net, "hierarchical")
    assert near.where(LARGE) == ("-DM_TABLE=__flash",)
    assert far.where(LARGE) == ("-DM_TABLE=__memx",)
    assert "WARNING: __flash" in far.texts["m.h"]
    assert "WARNING" not in near.texts["m.h"]


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_the_page_s_figures_are_those_of_today() -> None:
    needs(*(name for board in SIZED for name in board.missing))
    written = MARKED.search(PAGE.read_text())
    assert written is not None
    if versions() not in written[0]:
        pytest.skip(f"the page was measured with other versions than {versions()}")
    assert "\n".join(page()) + "\n" == written[0], "run python experiments/robots/boards.py --write"


def test_the_page_names_its_compilers() -> None:
    written = MARKED.search(PAGE.read_text())
    assert written is not None
    assert re.search(r"Measured with avr-gcc [\d.]+, .*, simavr [\d.]+", written[0])
