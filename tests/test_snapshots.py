"""What terminal and page say first of the worked missions, word for word, as a person has read it.

``python -m pytest tests/test_snapshots.py --rewrite`` writes ``tests/snapshots/`` anew; somebody reads what
changed, as another reader of the mission would, before it is kept.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from lxml import html

from tests.commands import mcpn
from tests.conftest import ROOT

SNAPSHOTS = Path(__file__).with_name("snapshots")
MISSIONS = ("ulysse", "courier", "drone", "glider", "rover")
TOLD = [f"{command}-{name}" for command in ("check",) for name in MISSIONS] + ["causes-ulysse", "page-ulysse"]
VOLATILE = re.compile(r"\d+\.\d+(?= s$)|\d{4}-\d\d-\d\d \d\d:\d\d UTC by mcpn \S+(?=engine)", re.MULTILINE)
"""Seconds, and when and by what a page was made."""


@pytest.mark.parametrize("name", TOLD)
def test_what_is_said_is_what_a_person_has_read(
    name: str, request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command, mission = name.split("-")
    monkeypatch.chdir(ROOT)  # a message names the file as it was given, and is wrapped where it is long
    path = Path("experiments", mission, "mission.xml")
    if command == "page":
        mcpn("report", path, "-o", tmp_path / "page.html")
        text = "\n".join(first_sheet(tmp_path / "page.html")) + "\n"
    else:
        text = mcpn("--width", 100, command, path).stdout
    text, file = VOLATILE.sub("-", text), SNAPSHOTS / f"{name}.txt"
    if request.config.getoption("--rewrite"):
        file.write_text(text)
    assert text == file.read_text(), "read what changed, and --rewrite keeps it"


def first_sheet(path: Path) -> Iterator[str]:
    """The lines of a report's first sheet, as they are read."""
    (header,) = html.parse(path).xpath("//header")
    for paragraph in header.iter("h1", "h2", "dt", "dd", "li", "p"):
        if isinstance(paragraph, html.HtmlElement):
            yield " ".join(paragraph.text_content().split())


def test_each_snapshot_is_compared() -> None:
    assert sorted(path.stem for path in SNAPSHOTS.iterdir()) == sorted(TOLD)
