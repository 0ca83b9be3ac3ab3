"""The experiments: each says how long it takes; the paper's counts are those of today's code."""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import ROOT

FOLDER = ROOT / "experiments"
LIBRARIES = {"callers", "dd_engine", "drawing", "limits", "plots"}
"""Modules that scripts share and that are no scripts."""
SCRIPTS = sorted(path.stem for path in FOLDER.glob("*.py") if path.stem not in LIBRARIES)
PAPER = ROOT / "papers" / "mcpn.md"
COUNTS = ("sizes", "controllers")
"""Tables without seconds: the same on every machine."""


def python(*arguments: object, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(FOLDER)}
    environment.pop("PYTHONSAFEPATH", None)
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=folder or FOLDER,  # not beside the checkout's own mcpn, which has no kernel
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_readme_names_every_script_and_how_long_it_takes() -> None:
    text = (FOLDER / "README.md").read_text()
    rows = dict(re.findall(r"^\| `(\w+)\.py`[^|]*\|.*\| ([^|]+) \|$", text, re.MULTILINE))
    assert sorted(rows) == SCRIPTS
    assert all(re.search(r"second|minute", time) for time in rows.values())


@pytest.mark.parametrize("script", SCRIPTS)
def test_a_script_says_how_long_it_takes(script: str) -> None:
    text = (FOLDER / f"{script}.py").read_text()
    said = text.partition('"""')[2].partition('"""')[0]
    assert re.search(r"second|minute", said), "the first lines say how long it takes"
    assert "ArgumentParser(" in text, "--help shows them"


def test_help_shows_the_time() -> None:
    found = python(FOLDER / "explicit_vs_symbolic.py", "--help")
    assert found.returncode == 0, found.stderr
    assert "minutes" in found.stdout


def test_counts_of_the_paper_are_those_of_today() -> None:
    script = (
        "import paper, re\n"
        "page = paper.PAGE.read_text()\n"
        f"assert paper.renewed(page, {COUNTS!r}, 1) == page, 'run python experiments/paper.py'\n"
        "assert set(paper.TABLES) == {name for _, name, _ in paper.BLOCK.findall(page)}\n"
    )
    found = python("-c", script)
    assert found.returncode == 0, found.stderr


def test_counts_of_growing_missions_in_the_paper_are_those_of_today() -> None:
    """Up to four parts, by the engine that keeps diagrams."""
    rows = rows_of("growth")
    told = [(family, int(n), int(markings), int(stable)) for family, n, _, markings, stable, *_ in rows]
    small = [row for row in told if row[1] <= 4]
    assert len(small) == 8
    script = (
        "from explicit_vs_symbolic import find\n"
        f"for family, n, markings, stable in {small!r}:\n"
        "    found = find('symbolic', family, n)\n"
        "    assert (found['markings'], found['stable']) == (markings, stable), (family, n, found)\n"
    )
    found = python("-c", script)
    assert found.returncode == 0, found.stderr


def rows_of(table: str) -> list[list[str]]:
    """The rows of a table of the paper, below its head."""
    text = PAPER.read_text().partition(f"<!-- measured: {table} -->\n")[2].partition("<!-- end -->")[0]
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines()[2:]]


def test_counts_beside_seconds_in_the_paper_are_those_of_today() -> None:
    """What is counted of sections, causes, and what decides each event; of those that take seconds."""
    sections = [(int(n), *counts) for n, *counts in (row[:5] for row in rows_of("sections")) if int(n) <= 100]
    causes = [
        (*name.split(" of "), *map(int, counts)) for name, *counts in (r[:4] for r in rows_of("causes"))
    ]
    small = {"courier", "drone", "ulysse", "ladder 10", "producers 4", "share 2", "drivers 2", "drivers 3"}
    ways = {row[0]: [*map(int, row[1:8]), row[11].partition("; ")[2]] for row in rows_of("ways")}
    chosen = {name: counts for name, counts in ways.items() if name in small}
    assert (len(sections), len(causes), len(chosen)) == (2, 7, 8)
    script = (
        "import causes, orders\n"
        "from composition import run_engine\n"
        "from missions import Parameters, generate\n"
        "from mcpn.answers.causes.find import find_causes\n"
        "from mcpn.drawing.compose import compose\n"
        f"for number, *counts in {sections!r}:\n"
        "    found = run_engine('local', generate(Parameters(number, min(20, number), 30, per_section=4)))\n"
        "    said = [str(found[key]) for key in ('types', 'most', 'local', 'stable')]\n"
        "    assert said == counts, (number, said)\n"
        "shapes = {'in a row': causes.in_a_row, 'in a chain': causes.in_a_chain}\n"
        f"for shape, parts, hardware, cuts, paths in {causes!r}:\n"
        "    of = compose(shapes[shape](int(parts), 3))\n"
        "    found = find_causes(of, engine='local').mission\n"
        "    told = len(of.mission.hardware), len(found.cut_sets), 3 ** int(parts)\n"
        "    assert told == (hardware, cuts, paths), (shape, parts, told)\n"
        f"chosen = {chosen!r}\n"
        "for name, net in orders.nets():\n"
        "    if name in chosen:\n"
        "        found = orders.listed(net, 'enough')\n"
        "        kept = str(found['kept']).partition('; ')[2]\n"
        "        told = [found['states'], found['edges'], *found['decided'], kept]\n"
        "        assert told == chosen.pop(name), (name, told)\n"
        "assert not chosen, chosen\n"
    )
    found = python("-c", script)
    assert found.returncode == 0, found.stderr


