"""The C target: compiles without a warning, does what the runtime does, and survives any input."""

from __future__ import annotations

import random
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

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
