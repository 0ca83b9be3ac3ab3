"""What the model declares of the language is what files say: written, judged by the schema, read, renamed."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, assert_type

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st
from lxml import etree

from mcpn.errors import InputError
from mcpn.mission.language.datatypes import NAME, Datatype, Interval
from mcpn.mission.language.forms import NAMESPACE, Field, form_of, language
from mcpn.mission.misfits import SCHEMA
from mcpn.mission.model import FAIL, SUCCEED, Mission, Objective, Parallel
from mcpn.mission.robot import Described, Hardware
from mcpn.mission.validate import find_errors
from mcpn.mission.writer import write_mission, written
from mcpn.mission.xml import read_mission
from mcpn.testing import missions
from mcpn.testing.names import renamed
from tests import small
from tests.conftest import ROOT
from tests.mission.test_built import nodes, put

RELAX_NG = etree.RelaxNG(etree.parse(SCHEMA))
DRAWN = (
    missions(text=True, numbers=True, max_events=2, facts=2)
    | missions(max_sections=12, max_events=1, pauses=7)
    | missions(max_sections=6, facts=3, lasting=True, crashes=True, late=True, numbers=True)
)
ATTRIBUTES = [(name, a) for name, tag in language().items() for a in tag.attributes.values()]
DATATYPES = {a.datatype.name: a.datatype for _, a in ATTRIBUTES if a.datatype.pattern is not None}


def tag_of(element: etree._Element) -> str:
    return etree.QName(element).localname


def lines_of(mission: Mission) -> etree._Element:
    """The root of its file, whose elements know their lines there once it is written without a head."""
    return etree.fromstring(etree.tostring(etree.fromstring(written(mission))))


def problems(path: Path, text: bytes) -> list[tuple[str, int | None, str]]:
    path.write_bytes(text)
    with pytest.raises(InputError) as caught:
        read_mission(path)
    return [(p.source.file, p.source.line, p.message) for p in caught.value.problems if p.source]


def test_types_of_the_model_are_seen() -> None:
    hardware = Hardware(name="h")
    assert_type(hardware.failure_rate, float | None)
    assert_type(hardware.faulty, bool)
    assert_type(Objective(name="o", activities=("a",)).activities, tuple[str, ...])
    with pytest.raises(TypeError):
        Objective(name="o")  # type: ignore[call-arg]


def test_every_attribute_and_element_has_words() -> None:
    for name, tag in language().items():
        assert tag.words.endswith("."), name
        for attribute in tag.attributes.values():
            assert attribute.words.endswith("."), f"{attribute.tag} of {name}"


# --- what is drawn is written and read ------------------------------------------------------------------

OTHERS: dict[type, st.SearchStrategy[Any]] = {
    bool: st.booleans(),
    int: st.integers(0, 3),
    float: st.sampled_from([0.0, 0.25, 1.0, 1e-30, 5e20, 1 / 3, Interval(1e-30, 1 / 3), Interval(0.25, 0.25)])
    | st.integers(0, 7),
    str: st.text(
        st.characters(codec="utf-8", exclude_categories=("Cc", "Cs"), exclude_characters="\ufffe\uffff")
    ),
}
"""Values of attributes that name nothing, by their class."""


def settable(element: Any) -> Iterator[Field]:
    for attribute in form_of(type(element)).attributes:
        if attribute.classes[0] in OTHERS and not attribute.several and attribute.datatype.name != NAME.name:
            yield attribute


@given(DRAWN, st.data())
def test_what_is_drawn_is_written_and_read_again(
    tmp_path_factory: pytest.TempPathFactory, drawn: Mission, data: st.DataObject
) -> None:
    # Some attribute of some element has another value, whether or not missions are drawn with it.
    every = [(element, a) for element in nodes(drawn, Described) for a in settable(element)]
    element, attribute = data.draw(st.sampled_from(every), label="attribute")
    value = data.draw(OTHERS[attribute.classes[0]], label="value")
    changed = put(drawn, element, replace(element, **{attribute.name: value}))
    assume(find_errors(changed) == [])
    event(attribute.tag)
    text = write_mission(changed)
    assert RELAX_NG.validate(etree.fromstring(text))
    path = tmp_path_factory.mktemp("drawn") / "m.xml"
    path.write_bytes(text)
    assert read_mission(path) == changed


@given(DRAWN)
def test_the_short_form_is_written_where_it_says_all(drawn: Mission) -> None:
    shorts = {}
    for activity in drawn.activities:
        (first, *others) = activity.alternatives
        says_more = first.name != activity.name or first.description is not None or first.parameters
        shorts[activity.name] = not others and not says_more
    root = etree.fromstring(write_mission(drawn))
    for element in root.iter(f"{{{NAMESPACE}}}activity"):
        assert (element.find(f"{{{NAMESPACE}}}alternative") is None) == shorts[str(element.get("name"))]


# --- what is broken has a line -----------------------------------------------------------------------------


@given(DRAWN, st.data())
def test_a_broken_attribute_has_its_line(
    tmp_path_factory: pytest.TempPathFactory, drawn: Mission, data: st.DataObject
) -> None:
    root = lines_of(drawn)
    places = [(e, a) for e in root.iter(etree.Element) for a in language()[tag_of(e)].attributes.values()]
    if data.draw(st.booleans(), label="left out"):
        needed = [(e, a) for e, a in places if a.tag in language()[tag_of(e)].required]
        element, attribute = data.draw(st.sampled_from(needed), label="place")
        del element.attrib[attribute.tag]
        expected = f"<{tag_of(element)}> has no attribute {attribute.tag}, which is required"
    else:
        judged = [(e, a) for e, a in places if a.datatype.pattern is not None]
        element, attribute = data.draw(st.sampled_from(judged), label="place")
        bad = data.draw(st.sampled_from(["°", "1/2", "a b!", "-"]) | st.text("-+*.,;", min_size=1))
        element.set(attribute.tag, bad)
        expected = (
            f"{attribute.tag} of <{tag_of(element)}> is {bad!r}, expected {attribute.datatype.expected}"
        )
    line = element.sourceline
    assert isinstance(line, int)
    path = tmp_path_factory.mktemp("broken") / "m.xml"
    assert (str(path), line, expected) in problems(path, etree.tostring(root))
    assert not RELAX_NG.validate(root)


RANGES = {
    "failure_rate": (0.0, 1e300),
    "repair_rate": (0.0, 1e300),
    "detection_rate": (0.0, 1e300),
    "rate": (0.0, 1e300),
    "duration": (5e-324, 1e300),
    "failure_probability": (0.0, 1.0),
    "demand_probability": (0.0, 1.0),
    "timeout": (0.001, 2_592_000.0),
    "retries": (0, 100_000),
    "repeat": (1, 100_000),
    "times": (1, 100_000),
    "most": (1, 9),
    "at_most": (1, 9),
    "at_least": (1, 9),
    "exactly": (1, 9),
    "exact": (0, 999_999),
    "line": (0, 999_999),
}
"""The least and the largest value of each number, as the pages say them."""


def test_every_number_has_a_range() -> None:
    assert {a.tag for _, a in ATTRIBUTES if {int, float}.intersection(a.classes)} == set(RANGES)


@given(DRAWN, st.data())
def test_a_number_out_of_range_is_told_with_its_line(
    tmp_path_factory: pytest.TempPathFactory, drawn: Mission, data: st.DataObject
) -> None:
    root = lines_of(drawn)
    elementary = [e for e in root.iter(etree.Element) if tag_of(e) != "objective" or "activities" in e.attrib]
    places = [(e, a) for e in elementary for a in set(language()[tag_of(e)].attributes) & set(RANGES)]
    assume(places)
    element, name = data.draw(st.sampled_from(sorted(places, key=lambda p: (p[0].sourceline or 0, p[1]))))
    least, largest = RANGES[name]
    number = data.draw(st.sampled_from([0, 1, 2, 1e300, 1e999, 100_001, 999_999, 0.5, 1.5, 100_000]))
    assume(isinstance(number, int) or not isinstance(least, int))
    element.set(name, str(number) if number != float("inf") else "1e999")
    path = tmp_path_factory.mktemp("range") / "m.xml"
    path.write_bytes(etree.tostring(root))
    source = f"{path}:{element.sourceline}: {name} of {element.get('name')} is "
    told = False
    try:
        read_mission(path)
    except InputError as error:
        told = source in str(error)
    event(f"{name} {told}")
    assert told == (not least <= number <= largest)


# --- texts and patterns -----------------------------------------------------------------------------------


@st.composite
def near(draw: st.DrawFn, holds: Datatype) -> str:
    """A text that the datatype allows, or one that differs from it by a character."""
    assert holds.pattern is not None
    spaces = st.sampled_from(["", " ", "\n", "\t", "\u00a0"])
    text = draw(st.from_regex(holds.pattern.replace(r"\s", " "), fullmatch=True))
    text = draw(spaces) + text + draw(spaces)
    at = draw(st.integers(0, len(text)))
    return text[:at] + draw(st.sampled_from(["", "", "-", ".", "e", "1", "_", "a", "é", "٣"])) + text[at:]


@pytest.mark.parametrize("name", DATATYPES)
@given(data=st.data())
def test_the_schema_and_the_reader_know_the_same_texts(name: str, data: st.DataObject) -> None:
    holds = DATATYPES[name]
    text = data.draw(near(holds))
    grammar = etree.parse(SCHEMA).getroot()
    rng = "{http://relaxng.org/ns/structure/1.0}"
    (start,) = grammar.iter(f"{rng}start")
    start.clear()
    attribute = etree.SubElement(
        etree.SubElement(start, f"{rng}element", name="x"), f"{rng}attribute", name="a"
    )
    etree.SubElement(attribute, f"{rng}ref", name=f"data.{name}")
    element = etree.Element(f"{{{NAMESPACE}}}x", a=text)
    assert etree.RelaxNG(grammar).validate(element) == holds.matches(text)


# --- other names ------------------------------------------------------------------------------------------

REFERS = {
    "affects": "resource",
    "detects": "resource",
    "consumes": "resource",
    "produces": "resource",
    "activities": "activity",
    "success": "block",
    "failure": "block",
    "abort": "block",
    "timeout_goto": "block",
    "recover": "block",
    "pause": "block",
    "goto": "block",
    "else": "block",
    "fact": "fact",
    "requires": "condition",
    "when": "condition",
    "event": "event",
    "protocol": "protocol",
    "failures": "reason",
    "reason": "reason",
}
"""What each attribute that refers to something names."""
REQUIRED = {
    **dict.fromkeys(("of", "in"), "objective"),
    **dict.fromkeys(("formula", "after", "before", "until", "without"), "formula"),
    **dict.fromkeys(("by", "followed_by", "then", "to", "gives"), "formula"),
}
"""The same of requirements, whose formulas name elements in words."""
NAMED = {
    "fault": "resource",
    "hardware": "resource",
    "software": "resource",
    "activity": "activity",
    "alternative": "alternative",
    "event": "event",
    "fact": "fact",
    "protocol": "protocol",
    **dict.fromkeys(("objective", "parallel", "use", "each"), "block"),
}
"""What each element is of the kind of."""


def test_every_attribute_that_refers_is_known() -> None:
    assert {a.tag: a.datatype.refers for _, a in ATTRIBUTES if a.datatype.refers} == REFERS | REQUIRED


def renaming(begun: re.Match[str]) -> str:
    """What stands before the name in a word of a condition, with that of its kind."""
    return f"{begun[0]}{'block' if begun[2] else 'fact'}__"


@given(DRAWN | missions(awkward_names=True, max_events=1, facts=2))
def test_renaming_reaches_every_name_and_nothing_else(drawn: Mission) -> None:
    there = renamed(drawn, lambda kind, name: f"{kind}__{name}")
    roots = (etree.fromstring(written(mission)) for mission in (drawn, there))
    for was, element in zip(*(root.iter() for root in roots), strict=True):
        tag = tag_of(element)
        for attribute, value in was.attrib.items():
            kind = NAMED.get(tag, "") if attribute == "name" else REFERS.get(str(attribute), "")
            if tag == "alternative" and attribute == "name":
                (around,) = {str(e.get("name")) for e in was.iterancestors(f"{{{NAMESPACE}}}activity")}
                kind = "activity" if value == around else "alternative"
            names = str(value).split() if kind else [str(value)]
            exits = (SUCCEED, FAIL) if kind == "block" else ()
            expected = [f"{kind}__{n}" if kind and n not in exits else n for n in names]
            if kind == "condition":
                expected = [re.sub(r"^(!?)(done\()?", renaming, word) for word in names]
            assert str(element.get(attribute)) == (" ".join(expected) if kind else str(value))
    assert renamed(there, lambda kind, name: name.removeprefix(f"{kind}__")) == drawn


# --- as XML Schema -----------------------------------------------------------------------------------------

NG = "{http://relaxng.org/ns/structure/1.0}"
XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="urn:mcpn:mission:1 m.xsd"'
LEG = f"""<mission name="m" xmlns="{NAMESPACE}" {XSI}><robot name="r"><hardware name="h"/>
<activity name="a"><alternative name="x" consumes="h"/><parameter name="p" value="1"/></activity></robot>
<objective name="o" activities="a"><parameter name="q" value="2"/></objective></mission>"""


def begins(pattern: etree._Element) -> set[str]:
    """The elements with which what a pattern matches may begin."""
    if pattern.tag == f"{NG}ref":
        name = str(pattern.get("name"))
        return {name} if name in language() else set()
    if pattern.tag == f"{NG}attribute":
        return set()
    found = set[str]()
    for part in pattern:
        first = begins(part)
        found |= first
        in_turn = pattern.tag in (f"{NG}group", f"{NG}oneOrMore")
        if in_turn and first and part.tag not in (f"{NG}optional", f"{NG}zeroOrMore"):
            break
    return found


def test_what_comes_first_tells_the_way() -> None:
    """Unique Particle Attribution, which XML Schema asks: no two ways of a choice begin alike."""
    schema = etree.parse(SCHEMA)
    assert next(schema.iter(f"{NG}interleave"), None) is None
    for choice in schema.iter(f"{NG}choice"):
        ways = [begins(way) for way in choice]
        assert sum(map(len, ways)) == len(set().union(*ways)), etree.tostring(choice)


def test_trang_makes_an_xsd_that_xerces_takes(tmp_path: Path) -> None:
    if shutil.which("trang") is None or shutil.which("jing") is None:
        pytest.skip("needs trang and jing (apt-get install trang jing)")
    xsd = tmp_path / "mission.xsd"
    subprocess.run(["trang", SCHEMA, xsd], check=True, capture_output=True)
    (tmp_path / "leg.xml").write_text(LEG)
    fitting = [tmp_path / "leg.xml", *sorted((ROOT / "experiments").glob("*/mission.xml"))]
    found = subprocess.run(["jing", xsd, *fitting], capture_output=True, text=True, check=False)
    assert (found.returncode, found.stdout) == (0, "")
    (tmp_path / "leg.xml").write_text(LEG.replace("parameter", "parametre"))
    found = subprocess.run(["jing", xsd, tmp_path / "leg.xml"], capture_output=True, text=True, check=False)
    assert found.returncode == 1


def test_a_root_may_say_where_an_xsd_is(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(LEG)
    assert read_mission(path).name == "m"
    path.write_text(LEG.replace(f" {XSI}", "").replace('<robot name="r"', f'<robot name="r" {XSI}'))
    with pytest.raises(InputError, match=r"found the attribute .*schemaLocation on <robot>"):
        read_mission(path)


def test_a_digit_that_is_no_number_is_refused() -> None:
    """Of a superscript ``isdigit`` is true, and ``int`` has no value."""
    children = (Objective(name="o", activities=("a",)),)
    of = small.mission(
        small.robot((), small.activity("a", ())), Parallel(name="p", blocks=children, success_when="²")
    )
    assert [each.message for each in find_errors(of)] == [
        "success_when of p is ², expected any, all or a whole number above 0"
    ]
