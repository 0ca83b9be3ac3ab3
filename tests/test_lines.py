"""Errors in XML files name the right line, also beyond the 65,534 lines that libxml2 knows."""

from __future__ import annotations

import gc
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn import xmlio
from mcpn.errors import InputError
from mcpn.logic.contest import NAMESPACES, read_properties
from mcpn.logic.questions import Questions
from mcpn.mission import misfits
from mcpn.mission.xml import read_mission
from mcpn.nets.formats import read_net
from mcpn.nets.formats.pnml import NAMESPACE, NET_TYPE
from mcpn.nets.petri import NetBuilder
from mcpn.trees.reading import read_forest
from tests.mutation import at_most

LINE = 70_003
"""Of each mistake. Blank lines follow, whose last one is what libxml2 would name."""
BEHIND = "\n\n\n"


class Mistake(NamedTuple):
    """A file that is wrong in one place.

    Args:
        before: What stands before the blank lines: whole lines.
        wrong: What stands on the line.
        after: What follows.
        said: A part of the message.
    """

    read: Callable[[Path], object]
    before: str
    wrong: str
    after: str
    said: str

    def text(self) -> str:
        before = self.before + "\n"
        return before + "\n" * (LINE - 1 - before.count("\n")) + self.wrong + BEHIND + self.after


def _properties(path: Path) -> object:
    builder = NetBuilder("n")
    builder.place("p", initial=1)
    return read_properties(path, Questions(builder.build()).names)


