"""The pages for users: their examples are run, their JSON keys and messages are those of the program."""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from mcpn.cli.line import command_line
from tests.commands import mcpn, output
from tests.conftest import ROOT, ULYSSE
from tests.drivers.robots import until

PAGES = sorted((ROOT / "docs").glob("*.md"))
COMMANDS = ROOT / "docs" / "commands.md"
FILE = re.compile(r'```xml title="(\S+)"\n(.*?)```', re.DOTALL)
KEYS = re.compile(r"<!-- keys: (.*?) -->\n((?:\|.*\n)+)")
EXIT_CODE = re.compile(r"#.*\bexit code (\d+)")
BLOCK = re.compile(
    r"(?:<!-- (?P<mark>[^\n]*?) -->\n)?"
    r'```(?P<kind>\w+)(?: title="(?P<title>\S+)")?\n(?P<text>.*?)```',
    re.DOTALL,
)
ELSEWHERE = {"ros2": "tests/controller/test_docs.py runs it with stand-ins for ROS 2"}
"""Pages whose Python is not run here, and where it is."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the mission that the pages speak of."""
    for path in (ROOT / "experiments" / "ulysse").glob("*.xml"):
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path / "build")  # generated Python is imported from there
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    return tmp_path


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_examples_run_in_their_order(page: Path, folder: Path) -> None:
    """Files are written, commands and Python run, and what a page shows of the output is in it."""
    shown, names = "", {"__name__": "__main__"}
    if "mcpn init ulysse --example ulysse" in page.read_text():
        for path in folder.glob("*.xml"):  # such a page begins with nothing but an installed mcpn
            path.unlink()
    for block in BLOCK.finditer(page.read_text()):
        mark, text = block["mark"] or "", block["text"]
        verb, _, rest = mark.partition(": ")
        if block["title"]:
            (folder / block["title"]).write_text(text)
        elif verb == "replace":
            file, _, old = rest.partition(" ")
            before = (folder / file).read_text()
            assert before.count(old) == 1
            (folder / file).write_text(before.replace(old, text.strip()))
        elif verb == "killed":
            killed(text, int(rest), folder)
        elif block["kind"] == "sh":
            assert mark == "run", "every shell example is marked <!-- run -->"
            shown = "".join(map(commanded, text.splitlines()))
        elif block["kind"] == "python" and page.stem not in ELSEWHERE:
            spoken(text, names)
        elif mark == "shows":
            lines = iter(" ".join(line.split()) for line in shown.splitlines())
            for line in text.splitlines():
                assert any(" ".join(line.split()) in found for found in lines), (
                    f"not shown, or not in this order: {line}"
                )


def commanded(line: str) -> str:
    """The output of one line of a shell example, which ends with the exit code that it says."""
    command, *rest = shlex.split(line, comments=True)
    if command == "cd":
        os.chdir(*rest)  # the fixture's monkeypatch comes back from it
        return ""
    target = rest.pop() if rest[-2:-1] == [">"] else None
    expected = EXIT_CODE.search(line)
    assert command == "mcpn"
    found = mcpn(*(rest[:-1] if target else rest))
    if found.returncode == 2 and ("pip install" in found.stderr or "named 'pyrobosim'" in found.stderr):
        pytest.skip(found.stderr)  # an extra that is not installed; the extra "test-all" has them all
    assert found.returncode == (int(expected[1]) if expected else 0), f"{line}: {found.stderr}"
    if target is not None:
        Path(target).write_text(found.stdout)
    return found.stdout


def killed(line: str, status: int, folder: Path) -> None:
    """Runs one line as a process of its own, which is killed; nothing that it has started goes on."""
    command, *rest = shlex.split(line)
    assert command == "mcpn"
    run = subprocess.Popen([sys.executable, "-m", "mcpn.cli", *rest], cwd=folder, stdout=subprocess.DEVNULL)
    assert run.wait(120) == 128 - status  # a shell tells the number of a signal so
    until(lambda: not in_folder(folder), 120)


