"""The experiments: each says how long it takes; the paper's counts are those of today's code."""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.conftest import ROOT

FOLDER = ROOT / "experiments"
LIBRARIES = {
    "faults/both_checkers",
    "faults/callers",
    "faults/campaigns",
    "faults/golden_meaning",
    "faults/golden_play",
    "faults/golden_trees",
    "faults/seeded_list",
    "faults/seeded_missions",
    "nets/dd_engine",
    "shared/contest_nets",
    "shared/drawing",
    "shared/limits",
    "shared/plots",
    "shared/rates",
}
"""Modules that scripts share and that are no scripts."""
FOLDERS = ("counts", "growth", "nets", "judges", "faults", "robots", "shared")
"""The other folders hold missions."""
MODULES = {f"{name}/{path.stem}" for name in FOLDERS for path in (FOLDER / name).glob("*.py")}
SCRIPTS = sorted(MODULES - LIBRARIES)
PAPER = ROOT / "papers" / "mcpn.md"
PAPERS = (PAPER, ROOT / "papers" / "comparison.md")


def python(*arguments: object, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    known = os.environ.get("PYTHONPATH", "").split(os.pathsep)  # where mcpn may be that is not installed
    path = os.pathsep.join(filter(None, [*(str(FOLDER / name) for name in FOLDERS), *known]))
    environment = {**os.environ, "PYTHONPATH": path}
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
    _, *parts = re.split(r"^### \[?(\w+)/", (FOLDER / "README.md").read_text(), flags=re.MULTILINE)
    row = re.compile(r"^\| `(\w+)\.py`[^|]*\|.*\| ([^|]+) \|$", re.MULTILINE)
    rows = [
        (f"{folder}/{name}", time)
        for folder, text in zip(parts[::2], parts[1::2], strict=True)
        for name, time in row.findall(text)
    ]
    assert sorted(name for name, _ in rows) == SCRIPTS
    assert all(re.search(r"second|minute", time) for _, time in rows)
    assert not [*FOLDER.glob("*.py")], "a script stands in the folder of its question"


@pytest.mark.parametrize("script", SCRIPTS)
def test_a_script_says_how_long_it_takes(script: str) -> None:
    text = (FOLDER / f"{script}.py").read_text()
    said = text.partition('"""')[2].partition('"""')[0]
    assert re.search(r"second|minute", said), "the first lines say how long it takes"
    assert "ArgumentParser(" in text or "campaigns.ran(" in text, "--help shows them"


def test_help_shows_the_time() -> None:
    found = python(FOLDER / "counts" / "explicit_vs_symbolic.py", "--help")
    assert found.returncode == 0, found.stderr
    assert "minutes" in found.stdout


def test_a_mission_seldom_comes_back_to_a_file_that_it_has_left() -> None:
    """Of Ulysse: what one file has found out of a mission is handed on, and not found out again."""
    found = python(FOLDER / "faults" / "returns.py")
    returns = {name: int(number) for name, number in re.findall(r"(\w+): .* (\d+) returns", found.stdout)}
    assert {*returns} == {"check", "causes", "controller"}, found.stderr
    assert max(returns.values()) <= 25


SMALL = {
    "sizes": r".*",
    "times": r".*",
    "controllers": r".*",
    "ways": r"ulysse|share 2|drivers 2",
    "proofs": r"(sites|hardware|data) \d",
    "growth": r"\w+ [1-4]",
    "sections": r"10|100",
    "causes": r".*",
    "side_by_side": r"(philosophers|slotted_ring|queens|branches|kanban|component_ring) [1-4]\b.*",
}
"""By table the rows that take a second or two at most; all others are compared where slow tests run."""


def stale(tables: Mapping[str, str], **asked: object) -> str:
    """What pages say of some rows of some tables that today's code does not."""
    script = (
        "import paper, re\n"
        "found = []\n"
        f"for name, rows in {dict(tables)!r}.items():\n"
        "    wanted = re.compile(rows).fullmatch\n"
        f"    asked = paper.Asked(wanted=lambda row: bool(wanted(row)), **{asked!r})\n"
        "    found += paper.stale(name, asked)\n"
        "print(*found, sep='\\n')\n"
    )
    found = python("-c", script)
    assert found.returncode == 0, found.stderr
    return found.stdout.strip()


@pytest.mark.parametrize("part", [0, 1])
def test_counts_in_the_papers_are_those_of_today(part: int) -> None:
    """In two processes, since each takes a second to begin."""
    tables = dict([*SMALL.items()][part::2])
    assert not stale(tables, seconds=60, timed=False), "run python experiments/counts/paper.py"


@pytest.mark.slow
@pytest.mark.parametrize("table", [name for name, rows in SMALL.items() if rows != ".*"])
def test_all_counts_in_the_papers_are_those_of_today(table: str) -> None:
    """Also of large missions, by each engine: some ten minutes."""
    assert not stale({table: ".*"}), "run python experiments/counts/paper.py"


def test_each_table_of_the_papers_is_measured_and_held() -> None:
    text = "".join(path.read_text() for path in PAPERS)
    tables = re.findall(r"<!-- measured: (\w+) -->\n(.*?)<!-- end -->", text, re.DOTALL)
    found = python("-c", "import paper; print(*paper.TABLES)")
    assert {name for name, _ in tables} == {*found.stdout.split()} == {*SMALL, "machine"}
    for name, table in tables:
        rows = [" ".join(row[: 2 if name in ("growth", "side_by_side") else 1]) for row in rows_of(table)]
        assert name == "machine" or any(re.fullmatch(SMALL[name], row) for row in rows)


def test_a_count_that_is_not_todays_is_told(tmp_path: Path) -> None:
    """Of a page with one digit changed, and with one row that there is not."""
    script = (
        "import paper, pathlib\n"
        "page = paper.PAGES[0].read_text()\n"
        "one, other = '| stable markings | 765 | 260 |', '| markings | 819111 | 44299 |'\n"
        "assert one in page and other in page\n"
        f"path = pathlib.Path({str(tmp_path / 'page.md')!r})\n"
        "path.write_text(page.replace(one, one.replace('260', '261')).replace(other, '| cards | 1 | 2 |'))\n"
        "paper.PAGES = (path,)\n"
        "for told in paper.stale('sizes', paper.Asked()): print(told)\n"
    )
    found = python("-c", script)
    assert found.returncode == 0, found.stderr
    rows, *counts = found.stdout.splitlines()
    assert {*rows.removeprefix("sizes: rows ").split(", ")} == {"cards", "markings"}
    assert "sizes, stable markings, mcpn: the page says 261, today's code 260" in counts


def rows_of(table: str) -> list[list[str]]:
    """The rows of a table of a paper, below its head."""
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()[2:]]