MISSION = '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><activity name="a"/></robot>'
OBJECTIVE = '<objective name="o" activities="a"/>'
NET = f'<pnml xmlns="{NAMESPACE}"><net id="n" type="{NET_TYPE}"><page id="g">'
NODES = '<place id="p"/><transition id="t"/>'
NET_ENDS = "</page></net></pnml>"
TREE = '<root BTCPP_format="4">\n<BehaviorTree ID="T">\n<Sequence>'
TREE_ENDS = "<AlwaysSuccess/></Sequence></BehaviorTree></root>"
PROPERTIES = f'<property-set xmlns="{NAMESPACES[0]}">'
ONE = "<integer-constant>1</integer-constant>"
UNKNOWN_PLACE = f"<integer-le>{ONE}<tokens-count><place>q</place></tokens-count></integer-le>"
MISTAKES = {
    "mission, a misspelled attribute": Mistake(
        read_mission, MISSION, '<objective name="o" activitis="a"/>', "</mission>", "attribute activitis"
    ),
    "mission, an unknown element": Mistake(
        read_mission, MISSION + OBJECTIVE, "<robott/>", "</mission>", "found <robott>"
    ),
    "mission, text": Mistake(
        read_mission,
        MISSION,
        f'<parallel name="b">words{OBJECTIVE}',
        "</parallel></mission>",
        "the text 'words'",
    ),
    "mission, an unknown name": Mistake(
        read_mission, MISSION, '<objective name="o" activities="b"/>', "</mission>", "objective o runs b"
    ),
    "mission, not well-formed": Mistake(
        read_mission, MISSION, "<objective name=o/>", "</mission>", "not well-formed"
    ),
    "robot, a wrong value": Mistake(
        read_mission,
        MISSION.removesuffix("</robot>"),
        '<hardware name="H?"/>',
        f"</robot>{OBJECTIVE}</mission>",
        "name of <hardware> is 'H?'",
    ),
    "net, an arc to nothing": Mistake(
        read_net, NET + NODES, '<arc id="a" source="p" target="nix"/>', NET_ENDS, "'nix'"
    ),
    "net, a number inside of a place": Mistake(
        read_net,
        f'{NET}<place id="p">',
        "<initialMarking>",
        f"<text>x</text></initialMarking></place>{NET_ENDS}",
        "found 'x' as initialMarking",
    ),
    "net, a remark": Mistake(
        read_net,
        f'{NET}<place id="p"><toolspecific tool="mcpn" version="1">',
        "<remark/>",
        f"</toolspecific></place>{NET_ENDS}",
        "found <remark>",
    ),
    "net, an unknown attribute": Mistake(read_net, NET, '<place id="p" x="1"/>', NET_ENDS, "attribute x"),
    "tree, an unknown port": Mistake(
        read_forest, TREE, '<Inverter x="1">', f"<AlwaysFailure/></Inverter>{TREE_ENDS}", "Inverter"
    ),
    "tree, a tree that is not there": Mistake(read_forest, TREE, '<SubTree ID="U"/>', TREE_ENDS, "U"),
    "tree, read as tinyxml2 reads it": Mistake(
        read_forest, f'{TREE}\n<Script code="a:=1 && 2"/>', '<SubTree ID="U"/>', TREE_ENDS, "U"
    ),
    "properties, an unknown place": Mistake(
        _properties,
        f"{PROPERTIES}<property><id>one</id><formula><all-paths><globally>",
        UNKNOWN_PLACE,
        "</globally></all-paths></formula></property></property-set>",
        "one: ",
    ),
    "properties, an unknown element": Mistake(
        _properties,
        f"{PROPERTIES}<property><id>one</id><formula>",
        "<nonsense/>",
        "</formula></property></property-set>",
        "<nonsense>",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES.values(), ids=MISTAKES)
@pytest.mark.parametrize("ends", ["\n", "\r\n"], ids=["lf", "crlf"])
def test_a_mistake_is_named_with_its_line(mistake: Mistake, ends: str, tmp_path: Path) -> None:
    path = tmp_path / ("n.pnml" if mistake.read is read_net else "f.xml")
    path.write_text(mistake.text(), newline=ends)
    with pytest.raises(InputError) as found:
        mistake.read(path)
    assert {(p.source.line if p.source else None) for p in found.value.problems} == {LINE}
    assert mistake.said in str(found.value)


@pytest.mark.parametrize("prefix", ["", "m:"])
def test_what_libxml2_alone_finds_has_its_line(prefix: str, tmp_path: Path) -> None:
    """Its own number for the line is that of a text behind; its path to the element is right."""
    mission = f'<{prefix}mission name="m" xmlns{":m" if prefix else ""}="urn:mcpn:mission:1">'
    robot = f'<{prefix}robot name="r"><{prefix}activity name="a"/></{prefix}robot>'
    objective = f'<{prefix}objective name="o" activities="a"/>'
    wrong = f'<{prefix}hardware name="H"/>'
    path = tmp_path / "m.xml"
    text = Mistake(read_mission, mission + robot + objective, wrong, f"</{prefix}mission>", "").text()
    root = xmlio.parse_bytes(path, text.encode())
    with patch.object(misfits, "_misfits", lambda among, core: iter(())):
        ((line, message),) = misfits.find_misfits(root)
    assert line == LINE
    assert "<hardware> with name and no children does not fit" in message


def _blanks() -> st.SearchStrategy[str]:
    return st.text(" \n", max_size=4).map(lambda text: text.replace(" \n", "\r\n"))


def _tags(draw: st.DrawFn, inside: str) -> str:
    """An element, with line ends wherever they may stand, and > and < where they end and begin no tag."""
    space = draw(_blanks())
    values = st.text("a >\n\u010a\u3e0a\u0a3e", max_size=6)
    attributes = "".join(f"\n{name}='{draw(values)}'" for name in draw(st.sets(st.sampled_from("abc"))))
    if not inside and draw(st.booleans()):
        return f"<e{attributes}{space}/>"
    return f"<e{attributes}{space}>{inside}</e{draw(_blanks())}>"


TEXTS = st.text("a >\n\u010a\u3e0a\u0a3e", max_size=8).map(lambda text: text.replace("]]>", ""))
BETWEEN = (
    _blanks()
    | TEXTS
    | TEXTS.map(lambda text: f"<!-- {text}\n<x> -->")
    | TEXTS.map(lambda text: f"<?p {text}\n<x>?>")
    | TEXTS.map(lambda text: f"<![CDATA[{text}\n<x>]]>")
)


@st.composite
def documents(draw: st.DrawFn) -> bytes:
    """Documents of few lines, in each encoding of Unicode."""

    def inside(depth: int) -> str:
        parts = [draw(BETWEEN)]
        for _ in range(draw(st.integers(0, 3)) if depth else 0):
            parts += _tags(draw, inside(depth - 1)), draw(BETWEEN)
        return "".join(parts)

    encoding = draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32-be"]))
    heads = ['<?xml version="1.0"\n?>', '<?xml version="1.0"?><!-- >\n -->\n']
    if not encoding.endswith(("-le", "-be")):  # which are recognised by how they begin
        heads += ["", "<!-- >\n -->\n"]
    head = draw(st.sampled_from(heads))
    return (head + _tags(draw, inside(3)) + draw(_blanks())).encode(encoding)


@given(documents(), st.integers(1, 12))
def test_the_lines_are_those_of_libxml2(data: bytes, known: int) -> None:
    path = Path("drawn.xml")
    right: list[object] = [element.sourceline for element in xmlio.parse_bytes(path, data).iter("*")]
    with patch.object(xmlio, "_KNOWN", known), patch.object(xmlio, "_CHUNK", 64):
        root = xmlio.parse_bytes(path, data)
        assert [xmlio.line_of(element) for element in root.iter("*")] == right
        with patch.object(xmlio, "read_bounded", lambda path, limit: data):
            begun, ended = [], list[int]()
            for event, element in xmlio.stream_xml(path, 1 << 20):
                if event == "start":
                    begun.append(xmlio.line_of(element))
                else:
                    ended = [xmlio.line_of(inside) for inside in element.iter("*")]
            assert begun == ended == right


SHAPES = {
    "elements": ("<r>", "<a/>\n", "</r>"),
    "elements before line ends": ("<r>", "<a/>", "\n" * 70_000 + "</r>"),
    "texts": ("<r>", "text > text\n", "</r>"),
    "a comment": ("<r><!--", "> \n", "--></r>"),
    "a section of text": ("<r><![CDATA[", "> \n", "]]></r>"),
    "a value": ("<r><a b='", "> \n", "'/></r>"),
    "a tag": ("<r><a", " \n", "/></r>"),
    "comments after the root": ("<r/>", "<!-- > -->\n", ""),
}


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_long_files_are_read_in_time_linear_in_their_lines(shape: tuple[str, str, str]) -> None:
    """Each takes some 3 µs a line; eight times that is allowed."""
    before, line, after = shape
    data = (before + line * 140_000 + after).encode()
    with at_most(3.5):
        xmlio.parse_bytes(Path("long.xml"), data)


def test_elements_that_were_let_go_are_not_held(tmp_path: Path) -> None:
    """A net is read in the memory of what it says, not of its document."""
    path = tmp_path / "n.pnml"
    path.write_text(Mistake(read_net, NET, "", NODES + '<place id="q"/>' * 5000 + NET_ENDS, "").text())
    most = 0
    for number, (event, element) in enumerate(xmlio.stream_xml(path, 1 << 24)):
        if event == "end" and element.get("id") not in ("g", "n"):
            element.clear(keep_tail=True)  # type: ignore[call-arg]
            parent = element.getparent()
            while parent is not None and element.getprevious() is not None:
                del parent[0]
        if not number % 2_000:
            most = max(most, sum(isinstance(each, xmlio._Numbered) for each in gc.get_objects()))
    assert number > 10_000
    assert 0 < most < 5000


def test_short_files_have_plain_elements() -> None:
    root = xmlio.parse_bytes(Path("short.xml"), b"<r>\n" * 9 + b"</r>" * 9)
    assert not any(isinstance(element, xmlio._Numbered) for element in root.iter())
