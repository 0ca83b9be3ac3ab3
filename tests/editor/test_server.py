"""The server for editors, by a client that shares no code with it."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import ROOT
from tests.editor.client import Client

pytest.importorskip("pygls", reason="needs mcpn[editor]")


@pytest.fixture
def client() -> Iterator[Client]:
    made = Client()
    yield made
    assert made.close() == 0


@pytest.fixture(scope="module")
def lasting() -> Iterator[Client]:
    """One server for tests that leave it as it was: to start one takes a second."""
    made = Client()
    yield made
    assert made.close() == 0


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copytree(ROOT / "experiments" / "ulysse", tmp_path / "ulysse")
    return (tmp_path / "ulysse").resolve()


def place(path: Path, text: str, part: str, within: int = 1) -> dict[str, Any]:
    """The parameters that ask about a part of a text."""
    before = text[: text.index(part) + within]
    position = {"line": before.count("\n"), "character": len(before) - before.rfind("\n") - 1}
    return {"textDocument": {"uri": path.as_uri()}, "position": position}


def said(text: str, range_: dict[str, Any]) -> str:
    """The text of a range in one line."""
    line: str = text.splitlines()[range_["start"]["line"]]
    assert range_["start"]["line"] == range_["end"]["line"]
    begin, end = (int(range_[side]["character"]) for side in ("start", "end"))
    return line[begin:end]


def test_problems_as_typed_and_their_mends(client: Client, folder: Path) -> None:
    robot = folder / "robot.xml"
    text = robot.read_text().replace('consumes="GPS_position"', 'consumes="GPS_psition"')
    client.open(robot, text)
    while robot.as_uri() not in client.diagnostics:
        client.receive()
    (problem, *_) = client.diagnostics[robot.as_uri()]
    assert problem["severity"] == 1
    assert "GPS_psition" in problem["message"]
    assert said(text, problem["range"]) == "GPS_psition"
    actions = client.ask(
        "textDocument/codeAction",
        textDocument={"uri": robot.as_uri()},
        range=problem["range"],
        context={"diagnostics": [problem]},
    )
    assert "Change GPS_psition to GPS_position" in [action["title"] for action in actions]
    change = {"range": problem["range"], "text": "GPS_position"}
    document = {"uri": robot.as_uri(), "version": 2}
    client.tell("textDocument/didChange", textDocument=document, contentChanges=[change])
    client.diagnostics.clear()
    client.ask("textDocument/hover", **place(robot, text, "<hardware", 3))
    assert client.diagnostics[robot.as_uri()] == []


def test_names_across_files(client: Client, folder: Path) -> None:
    robot, protocols = folder / "robot.xml", folder / "protocols.xml"
    text = protocols.read_text()
    client.open(protocols)
    name = "thruster_actuator"
    (found,) = client.ask(
        "textDocument/definition",
        **place(
            robot, robot.read_text(), f' {name}"' if f' {name}"' in robot.read_text() else f'"{name}"', 3
        ),
    )
    assert found["uri"] == robot.as_uri()
    assert said(robot.read_text(), found["range"]) == name
    uses = client.ask(
        "textDocument/references",
        **place(robot, robot.read_text(), f'name="{name}"', 8),
        context={"includeDeclaration": True},
    )
    assert len(uses) == sum(
        path.read_text().count(name) for path in (robot, protocols, folder / "mission.xml")
    )
    edit = client.ask(
        "textDocument/rename", **place(robot, robot.read_text(), f'name="{name}"', 8), newName="propeller"
    )
    assert sum(map(len, edit["changes"].values())) == len(uses)
    at = place(protocols, text, "objective name", 17)
    assert "is no name" in client.refused("textDocument/rename", **at, newName="1 x")
    assert "is taken" in client.refused(
        "textDocument/rename", **place(protocols, text, "<objective", 17), newName="isopheric_observation"
    )


FORMULAS = """<mission name="m" xmlns="urn:mcpn:mission:1">
<robot name="r">
<hardware name="sonar"/><hardware name="motor"/><event name="leak"/><fact name="door" values="closed open"/>
<activity name="swim" requires="door=open"><alternative name="fast" consumes="motor"/>
<alternative name="slow"/></activity>
<activity name="look" consumes="sonar" faulty="true"/>
</robot>
<protocols><protocol name="p"><objective name="inside" activities="swim"/></protocol></protocols>
<requirement name="one" formula="G (happens(leak) -&gt; F !oos(sonar))"/>
<requirement name="two"><response to="fact(door)=open" gives="alternative(swim)=slow"/></requirement>
<objective name="out" success="home"><on event="leak" goto="home"/>
<objective name="dive" activities="swim look"/><use name="visit" protocol="p"/></objective>
<parallel name="both"><objective name="left" activities="swim" abort="fail"/>
<objective name="right" activities="look"/></parallel>
<objective name="home" activities="swim" success="succeed"><route when="door=open done(dive)" goto="out"/>
</objective>
</mission>
"""


def test_a_wrong_name_in_a_formula_is_underlined_at_once(client: Client, tmp_path: Path) -> None:
    path = (tmp_path / "mission.xml").resolve()
    client.open(path, FORMULAS)
    for right, wrong in (("oos(sonar", "oos(sonr"), ("alternative(swim)=slow", "alternative(swim)=slw")):
        client.diagnostics.clear()
        text = FORMULAS.replace(right, wrong)
        client.tell(
            "textDocument/didChange",
            textDocument={"uri": path.as_uri(), "version": 2},
            contentChanges=[{"text": text}],
        )
        client.ask("textDocument/hover", **place(path, text, "<hardware", 3))
        (problem,) = [d for d in client.diagnostics[path.as_uri()] if d["severity"] == 1]
        assert said(text, problem["range"]) == wrong.split("(")[1] if "=" not in wrong else "slw"


@pytest.mark.parametrize(
    ("part", "within", "has", "hasnt"),
    [
        ("happens(leak", 8, {"leak", "sonar_EV_OOS", "OBJ_dive_EV_OK", "look_EV_OOS"}, {"sonar", "dive"}),
        ("oos(sonar", 4, {"sonar", "motor", "look"}, {"leak", "swim"}),
        ("G (happens", 0, {"objective", "oos", "success", "AG"}, {"sonar"}),
        ("fact(door)=open", 11, {"closed", "open"}, {"door"}),
        ("swim)=slow", 6, {"fast", "slow"}, {"swim"}),
        ('requires="door', 10, {"door", "done"}, {"open", "leak"}),
        ('requires="door=open', 15, {"open", "closed"}, {"door"}),
        ("done(dive", 5, {"dive", "home", "left"}, {"both", "door"}),
        (
            'leak" goto="home',
            12,
            {"out", "both", "home", "succeed", "fail", "abort"},
            {"dive", "left", "inside"},
        ),
        ('abort="fail', 7, {"succeed", "fail", "abort"}, {"left", "right", "home"}),
    ],
)
def test_completion_inside_values(
    lasting: Client, tmp_path: Path, part: str, within: int, has: set[str], hasnt: set[str]
) -> None:
    path = (tmp_path / "mission.xml").resolve()
    lasting.open(path, FORMULAS)
    offered = {
        i["label"] for i in lasting.ask("textDocument/completion", **place(path, FORMULAS, part, within))
    }
    assert has <= offered
    assert not hasnt & offered


def test_outline_and_formatting(client: Client, tmp_path: Path) -> None:
    path = (tmp_path / "mission.xml").resolve()
    client.open(path, FORMULAS)
    (whole,) = client.ask("textDocument/documentSymbol", textDocument={"uri": path.as_uri()})
    assert whole["name"] == "m"
    assert [inner["name"] for inner in whole["children"]] == ["r", "p", "one", "two", "out", "both", "home"]
    options = {"tabSize": 2, "insertSpaces": True}
    (edit,) = client.ask("textDocument/formatting", textDocument={"uri": path.as_uri()}, options=options)
    assert edit["newText"].splitlines()[2] == '    <hardware name="sonar"/>'
    changed = {"uri": path.as_uri(), "version": 2}
    client.tell("textDocument/didChange", textDocument=changed, contentChanges=[{"text": edit["newText"]}])
    assert client.ask("textDocument/formatting", textDocument={"uri": path.as_uri()}, options=options) == []


def test_words_of_the_language(client: Client, folder: Path) -> None:
    mission = folder / "mission.xml"
    text = '<mission xmlns="urn:mcpn:mission:1" name="m"><import href="robot.xml"/>\n<objective name="o" \n'
    client.open(mission, text + '\n<parallel name="p">\n<\n')
    at = {"textDocument": {"uri": mission.as_uri()}}
    names = client.ask("textDocument/completion", **at, position={"line": 1, "character": 20})
    assert {"activities", "timeout", "retries"} <= {item["label"] for item in names}
    assert "name" not in {item["label"] for item in names}
    assert all(item["documentation"] for item in names)
    tags = client.ask("textDocument/completion", **at, position={"line": 4, "character": 1})
    assert {item["label"] for item in tags} >= {"objective", "use"}
    assert "parallel" not in {item["label"] for item in tags}
    words = text.replace('name="o" \n', 'name="o" activities="')
    client.tell(
        "textDocument/didChange",
        textDocument={"uri": mission.as_uri(), "version": 2},
        contentChanges=[{"text": words}],
    )
    end = {"line": 1, "character": len(words.splitlines()[1])}
    activities = client.ask("textDocument/completion", **at, position=end)
    assert "move" in {item["label"] for item in activities} or len(activities) > 3
    hover = client.ask("textDocument/hover", **at, position={"line": 1, "character": 14})
    assert hover["contents"]["value"].startswith("**name**")


def test_what_states_say_comes_after_a_save(client: Client, folder: Path) -> None:
    protocols = folder / "protocols.xml"
    client.open(protocols)
    for _ in range(200):
        said = hovered(client, protocols) or ""
        if "The loss of thruster_actuator, or of GPS_sensor and IMU_sensor together beforehand" in said:
            return
        time.sleep(0.2)
    pytest.fail("the states say nothing")


def hovered(client: Client, protocols: Path) -> str | None:
    found = client.ask("textDocument/hover", **place(protocols, protocols.read_text(), 'name="diving"', 8))
    return None if found is None else str(found["contents"]["value"])


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs devices")
def test_what_is_no_regular_file_is_not_read(client: Client, folder: Path) -> None:
    """Reading `/dev/zero` or a FIFO never ended, also one beside the file that is asked for."""
    os.mkfifo(folder / "fifo.xml")
    for uri in (
        "file:///dev/zero",
        (folder / "fifo.xml").as_uri(),
        folder.as_uri(),
        "file:///a%00b",
        "untitled:1",
    ):
        at = {"textDocument": {"uri": uri}, "position": {"line": 0, "character": 0}}
        assert client.ask("textDocument/hover", **at) is None
        client.ask("textDocument/completion", **at)
        client.tell("textDocument/didSave", textDocument={"uri": uri})
    beside = (folder / "nothing.xml").as_uri()
    client.tell("textDocument/didSave", textDocument={"uri": beside})
    at = {"textDocument": {"uri": beside}, "position": {"line": 0, "character": 0}}
    assert client.ask("textDocument/hover", **at) is None


OUTSIDE = """<robot name="r" xmlns="urn:mcpn:mission:1">
  <hardware name="hidden"/><activity name="a" consumes="hidden"/>
