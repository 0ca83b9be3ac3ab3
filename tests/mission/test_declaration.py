"""What the model declares of the language is what files say: written, judged by the schema, read, renamed."""

from __future__ import annotations

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
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Described, Hardware
from mcpn.mission.validate import find_errors
from mcpn.mission.writer import write_mission, written
from mcpn.mission.xml import read_mission
from mcpn.testing import missions
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
