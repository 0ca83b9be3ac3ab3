"""Outline and formatting of texts of missions."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from mcpn.editor.layout import WIDTH, formatted
from mcpn.editor.outline import Outlined, outline
from mcpn.editor.scan import scan
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.testing import missions
from mcpn.testing.printing import as_xml
from tests.conftest import ROOT

FILE = Path("/nowhere/mission.xml")
WORKED = sorted(p for p in (ROOT / "experiments").glob("*/*.xml") if "urn:mcpn:mission:1" in p.read_text())


def walked(outlined: list[Outlined]) -> Iterator[Outlined]:
    for each in outlined:
        yield each
        yield from walked(each.inside)


@given(missions(text=True, events=1, facts=1), st.randoms())
def test_a_formatted_mission_is_the_same_mission(mission: Mission, random: Random) -> None:
    text = as_xml(mission)
    text = "".join(random.choice(["\n", "\n\n\n", "  ", ""]) + line.strip() for line in text.split("\n"))
    laid = formatted(text)
    assert laid is not None
    assert formatted(laid) == laid
    was, now = (read_mission(FILE, unsaved={FILE: each}) for each in (text, laid))
    assert was == now == mission
    for line in laid.split("\n"):
        assert len(line) <= WIDTH or line.count('="') == 1


@pytest.mark.parametrize("path", WORKED, ids=lambda path: str(path.relative_to(ROOT)))
def test_worked_files_keep_comments_and_empty_lines(path: Path) -> None:
    text = path.read_text()
    laid = formatted(text)
    assert laid is not None
    assert formatted(laid) == laid
    parser = etree.XMLParser(remove_blank_text=True)
    was, now = (etree.fromstring(each.encode(), parser) for each in (text, laid))
    assert etree.tostring(was, method="c14n") == etree.tostring(now, method="c14n")
    assert laid.count("\n\n") <= text.count("\n\n")


def test_long_tags_go_on_in_lines_of_their_own() -> None:
    long = f'<m a="1" b="{"x " * 50}" c="{"y " * 10}"  d="2"><!-- <n   k="1"/> --><n/></m>'
    assert formatted(long) == "\n".join(
        [
            f'<m a="1" b="{"x " * 50}"',
            f'   c="{"y " * 10}" d="2">',
            '  <!-- <n   k="1"/> -->',
            "  <n/>",
            "</m>\n",
        ]
    )


@pytest.mark.parametrize(
    "text", ["<m>", "", "words", "<m>words<n/></m>", "<m><n/>words</m>", '<!DOCTYPE m [<!ENTITY e "x">]><m/>']
)
def test_what_is_no_file_of_a_mission_is_left_alone(text: str) -> None:
    assert formatted(text) is None


@given(missions(events=1, facts=1))
def test_the_outline_has_every_named_element(mission: Mission) -> None:
    """Held against lxml: the same names in the same order, each from its start tag to behind its end tag."""
    text = as_xml(mission)
    root = etree.fromstring(text)
    found = list(walked(outline(text, scan(text))))
    assert [each.element.texts["name"] for each in found] == [
        e.get("name") for e in root.iter() if "name" in e.attrib
    ]
    for each, element in zip(found, (e for e in root.iter() if "name" in e.attrib), strict=True):
        part = etree.fromstring(text[each.element.begin : each.end].replace(" xmlns=", " was="))
        assert part.tag == etree.QName(element).localname
        assert len(list(part.iter())) == len(list(element.iter()))


@given(missions(events=1), st.data())
def test_the_outline_of_a_part_of_a_text_has_what_is_there(mission: Mission, data: st.DataObject) -> None:
    text = as_xml(mission)
    part = text[: data.draw(st.integers(0, len(text)))]
    for each in walked(outline(part, scan(part))):
        assert each.element.begin < each.end <= len(part)