</robot>"""
IMPORTING = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <import href="HREF"/>
  <objective name="o" activities="a"/>
</mission>"""


@pytest.mark.parametrize("way", ["..", "link", "folder"])
def test_nothing_outside_of_the_mission_s_directory_is_read(client: Client, tmp_path: Path, way: str) -> None:
    inside = (tmp_path / "inside").resolve()
    inside.mkdir()
    outside = inside.parent / "outside.xml"
    outside.write_text(OUTSIDE)
    href = {"..": "../outside.xml", "link": "linked.xml", "folder": "around/outside.xml"}[way]
    (inside / "linked.xml").symlink_to(outside)
    (inside / "around").symlink_to(inside.parent)
    mission = inside / "mission.xml"
    mission.write_text(text := IMPORTING.replace("HREF", href))
    client.open(mission)
    at = place(mission, text, 'activities="', len('activities="'))
    assert client.ask("textDocument/definition", **at) == []
    labels = [item["label"] for item in client.ask("textDocument/completion", **at)]
    assert "a" not in labels
    assert "not declared" in client.refused("textDocument/rename", **at, newName="b")
    assert outside.as_uri() not in client.diagnostics
    (problem,) = client.diagnostics[mission.as_uri()]
    assert problem["message"].startswith(f"import of {href} leaves the mission's directory")