def in_folder(folder: Path) -> list[int]:
    """The processes that run in a folder, but for this one."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if (process / "cwd").resolve() == folder.resolve() and int(process.name) != os.getpid():
                found.append(int(process.name))
    return found


def spoken(text: str, names: dict[str, Any]) -> None:
    """Runs Python; what it prints is what the comments after its print lines say."""
    told = []
    for line, after in pairwise([*text.splitlines(), ""]):
        if "print(" in line and re.search(r"\)  # \S", line):
            told.append(line.rpartition("  # ")[2])
        if after.startswith("# "):
            told.append(after[2:])
    out = io.StringIO()
    for module in re.findall(r"^(?:from|import) (distributed|stormpy)\b", text, re.MULTILINE):
        pytest.importorskip(module, reason=f"needs {module}: the extra test-all")
    with contextlib.redirect_stdout(out):
        exec(compile(text, "<example>", "exec"), names)
    assert not told or out.getvalue().splitlines() == told


README = (ROOT / "README.md").read_text()
FIRST, SECOND, *TOUR = (found["text"] for found in BLOCK.finditer(README) if found["kind"] == "sh")
"""The two commands that set mcpn up and test it, and what the tour shows."""


@pytest.fixture
def clone(folder: Path) -> Path:
    """A checkout, as far as the page speaks of it."""
    (folder / "experiments").symlink_to(ROOT / "experiments")
    return folder


def test_the_readme_begins_with_what_mcpn_answers() -> None:
    """An activity of the mission, and what the program prints; then two commands."""
    begins = README[: README.index("## Set-up")]
    written, shown = (found["text"] for found in BLOCK.finditer(begins))
    robot = " ".join(ULYSSE.with_name("robot.xml").read_text().split())
    assert " ".join(written.split()) in robot
    assert set(shown.splitlines()) <= set(mcpn("causes", ULYSSE).stdout.splitlines())
    assert README.index("![The report") < README.index(FIRST) < README.index(SECOND)
    assert (FIRST + SECOND).count("\n") == 2
    install = re.compile(r"\.venv/bin/pip install (\S+)")
    assert [*install.findall(FIRST), *install.findall(SECOND)] == [".", '"mcpn[test]"']  # built once


def test_the_shell_of_the_readme_runs(clone: Path) -> None:
    for command in FIRST.split(" && ")[2:]:
        commanded(command.removeprefix(".venv/bin/"))
    assert (clone / "build" / "ulysse" / "controller.json").is_file()
    for line in "".join(TOUR).splitlines():
        if line != ". .venv/bin/activate":
            commanded(line)


def test_the_python_of_the_readme_is_true_in_a_script_in_the_checkout() -> None:
    (text,) = (found["text"] for found in BLOCK.finditer(README) if found["kind"] == "python")
    unsafe = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}
    run = subprocess.run(
        [sys.executable, "-c", text], cwd=ROOT, env=unsafe, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.splitlines() == re.findall(r"  # (.*)", text)


@pytest.mark.parametrize(("line", "table"), KEYS.findall(COMMANDS.read_text()))
def test_keys_are_those_of_the_command(line: str, table: str) -> None:
    arguments = shlex.split(line)
    if "mission.pnml" in arguments:
        output("convert", "mission.xml", "mission.pnml")
    if "drivers.toml" in arguments:
        activities = re.findall(r'<activity name="(\w+)"', Path("robot.xml").read_text())
        nothing = "".join(f"[activities.{name}]\nnothing = true\n" for name in activities)
        Path("drivers.toml").write_text(f'never = ["*"]\n{nothing}')
    found = output(*arguments)
    named = [name for row in table.splitlines()[2:] for name in re.findall(r"`(\w+)`", row.split("|")[1])]
    assert sorted(named) == sorted(found[0] if isinstance(found, list) else found)


def test_every_command_has_its_keys_on_the_page() -> None:
    described = {shlex.split(line)[0] for line, _ in KEYS.findall(COMMANDS.read_text())}
    assert described | {"lsp", "serve"} == set(command_line.commands)  # which prints nothing for programs


def test_the_message_of_contention_is_the_programs(folder: Path) -> None:
    text = (ROOT / "docs" / "contention.md").read_text()
    for name, content in FILE.findall(text):
        (folder / name).write_text(content)
    ((name, message),) = re.findall(r"<!-- message: (\S+) -->\n```text\n(.*?)\n```", text, re.DOTALL)
    for engine in ("explicit", "symbolic", "local"):
        assert message in mcpn("check", name, "--engine", engine).stdout.replace("\n", " ")
    assert output("alternatives", name, code=1)["message"] == message


TEXTS = [
    *PAGES,
    *sorted(ROOT.glob("*.md")),
    *sorted((ROOT / "papers").glob("*.md")),
    ROOT / "experiments" / "README.md",
    *sorted((ROOT / "experiments").glob("*/README.md")),
    ROOT / "changelog.d" / "README.md",
]


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as sites and viewers of Markdown make them."""
    prose = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
    titles = re.findall(r"^#+ (.*)$", prose, re.MULTILINE)
    plain = (re.sub(r"\[(.*?)\]\(.*?\)", r"\1", title).lower() for title in titles)
    return {re.sub(r"[^\w\- ]", "", title).strip().replace(" ", "-") for title in plain}