def test_the_paper_is_measured_without_the_tests() -> None:
    """The package and the folder of experiments are enough."""
    found = python(
        "-c", "import paper, sys; assert not [m for m in sys.modules if m.split('.')[0] == 'tests']"
    )
    assert found.returncode == 0, found.stderr


NOT_MEASURED = {
    *("133", "150", "155", "764", "3628", "765", "2017"),  # what the paper prints, and what is near it
    "41",  # switches of the search for designs
    "10",  # seconds after which a listing, or a proof, is stopped
    "17",  # digits of the parts that vectors of chances are counted in
    "4,096",  # firings behind an event after which each marking is kept
}


def test_numbers_in_the_prose_of_the_papers_are_constants() -> None:
    """What is measured stands in tables, which are written anew; Table 1 is held elsewhere."""
    prose = "".join(path.read_text().partition("## References")[0] for path in PAPERS)
    prose = re.sub(r"<!-- measured: \w+ -->\n.*?<!-- end -->", "", prose, flags=re.DOTALL)
    words = re.sub(r"\[\d+(?:, \d+)*\]|(?:Fig\.|Proposition|section) \d+", "", prose)
    assert {*re.findall(r"(?<![\w.])\d[\d,]*\d(?![\w.]*\w)", words)} <= NOT_MEASURED
    assert not re.findall(r"\d ?ms\b|\d\.\d+ s\b", prose)
    assert "kUnkept = 4096;" in (ROOT / "kernel" / "src" / "markings" / "settling.cpp").read_text()
    assert table1_sizes() == {"133", "150"}


