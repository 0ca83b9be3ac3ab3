"""The pages for users: their examples are run, their JSON keys and messages are those of the program."""

from __future__ import annotations

import io
import re
import shlex
import shutil
from pathlib import Path

import pytest

from mcpn.cli.line import command_line
from tests.commands import mcpn, output
from tests.conftest import ROOT

PAGES = sorted((ROOT / "docs").glob("*.md"))
COMMANDS = ROOT / "docs" / "commands.md"
RUN = re.compile(r"<!-- run -->\n```sh\n(.*?)```", re.DOTALL)
FILE = re.compile(r"<!-- file: (\S+) -->\n```xml\n(.*?)```", re.DOTALL)
KEYS = re.compile(r"<!-- keys: (.*?) -->\n((?:\|.*\n)+)")
EXIT_CODE = re.compile(r"#.*\bexit code (\d+)")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the mission that the pages speak of."""
    for path in (ROOT / "experiments" / "ulysse").glob("*.xml"):
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    return tmp_path


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_shell_examples_run(page: Path, folder: Path) -> None:
    text = page.read_text()
    for name, content in FILE.findall(text):
        (folder / name).write_text(content)
    blocks = RUN.findall(text)
    assert len(blocks) == text.count("```sh"), "every shell example is marked <!-- run -->"
    for line in "".join(blocks).splitlines():
        command, *rest = shlex.split(line, comments=True)
        target = rest.pop() if rest[-2:-1] == [">"] else None
        expected = EXIT_CODE.search(line)
        assert command == "mcpn"
        found = mcpn(*(rest[:-1] if target else rest))
        assert found.returncode == (int(expected[1]) if expected else 0), f"{line}: {found.stderr}"
        if target is not None:
            (folder / target).write_text(found.stdout)


@pytest.mark.parametrize(("line", "table"), KEYS.findall(COMMANDS.read_text()))
def test_keys_are_those_of_the_command(line: str, table: str) -> None:
    arguments = shlex.split(line)
    if "mission.pnml" in arguments:
        output("convert", "mission.xml", "mission.pnml")
    found = output(*arguments)
    named = [name for row in table.splitlines()[2:] for name in re.findall(r"`(\w+)`", row.split("|")[1])]
    assert sorted(named) == sorted(found[0] if isinstance(found, list) else found)


def test_every_command_has_its_keys_on_the_page() -> None:
    described = {shlex.split(line)[0] for line, _ in KEYS.findall(COMMANDS.read_text())}
    assert described == set(command_line.commands)


def test_the_message_of_contention_is_the_programs(folder: Path) -> None:
    text = (ROOT / "docs" / "contention.md").read_text()
    for name, content in FILE.findall(text):
        (folder / name).write_text(content)
    ((name, message),) = re.findall(r"<!-- message: (\S+) -->\n```text\n(.*?)\n```", text, re.DOTALL)
    for engine in ("explicit", "symbolic", "local"):
        assert message in mcpn("check", name, "--engine", engine).stdout.replace("\n", " ")
    assert output("alternatives", name, code=1)["message"] == message


def test_links_lead_somewhere() -> None:
    for page in [*PAGES, ROOT / "README.md", *(ROOT / "papers").glob("*.md")]:
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
            if "://" not in target:
                assert (page.parent / target).exists(), f"{page.name}: {target}"
