"""Nets as other tools write them: PNML of pm4py, ProM, WoPeD, ePNK, PIPE and TAPAAL."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import mcpn
from mcpn.errors import InputError
from mcpn.logic.questions import Questions
from mcpn.nets.formats import read_net, save_net
from mcpn.nets.formats.pnml import NET_TYPES
from mcpn.nets.petri import PetriNet

PTNET = "http://www.pnml.org/version-2009/grammar/ptnet"


def read(text: str, folder: Path, suffix: str = ".pnml") -> PetriNet:
    path = folder / f"n{suffix}"
    path.write_text(text)
    return read_net(path)


def net_of(inside: str, kind: str = PTNET) -> str:
    return f'<pnml>\n<net id="n" type="{kind}">\n{inside}\n</net></pnml>'


def arcs(net: PetriNet, name: str) -> tuple[dict[str, int], dict[str, int], dict[str, int]]:
    t = net.transitions[net.transition_index[name]]
    consume, produce, read_ = (
        {net.places[p].name: w for p, w in side} for side in (t.consume, t.produce, t.read)
    )
    return consume, produce, read_


PM4PY = """<?xml version='1.0' encoding='UTF-8'?>
<pnml>
  <net id="imdf" type="http://www.pnml.org/version-2009/grammar/pnmlcoremodel">
    <name><text>imdf</text></name>
    <page id="n0">
      <place id="source"><name><text>source</text></name>
        <initialMarking><text>1</text></initialMarking></place>
      <place id="p_4"><name><text>waiting room</text></name></place>
      <transition id="skip_1"><name><text>skip_1</text></name>
        <graphics><position x="0" y="0"/><dimension x="40" y="40"/></graphics>
        <toolspecific tool="ProM" version="6.4" activity="$invisible$" localNodeID="1-2-3"/></transition>
      <transition id="t7"><name><text>register request</text></name></transition>
      <arc id="a1" source="source" target="t7">
        <name><text>1</text></name><arctype><text>normal</text></arctype>
        <inscription><text>1</text></inscription></arc>
      <arc id="a2" source="t7" target="p_4"><inscription><text>2</text></inscription></arc>
      <arc id="a3" source="p_4" target="skip_1"><inscription><text>1</text></inscription></arc>
    </page>
    <finalmarkings><marking><place idref="p_4"><text>0</text></place></marking></finalmarkings>
  </net>
</pnml>"""


def test_a_net_of_process_mining_is_read_with_its_names(tmp_path: Path) -> None:
    net = read(PM4PY, tmp_path)
    assert [(p.name, p.label, p.initial) for p in net.places] == [
        ("source", None, 1),
        ("p_4", "waiting room", 0),
    ]
    assert arcs(net, "t7") == ({"source": 1}, {"p_4": 2}, {})
    asked = Questions(net)
    assert asked.formula('EF "waiting room" = 2') == asked.formula("EF p_4 = 2")
    assert asked.formula('EF enabled("register request")') == asked.formula("EF enabled(t7)")
    assert mcpn.open(net).states().states == 4


@pytest.mark.parametrize("suffix", [".pnml", ".json"])
def test_names_are_kept_beside_ids(suffix: str, tmp_path: Path) -> None:
    net = read(PM4PY, tmp_path)
    save_net(net, tmp_path / f"again{suffix}")
    again = read_net(tmp_path / f"again{suffix}")
    assert again == net
    assert [p.label for p in again.places] == [None, "waiting room"]
    assert [t.label for t in again.transitions] == [None, "register request"]


def test_tina_keeps_the_names_of_places(tmp_path: Path) -> None:
    net = read(PM4PY, tmp_path)
    save_net(net, tmp_path / "again.net")
    again = read_net(tmp_path / "again.net")
    assert again == net
    assert [p.label for p in again.places] == [None, "waiting room"]


def test_a_name_of_several_is_refused_and_an_id_of_one_file(tmp_path: Path) -> None:
    net = read(
        net_of(
            '<place id="a"><name><text>b</text></name></place><place id="b"/>'
            '<place id="c"><name><text>d</text></name></place>'
            '<place id="e"><name><text>d</text></name></place>'
        ),
        tmp_path,
    )
    asked = Questions(net)
    with pytest.raises(InputError, match="b may mean the places b and a, expected an id"):
        asked.formula("EF b")
    with pytest.raises(InputError, match="d may mean the places c and e, expected an id"):
        asked.formula("EF d")
    assert asked.names.place_of_file("b") == 1  # files of properties mean ids
    assert asked.names.place("a") == 0
    with pytest.raises(InputError, match="no place is named f"):
        asked.names.place_of_file("f")


WOPED = """<?xml version="1.0" encoding="UTF-8"?>
<pnml>
  <net type="http://www.informatik.hu-berlin.de/top/pntd/ptNetb" id="noID">
    <place id="p1">
      <name><text>p1</text><graphics><offset x="60" y="120"/></graphics></name>
      <graphics><position x="60" y="80"/><dimension x="40" y="40"/></graphics>
      <initialMarking><text>1</text></initialMarking>
    </place>
    <transition id="t1_op_1">
      <name><text>split</text><graphics><offset x="1" y="2"/></graphics></name>
      <graphics><position x="180" y="80"/><dimension x="40" y="40"/></graphics>
      <toolspecific tool="WoPeD" version="1.0">
        <operator id="t1" type="104"/><time>0</time><timeUnit>1</timeUnit><orientation>1</orientation>
      </toolspecific>
    </transition>
    <arc id="a1" source="p1" target="t1_op_1">
      <inscription><text>1</text><graphics><offset x="500.0" y="-12.0"/></graphics></inscription>
      <toolspecific tool="WoPeD" version="1.0"><probability>1.0</probability></toolspecific>
    </arc>
    <toolspecific tool="WoPeD" version="1.0"><bounds/><resources/><simulations/></toolspecific>
  </net>
