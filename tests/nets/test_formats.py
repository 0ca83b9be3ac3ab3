"""Net files: what is written is read back, what is foreign is read without loss, what is broken is told."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError
from mcpn.nets.formats import READABLE, WRITABLE, read_net, save_net
from mcpn.nets.petri import PetriNet
from tests.conftest import ROOT
from tests.nets.nets import reachable


@pytest.mark.parametrize("suffix", [suffix for suffix in READABLE if suffix in WRITABLE])
def test_the_net_of_a_mission_is_read_back(ulysse_net: MissionNet, tmp_path: Path, suffix: str) -> None:
    warning = save_net(ulysse_net.net, tmp_path / f"u{suffix}")
    assert (warning is not None) == (suffix == ".pnml")
    back = read_net(tmp_path / f"u{suffix}")
    assert (back.places, back.transitions, back.priorities) == (
        ulysse_net.net.places,
        ulysse_net.net.transitions,
        True,
    )


def test_json_keeps_where_places_come_from(ulysse_net: MissionNet, tmp_path: Path) -> None:
    save_net(ulysse_net.net, tmp_path / "u.json")
    back = read_net(tmp_path / "u.json")
    assert [p.provenance for p in back.places] == [p.provenance for p in ulysse_net.net.places]
    sources = {
        (p.provenance.source.file, p.provenance.source.line)
        for p in back.places
        if p.provenance and p.provenance.source
    }
    assert any(file.endswith("robot.xml") for file, _ in sources)


def test_pictures_show_every_node_and_arc(ulysse_net: MissionNet, tmp_path: Path) -> None:
    save_net(ulysse_net.net, tmp_path / "u.dot")
    text = (tmp_path / "u.dot").read_text()
    net = ulysse_net.net
    arcs = sum(len(t.consume) + len(t.produce) + len(t.read) for t in net.transitions)
    assert text.count(" -> ") == arcs
    assert text.count("shape=circle") == 133
    elements = {str(p.provenance) for p in net.places} | {str(t.provenance) for t in net.transitions}
    assert text.count("subgraph cluster_") == len(elements)


def test_nets_of_the_contest_are_read_without_loss(mcc: Path, mcc_oracles: dict[str, dict[str, str]]) -> None:
    for model, row in mcc_oracles.items():
        net = read_net(mcc / model / "model.pnml")
        arcs = sum(len(t.consume) + len(t.produce) for t in net.transitions)
        found = [len(net.places), len(net.transitions), arcs, sum(net.initial)]
        assert found == [int(row[k]) for k in ("places", "transitions", "arcs", "initial_tokens")], model


def test_nets_of_the_contest_survive_every_format(mcc: Path, tmp_path: Path) -> None:
    for model in ("Kanban-PT-00005", "RobotManipulation-PT-00001", "SharedMemory-PT-000005"):
        net = read_net(mcc / model / "model.pnml")
        for suffix in (".net", ".json", ".pnml"):
            save_net(net, tmp_path / f"n{suffix}")
            back = read_net(tmp_path / f"n{suffix}")
            assert (back.places, back.transitions, back.priorities) == (net.places, net.transitions, False)


def test_the_reference_net_is_read(reference: Path) -> None:
    net = read_net(reference / "ulysse_reference.net")
    assert (len(net.places), len(net.transitions), net.priorities) == (133, 150, True)


def pnml(inside: str, kind: str = "http://www.pnml.org/version-2009/grammar/ptnet") -> str:
    return (
        '<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml">\n'
        f'<net id="n" type="{kind}"><page id="g">\n'
        f'<place id="p"/><transition id="t"/>\n{inside}</page></net></pnml>'
    )


def marked(text: str) -> str:
    return pnml(f'<place id="q"><initialMarking><text>{text}</text></initialMarking></place>')


def weighted(text: str) -> str:
    return pnml(f'<arc id="a" source="p" target="t"><inscription><text>{text}</text></inscription></arc>')


BROKEN_PNML = {
    "not XML": ("net", 1, "not well-formed"),
    "empty": ("", 1, "not well-formed"),
    "truncated": (pnml("")[:-20], 4, "not well-formed"),
    "DTD": ("<!DOCTYPE pnml [<!ENTITY a 'b'>]>" + pnml(""), 1, "DTD"),
    "no net": ('<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml"/>', 1, "one <net>"),
    "a mission": ('<mission xmlns="urn:mcpn:mission:1" name="m"/>', 1, "found <mission>"),
    "coloured": (pnml("", "http://www.pnml.org/version-2009/grammar/symmetricnet"), 2, "symmetricnet"),
    "negative marking": (marked("-1"), 4, "found '-1' as initialMarking"),
    "no number": (marked("many"), 4, "'many'"),
    "absurd marking": (marked("9" * 4000), 4, "at most 18 digits"),
    "no text": (marked(""), 4, "found an empty text as initialMarking"),
    "weight 0": (weighted("0"), 4, "weight 0"),
    "absurd weight": (weighted("1" + "0" * 30), 4, "at most 18 digits"),
    "dangling arc": (pnml('<arc id="a" source="p" target="u"/>'), 4, "'u', expected a place or"),
    "place to place": (pnml('<place id="q"/><arc id="a" source="p" target="q"/>'), 4, "joins two places"),
    "double id": (pnml('<place id="p"/>'), 4, "found a second element of the id p"),
    "no id": (pnml("<transition/>"), 4, "without an id"),
    "reset": (
        pnml('<arc id="a" source="p" target="t"><type value="reset"/></arc>'),
        4,
        "of type 'reset', expected normal, ",
    ),
    "reference to itself": (
        pnml('<referencePlace id="r" ref="r"/><arc id="a" source="r" target="t"/>'),
        4,
        "expected the id of a place",
    ),
}
BROKEN_TINA = {
    "keyword": ("net n\nplace p\n", 2, "expected one of net, pl"),
    "no arrow": ("net n\ntr t p q\n", 2, "expected '->' between"),
    "two arrows": ("net n\ntr t p -> q -> r\n", 2, "found a second '->', expected one"),
    "stopwatch": ("net n\ntr t p!1 -> q\n", 2, "stopwatch arcs are not supported"),
    "weight": ("net n\ntr t p*x -> q\n", 2, "expected PLACE"),
    "weight 0": ("net n\ntr t p*0 -> q\n", 2, "found the arc p*0, expected a weight from 1"),
    "absurd marking": (f"net n\npl p ({'9' * 40})\n", 2, "below 10^18"),
    "time": ("net n\ntr t [1,2] p -> q\n", 2, "only untimed nets"),
    "open brace": ("net n\ntr {t p -> q\n", 2, "column 4"),
    "three levels": (
        "tr a p -> q\ntr b p -> q\ntr c p -> q\npr a > b\npr b > c\n",
        5,
        "above all of the levels after its own",
    ),
    "partial order": (
        "tr a p -> q\ntr b p -> q\ntr c p -> q\npr a > b\n",
        4,
        "they leave open how a and c stand to each other",
    ),
    "unknown in pr": ("tr a p -> q\npr a > z\n", 2, "pr names 'z', expected a transition that is declared"),
    "read arc out": ("tr a p -> q?1\n", 1, "among the outputs"),
    "no name": ("net n\ntr\n", 2, "without a name"),
}


@pytest.mark.parametrize(
    ("suffix", "name"),
    [*((".pnml", name) for name in BROKEN_PNML), *((".net", name) for name in BROKEN_TINA)],
)
def test_a_broken_net_is_told_with_its_line(suffix: str, name: str, tmp_path: Path) -> None:
    text, line, message = (BROKEN_PNML if suffix == ".pnml" else BROKEN_TINA)[name]
    path = tmp_path / f"n{suffix}"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_net(path)
    (problem,) = caught.value.problems
    assert problem.source is not None
    assert (problem.source.file, problem.source.line) == (str(path), line), problem
    assert message in problem.message


@pytest.mark.parametrize(
    "text", ["", "[]", "{", '{"format": "mcpn-net", "version": 1}', '{"format": "other"}', "[" * 100_000]
)
def test_broken_json_is_told(text: str, tmp_path: Path) -> None:
    (tmp_path / "n.json").write_text(text)
    with pytest.raises(InputError, match=r"n\.json"):
        read_net(tmp_path / "n.json")


def test_unknown_suffixes_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"expected \.pnml"):
        read_net(tmp_path / "n.txt")
    with pytest.raises(InputError, match=r"expected \.pnml"):
        save_net(PetriNet("n", (), ()), tmp_path / "n.txt")


def test_nothing_is_lost_where_writing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "n.json"
    path.write_text("what stood here")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(InputError, match="No space left"):
        save_net(PetriNet("n", (), ()), path)
    assert path.read_text() == "what stood here"
    assert list(tmp_path.iterdir()) == [path]


def test_what_the_page_writes_instead_of_a_partial_order_has_its_markings(tmp_path: Path) -> None:
    """The net of the page against firing by the relation: a above b, and c beside them."""
    page = (ROOT / "docs" / "nets.md").read_text()
    text = page.partition('title="partial.net"\n')[2].partition("```")[0]
    (tmp_path / "whole.net").write_text(text)
    whole = read_net(tmp_path / "whole.net")
    places = ("p", "q", "r", "s", "t")

    def fired(m: frozenset[str]) -> Iterator[tuple[str, frozenset[str]]]:
        if {"p", "q"} <= m:
            yield "a", m - {"p", "q"} | {"r"}
        elif "s" in m:
            yield "b", m - {"s"} | {"t"}
        if "q" not in m:
            yield "c", m | {"q"}

    by_relation, queue = set[frozenset[str]](), [frozenset({"p", "s"})]
    while queue:
        if (marking := queue.pop()) not in by_relation:
            by_relation.add(marking)
            queue += [after for _, after in fired(marking)]
    markings, edges, safe = reachable(whole)
    assert safe
    assert {whole.marked(m) & {*places} for m in markings} == by_relation
    assert (len(markings), edges) == (len(by_relation), sum(len([*fired(m)]) for m in by_relation))
