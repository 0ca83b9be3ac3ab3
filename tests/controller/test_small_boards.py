"""Generated C on small boards: its size, its stack, and what it needs of a library."""

from __future__ import annotations

import random
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any, get_args
from unittest.mock import patch

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Robot
from mcpn.robot.targets import c, files
from mcpn.testing import missions
from tests.controller.test_c import STRICT, build, run_lines
from tests.controller.traces import Traced, random_events


def compiled(texts: dict[str, str], folder: Path, *options: str) -> Path:
    """The object of a controller, and beside it what the compiler says of its stack."""
    for name, text in texts.items():
        (folder / name).write_text(text)
    (source,) = (name for name in texts if name.endswith(".c") and not name.endswith("_main.c"))
    found = folder / "controller.o"
    command = ["gcc", *STRICT, *options, "-fstack-usage", "-c", source, "-o", "controller.o"]
    subprocess.run(command, cwd=folder, check=True)
    return found


def frames(found: Path) -> dict[str, int]:
    """By function the bytes of its frame."""
    rows = (line.split("\t") for line in found.with_suffix(".su").read_text().splitlines())
    return {row[0].rpartition(":")[2].partition(".")[0]: int(row[1]) for row in rows}


def figure(text: str, behind: str) -> int:
    """The number in a header's comment that stands before some words."""
    found = re.search(rf"(\d+) {behind}", text.replace("\n * ", " "))
    assert found is not None, behind
    return int(found[1])


def test_the_header_says_what_a_controller_takes(
    made: tuple[dict[str, str], dict[str, Any]], tmp_path: Path
) -> None:
    header = made[0]["ulysse.h"]
    sizes = (
        '#include <stdio.h>\n#include "ulysse.h"\nint main(void) { ulysse_action a[ULYSSE_MAX_ACTIONS];\n'
        '(void)printf("%zu %zu", sizeof(ulysse_controller), sizeof a); return 0; }\n'
    )
    program = build({"ulysse.h": header, "sizes.c": sizes}, tmp_path / "sizes")
    run = subprocess.run([program], capture_output=True, text=True, check=True)
    figures = figure(header, "bytes of a controller"), figure(header, "bytes of a buffer for actions")
    assert run.stdout.split() == [str(number) for number in figures]
    for level in ("-O1", "-O2", "-Os"):
        stack = frames(compiled(made[0], tmp_path, level))
        inside = sum(size for name, size in stack.items() if not name.startswith("ulysse_"))
        assert inside + stack["ulysse_handle"] <= figure(header, "bytes of stack in a call")


def test_the_largest_table_is_named_and_one_that_is_too_large_is_warned_of(ulysse_net: MissionNet) -> None:
    with patch.object(c, "LARGEST_TABLE", 10):
        warned = files(document(generate(ulysse_net), ulysse_net), "c")
    header = files(document(generate(ulysse_net), ulysse_net), "c")["ulysse.h"]
    rows = re.findall(r"uint(\d+)_t (\w+)\[(\d+)\]", warned["ulysse.c"])
    largest = max(int(bits) // 8 * int(count) for bits, _, count in rows)
    said = re.search(r"largest table is\s\*? ?(\w+), (\d+) bytes\.", header.replace("\n *", ""))
    assert said is not None
    assert (int(said[2]), said[1] in {name for _, name, _ in rows}) == (largest, True)
    assert "WARNING: avr-gcc takes at most 10" in warned["ulysse.h"]
    assert "WARNING" not in header


def test_tables_go_where_a_macro_says_and_names_can_be_left_out(
    made: tuple[dict[str, str], dict[str, Any]], tmp_path: Path
) -> None:
    elsewhere = '-DULYSSE_TABLE=__attribute__((section("elsewhere")))'
    found = compiled(made[0], tmp_path, "-Os", elsewhere, "-DULYSSE_NO_NAMES")
    sizes = subprocess.run(["size", "-A", str(found)], capture_output=True, text=True, check=True).stdout
    section = {
        row[0]: int(row[1]) for line in sizes.splitlines() if (row := line.split())[1:] and row[1].isdigit()
    }
    assert section["elsewhere"] >= figure(made[0]["ulysse.h"], "bytes of constant tables")
    assert sum(size for name, size in section.items() if name.startswith((".rodata", ".data"))) < 600
    assert b"GPS_sensor" not in found.read_bytes()
    assert b"GPS_sensor" in compiled(made[0], tmp_path, "-Os").read_bytes()


def test_whether_an_event_is_possible_takes_no_buffer(tmp_path: Path) -> None:
    """300 actions took 3,600 bytes of stack."""
    names = tuple(f"x{number}" for number in range(100))
    rows = tuple(Activity(name=name, alternatives=(Alternative(name=name),)) for name in names)
    blocks = (Objective(name="o", activities=names, failure="p"), Objective(name="p", activities=names))
    net = compose(Mission(name="wide", robots=(Robot(name="r", activities=rows),), blocks=blocks))
    for form in get_args(Form):
        texts = files(document(generate(net, form), net), "c")
        assert "define WIDE_MAX_ACTIONS 300U" in texts["wide.h"]
        stack = frames(compiled(texts, tmp_path, "-Os"))
        assert sum(size for name, size in stack.items() if not name.startswith("wide_")) < 600
        assert stack["wide_possible"] < 100


def test_no_structure_is_initialised_by_another_one(made: tuple[dict[str, str], dict[str, Any]]) -> None:
    """SDCC refuses that."""
    assert not re.search(r"ulysse_\w+ \w+ = \*", made[0]["ulysse.c"])


@pytest.mark.parametrize("board", ["z80", "stm8", "mcs51 --model-large"])
def test_sdcc_takes_it_without_a_warning(
    made: tuple[dict[str, str], dict[str, Any]], board: str, tmp_path: Path
) -> None:
    if shutil.which("sdcc") is None:
        pytest.skip("needs sdcc")
    for name in ("ulysse.h", "ulysse.c"):
        (tmp_path / name).write_text(made[0][name])
    command = ["sdcc", *f"-m{board}".split(), "--std-c99", "-c", "ulysse.c"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (run.returncode, run.stdout + run.stderr) == (0, "")


@pytest.mark.long
@settings(
    max_examples=10,
    suppress_health_check=list(HealthCheck),
    deadline=None,
    phases=(Phase.explicit, Phase.reuse, Phase.generate),  # each example is compiled: shrinking takes minutes
)
@given(
    missions(
        max_objectives=3,
        max_depth=1,
        events=1,
        timeouts=3,
        faults=1,
        reasons=3,
        awkward_names=True,
        text=True,
    )
    | missions(max_objectives=3, max_depth=1, max_sections=6, events=1, pauses=9)
    | missions(max_objectives=3, max_depth=1, max_sections=6, facts=2)
    | missions(max_objectives=3, max_depth=1, max_sections=6, faults=1, lasting=True, crashes=True)
    | missions(max_objectives=2, max_depth=1, max_sections=5, late=True, lasting=True, facts=1),
    st.integers(0, 2**32),
    st.sampled_from(get_args(Form)),
)
def test_any_mission(
    tmp_path_factory: pytest.TempPathFactory, mission: Mission, seed: int, form: Form
) -> None:
    mission_net = compose(mission)
    try:
        controller = generate(mission_net, form, max_states=2000)
    except (SemanticsError, LimitError):
        return
    program = build(files(document(controller, mission_net), "c"), tmp_path_factory.mktemp("c"))
    traced = Traced(document(controller, mission_net))
    events = random_events(traced, random.Random(seed), 300)
    traced.restart()
    assert run_lines(program, events) == traced.lines(events)