</pnml>"""
PIPE = """<?xml version="1.0" encoding="ISO-8859-1"?>
<pnml>
<net id="Net-One" type="P/T net">
  <token id="Default" enabled="true" red="0" green="0" blue="0"/>
  <labels x="1" y="2" width="3" height="4" border="true"><text>a note</text></labels>
  <place id="P0"><graphics><position x="1" y="2"/></graphics>
    <name><value>P0</value><graphics><offset x="0" y="0"/></graphics></name>
    <initialMarking><value>Default,3</value><graphics><offset x="0" y="0"/></graphics></initialMarking>
    <capacity><value>0</value></capacity></place>
  <place id="P1"><initialMarking><value>1</value></initialMarking></place>
  <transition id="T0"><name><value>T0</value></name><orientation><value>0</value></orientation>
    <rate><value>1.0</value></rate><timed><value>false</value></timed>
    <infiniteServer><value>false</value></infiniteServer><priority><value>1</value></priority></transition>
  <arc id="P0 to T0" source="P0" target="T0"><graphics/>
    <inscription><value>Default,2</value><graphics/></inscription><tagged><value>false</value></tagged>
    <arcpath id="000" x="1" y="2" curvePoint="false"/><type value="normal"/></arc>
  <arc id="P1 to T0" source="P1" target="T0"><type value="inhibitor"/></arc>
</net>
</pnml>"""
EPNK = f"""<?xml version="1.0" encoding="UTF-8"?>
<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml"
      xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="a b">
  <net id="n1" type="{PTNET}">
    <page id="pg1"><name><text>one</text></name>
      <place id="p1"><initialMarking><text>1</text></initialMarking></place>
      <page id="pg2"><transition id="t1"/><referencePlace id="rp1" ref="p1"><name><text>p1</text></name>
        </referencePlace><arc id="a1" source="rp1" target="t1"/></page>
    </page>
    <page id="pg3"><place id="p2"/><referenceTransition id="rt1" ref="t1"/>
      <arc id="a2" source="rt1" target="p2"/></page>
  </net>
</pnml>"""
TAPAAL = """<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<pnml xmlns="http://www.informatik.hu-berlin.de/top/pnml/ptNetb">
  <net active="true" id="n" type="P/T net">
    <place displayName="true" id="p" initialMarking="3" invariant="&lt; inf" name="the stock" nameOffsetX="0"
           nameOffsetY="0" positionX="135" positionY="75"/>
    <place id="q" initialMarking="0" invariant="&lt; inf" name="q"/>
    <transition angle="0" displayName="true" id="t" infiniteServer="false" name="t" player="0" positionX="1"
                positionY="2" priority="0" urgent="false"/>
    <arc id="a" inscription="[0,inf)" nameOffsetX="0" source="p" target="t" type="timed" weight="1">
      <arcpath arcPointType="false" id="0" xCoord="1" yCoord="2"/></arc>
    <arc id="b" inscription="1" source="t" target="q" type="normal" weight="2"/>
    <arc id="c" inscription="[0,inf)" source="q" target="t" type="tapnInhibitor" weight="3"/>
  </net>
  <k-bound bound="3"/>
  <feature isGame="false" isTimed="true"/>
