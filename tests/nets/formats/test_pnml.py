"""PNML beyond plain reading and writing: odd names, references, read arcs, units, hostile files."""

from __future__ import annotations

import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from mcpn.errors import InputError
from mcpn.nets.formats import read_net, save_net
from mcpn.nets.formats.pnml import NAMESPACE, NET_TYPE
from mcpn.nets.formats.pnml_writer import write_pnml
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.steps import WorkStep, heard_by
from tests.nets.nets import odd_nets

NCNAMES = st.from_regex(r"[A-Za-z_][-A-Za-z0-9_.]{0,5}", fullmatch=True)


def read(text: str | bytes, folder: Path) -> PetriNet:
    path = folder / "n.pnml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_net(path)


@given(net=odd_nets(line_breaks=True))
def test_written_nets_are_read_back_equal(tmp_path_factory: pytest.TempPathFactory, net: PetriNet) -> None:
    folder = tmp_path_factory.mktemp("pnml")
    assert read(write_pnml(net), folder) == net


@given(net=odd_nets(line_breaks=True))
def test_ids_are_unique_and_ids_of_xml(net: PetriNet) -> None:
    root = etree.fromstring(write_pnml(net))
    ids = [element.get("id", "") for element in root.iter() if element.get("id") is not None]
    assert len(ids) == len(set(ids))
    # The validator of XML itself judges: an ID must be an NCName.
    schema = etree.XMLSchema(
        etree.fromstring(
            '<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema"><xs:element name="ids"><xs:complexType>'
            '<xs:sequence><xs:element name="e" maxOccurs="unbounded"><xs:complexType>'
            '<xs:attribute name="id" type="xs:ID"/></xs:complexType></xs:element></xs:sequence>'
            "</xs:complexType></xs:element></xs:schema>"
        )
    )
    document = etree.Element("ids")
    for key in ids:
        etree.SubElement(document, "e", id=key)
    schema.assertValid(document)


@given(names=st.sets(NCNAMES, min_size=2, max_size=6))
def test_names_that_can_be_ids_are_the_ids(names: set[str]) -> None:
    builder = NetBuilder("a net")
    for name in names:
        builder.place(name)
    root = etree.fromstring(write_pnml(builder.build()))
    assert [place.get("id") for place in root.iter(f"{{{NAMESPACE}}}place")] == list(names)


def test_other_tools_see_a_read_arc_as_two(tmp_path: Path) -> None:
    builder = NetBuilder("n")
    builder.place("p", initial=1)
    builder.transition("t", read={"p": 2})
    data = write_pnml(builder.build())
    root = etree.fromstring(data)
    arcs = [(arc.get("source"), arc.get("target")) for arc in root.iter(f"{{{NAMESPACE}}}arc")]
    assert arcs == [("p", "t"), ("t", "p")]
    for element in list(root.iter(f"{{{NAMESPACE}}}toolspecific")):
        parent = element.getparent()
        assert parent is not None
        parent.remove(element)
    plain = read(etree.tostring(root), tmp_path)
    assert plain.transitions[0].consume == plain.transitions[0].produce == ((0, 2),)


def body(inside: str) -> str:
    return f'<pnml xmlns="{NAMESPACE}">\n<net id="n" type="{KIND}">\n{inside}\n</net></pnml>'


def remark(name: str, value: str) -> str:
    return f'<toolspecific tool="mcpn" version="1"><{name} value="{value}"/></toolspecific>'


KIND = f"{NAMESPACE[:-4]}ptnet"
BASE = '<place id="p"/><transition id="t"/>'