@pytest.mark.parametrize("page", TEXTS, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for target, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)\s]*))?\)", page.read_text()):
        if "://" in target:
            continue
        path = page.parent / target if target else page
        assert path.exists(), f"{page.name}: {target}"
        if anchor:
            assert anchor in anchors(path), f"{page.name}: {target}#{anchor}"


def test_the_page_on_adding_names_what_is_there() -> None:
    """Files that have been renamed or split since, and names that no longer stand in them."""

    def found(file: str) -> Path:
        return next((path for path in (ROOT / "mcpn" / file, ROOT / file) if path.exists()), ROOT / "none")

    page = (ROOT / "docs" / "adding.md").read_text()
    files = {*re.findall(r"`((?:\w+/)+[\w.]*\w)`", page)}
    assert len(files) > 50
    assert {file for file in files if found(file).name == "none"} == set()
    named = re.findall(r"`(\w+)`(?:(?:,| and| or)? `\w+`)* (?:in|of) `((?:\w+/)+\w+\.py)`", page)
    assert len(named) > 20
    assert [
        (name, file) for name, file in named if not re.search(rf"\b{name}\b", found(file).read_text())
    ] == []


@pytest.mark.slow
def test_the_site_builds_without_a_warning_and_loads_nothing_from_elsewhere(folder: Path) -> None:
    pytest.importorskip("mkdocs", reason="needs mcpn[docs]")
    built = subprocess.run(
        [
            sys.executable,
            "-m",
            "mkdocs",
            "build",
            "--strict",
            "-q",
            "-f",
            ROOT / "mkdocs.yml",
            "-d",
            folder / "site",
        ],
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    pages = list((folder / "site").rglob("*.html"))
    assert len(pages) > len(PAGES)
    for page in pages:
        loaded = re.findall(
            r"<(?:script|link|img|iframe)[^>]*(?:src|href)=[\"']?((?:https?:)?//[^\"'> ]+)", page.read_text()
        )
        assert loaded == [], page.name


def test_the_first_page_leads_to_every_other() -> None:
    """Three readers have a path each; no page stands beside them."""
    text = (ROOT / "docs" / "index.md").read_text()
    paths = re.findall(r"^### (.*)$", text, re.MULTILINE)
    assert len(paths) == 3
    assert all(f"tutorial-{reader}.md" in text for reader in ("designer", "robot", "researcher"))
    assert {page.name for page in PAGES} - {"index.md"} <= set(re.findall(r"\]\(([\w-]+\.md)\)", text))
