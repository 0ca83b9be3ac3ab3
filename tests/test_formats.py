"""JSON formats: what commands print and write is what the schemas of the package say."""

from __future__ import annotations

import json
import random
import shutil
from collections.abc import Iterator
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError

from mcpn.errors import SemanticsError
from mcpn.report.documents import FORMATS, json_schema
from mcpn.robot.runtime import Controller
from mcpn.robot.runtime.journal import Journal
from tests.commands import mcpn, output
from tests.conftest import ROOT

SCHEMAS: dict[str, dict[str, Any]] = {name: json_schema(document) for name, document in FORMATS.items()}
CONTENDED = ROOT / "docs" / "contention.md"
LATER = (
    '<mission name="later" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="wheels"/>'
    '<activity name="go" consumes="wheels"/></robot><objective name="one" activities="go"/></mission>'
)
UNBOUNDED = "net u\npl p (1)\ntr t p -> p q\npl q (0)\n"
PRINTED = {
    "check mission.xml": "check",
    "check mission.xml --engine local": "check",
    "check contended.xml --internal": "check",
    "check courier/mission.xml --strict": "check",
    "check mission.pnml": "check-net",
    "check unbounded.net": "check-net",
    "check dead.net": "check-net",
    "check dead.net --structure": "check-structure",
    "causes mission.xml": "causes",
    "causes mission.xml --objective transect.diving": "causes",
    "causes contended.xml": "error",
    "alternatives contended.xml": "error",
    "states unbounded.net": "error",
    "states unsafe.net": "states",
    "states mission.xml": "states",
    "states mission.xml --engine symbolic": "states",
    "states mission.xml --engine local": "states",
    "alternatives mission.xml": "alternatives",
    "alternatives mission.xml --engine symbolic": "alternatives",
    "compare dead.net": "compare",
    "compare courier/mission.xml later.xml": "compare-missions",
    "ask mission.xml EF(success) AF(success|failure)": "ask",
    "ask mission.xml EF(failure) --on alternatives --engine local": "ask",
    "ask mission.pnml --examination ReachabilityDeadlock": "ask",
    "ask mission.xml": "words",
    "ask courier/mission.xml --robot-safety": "robot-safety",
    "ask mission.xml --hoa F(success)": "automata",
    "ask courier/mission.xml": "words",
    "simulate mission.xml --random 9 --seed 3": "simulate",
    "simulate mission.xml --tokens --random 9": "simulate-tokens",
    "simulate dead.net --random 9": "simulate-tokens",
    "bench mission.xml --runs 20 --duration 1 --against python --traces one": "bench",
    "tests courier/mission.xml -o one": "tests",
    "tests nav/mission.xml --btcpp m.json --tree tree.xml": "mocks-told",
    "controller mission.xml -o one": "controller",
    "controller mission.xml -o one --form modular": "controller",
    "monitor mission.xml -o one": "monitor",
    "monitor mission.xml --log robot.log": "monitor",
    "convert mission.xml other.pnml": "convert",
    "convert mission.xml other.svg": "convert",
    "report mission.xml -o report.html": "report",
    "init another": "init",
    "schema": "schema",
    "schema check": "schema",
}
"""By command line: the format of what it prints."""
WRITTEN = {
    "causes mission.xml --fmeca f.json": ("f.json", "fmeca"),
    "alternatives mission.xml -o g.json": ("g.json", "alternatives-graph"),
    "convert mission.xml n.json": ("n.json", "net"),
    "convert unbounded.net n.json": ("n.json", "net"),
    "convert courier/mission.xml n.json": ("n.json", "net"),  # its internal transitions have ranks
    "controller mission.xml -o one": ("one/controller.json", "controller-document"),
    "controller mission.xml -o one --form minimised": ("one/controller.json", "controller-document"),
    "controller mission.xml -o one --form modular": ("one/controller.json", "controller-rules"),
    "controller courier/mission.xml -o one --form modular": ("one/controller.json", "controller-rules"),
    "monitor mission.xml -o one": ("one/monitors.json", "monitors"),
    "tests nav/mission.xml --btcpp m.json --tree tree.xml": ("m.json", "mocks"),
}
"""By command line: the file that it writes, and its format."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with missions and nets of every kind."""
    monkeypatch.chdir(tmp_path)
    for path in (ROOT / "experiments" / "ulysse").glob("*.xml"):
        shutil.copy(path, tmp_path)
    contended = CONTENDED.read_text().partition("```xml")[2].partition("\n")[2].partition("```")[0]
    (tmp_path / "contended.xml").write_text(contended)
    shutil.copytree(ROOT / "experiments" / "courier", tmp_path / "courier")
    (tmp_path / "later.xml").write_text(LATER)
    (tmp_path / "robot.log").write_text("MISSION_EV_START\nOBJ_coral_head.manual_moving_EV_OK\n")
    (tmp_path / "unbounded.net").write_text(UNBOUNDED)
    leaves = "<ReactiveSequence><IsX/><Sequence><go/><act/></Sequence></ReactiveSequence>"
    tree = f'<root BTCPP_format="4"><BehaviorTree ID="M">{leaves}</BehaviorTree></root>'
    (tmp_path / "tree.xml").write_text(tree)
    (tmp_path / "unsafe.net").write_text("net n\npl p (1)\npl q (1)\ntr t p -> q\n")
    (tmp_path / "dead.net").write_text("net n\npl p (1)\npl q (0)\ntr t p -> q\n")
    return tmp_path


