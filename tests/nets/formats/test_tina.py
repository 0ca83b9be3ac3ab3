"""TINA's syntax in full: superposed declarations, labels, priorities, continuation, hostile texts."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.errors import InputError, Problem
from mcpn.events import Event
from mcpn.nets.formats import read_net
from mcpn.nets.formats.tina import read_tina, write_tina
from mcpn.nets.petri import NetBuilder, PetriNet
from tests.nets.nets import odd_nets

HERE = Path("n.net")


def read(text: str) -> PetriNet:
    return read_tina(HERE, text.encode())


def problem_of(data: bytes) -> Problem | None:
    """What is wrong with a text; any error but the one that says so is a failure."""
    try:
        read_tina(HERE, data)
    except InputError as error:
        (problem,) = error.problems
        return problem
    return None


@given(net=odd_nets())
def test_written_nets_are_read_back_equal(net: PetriNet) -> None:
    if len({t.internal for t in net.transitions}) < 2:
        # One level alone: no pr line, and no effect.
        net = replace(net, priorities=False, transitions=tuple(replace(t, rank=0) for t in net.transitions))
    assert read(write_tina(net)) == net


@given(text=st.text(st.sampled_from("tplrnb {}\\:->*?!1[]w,()#\n\r\tab<0K"), max_size=60))
def test_any_text_is_read_or_told_with_its_line(text: str) -> None:
    problem = problem_of(text.encode())
    if problem:
        assert problem.source is not None
        assert problem.source.line is not None
        assert 1 <= problem.source.line <= text.count("\n") + text.count("\r") + 1


@given(data=st.binary(max_size=40))
def test_any_bytes_are_read_or_told(data: bytes) -> None:
    problem = problem_of(data)
    assert problem is None or problem.source is not None


def test_everything_that_the_syntax_says() -> None:
    net = read(
        "# a comment\n"
        "net {my net}\n"
        "pl a : {label of a place} (2K) # two thousand\n"
        "pl b (1M)\r\n"
        "tr t : go [0,w[ a*3 b?2 -> {odd \\} name}*2 c\n"
        "tr {a b}{p}->{q}\n"
        "tr u\n"
        "tr v a->b\n"
        "tr split\n"
        "   a\n"
        "\t-> b b\n"
        "pl b t*2 -> u?1 u*4\n"
        "lb u late\n"
        "lb a {label of a place}\n"
        "nt n1 0 {a note: tr x y -> \\{\\}}\n"
        "pl x-y (0)\n"
    )
    assert net.name == "my net"
    initial = {p.name: p.initial for p in net.places}
    assert initial == {
        "a": 2000,
        "b": 1_000_000,
        "odd } name": 0,
        "c": 0,
        "p": 0,
        "q": 0,
        "x-y": 0,
    }

    def arcs(name: str) -> tuple[dict[str, int], dict[str, int], dict[str, int], str | None]:
        t = net.transitions[net.transition_index[name]]
        consume, produce, read_ = (
            {net.places[p].name: w for p, w in side} for side in (t.consume, t.produce, t.read)
        )
        return consume, produce, read_, None if t.event is None else str(t.event)

    assert arcs("t") == ({"a": 3}, {"odd } name": 2, "c": 1, "b": 2}, {"b": 2}, "go")
    assert arcs("a b") == ({"p": 1}, {"q": 1}, {}, None)
    assert arcs("u") == ({"b": 4}, {}, {"b": 1}, "late")
    assert arcs("v") == ({"a": 1}, {"b": 1}, {}, None)
    assert arcs("split") == ({"a": 1}, {"b": 2}, {}, None)
    assert not net.priorities


def test_the_last_label_counts_and_an_empty_one_is_none() -> None:
    net = read("tr t : a p -> q\nlb t b\ntr u : {}\nlb v a tr v : b\nlb v {} pl p : x lb p y lb q {}")
    assert [t.event and str(t.event) for t in net.transitions] == ["b", None, None]
    assert [p.label for p in net.places] == ["y", None]


def levels(priorities: str) -> dict[str, str | None]:
    net = read(f"tr a : A p ->\ntr b p ->\ntr c : C p ->\ntr d p ->\n{priorities}\n")
    assert net.priorities
    return {t.name: None if t.event is None else str(t.event) for t in net.transitions}


@pytest.mark.parametrize(
    "priorities",
    [
        "pr a b > c d",
        "pr c d < b a",
        "pr a b > c\npr b a > d",
        "pr a > c d\npr b > c\npr d < b",
        "pr a > c\npr a > d\npr b > c\npr b > d",
        "pr a b\n  > c\n  d",
        "pr a b > c d\npr a > c",
    ],
)
def test_two_levels_make_internal_transitions_and_events(priorities: str) -> None:
    assert levels(priorities) == {"a": None, "b": None, "c": "C", "d": "d"}


@pytest.mark.parametrize(
    "priorities",
    [
        "pr a > b",
        "pr a > b\npr c > d",
        "pr a b > c",
        "pr a > b c d\npr b > c",
        "pr a > a",
        "pr a > b\npr b > a",
    ],
)
def test_other_priorities_are_refused(priorities: str) -> None:
    with pytest.raises(InputError, match="above all of the levels after its own"):
        levels(priorities)


@pytest.mark.parametrize("priorities", ["pr a > b c d\npr b > c d", "pr b > c d\npr a > b c\npr a > d"])
def test_more_levels_rank_internal_transitions(priorities: str) -> None:
    net = read(f"tr a p -> q\ntr b q -> p\ntr c : C p -> p\ntr d p -> p\n{priorities}\n")
    assert levels(priorities) == {"a": None, "b": None, "c": "C", "d": "d"}
    assert [t.rank for t in net.transitions] == [0, 1, 0, 0]


def test_ranks_without_events_are_refused() -> None:
    builder = NetBuilder("ranks", priorities=True)
    builder.place("p", initial=1)
    builder.transition("first", consume=["p"])
    builder.transition("second", consume=["p"], rank=1)
    with pytest.raises(InputError, match="ranks of a net without events"):
        write_tina(builder.build())


def test_without_priorities_labels_are_events() -> None:
    net = read("tr a : EV p -> q\ntr b q -> p\n")
    assert [(t.event, t.internal) for t in net.transitions] == [(Event.parse("EV"), False), (None, True)]
    assert not net.priorities


# Figures of the two reference nets as their comments state them.
def test_the_reference_nets_are_read(reference: Path) -> None:
    ulysse = read_net(reference / "ulysse_reference.net")
    assert (len(ulysse.places), len(ulysse.transitions), ulysse.priorities) == (133, 150, True)
    resource = read_net(reference / "hardware_resource_fig10.net")
    assert len(resource.transitions) == 10
    assert {p.name for p in resource.places if p.initial} == {"Rx_free", "Rx_available"}
    assert [t.name for t in resource.transitions if t.internal] == ["Rx_9", "Rx_3", "Rx_4", "Rx_8"]
    events = {str(t.event) for t in resource.transitions if t.event is not None}
    assert {"Rx_EV_OOS", "Rx_EV_RD"} <= events
    assert len(events) == 5  # two transitions share Rx_EV_OOS


BROKEN = {
    "words before any keyword": ("  a b\n", 1, "column 3: found 'a', expected one of net, pl"),
    "a keyword mistyped": (
        "net n\nplace p\n",
        2,
        "column 1: found 'place' where the declaration should end, expected one of",
    ),
    "a keyword as a name": ("tr t pl -> q\n", 1, "column 9: found '->', expected a place"),
    "a keyword as a label": ("tr t : pl -> q\n", 1, "expected a label; as a name write {pl}"),
    "a note without 0 or 1": ("nt n 2 {text}\n", 1, "found '2' after the name of a note, expected 0 or 1"),
    "a note without a text": ("nt n 0\ntr t p -> q\n", 1, "expected a note's text"),
    "stopwatch": ("tr t p!1 -> q\n", 1, "stopwatch arcs are not supported"),
    "stopwatch inhibitor": ("tr t p!-1 -> q\n", 1, "stopwatch inhibitor arcs are not supported"),
    "inhibitor into pl": (
        "pl p t?-1 -> u\n",
        1,
        "found an inhibitor arc among the inputs of place p, expected",
    ),
    "inhibitor out of tr": (
        "tr t p -> q?-1\n",
        1,
        "found an inhibitor arc among the outputs of transition t, expected",
    ),
    "inhibitor of an unbounded place": ("tr t -> p\ntr u p?-1 -> q\n", 2, "expected a bound of p"),
    "negative weight": ("tr t p*-2 -> q\n", 1, "column 8: found '-2', expected PLACE*WEIGHT"),
    "weight missing": ("tr t p* -> q\n", 1, "found '->', expected PLACE*WEIGHT"),
    "weight in braces": ("tr t p*{2} -> q\n", 1, "found '{2}'"),
    "scaled beyond": ("pl p (1E)\n", 1, "below 10^18"),
    "marking unclosed": ("pl p (1\n", 1, "expected ')'"),
    "marking empty": ("pl p ()\n", 1, "found ')', expected a marking"),
    "marking negative": ("pl p (-1)\n", 1, "found '-1', expected a marking"),
    "marking fraction": ("pl p (1.5)\n", 1, "found '1.5', expected a marking"),
    "two markings": ("pl p (1) (2)\n", 1, "found '('"),
    "strict interval": ("tr t ]0,w[ p -> q\n", 1, "only untimed nets"),
    "delay": ("tr t [0,5] p -> q\n", 1, "only untimed nets"),
    "late delay": ("tr t\n  [1,w[ p -> q\n", 2, "only untimed nets"),
    "label missing": ("tr t :\n", 1, "found the end of the declaration, expected a label"),
    "label of nothing": ("tr t p -> q\nlb z b\n", 2, "lb names 'z', expected a place or a transition"),
    "read arc into pl": ("pl p t?1 -> u\n", 1, "found a read arc among the inputs of place p, expected"),
    "stray brace": ("net n\ntr t p} -> q\n", 2, "column 7"),
    "brace over lines": ("tr {a\nb} p -> q\n", 1, "without its '}' on the same line"),
    "net without a name": ("net\n", 1, "expected the net's name"),
    "net with two names": ("net a b\n", 1, "found 'b' where the declaration should end"),
    "pr without relation": ("tr a p -> q\npr a\n", 2, "'>' or '<'"),
    "pr without lower": ("tr a p -> q\npr a >\n", 2, "expected a transition"),
    "pr with two relations": ("tr a p -> q\ntr b p -> q\npr a > b > a\n", 3, "found '>'"),
    "not UTF-8": ("net n\npl \udcff\n", 2, "not UTF-8"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_texts_are_told_with_line_and_column(name: str) -> None:
    text, line, message = BROKEN[name]
    with pytest.raises(InputError) as caught:
        read_tina(HERE, text.encode(errors="surrogateescape"))
    (problem,) = caught.value.problems
    assert problem.source is not None
    assert problem.source.line == line, problem
    assert message in problem.message


def test_line_breaks_in_names_are_told() -> None:
    builder = NetBuilder("n")
    builder.place("p")
    builder.transition("t", consume=["p"], event=Event.parse("two\nlines"))
    with pytest.raises(InputError, match="line break"):
        write_tina(builder.build())


@pytest.mark.parametrize(
    "text",
    [
        "tr t " + "p" * 500_000,
        "tr t " + "p " * 100_000 + "-> q",
        "tr t " + "-" * 500_000 + "> q",
        "tr {" + "\\" * 500_000,
        "tr {" + "\\{" * 250_000 + "} p -> q",
        "tr t [" * 100_000,
        "".join(f"tr t{n} p -> q\n" for n in range(20_000))
        + " ".join(["pr", *(f"t{n}" for n in range(10_000)), ">", *(f"t{n}" for n in range(10_000, 20_000))]),
    ],
    ids=["word", "arcs", "dashes", "backslashes", "escapes", "brackets", "priorities"],
)
def test_long_texts_take_linear_time(text: str) -> None:
    start = time.process_time()  # of this process alone, whatever else runs
    problem_of(text.encode())
    assert time.process_time() - start < 15


@pytest.mark.parametrize(("suffix", "power"), [("K", 3), ("M", 6), ("G", 9), ("T", 12), ("P", 15), ("E", 18)])
def test_a_letter_after_a_number_is_a_power_of_ten(tmp_path: Path, suffix: str, power: int) -> None:
    path = tmp_path / "n.net"
    most = 10**18 - 1  # what a net may say
    path.write_text(f"net n\npl a (13{suffix})\ntr t a*2{suffix} -> b\n")
    if 13 * 10**power > most:
        with pytest.raises(InputError):
            read_net(path)
        return
    net = read_net(path)
    assert net.initial[net.place_index["a"]] == 13 * 10**power
    assert net.transitions[0].consume == ((net.place_index["a"], 2 * 10**power),)
