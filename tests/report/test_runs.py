"""A run as a sequence diagram: the counterexample that check shows, each message by who says it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from lxml import etree

from mcpn.report.pictures.runs import Message, Sequence, mermaid
from tests.commands import mcpn, output
from tests.conftest import ROOT, ULYSSE

ENDLESS = """<mission name="endless" xmlns="urn:mcpn:mission:1">
  <robot name="auv">
    <hardware name="thruster" repairable="false"/><event name="call"/>
    <activity name="swim" consumes="thruster"/>
  </robot>
  <on event="call" goto="go"/>
  <requirement name="quiet" formula="AG !event(call)"/>
  <objective name="go" activities="swim"/>
</mission>
"""


def diagram(text: str) -> tuple[dict[str, str], list[tuple[str, str, str]]]:
    """Names of participants by key, and messages: from, to, text."""
    head, *lines = text.splitlines()
    assert head == "sequenceDiagram"
    names = dict(re.findall(r"^  participant (\w+) as (.*)$", text, re.MULTILINE))
    found = [m.groups() for line in lines if (m := re.fullmatch(r"  (\w+)(?:->>|--x)(\w+): (.*)", line))]
    return names, [(names[a], names[b], said) for a, b, said in found]


def test_mermaid_says_the_run_without_failures(tmp_path: Path) -> None:
    path = tmp_path / "run.mmd"
    output("convert", ULYSSE, path, "--draw", "run")
    names, messages = diagram(path.read_text())
    assert all(to == "controller" for _, to, _ in messages)
    events = [(who, said) for who, _, said in messages if who != "controller"]
    assert events[0] == ("operator", "mission ulysse starts")
    assert all(said == f"objective {who} succeeds" for who, said in events[1:])
    assert messages[-1][2] == "the mission ends in success"
    assert ("controller", "controller", "localisation runs as gps_localisation") in messages
    assert [*names.values()] == list(dict.fromkeys(["controller", *(who for who, _ in events)]))


def test_the_first_counterexample_is_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.xml").write_text(ENDLESS)
    shown = mcpn("check", "m.xml").stdout
    assert "quiet" in shown
    mcpn("convert", "m.xml", "run.mmd", "--draw", "run")
    text = Path("run.mmd").read_text()
    assert "title endless: quiet is not met" in text
    names, messages = diagram(text)
    assert ("operator", "controller", "mission endless starts") in messages
    mcpn("convert", "m.xml", "run.svg", "--draw", "run")
    root = etree.parse("run.svg").getroot()
    drawn = [str(t.text) for t in root.iter("{*}text")]
    assert drawn == ["endless: quiet is not met", *names.values(), *(said for *_, said in messages)]
    marked = [path.get("marker-end") for path in root.iter("{*}path")]
    assert sum(marker is not None for marker in marked) == len(messages)


def test_many_objectives_share_a_lifeline(tmp_path: Path) -> None:
    path = tmp_path / "run.mmd"
    output("convert", ROOT / "experiments" / "courier" / "mission.xml", path, "--draw", "run")
    names, messages = diagram(path.read_text())
    assert set(names.values()) == {"controller", "operator", "objectives"}
    assert ("objectives", "controller", "objective ride_up succeeds") in messages


def test_nothing_of_mermaids_own_stands_in_a_text() -> None:
    text = mermaid(Sequence("a;b", (Message("x#1", "50 % {of}\n<y>", "failure"),)))
    assert re.findall(r"[;#]", re.sub(r"#\d+;", "", text)) == []
    assert "\n  p1--xp0: 50 #37; #123;of#125; #60;y#62;\n" in text