def test_a_linked_mission_beside_a_file_is_not_read(client: Client, tmp_path: Path) -> None:
    inside = (tmp_path / "inside" / "deep").resolve()
    inside.mkdir(parents=True)
    elsewhere = tmp_path / "elsewhere.xml"
    elsewhere.write_text(IMPORTING.replace("HREF", "robot.xml"))
    (inside / "mission.xml").symlink_to(elsewhere)
    robot = inside / "robot.xml"
    robot.write_text(OUTSIDE)
    client.open(robot)
    at = place(robot, OUTSIDE, 'name="a"', len('name="'))
    found = client.ask("textDocument/references", **at, context={"includeDeclaration": True})
    assert [each["uri"] for each in found] == [robot.as_uri()]


@pytest.mark.parametrize("href", ["a" * 300, "a&#0;b", "a\0b", "loop.xml", "."])
def test_an_import_that_no_file_can_have(lasting: Client, folder: Path, href: str) -> None:
    (folder / "loop.xml").symlink_to(folder / "loop.xml")
    mission = folder / "typed.xml"
    text = IMPORTING.replace("HREF", href)
    lasting.open(mission, text)
    hovered = lasting.ask("textDocument/hover", **place(mission, text, "activities"))
    assert "Activities" in hovered["contents"]["value"]


def test_two_names_on_an_element(lasting: Client, folder: Path) -> None:
    mission = folder / "typed.xml"
    text = IMPORTING.replace('<import href="HREF"/>', '<objective name="x" name="y" activities="a"/>')
    lasting.open(mission, text)
    (outer,) = lasting.ask("textDocument/documentSymbol", textDocument={"uri": mission.as_uri()})
    assert [inner["name"] for inner in outer["children"]] == ["x", "o"]


@pytest.mark.parametrize("length", ["99999999999", "9" * 30, "9" * 5000, "-5", "x", "0"])
@pytest.mark.parametrize("body", ["", "{}", "\n\n"])
def test_lengths_that_no_message_has_are_passed_over(
    lasting: Client, folder: Path, length: str, body: str
) -> None:
    """A length beyond memory ended the server."""
    assert lasting.process.stdin is not None
    lasting.process.stdin.write(f"Content-Length: {length}\r\n\r\n{body}".encode())
    at = {"textDocument": {"uri": (folder / "no.xml").as_uri()}, "position": {"line": 0, "character": 0}}
    assert lasting.ask("textDocument/hover", **at) is None