def test_references_lead_across_pages(tmp_path: Path) -> None:
    net = read(
        body(
            '<page id="a"><place id="p"><name><text>other name</text></name>'
            "<initialMarking><text> 3 </text></initialMarking></place>"
            '<referenceTransition id="rt" ref="rt2"/></page>'
            '<page id="b"><page id="c"><transition id="t"/><referencePlace id="r1" ref="r2"/></page>'
            '<referencePlace id="r2" ref="p"/><referenceTransition id="rt2" ref="t"/>'
            '<arc id="x" source="r1" target="t"/><arc id="y" source="rt" target="r2">'
            "<inscription><text>4</text></inscription></arc></page>"
        ),
        tmp_path,
    )
    assert [(p.name, p.initial) for p in net.places] == [("p", 3)]
    (t,) = net.transitions
    assert (t.name, t.consume, t.produce) == ("t", ((0, 1),), ((0, 4),))


def test_long_chains_of_references_are_quick(tmp_path: Path) -> None:
    count = 20_000
    chain = "".join(f'<referencePlace id="r{n}" ref="r{n + 1}"/>' for n in range(count))
    start = time.process_time()  # of this process alone, whatever else runs
    net = read(body(f'{BASE}{chain}<place id="r{count}"/><arc id="a" source="r0" target="t"/>'), tmp_path)
    assert net.transitions[0].consume == ((1, 1),)
    assert time.process_time() - start < 10


def test_arcs_between_the_same_ends_add_up(tmp_path: Path) -> None:
    net = read(body(BASE + "".join(f'<arc id="a{n}" source="p" target="t"/>' for n in range(3))), tmp_path)
    assert net.transitions[0].consume == ((0, 3),)


def test_units_are_the_places_of_each_unit_that_has_any(tmp_path: Path) -> None:
    net = read(
        body(
            '<place id="a"/><place id="b"/><place id="c"/>'
            '<toolspecific tool="nupn" version="1.1"><structure units="3" root="u0" safe="true">'
            '<unit id="u0"><places/><subunits>u1 u2</subunits></unit>'
            '<unit id="u1"><places>a\n c</places><subunits/></unit>'
            '<unit id="u2"><places>b</places><subunits/></unit></structure></toolspecific>'
        ),
        tmp_path,
    )
    assert net.units == ((0, 2), (1,))


def test_lines_are_told_even_far_down(tmp_path: Path) -> None:
    # Beyond line 65,535 libxml2 takes an element's line from the text beside it, hence the next line here.
    with pytest.raises(InputError, match=r"n\.pnml:10000[34]: "):
        read(body("\n" * 100_000 + '<place id="p"/><place id="p"/>'), tmp_path)


class Heard:
    def __init__(self) -> None:
        self.steps: list[str] = []

    def begins(self, step: WorkStep) -> None:
        self.steps.append(str(step))

    def comes_to(self, states: int, edges: int) -> None:
        raise AssertionError("nothing is explored")


def test_a_large_file_tells_how_far_it_is_read(tmp_path: Path) -> None:
    heard = Heard()
    with heard_by(heard):
        net = read(body(" " * (9 << 20) + BASE), tmp_path)
    assert [place.name for place in net.places] == ["p"]
    assert heard.steps == ["reading n.pnml (4 of 9 MiB)", "reading n.pnml (8 of 9 MiB)"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<pnml/>", "found none"),
        (f'<pnml><net id="a" type="{KIND}"/><net id="b" type="{KIND}"/></pnml>', "found a second"),
        (f'<pnml><net id="a" type="{KIND}"><page id="p"><net id="b"/></page></net></pnml>', "found <net>"),
    ],
)
def test_a_file_has_one_net(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"n.pnml:1: .*{message}"):
        read(text, tmp_path)


def test_what_other_tools_say_beside_the_net_is_passed_over(tmp_path: Path) -> None:
    other = "<toolspecific tool='x'><place id='q'/><net id='m'/></toolspecific>"
    text = body(f'{BASE}{other}<page id="g">{other}<place id="r"/></page>')
    net = read(text.replace("<net", f"{other}<net", 1), tmp_path)
    assert [place.name for place in net.places] == ["p", "r"]