def test_the_paper_is_measured_without_the_tests() -> None:
    """The package and the folder of experiments are enough."""
    found = python(
        "-c", "import paper, sys; assert not [m for m in sys.modules if m.split('.')[0] == 'tests']"
    )
    assert found.returncode == 0, found.stderr


NOT_MEASURED = {
    *("133", "150", "155", "764", "3628", "765", "2017"),  # what the paper prints, and what is near it
    "4,096",  # firings behind an event after which each marking is kept
    "5,000",  # milliseconds that a run which was stopped counts
}


def test_numbers_in_the_prose_of_the_paper_are_constants() -> None:
    """What is measured stands in tables, which are written anew; Table 1 is held elsewhere."""
    prose, _, _ = PAPER.read_text().partition("## References")
    prose = re.sub(r"<!-- measured: \w+ -->\n.*?<!-- end -->", "", prose, flags=re.DOTALL)
    assert {*re.findall(r"(?<![\w.])\d[\d,]*\d\d(?![\w.]*\w)", prose)} <= NOT_MEASURED
    assert not re.findall(r"\d ?ms\b|\d\.\d+ s\b", prose)
    assert "kUnkept = 4096;" in (ROOT / "kernel" / "src" / "markings" / "settling.cpp").read_text()
    assert table1_sizes() == {"133", "150"}


def table1_sizes() -> set[str]:
    """Places and transitions of the paper's net, as its table on the page says."""
    rows = re.findall(r"^\| (?:places|transitions) \| (\d+) \| (\d+) \|$", PAPER.read_text(), re.MULTILINE)
    assert all(one == other for one, other in rows)
    return {one for one, _ in rows}


def test_no_table_of_the_paper_is_empty_or_typed_by_hand() -> None:
    page = PAPER.read_text()
    blocks = re.findall(r"<!-- measured: \w+ -->\n(.*?)<!-- end -->", page, re.DOTALL)
    assert all(block.strip() for block in blocks)
    rest = re.sub(r"<!-- measured: \w+ -->\n.*?<!-- end -->", "", page, flags=re.DOTALL)
    assert not re.search(r"^\|", rest, re.MULTILINE)


def test_explicit_and_symbolic_side_by_side() -> None:
    """The smallest members of both families, counted by every engine that takes them."""
    script = (
        "from explicit_vs_symbolic import FAMILIES, find\n"
        "for family in FAMILIES:\n"
        "    engines = ('explicit', 'symbolic', 'direct', 'local')\n"
        "    by_engine = {engine: find(engine, family, 2) for engine in engines}\n"
        "    for name in ('markings', 'stable'):\n"
        "        assert len({found[name] for found in by_engine.values() if name in found}) == 1, by_engine\n"
    )
    found = python("-c", script)
    assert found.returncode == 0, found.stderr


def test_several_tokens_side_by_side() -> None:
    """The smallest members, by both engines."""
    script = (
        "from several_tokens import FAMILIES, SIZES, find\n"
        "for family, (size, *_) in SIZES.items():\n"
        "    found = [find(engine, family, size)['counts'] for engine in ('symbolic', 'explicit')]\n"
        "    assert found[0] == found[1], (family, found)\n"
        "    assert found[0][0] == FAMILIES[family].markings(size), (family, found)\n"
    )
    found = python("-c", script)
    assert found.returncode == 0, found.stderr


def test_what_grows_is_plotted(tmp_path: Path) -> None:
    """The smallest member of each family, in the files of ``-o``."""
    pytest.importorskip("matplotlib", reason="needs matplotlib: the extra experiments")
    folder = tmp_path / "new" / "folder"
    found = python(FOLDER / "explicit_vs_symbolic.py", "--most", 1, "-o", folder)
    assert found.returncode == 0, found.stderr
    with (folder / "explicit_vs_symbolic.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["family"], row["n"]) for row in rows] == [("branches", "1"), ("row", "1")]
    assert (folder / "explicit_vs_symbolic.svg").read_text().count(">seconds<") == 2
    (tmp_path / "file").touch()
    found = python(FOLDER / "families.py", "-o", tmp_path / "file" / "below")
    assert (found.returncode, found.stdout) == (2, "")
    assert "Traceback" not in found.stderr