def table1_sizes() -> set[str]:
    """Places and transitions of the paper's net, as its table on the page says."""
    rows = re.findall(r"^\| (?:places|transitions) \| (\d+) \| (\d+) \|$", PAPER.read_text(), re.MULTILINE)
    assert all(one == other for one, other in rows)
    return {one for one, _ in rows}


@pytest.mark.parametrize("paper", PAPERS, ids=lambda path: path.stem)
def test_no_table_of_the_papers_is_empty_or_typed_by_hand(paper: Path) -> None:
    page = paper.read_text()
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


def test_trees_are_asked_the_same() -> None:
    """By mcpn, and by a model checker where one is installed with BehaVerify: each answer is known."""
    found = python(FOLDER / "judges" / "trees.py", "--sizes", 2, 3)
    assert found.returncode == 0, found.stderr
    rows = rows_of(found.stdout)
    assert [row[:2] for row in rows] == [["2", "7"], ["3", "10"]]
    assert all(re.fullmatch(r"\d+\.\d\d", row[2]) for row in rows)


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


def test_modes_of_the_mission_with_suaves_job_are_all_that_its_tree_changes_to() -> None:
    """Two for motion, three for the search; the page has what the script finds."""
    found = python(
        "-c", "import nav2; print(nav2.put(nav2.PAGE.read_text(), 'suave', '\\n'.join(nav2.modes()) + '\\n'))"
    )
    assert found.returncode == 0, found.stderr
    page = (ROOT / "papers" / "nav2.md").read_text()
    assert found.stdout == page + "\n"
    for motion in ("all_thrusters", "recover_thrusters"):
        assert f"| inspect | {motion} |  |\n" in page
        assert all(f"| search | {motion} | spiral_{path} |\n" in page for path in ("high", "medium", "low"))
    assert page.count("| search |") == 6


def test_nav2s_default_tree(trees: Path) -> None:
    found = python(FOLDER / "robots" / "nav2.py", "--trees", trees)
    assert found.returncode == 0, found.stderr
    sets = ("controller_server", "lidar", "odometry", "planner_server", "wheels")
    fails = " or ".join(f"`{name}`" for name in sets)
    assert f"The mission fails by the loss of {fails}." in found.stdout
    assert "| A path is followed by dead reckoning |" in found.stdout
    assert found.stdout.count("| no |") == 3
    assert (
        "| nothing | objective Sequence3.BackUp (all 6) leads only to failure by its success" in found.stdout
    )


def test_what_grows_is_plotted(tmp_path: Path) -> None:
    """The smallest member of each family, in the files of ``-o``."""
    pytest.importorskip("matplotlib", reason="needs matplotlib: the extra experiments")
    folder = tmp_path / "new" / "folder"
    found = python(FOLDER / "counts" / "explicit_vs_symbolic.py", "--most", 1, "-o", folder)
    assert found.returncode == 0, found.stderr
    with (folder / "explicit_vs_symbolic.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["family"], row["n"]) for row in rows] == [("branches", "1"), ("row", "1")]
    assert (folder / "explicit_vs_symbolic.svg").read_text().count(">CPU seconds<") == 2
    (tmp_path / "file").touch()
    found = python(FOLDER / "counts" / "explicit_vs_symbolic.py", "-o", tmp_path / "file" / "below")
    assert (found.returncode, found.stdout) == (2, "")
    assert "Traceback" not in found.stderr
