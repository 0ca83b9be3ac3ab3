"""The experiment that changes mcpn at one place at a time: what it draws, and what it says of it."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

from tests.conftest import ROOT

SOURCE = b'''"""A file: a < b."""

def larger(a: int, b: int, often: bool = False) -> int:
    """The larger: a < b."""
    assert a != b, f"{a + b}"
    if a < b and not often:
        return b
    raise ValueError("a + b")
'''


@pytest.fixture(scope="module")
def mutants() -> ModuleType:
    sys.path.append(str(ROOT / "experiments" / "faults"))
    try:
        import mutants  # type: ignore[import-not-found]
    finally:
        sys.path.remove(str(ROOT / "experiments" / "faults"))
    found: ModuleType = mutants
    return found


def test_the_mutants_of_a_small_file(mutants: ModuleType) -> None:
    found = mutants.mutants_of("small.py", SOURCE)
    changes = {m.told(SOURCE).partition("larger: ")[2] for m in found}
    condition = "a < b and not often"
    assert changes == {
        "False  ->  True",  # the default
        *(f"{condition}  ->  {other}" for other in ("False", "True", "(a < b or not often)")),
        *(f"{condition}  ->  {other}" for other in ("(not often)", "(a < b)")),
        "a < b  ->  (a <= b)",
        "not often  ->  (often)",
        "return b  ->  return None",
        'raise ValueError("a + b")  ->  pass',
    }
    assert {m.line for m in found} == {3, 6, 7, 8}


@pytest.mark.parametrize(
    "path",
    ["mcpn/errors.py", pytest.param("mcpn/spaces/stable/confluence_by_sets.py", marks=pytest.mark.slow)],
)
def test_each_mutant_parses_and_is_another_program(mutants: ModuleType, path: str) -> None:
    source = (ROOT / path).read_bytes()
    found = mutants.mutants_of(path, source)
    programs = {ast.dump(ast.parse(mutant.applied(source))) for mutant in found}
    assert len(found) > 20
    assert ast.dump(ast.parse(source)) not in programs


def test_each_folder_has_its_share_of_every_beginning(mutants: ModuleType) -> None:
    made = [
        mutants.Mutant(f"{folder}/f.py", line, "-", 0, 0, "")
        for folder, count in (("few", 10), ("many", 90))
        for line in range(count)
    ]
    for seed in range(5):
        drawn = mutants.stratified(made, seed)
        assert sorted(drawn, key=made.index) == made
        for number in range(len(drawn)):
            few = sum(mutant.path == "few/f.py" for mutant in drawn[:number])
            assert abs(few - number / 10) <= 2
    assert mutants.stratified(made, 1) == mutants.stratified(made, 1) != mutants.stratified(made, 2)


def test_the_tests_that_call_what_is_changed(mutants: ModuleType) -> None:
    one, other = {"mcpn/a.py": ["A.f", "g"]}, {"mcpn/a.py": ["g"], "mcpn/b.py": ["h"]}
    tests = [
        mutants.Test("", 0.0, {"mcpn/b.py": ["h"]}),  # when the tests are imported
        mutants.Test("tests/test_x.py::one", 3.0, one),
        mutants.Test("tests/test_y.py::two", 1.0, other),
        mutants.Test("tests/test_x.py::three", 2.0, one),
        mutants.Test("tests/test_y.py::four", 9.0, {"mcpn/c.py": ["k"]}),
    ]

    def noticing(path: str, around: str, outside: bool = False, seconds: float = 100) -> list[str]:
        found = mutants.noticing(mutants.Mutant(path, 1, around, 0, 0, "", outside), tests, seconds)
        return [name.partition("::")[2] for name in found]

    assert noticing("mcpn/a.py", "A.f") == ["three", "one"]
    assert noticing("mcpn/a.py", "g") == ["two", "three", "one"]
    assert noticing("mcpn/a.py", "g", seconds=4) == ["two", "three"]
    assert noticing("mcpn/a.py", "g", seconds=0.5) == ["two"]
    assert noticing("mcpn/a.py", "nobody") == []
    assert noticing("mcpn/a.py", "A", outside=True) == ["two", "three", "one"]
    assert noticing("mcpn/b.py", "h") == ["two"]
    assert noticing("mcpn/b.py", "elsewhere") == []


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout with two files and the experiment."""
    for path in ("experiments/faults", "mcpn/spaces"):
        (tmp_path / path).mkdir(parents=True)
    shutil.copy(ROOT / "experiments" / "faults" / "mutants.py", tmp_path / "experiments" / "faults")
    for name in ("old", "new"):
        (tmp_path / "mcpn" / "spaces" / f"{name}.py").write_bytes(SOURCE)
    return tmp_path


