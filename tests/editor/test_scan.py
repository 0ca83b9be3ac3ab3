"""Elements, names and places in texts, against lxml and against the model of missions."""

from __future__ import annotations

import pytest
from hypothesis import event, example, given
from hypothesis import strategies as st
from lxml import etree

from mcpn.editor.scan import Scan, ScannedElement, scan
from mcpn.editor.symbols import symbols, words
from mcpn.logic.syntax import BINDING
from mcpn.mission.model import Mission
from mcpn.mission.writer import write_mission
from mcpn.mission.xml import read_mission
from mcpn.testing import missions
from mcpn.testing.awkward_names import renamed
from tests.conftest import ROOT

FILES = sorted((ROOT / "experiments").glob("*/*.xml"))


def test_a_scan_finds_what_a_parser_finds() -> None:
    for path in FILES:
        text = path.read_text()
        parsed = [e for e in etree.fromstring(text.encode()).iter() if isinstance(e.tag, str)]
        scanned = scan(text)
        assert [e.tag for e in scanned] == [etree.QName(e).localname for e in parsed], path
        for element, of in zip(scanned, parsed, strict=True):
            known = {str(name): str(value) for name, value in of.attrib.items()}
            found = {name: etree.fromstring(f'<a b="{v}"/>').get("b") for name, v in element.texts.items()}
            assert {name: value for name, value in found.items() if not name.startswith("xmlns")} == known
            parent = of.getparent()
            assert (element.parent.tag if element.parent else None) == (
                None if parent is None else etree.QName(parent).localname
            )
            for attribute in element.attributes:
                assert text[attribute.begin : attribute.end] == attribute.value


def test_formulas_offer_every_operator_that_is_a_word() -> None:
    offered = {offer.text for offer in words("formula", "", "", [])}
    assert {operator for operator in BINDING if operator.isalpha()} <= offered


def enclosing(text: str, offset: int) -> ScannedElement | None:
    """What :meth:`Scan.around` finds, by a scan of all that stands before."""
    found = scan(text[:offset] + "<here/>")
    return found[-1].parent if found and found[-1].tag == "here" else None


@example("<!--")
@given(st.text("<>/\"'= abm!-?\n", max_size=60))
def test_any_text_is_scanned(text: str) -> None:
    for element in scan(text):
        assert 0 <= element.begin < element.end <= len(text)
        assert all(text[a.begin : a.end] == a.value for a in element.attributes)
    enclosing(text, len(text) // 2)


EDITS = st.sampled_from(
    [
        "",
        " ",
        "\n",
        '"',
        "<",
        ">",
        "/>",
        "</",
        "<!--",
        "<!-->",
        "<?",
        "-->",
        'name="x"',
        "a",
        "1",
        "<hardware name='h'/>",
        "</a>",
    ]
)


@given(mission=missions(), data=st.data())
def test_an_edit_is_scanned_as_the_whole_is(mission: Mission, data: st.DataObject) -> None:
    text, kept = write_mission(mission).decode(), Scan()
    kept.of(text)
    for _ in range(data.draw(st.integers(1, 5))):
        at = data.draw(st.integers(0, len(text)))
        removed = data.draw(st.integers(0, 3) | st.integers(0, 80))
        text = text[:at] + data.draw(EDITS) + text[at + removed :]
        symbols("m.xml", kept.elements)  # which elements keep
        found, whole = kept.of(text), scan(text)

        def shown(of: list[ScannedElement]) -> list[object]:
            number = {id(e): n for n, e in enumerate(of)}
            return [
                (
                    e.tag,
                    e.begin,
                    e.end,
                    e.closed,
                    e.holds,
                    number.get(id(e.parent)),
                    [(a.name, a.value, a.begin, a.element is e) for a in e.attributes],
                )
                for e in of
            ]

        def named(of: list[ScannedElement]) -> list[object]:
            return [(s.kind, s.scope, s.name, s.begin, s.declares) for s in symbols("m.xml", of)]

        assert shown(found) == shown(whole)
        assert named(found) == named(whole)
        place = data.draw(st.integers(0, len(text)))
        typed = next((e for e in reversed(scan(text[:place])) if not e.closed), None)
        if (inside := kept.open_at(place)) is not None:
            assert typed is not None
            assert (inside.tag, inside.begin, inside.texts) == (typed.tag, typed.begin, typed.texts)
        else:
            around, expected = kept.around(place), enclosing(text, place)
            assert (around and around.begin) == (expected and expected.begin)


@given(mission=missions(), data=st.data())
def test_another_name_in_all_its_places_is_the_mission_of_that_name(
    mission: Mission, data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    text = write_mission(mission).decode()
    known = symbols("m.xml", scan(text))
    symbol = data.draw(st.sampled_from([s for s in known if s.declares and s.kind != "alternative"]))
    event(symbol.kind)
    for place in sorted((s for s in known if symbol.means(s)), key=lambda s: -s.begin):
        text = f"{text[: place.begin]}other_{place.name}{text[place.end :]}"
    path = tmp_path_factory.mktemp("renamed") / "m.xml"
    path.write_text(text)
    found = read_mission(path)  # whatever the name, nothing refers to the old one
    alone = sum(s.declares and (s.kind, s.name) == (symbol.kind, symbol.name) for s in known) == 1
    if alone and symbol.kind != "activity":  # an alternative may have the name of its activity

        def rename(kind: str, name: str) -> str:
            return f"other_{name}" if (kind, name) == (symbol.kind, symbol.name) else name

        assert found == renamed(mission, rename)