BROKEN = {
    "open reference": ('<referencePlace id="r" ref="z"/>', 3, "reference r leads to 'z'"),
    "circle of references": (
        '<referencePlace id="r" ref="s"/>\n<referencePlace id="s" ref="r"/>',
        3,
        "leads in a circle",
    ),
    "reference to another kind": (f'{BASE}\n<referencePlace id="r" ref="t"/>', 4, "of another kind"),
    "coloured marking": (
        '<place id="p"><hlinitialMarking/></place>',
        3,
        "<hlinitialMarking> in place p",
    ),
    "guard": ('<transition id="t">\n<condition/></transition>', 4, "<condition> in transition t"),
    "declaration": ("<declaration/>", 3, "found <declaration>"),
    "capacity": (
        '<place id="p"><capacity><value>1</value></capacity></place>',
        3,
        "<capacity> '1' in place p, expected '0'",
    ),
    "two markings": (
        '<place id="p"><initialMarking><text>1</text></initialMarking>\n'
        "<initialMarking><text>2</text></initialMarking></place>",
        4,
        "found a second initialMarking, expected one",
    ),
    "two texts": (
        '<place id="p"><initialMarking><text>1</text><text>2</text></initialMarking></place>',
        3,
        "found 2 texts of initialMarking, expected one",
    ),
    "text in parts": (
        '<place id="p"><initialMarking><text>1<b/>0</text></initialMarking></place>',
        3,
        "found <b> in <text>, expected nothing",
    ),
    "fraction": ('<place id="p"><initialMarking><text>1.5</text></initialMarking></place>', 3, "'1.5'"),
    "foreign digits": ('<place id="p"><initialMarking><text>٣</text></initialMarking></place>', 3, "'٣'"),
    "arc without ends": (f'{BASE}<arc id="a"/>', 3, "source of arc a is ''"),
    "arc between transitions": (
        f'{BASE}<transition id="u"/><arc id="a" source="t" target="u"/>',
        3,
        "arc a joins two transitions, expected a place and a transition",
    ),
    "half a read arc": (
        f'{BASE}<arc id="a" source="p" target="t"><toolspecific tool="mcpn" version="1"><read/>'
        "</toolspecific></arc>",
        3,
        "found read arc a alone, expected an arc back",
    ),
    "a later version": (
        '<place id="p"><toolspecific tool="mcpn" version="2"/></place>',
        3,
        "found version='2' of <toolspecific>, expected '1'",
    ),
    "a name given twice": (
        '<place id="p"/>\n<place id="q"><toolspecific tool="mcpn" version="1">'
        '<name value="p"/></toolspecific></place>',
        4,
        "found a second place named p, expected",
    ),
    "event without a name": (
        '<transition id="t"><toolspecific tool="mcpn" version="1"><event value=""/></toolspecific>'
        "</transition>",
        3,
        "found an event without a name of transition t, expected one",
    ),
    "two kinds": (
        f'{BASE}<arc id="a" source="p" target="t" type="read"><type value="inhibitor"/></arc>',
        3,
        "found arc a of types 'read' and 'inhibitor', expected one",
    ),
    "two kinds in a type": (
        f'{BASE}<arc id="a" source="p" target="t"><type value="normal"><text>inhibitor</text></type></arc>',
        3,
        "found arc a of types 'normal' and 'inhibitor', expected one",
    ),
    "no kind in a type": (f'{BASE}<arc id="a" source="p" target="t"><type/></arc>', 3, "of type ''"),
    "inhibitor that is remarked to read": (
        f'{BASE}<arc id="a" source="p" target="t" type="inhibitor"><toolspecific tool="mcpn" version="1">'
        "<read/></toolspecific></arc>",
        3,
        "found arc a of types 'inhibitor' and a remark of mcpn, expected one",
    ),
    "two weights": (
        f'{BASE}<arc id="a" source="p" target="t" weight="2"><inscription><text>3</text></inscription></arc>',
        3,
        "found weight 2 and inscription 3 of arc a, expected one number",
    ),
    "a remark where it says nothing": (
        f'<place id="p">{remark("rank", "1")}</place>',
        3,
        "found <rank> of mcpn in <place>, where it says nothing",
    ),
    "a remark twice": (
        f'<transition id="t">{remark("event", "a")}{remark("event", "b")}</transition>',
        3,
        "found a second <event> of mcpn, expected one",
    ),
    "priorities of another kind": (
        remark("priorities", "event > internal"),
        3,
        "found value='event > internal' of <priorities>, expected 'internal > event'",
    ),
    "rank without priorities": (
        f'<transition id="t">{remark("rank", "1")}</transition>',
        3,
        "found '1' as rank of transition t, expected none: the net has no priorities",
    ),
    "rank of an event": (
        f'<transition id="t">{remark("event", "a")}{remark("rank", "1")}</transition>'
        f"{remark('priorities', 'internal > event')}",
        3,
        "found '1' as rank of transition t, expected none: events come after all ranks",
    ),
    "a unit of no place": (
        '<toolspecific tool="nupn" version="1.1"><structure><unit id="u"><places>p</places></unit>'
        "</structure></toolspecific>",
        3,
        "found 'p' in a unit, expected the id of a place",
    ),
    "too deep": ("<page id='a'>" * 300, 3, "not well-formed"),
    "entity": ("&lol;", 3, "not well-formed"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_told_with_their_line(name: str, tmp_path: Path) -> None:
    inside, line, message = BROKEN[name]
    with pytest.raises(InputError) as caught:
        read(body(inside), tmp_path)
    (problem,) = caught.value.problems
    assert problem.source is not None
    assert problem.source.line == line, problem
    assert message in problem.message


def test_what_cannot_be_said_is_told_and_nothing_written(tmp_path: Path) -> None:
    for name in ("a\0b", "bell\a", "half \ud800"):
        builder = NetBuilder("n")
        builder.place(name)
        with pytest.raises(InputError, match="cannot stand in XML"):
            save_net(builder.build(), tmp_path / "n.pnml")
    builder = NetBuilder("n")
    builder.place("p", initial=10**18)
    with pytest.raises(InputError, match="at most 18 digits"):
        save_net(builder.build(), tmp_path / "n.pnml")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ends", ["\n", "\r\n"], ids=["lf", "crlf"])
def test_white_space_between_nodes_may_be_long(ends: str, tmp_path: Path) -> None:
    """The parser gives it in parts, between which the reader takes the node before it."""
    path = tmp_path / "n.pnml"
    places = ('<place id="p"/>', '<place id="q"/>', "")
    text = ("\n" * 100_000).join(places)
    net = f'<pnml xmlns="{NAMESPACE}"><net id="n" type="{NET_TYPE}"><page id="g">{text}</page></net></pnml>'
    path.write_text(net, newline=ends)
    program = "import sys, mcpn; print(len(mcpn.open(sys.argv[1]).net.places))"
    run = subprocess.run(
        [sys.executable, "-c", program, str(path)], capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "2\n", "")


def test_large_nets_are_read_quickly(mcc: Path) -> None:
    start = time.process_time()  # of this process alone, whatever else runs
    net = read_net(mcc / "Dekker-PT-050" / "model.pnml")
    assert time.process_time() - start < 10
    assert (
        len(net.units) == 101
    )  # as its NUPN section says: <structure units="102"> less a root without places


@pytest.mark.parametrize("one_in", [6, pytest.param(1, marks=pytest.mark.slow)])
def test_contest_nets_survive_writing(mcc: Path, tmp_path: Path, fresh_seed: int, one_in: int) -> None:
    models = sorted(folder.name for folder in mcc.iterdir() if folder.is_dir())
    for model in models[fresh_seed % one_in :: one_in]:
        net = read_net(mcc / model / "model.pnml")
        assert read(write_pnml(net), tmp_path) == replace(net, units=())
