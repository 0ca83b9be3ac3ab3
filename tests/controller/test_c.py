"""The C target: compiles without a warning, does what the runtime does, and survives any input."""

from __future__ import annotations

import json
import random
import re
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any, get_args
from unittest.mock import patch

import pytest
from hypothesis import HealthCheck, Phase, example, given, settings
from hypothesis import strategies as st

from mcpn.controller import rules
from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot
from mcpn.robot.targets import c, files
from mcpn.robot.targets.c import Array
from mcpn.robot.targets.names import C_KEYWORDS, C_SIGNIFICANT, c_string, comment, identifiers
from mcpn.testing import missions
from tests.controller.traces import Place, Traced, canonical, random_events, tour

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
SANITIZE = ["-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
COMPILERS = {
    "gcc": ["gcc"] if shutil.which("gcc") else None,
    "clang": ["clang"]
    if shutil.which("clang")
    else [sys.executable, "-m", "ziglang", "cc"]
    if find_spec("ziglang")
    else None,
}


def build(texts: dict[str, str], folder: Path, *options: str, compiler: str = "gcc") -> Path:
    command = COMPILERS[compiler]
    if command is None:
        pytest.skip(f"needs {compiler}")
    folder.mkdir(exist_ok=True)
    for name, text in texts.items():
        (folder / name).write_text(text)
    program = folder / "program"
    sources = [str(folder / name) for name in texts if name.endswith(".c")]
    run = subprocess.run(
        [*command, *STRICT, *options, "-o", str(program), *sources], capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""
    return program


def run_lines(program: Path, events: list[str]) -> list[str]:
    run = subprocess.run(
        [str(program), "all"], input="\n".join(events) + "\n", capture_output=True, text=True
    )
    assert (run.returncode, run.stderr) == (0, "")
    return [canonical(line) for line in run.stdout.splitlines()]


@pytest.fixture(scope="module", params=["flat", "hierarchical", "modular", "modular in parts"])
def made(request: pytest.FixtureRequest, ulysse_net: MissionNet) -> tuple[dict[str, str], dict[str, Any]]:
    form, _, parts = request.param.partition(" ")
    with patch.object(rules, "FEW_RULES", 0 if parts else rules.FEW_RULES):
        controller = generate(ulysse_net, form)
    return files(document(controller, ulysse_net), "c"), document(controller, ulysse_net)


@pytest.fixture(scope="module")
def sanitized(made: tuple[dict[str, str], dict[str, Any]], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program under sanitizers."""
    return build(made[0], tmp_path_factory.mktemp("sanitized"), *SANITIZE)


@pytest.mark.parametrize("compiler", ["gcc", pytest.param("clang", marks=pytest.mark.long)])
def test_every_edge_of_ulysse(
    made: tuple[dict[str, str], dict[str, Any]], compiler: str, tmp_path: Path
) -> None:
    texts, said = made
    traced = Traced(said)
    events, edges = tour(traced)
    assert len(edges) == 1332
    if said["form"] != "modular":
        check_edges(traced, said, edges)
    program = build(texts, tmp_path, compiler=compiler)
    traced.restart()
    assert run_lines(program, events) == traced.lines(events)


def check_edges(traced: Traced, said: dict[str, Any], edges: set[tuple[Place, str]]) -> None:
    """All edges inside sections are taken: by type, state and event of the type."""
    taken = {(place[0], place[1], event) for place, event in edges if place[0] is not None}
    inside = {
        (section.type, state, section.number[event])
        for name, state, event in taken
        if event in (section := traced.tables.sections[str(name)]).number
    }
    assert len(inside) == sum(len(row["edges"]) for row in said["types"])


def test_random_events_under_sanitizers(made: tuple[dict[str, str], dict[str, Any]], sanitized: Path) -> None:
    traced = Traced(made[1])
    events = random_events(traced, random.Random(1), 5000)
    traced.restart()
    assert run_lines(sanitized, events) == traced.lines(events)


def test_any_bytes_under_sanitizers(made: tuple[dict[str, str], dict[str, Any]], sanitized: Path) -> None:
    rng = random.Random(2)
    known = sorted(Traced(made[1]).tables.known)
    longest = max(map(len, known))
    lines: list[bytes] = []
    for _ in range(3000):
        name = rng.choice(known).encode()
        lines.append(
            rng.choice(
                [
                    name,
                    name[: rng.randrange(len(name))],
                    name + b"+" + rng.randbytes(rng.randrange(300)).replace(b"\n", b""),
                    name + b"\0",
                    b"\0" + name,
                    rng.randbytes(rng.randrange(200)).replace(b"\n", b" "),
                    b"A" * (longest + rng.randrange(-1, 3)),
                    b"\xff" * 100_000,
                ]
            )
        )
    for end in (b"\n", b"", b"\0"):
        run = subprocess.run([sanitized], input=b"\n".join(lines) + end, capture_output=True)
        assert (run.returncode, run.stderr) == (0, b"")
        statuses = [line.split(b":")[0] for line in run.stdout.splitlines()]
        expected = [line for line in [*lines[:-1], lines[-1] + end.strip()] if line]
        assert len(statuses) == len(expected)
        wanted = [line.decode("latin-1") in known for line in expected]
        assert [status != b"unknown" for status in statuses] == wanted


HARNESS = """
#include <stdio.h>
#include "ulysse.h"
/* Any bytes as a controller, then every event: no number is believed. */
int main(void)
{
    ulysse_controller controller;
    ulysse_action actions[ULYSSE_MAX_ACTIONS];
    size_t count;
    unsigned valid = 0;
    while (fread(&controller, sizeof controller, 1, stdin) == 1) {
        unsigned event;
        valid += (unsigned)ulysse_valid(&controller);
        for (event = 0; event <= ULYSSE_COUNT_EVENT + 1U; event++) {
            ulysse_controller copy = controller;
            if (ulysse_handle(&copy, (ulysse_event)event, actions, &count) == ULYSSE_TAKEN) {
                size_t i;
                for (i = 0; i < count; i++) {
                    if (ulysse_activity_name(actions[i].subject)[0] == 0) { return 1; }
                }
                if ((ulysse_valid(&controller) == 1) && (ulysse_valid(&copy) == 0)) { return 2; }
            }
            (void)ulysse_running(&controller, (ulysse_number)event);
            (void)ulysse_possible(&controller, (ulysse_event)event);
        }
    }
    printf("%u\\n", valid);
    return 0;
}
"""


def test_a_broken_snapshot_is_seen_and_harms_nothing(
    made: tuple[dict[str, str], dict[str, Any]], tmp_path: Path
) -> None:
    texts = {name: text for name, text in made[0].items() if not name.endswith("_main.c")}
    program = build(texts | {"harness.c": HARNESS}, tmp_path, *SANITIZE)
    run = subprocess.run([program], input=random.Random(3).randbytes(30_000), capture_output=True, text=False)
    assert (run.returncode, run.stderr) == (0, b"")
    assert 0 <= int(run.stdout) < 5000


def test_sizes_in_the_header_are_those_of_the_compiler(
    made: tuple[dict[str, str], dict[str, Any]], tmp_path: Path
) -> None:
    header = made[0]["ulysse.h"]
    (tmp_path / "ulysse.h").write_text(header)
    code = made[0]["ulysse.c"]
    source = tmp_path / "ulysse.c"
    names = [
        line.split("[")[0].split()[-1]
        for line in code.splitlines()
        if line.startswith("static const ULYSSE_TABLE uint")
    ]
    source.write_text(
        code
        + '\n#include <stdio.h>\nint main(void) { (void)printf("%zu", '
        + " + ".join(f"sizeof {name}" for name in names)
        + "); return 0; }\n"
    )
    subprocess.run(["gcc", "-o", tmp_path / "sizes", source], check=True, cwd=tmp_path)
    size = subprocess.run([tmp_path / "sizes"], capture_output=True, text=True, check=True).stdout
    assert f" {size} bytes of constant tables" in header


# --- small boards -----------------------------------------------------------------------------------------


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


# --- names ---


@given(st.lists(st.text(max_size=80), unique=True), st.integers(6, 70))
def test_identifiers_are_such_and_differ(names: list[str], longest: int) -> None:
    found = identifiers(names, keywords=C_KEYWORDS, longest=longest, taken=["X_Y"])
    assert list(found) == names
    assert len({text.lower() for text in found.values()}) == len(names)
    for text in found.values():
        assert text.isascii()
        assert text.isidentifier()
        assert len(text) <= longest
        assert text not in C_KEYWORDS
        assert text.lower() != "x_y"
    assert identifiers(names, keywords=C_KEYWORDS, longest=longest, taken=["X_Y"]) == found


def named(name: str) -> dict[str, str]:
    """The files of a small mission of some name."""
    activity = Activity(name="a", alternatives=(Alternative(name="w", consumes=("h",)),))
    robot = Robot(name="r", hardware=(Hardware(name="h"),), activities=(activity,))
    blocks = (Objective(name="o", activities=("a",), timeout=1.0),)
    mission_net = compose(Mission(name=name, robots=(robot,), blocks=blocks))
    return files(document(generate(mission_net), mission_net), "c")


def test_no_mission_s_name_makes_a_name_of_the_templates(tmp_path: Path) -> None:
    text = "\n".join(named("zz").values())
    interface = set(re.findall(r"\bzz_(\w+)", text))
    words = {word for word in re.findall(r"\b[a-z]\w*\b", text) if not word.startswith("zz")}
    clashing = {w[: -len(i) - 1] for w in words for i in interface if w.endswith(f"_{i}")}
    assert {"local", "move"} <= clashing
    headers = set(re.findall(r"#include <(\w+)\.h>", text))
    assert {"stdint", "string"} <= headers
    for name in clashing | headers:
        assert f"{name}.h" not in named(name)
    for name in ("local", "string", "int", "a_b"):
        build(named(name), tmp_path / name, "-I", str(tmp_path / name))


def test_collisions_and_keywords() -> None:
    assert identifiers(["a.b", "a_b", "A_B", "int", "1", ""], keywords=C_KEYWORDS) == {
        "a.b": "a_b",
        "a_b": "a_b_2",
        "A_B": "A_B_3",
        "int": "int_2",
        "1": "x_1",
        "": "x_",
    }
    long = ["x" * 200 + "a", "x" * 200 + "b"]
    assert len(set(identifiers(long, longest=C_SIGNIFICANT).values())) == 2


@example("*\\")
@example("/\\*/*/")
@given(st.text(max_size=40) | st.text('*/\\?\n"', max_size=8))
def test_strings_end_where_they_should(text: str) -> None:
    literal = c_string(text)
    assert literal.isascii()
    assert literal[0] == literal[-1] == '"'
    inner = literal[1:-1]
    assert '"' not in inner
    assert "?" not in inner
    read = json.loads('"' + inner.replace("\\", "\\\\") + '"') if inner.isascii() else ""
    out, i = bytearray(), 0
    while i < len(read):
        if read[i] == "\\":
            out.append(int(read[i + 1 : i + 4], 8))
            i += 4
        else:
            out += read[i].encode()
            i += 1
    assert bytes(out) == text.encode("utf-8", "replace")
    assert "*/" not in comment(text)
    assert "\n" not in comment(text)


def test_arrays_are_as_small_as_their_numbers() -> None:
    assert [Array("a", v, "").bytes for v in ([], [255, 0], [256], [65536])] == [1, 2, 2, 4]