</pnml>"""


def test_a_net_of_woped_is_read(tmp_path: Path) -> None:
    net = read(WOPED, tmp_path)
    assert arcs(net, "t1_op_1") == ({"p1": 1}, {}, {})
    assert net.transitions[0].label == "split"


BPMN2PNML = """<?xml version="1.0" encoding="UTF-8"?>
<pnml type="http://www.informatik.hu-berlin.de/top/pntd/ptNetb" id="noID">
  <net>
    <place id="f1"><name><text>p_f1</text></name><initialMarking><text>1</text></initialMarking></place>
    <place id="f2"><name><text>p_f2</text></name><initialMarking><text>0</text></initialMarking></place>
    <transition id="a"><name><text>a</text></name></transition>
    <arc id="arc_f1_to_a" source="f1" target="a"/>
    <arc id="arc_a_to_f2" source="a" target="f2"/>
  </net>
</pnml>"""


def test_a_type_of_the_net_may_stand_on_the_root(tmp_path: Path) -> None:
    """As bpmn2pnml-ltl-analyzer writes it; one that is not known is refused there, too."""
    net = read(BPMN2PNML, tmp_path)
    assert arcs(net, "a") == ({"f1": 1}, {"f2": 1}, {})
    assert net.initial == (1, 0)
    coloured = "http://www.pnml.org/version-2009/grammar/symmetricnet"
    for wrong in (
        BPMN2PNML.replace("http://www.informatik.hu-berlin.de/top/pntd/ptNetb", coloured),
        BPMN2PNML.replace("<net>", f'<net type="{coloured}">'),
        net_of(BASE).replace("<pnml>", f'<pnml type="{coloured}">'),
    ):
        found = r"expected a place/transition net .*, found type '.*symmetricnet'"
        with pytest.raises(InputError, match=found):
            read(wrong, tmp_path)


def test_a_net_of_pipe_is_read(tmp_path: Path) -> None:
    net = read(PIPE, tmp_path)
    assert net.initial[:2] == (3, 1)
    assert arcs(net, "T0") == ({"P0": 2}, {}, {"complement of P1": 1})
    assert net.enabled(net.initial) == []


def test_a_net_of_several_pages_is_read(tmp_path: Path) -> None:
    assert arcs(read(EPNK, tmp_path), "t1") == ({"p1": 1}, {"p2": 1}, {})


def test_a_net_of_tapaal_is_read(tmp_path: Path) -> None:
    net = read(TAPAAL, tmp_path)
    assert (net.places[0].label, net.initial[:2]) == ("the stock", (3, 0))
    consume, produce, _ = arcs(net, "t")
    assert (
        {name: w for name, w in consume.items() if name in "pq"},
        {name: w for name, w in produce.items() if name in "pq"},
    ) == ({"p": 1}, {"q": 2})
    assert mcpn.open(net).states().states == 3  # q holds 4 after two firings, which disables the third


@pytest.mark.parametrize(
    ("was", "becomes", "line", "message"),
    [
        ('invariant="&lt; inf" name="q"', 'invariant="&lt;= 3"', 6, "invariant='<= 3' of place q"),
        ('urgent="false"', 'urgent="true"', 8, "urgent='true' of transition t"),
        ('player="0"', 'player="1"', 8, "player='1' of transition t"),
        ('priority="0"', 'priority="2"', 8, "priority='2' of transition t"),
        (
            'inscription="[0,inf)" nameOffsetX',
            'inscription="[1,4]" nameOffsetX',
            9,
            "inscription='[1,4]' of arc a",
        ),
        ('type="timed"', 'type="transport"', 9, "found arc a of type 'transport', expected normal, "),
        ('weight="2"', 'weight="n"', 11, "found 'n' as weight, expected a number"),
        ('active="true"', 'active="false"', 3, "active='false' of net n"),
        ('isGame="false"', 'isGame="true"', 15, "isGame='true' of <feature>"),
        (
            'initialMarking="0"',
            'initialMarking=""',
            6,
            "found an empty text as initialMarking, expected a number",
        ),
        ('id="q"', 'id="q" guard="x"', 6, "found the attribute guard of place q, expected id, name, "),
        ('weight="2"', 'wieght="2"', 11, "found the attribute wieght of arc b, .*; did you mean weight?"),
    ],
)
def test_what_the_dialect_says_beyond_is_refused(
    was: str, becomes: str, line: int, message: str, tmp_path: Path
) -> None:
    assert was in TAPAAL
    with pytest.raises(InputError, match=message.replace("(", r"\(").replace("[", r"\[")) as caught:
        read(TAPAAL.replace(was, becomes), tmp_path)
    (problem,) = caught.value.problems
    assert problem.source is not None
    assert problem.source.line == line


BASE = '<place id="p"><initialMarking><text>1</text></initialMarking></place><transition id="t"/>'


@pytest.mark.parametrize(
    "kind",
    [
        "<type value='{}'/>",
        "<type><text>{}</text></type>",
        "<arctype><text>{}</text></arctype>",
        "<type><value>{}</value></type>",
    ],
)
def test_kinds_of_arcs_are_read_however_they_are_said(kind: str, tmp_path: Path) -> None:
    def of(said: str) -> tuple[dict[str, int], dict[str, int], dict[str, int]]:
        arc = f'<arc id="a" source="p" target="t">{kind.format(said)}</arc>'
        return arcs(read(net_of(BASE + arc), tmp_path), "t")

    assert of("normal") == ({"p": 1}, {}, {})
    assert of("read") == of("test") == ({}, {}, {"p": 1})
    assert of("inhibitor") == ({}, {}, {"complement of p": 1})
    for other in ("reset", "", "equal"):
        with pytest.raises(InputError, match=f"n.pnml:3: found arc a of type '{other}', expected normal"):
            of(other)


def test_an_arc_that_names_another_weight_is_refused(tmp_path: Path) -> None:
    arc = '<arc id="a" source="p" target="t"><name><text>3</text></name></arc>'
    with pytest.raises(InputError, match="found the name 3 of arc a and its weight 1, expected one number"):
        read(net_of(BASE + arc), tmp_path)


def test_read_and_inhibitor_arcs_lead_to_transitions(tmp_path: Path) -> None:
    for kind in ("read", "inhibitor"):
        with pytest.raises(InputError, match=f"{kind} arc a leads to a place, expected a transition"):
            read(net_of(f'{BASE}<arc id="a" source="t" target="p" type="{kind}"/>'), tmp_path)


@pytest.mark.parametrize("kind", NET_TYPES)
def test_types_of_nets_are_known_whole(kind: str, tmp_path: Path) -> None:
    assert read(net_of(BASE, kind), tmp_path).initial == (1,)
    for other in (f"http://example.org/{kind}", f"{kind}2", kind[1:], f"{kind}/symmetric"):
        with pytest.raises(InputError, match=r"n\.pnml:2: expected a place/transition net"):
            read(net_of(BASE, other), tmp_path)


def test_elements_of_another_namespace_are_refused(tmp_path: Path) -> None:
    other = '<x:place xmlns:x="urn:other" id="r"/>'
    with pytest.raises(InputError, match="found <place> of the namespace urn:other in net n"):
        read(net_of(BASE + other), tmp_path)


def test_text_between_elements_is_refused(tmp_path: Path) -> None:
    for inside in (f"three{BASE}", f"{BASE}three", '<place id="p">three</place>', f"{BASE} three {BASE}"):
        with pytest.raises(InputError, match="found the text 'three' in"):
            read(net_of(inside), tmp_path)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("n.ndr", "p 50.0 50.0 p0 1 n\n", "ndrio"),
        ("n.tapn", "<pnml/>", "TAPAAL"),
        ("n.xml", net_of(BASE), "expected the suffix .pnml"),
        (
            "n.xml",
            f"<?xml version='1.0'?><!-- a --><?x y?>\n{EPNK.partition('?>')[2]}",
            "expected the suffix .pnml",
        ),
    ],
)
def test_files_of_other_tools_are_named(name: str, text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    for opened in (mcpn.open, read_net):
        with pytest.raises(InputError, match=words):
            opened(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "right"),
    [
        ("coremodel.pnml", (2, 2)),
        ("ptnetb_2004.pnml", (2, 2)),
        ("pipe_value.pnml", (1, 1)),
        ("type_as_text.pnml", (2, 1)),
        ("one_line.net", (2, 2)),
        ("two_on_a_line.net", (3, 2)),
        ("tapaal_attributes.pnml", "invariant='<= 3' of place q, expected '< inf'"),
        ("arc_type_attribute.pnml", "inscription='3' of arc b, expected '1'"),
        ("json_unknown_keys.json", 'found "extra", expected one of the keys format'),
        ("graph.ndr", "ndrio"),
    ],
)
def test_files_that_once_were_read_wrongly(faults: Path, name: str, right: tuple[int, int] | str) -> None:
    path = faults / "files" / name
    if isinstance(right, str):
        with pytest.raises(InputError, match=re.escape(right)):
            mcpn.open(path)
        return
    net = read_net(path)
    assert (len(net.places), mcpn.open(net).states().states) == right