def validate(value: object, name: str) -> None:
    Draft202012Validator(SCHEMAS[name]).validate(value)


@pytest.mark.parametrize("line", PRINTED)
def test_what_is_printed_is_of_its_format(line: str) -> None:
    arguments = line.split()
    if "mission.pnml" in arguments:
        mcpn("convert", "mission.xml", "mission.pnml")
    if "nav/mission.xml" in arguments:
        mcpn("init", "nav", "--from", "tree.xml", "--faulty-leaves")
    found = mcpn(*arguments, "--json")
    assert found.returncode in (0, 1), found.stderr
    validate(json.loads(found.stdout), PRINTED[line])


@pytest.mark.parametrize("line", WRITTEN)
def test_what_is_written_is_of_its_format(line: str, folder: Path) -> None:
    if "nav/mission.xml" in line:
        mcpn("init", "nav", "--from", "tree.xml", "--faulty-leaves")
    assert mcpn(*line.split()).returncode == 0
    file, name = WRITTEN[line]
    validate(json.loads((folder / file).read_text()), name)


def test_every_schema_is_one_and_is_used() -> None:
    for schema in SCHEMAS.values():
        Draft202012Validator.check_schema(schema)
    left = {"snapshot", "journal"}
    assert set(SCHEMAS) == {*PRINTED.values(), *(name for _, name in WRITTEN.values()), *left}


def unions(schema: object) -> Iterator[object]:
    """Types that are several, of which one is not null: ajv refuses them in its strict mode."""
    if isinstance(schema, dict):
        if isinstance(types := schema.get("type"), list) and len({*types} - {"null"}) > 1:
            yield schema
        for inside in schema.values():
            yield from unions(inside)
    elif isinstance(schema, list):
        for inside in schema:
            yield from unions(inside)


@pytest.mark.parametrize("name", SCHEMAS)
def test_no_schema_has_a_union_of_types(name: str) -> None:
    assert list(unions(SCHEMAS[name])) == []


def test_what_a_run_leaves_is_of_its_format(ulysse_document: dict[str, Any]) -> None:
    """Of each step: the line of the journal, and the snapshot behind it."""
    controller, stream = Controller.from_document(ulysse_document), StringIO()
    controller.observe(journal := Journal(stream))
    rng = random.Random(1)
    for _ in range(40):
        controller.handle(rng.choice(controller.possible))
        validate(json.loads(controller.snapshot()), "snapshot")
    journal.resumed(controller.count)
    lines = stream.getvalue().splitlines()
    assert len(lines) > 2
    for line in lines:
        validate(json.loads(line), "journal")


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_schema_says_no_to_what_lacks_a_key_or_has_one_too_many(name: str) -> None:
    schema = SCHEMAS[name].get("anyOf", [SCHEMAS[name]])[0]
    schema = schema.get("items", schema)
    required = dict.fromkeys(schema["required"])
    with pytest.raises(ValidationError):
        validate([{}] if "items" in SCHEMAS[name] else {}, name)
    if schema.get("additionalProperties") is False:
        unknown = Draft202012Validator({"additionalProperties": False, "properties": schema["properties"]})
        assert not unknown.is_valid({**required, "colour": "blue"})


def test_kinds_of_errors_are_those_of_the_schema() -> None:
    import mcpn.answers.compare  # noqa: F401  # whose error is a kind of its own

    kinds = {SemanticsError.kind, *(error.kind for error in SemanticsError.__subclasses__())}
    assert kinds == set(SCHEMAS["error"]["properties"]["error"]["enum"])


def test_an_unknown_schema_is_an_error_that_names_those_there_are() -> None:
    found = mcpn("schema", "checks")
    assert found.returncode == 2
    assert all(name in found.stderr for name in SCHEMAS)
    assert json.loads(output("schema", "check")["schema"]) == SCHEMAS["check"]


def declared(node: Any) -> set[str]:
    """The keys that a schema declares, at any depth."""
    if isinstance(node, list):
        return set().union(*map(declared, node))
    if not isinstance(node, dict):
        return set()
    inner = set().union(*map(declared, node.values()))
    return inner | {*node["properties"]} if isinstance(node.get("properties"), dict) else inner


def test_the_page_has_every_key() -> None:
    """In the section of its format, or among those that several formats share."""
    sections = (ROOT / "docs" / "formats.md").read_text().split("<!-- format ")
    by_name = {section.split(" ", 1)[0]: section.split("<!-- end -->")[0] for section in sections[1:]}
    for name, document in FORMATS.items():
        if name == "controller-rules":
            continue  # the page leads to its schema
        text = by_name[name] + by_name["many"]
        missing = [key for key in declared(json_schema(document)) if f"{key}`" not in text]
        assert missing == [], name
