"""Patterns that meet text from outside take time in proportion to its length."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from importlib import import_module
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from lxml import etree

from mcpn.errors import InputError
from mcpn.mission.language import datatypes
from mcpn.mission.language.datatypes import Datatype
from mcpn.mission.language.relax_ng import _data
from mcpn.mission.xml import read_mission
from mcpn.xmlio import parse_xml, stream_xml
from tests.conftest import ROOT
from tests.mutation import at_most

LENGTH = 15_000
"""Characters of a run. A quadratic pattern takes some 10^8 steps of them, a linear one some 10^4."""

SECONDS = 0.5
"""Of CPU time: far above what 10^4 steps take on any machine, and below 10^8."""

UNITS = (
    *(" ", "\t", "\n", "a", "7", "_", ".", "-", "!", "=", "(", ")", "[", "]", "{", "}", '"', "\\", "<", ":"),
    *("a ", "a.", "a=", "[a", "a(", "done(", "OBJ_", "fact(", "P1", "a _EV_ ", "--a: ", "@media{", "e+"),
)  # fmt: skip
BEFORE = ("", "a", "done(", "P1DT", "1.", "a='")
BEHIND = ("!", " ]x")


SEARCHES = ("search", "findall", "finditer", "split", "sub")
"""Functions that look for a pattern at each place of a text."""


def patterns() -> Iterator[tuple[str, re.Pattern[str], bool]]:
    """The patterns of each module, and whether they are looked for at each place of a text."""
    for path in sorted((ROOT / "mcpn").rglob("*.py")):
        text = path.read_text()
        if "import re\n" not in text:
            continue
        module = import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))
        calls = [
            (node.func.value.id, node.func.attr, node.args)
            for node in ast.walk(ast.parse(text))
            if isinstance(node, ast.Call)
            and isinstance(node.func, ast.Attribute)
            and isinstance(node.func.value, ast.Name)
        ]
        for name, value in vars(module).items():
            if isinstance(value, re.Pattern):
                yield (
                    f"{module.__name__}.{name}",
                    value,
                    any((name, way) in {c[:2] for c in calls} for way in SEARCHES),
                )
        for of, way, given in calls:
            if (
                of == "re"
                and way != "compile"
                and given
                and isinstance(given[0], ast.Constant)
                and isinstance(given[0].value, str)
            ):
                yield f"{module.__name__} {given[0].value}", re.compile(given[0].value), way in SEARCHES


DATATYPES = {value.name: value for value in vars(datatypes).values() if isinstance(value, Datatype)}
PATTERNS = {name: (pattern, searched) for name, pattern, searched in patterns()}


def texts() -> Iterator[str]:
    for before, unit, behind in product(BEFORE, UNITS, BEHIND):
        yield before + unit * (LENGTH // len(unit)) + behind


def test_patterns_are_found() -> None:
    assert len(DATATYPES) > 20
    assert len(PATTERNS) > 30
    assert any("syntax" in name for name in PATTERNS)


@pytest.mark.parametrize("datatype", DATATYPES.values(), ids=DATATYPES)
def test_datatypes_read_long_runs(datatype: Datatype) -> None:
    for text in texts():
        with at_most(SECONDS):
            datatype.matches(text)


@pytest.mark.parametrize("datatype", DATATYPES.values(), ids=DATATYPES)
def test_the_schema_reads_long_runs(datatype: Datatype) -> None:
    """libxml2 matches the same patterns, and as the same."""
    root = etree.Element("{http://relaxng.org/ns/structure/1.0}element", name="x")
    root.set("datatypeLibrary", "http://www.w3.org/2001/XMLSchema-datatypes")
    root.append(_data(datatype))
    validator = etree.RelaxNG(root)
    for text in texts():
        element = etree.Element("x")
        element.text = text
        with at_most(SECONDS):
            fits = validator.validate(element)
        assert fits == datatype.matches(text)


@pytest.mark.parametrize(("pattern", "searched"), PATTERNS.values(), ids=PATTERNS)
def test_patterns_read_long_runs(pattern: re.Pattern[Any], searched: bool) -> None:
    for run in texts():
        text = run.encode() if isinstance(pattern.pattern, bytes) else run
        with at_most(SECONDS):
            pattern.fullmatch(text)
        if searched:
            with at_most(SECONDS):
                for _ in pattern.finditer(text):
                    pass


@pytest.mark.parametrize("attribute", ["consumes", "produces"])
def test_names_and_spaces_in_a_file(tmp_path: Path, attribute: str) -> None:
    """They took seconds at this length, and time as its square."""
    path = tmp_path / "m.xml"
    path.write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="H"/>\n'
        f'<activity name="a" {attribute}="{" " * LENGTH}!"/></robot>\n'
        '<objective name="o" activities="a"/></mission>'
    )
    with (
        at_most(SECONDS),
        pytest.raises(InputError, match=f"{path}:2:.*names of letters, digits and _") as found,
    ):
        read_mission(path)
    assert len(str(found.value)) < 500


@pytest.mark.parametrize("name", ["quadratic_names.xml"])
def test_a_mission_that_was_slow(faults: Path, name: str) -> None:
    with at_most(4 * SECONDS), pytest.raises(InputError, match="names of letters, digits and _"):
        read_mission(faults / name)


@pytest.mark.parametrize("read", ["mission", "tree", "net"])
def test_an_element_with_very_many_attributes_is_refused_at_once(read: str, tmp_path: Path) -> None:
    """Reading them took time in proportion to their square: twice as many may not take four times as long."""
    names = {"mission": '<mission xmlns="urn:mcpn:mission:1" {}/>', "tree": "<root {}/>", "net": "<pnml {}/>"}
    for count in (20_000, 40_000, 80_000):
        text = names[read].format(" ".join(f'a{number}="1"' for number in range(count)))
        file = tmp_path / {"mission": "m.xml", "tree": "t.xml", "net": "n.pnml"}[read]
        file.write_text(text)
        reader = (lambda path: list(stream_xml(path, 1 << 24))) if read == "net" else _tree
        with at_most(SECONDS), pytest.raises(InputError, match="attributes on one element, expected at most"):
            reader(file)


def _tree(path: Path) -> object:
    return parse_xml(path, 1 << 24)