def listed(checkout: Path, *arguments: str, path: str | None = None) -> tuple[set[str], str]:
    """The files of which mutants are drawn, and what is said beside."""
    environment = {**os.environ, "GIT_CEILING_DIRECTORIES": str(checkout.parent)}
    command = [sys.executable, "experiments/faults/mutants.py", "--list", "--seed", "1", *arguments]
    found = subprocess.run(
        command,
        cwd=checkout,
        env={**environment, "PATH": environment["PATH"] if path is None else path},
        capture_output=True,
        text=True,
        check=True,
    )
    return set(re.findall(r"^mcpn/spaces/(\w+)\.py:", found.stdout, re.MULTILINE)), found.stderr


@pytest.mark.skipif(shutil.which("git") is None, reason="needs git")
def test_since_a_revision_or_a_date(checkout: Path) -> None:
    def git(*arguments: str, day: int) -> None:
        at = f"2020-01-{day:02}T12:00:00"
        who = {"GIT_AUTHOR_DATE": at, "GIT_COMMITTER_DATE": at}
        command = ["git", "-c", "user.name=n", "-c", "user.email=e@e", *arguments]
        subprocess.run(command, cwd=checkout, env={**os.environ, **who}, check=True, capture_output=True)

    new = checkout / "mcpn" / "spaces" / "new.py"
    git("init", day=1)
    git("add", ".", day=1)
    git("commit", "-m", "first", day=1)
    new.write_bytes(SOURCE + b"\n")
    (checkout / "mcpn" / "spaces" / "gone.py").write_bytes(SOURCE)
    git("add", ".", day=20)
    git("commit", "-m", "second", day=20)
    git("rm", "mcpn/spaces/gone.py", day=21)
    git("commit", "-m", "third", day=21)
    assert listed(checkout) == ({"old", "new"}, "")
    assert listed(checkout, "--since", "HEAD~2") == ({"new"}, "")
    assert listed(checkout, "--since", "HEAD") == (set(), "")
    assert listed(checkout, "--since", "2020-01-10") == ({"new"}, "")
    assert listed(checkout, "--since", "2019-12-24") == ({"old", "new"}, "")
    new.write_bytes(SOURCE + b"\n\n")  # not committed yet
    assert listed(checkout, "--since", "HEAD") == ({"new"}, "")


@pytest.mark.parametrize("path", [None, ""], ids=["no repository", "no git"])
def test_without_git_all_files_are_drawn_and_it_says_so(checkout: Path, path: str | None) -> None:
    files, said = listed(checkout, "--since", "HEAD", path=path)
    assert files == {"old", "new"}
    assert said == "git does not know what changed: mutants of all files are drawn\n"


@pytest.mark.slow
def test_a_run(tmp_path: Path) -> None:
    command = [
        sys.executable,
        str(ROOT / "experiments" / "faults" / "mutants.py"),
        "--seed",
        "1",
        "--number",
        "3",
    ]
    what = ["--why", "--folder", "mcpn/errors.py", "--tests", "tests/test_errors.py"]
    found = subprocess.run([*command, *what], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    lines = found.stdout.splitlines()
    assert re.fullmatch(r"3 of \d+ mutants of 1 files, --seed 1", lines[0])
    assert re.fullmatch(r"\d+ tests without any change: passed", lines[1])
    said = re.findall(r"^(killed|timeout|survived|not called) mcpn/errors\.py:", found.stdout, re.MULTILINE)
    assert len(said) == 3
    counts = (f"{said.count(how)} {how}" for how in ("killed", "timeout", "survived", "not called"))
    assert lines[-1] == f"3 run: {', '.join(counts)}"
    noticed = re.findall(r"^(?:FAILED|ERROR) tests/test_errors\.py", found.stdout, re.MULTILINE)
    assert len(noticed) == said.count("killed") > 0
