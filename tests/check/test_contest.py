"""Property files and examinations of the contest are answered as the definitions say."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.sax.saxutils import escape

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.check.logic.contest import read_properties
from mcpn.check.logic.formulas import (
    EG,
    EU,
    EX,
    And,
    Compare,
    Const,
    Deadlock,
    Derived,
    Enabled,
    Formula,
    Not,
    Or,
    Stable,
    Sum,
)
from mcpn.check.logic.questions import Questions
from mcpn.check.logic.verdicts import answer_examination, answer_file
from mcpn.check.nets.behaviour import EXAMINATIONS
from mcpn.check.spaces import Engine
from mcpn.errors import InputError, UnboundedError
from mcpn.net.petri import Marking, NetBuilder, PetriNet
from tests.check.formulas import edges_of, formulas, satisfying
from tests.draws import fewer
from tests.net.nets import graph_of, nets, state_machines, token_nets

PLAIN = (
    token_nets()
    | nets(max_places=5, max_transitions=6, max_weight=2, events=False)
    | state_machines().map(lambda drawn: drawn[0])
)
ASKED: tuple[Engine | str, ...] = ("auto", "explicit", "symbolic")


def element(tag: str, *inside: str) -> str:
    return f"<{tag}>{''.join(inside)}</{tag}>"


def written(formula: Formula) -> str:
    """A formula in the contest's XML, which has one relation between sums."""
    match formula:
        case Const(value):
            return element(str(value).lower())
        case Stable():
            return element("true")  # of nets without priorities
        case Deadlock():
            return element("deadlock")
        case Enabled(names):
            return element("is-fireable", *(element("transition", escape(name)) for name in names))
        case Not(a):
            return element("negation", written(a))
        case And(inside):
            return element("conjunction", *map(written, inside))
        case Or(inside):
            return element("disjunction", *map(written, inside))
        case Derived("->", (a, b)):
            return element("implication", written(a), written(b))
        case Derived("<->", (a, b)):
            return element("equivalence", written(a), written(b))
        case Compare(a, "<=", b):
            return element("integer-le", total(a), total(b))
        case Compare(a, ">=", b):
            return written(Compare(b, "<=", a))
        case Compare(a, "<", b):
            return written(Not(Compare(b, "<=", a)))
        case Compare(a, ">", b):
            return written(Not(Compare(a, "<=", b)))
        case Compare(a, "=", b):
            return element("conjunction", written(Compare(a, "<=", b)), written(Compare(b, "<=", a)))
        case Compare(a, "!=", b):
            return element("exclusive-disjunction", written(Compare(a, "<", b)), written(Compare(a, ">", b)))
        case EX(a):
            return element("exists-path", element("next", written(a)))
        case EG(a):
            return element("exists-path", element("globally", written(a)))
        case EU(a, b):
            return element("exists-path", until(a, b))
        case Derived("AU", (a, b)):
            return element("all-paths", until(a, b))
        case Derived(operator, (a,)):
            tag = {"X": "next", "F": "finally", "G": "globally"}[operator[1]]
            return element({"E": "exists-path", "A": "all-paths"}[operator[0]], element(tag, written(a)))
    raise TypeError(formula)


def until(a: Formula, b: Formula) -> str:
    return element("until", element("before", written(a)), element("reach", written(b)))


def total(of: Sum) -> str:
    parts = [element("integer-constant", str(of.constant))]
    parts += [element("tokens-count", element("place", escape(name))) for name in of.places]
    return element("integer-sum", *parts)


def bound(places: Sequence[str]) -> str:
    return element("place-bound", *(element("place", escape(name)) for name in places))


def file_of(folder: Path, bodies: dict[str, str]) -> Path:
    path = folder / "properties.xml"
    asked = [element("property", element("id", n), element("formula", body)) for n, body in bodies.items()]
    path.write_text("\n".join(['<property-set xmlns="http://mcc.lip6.fr/">', *asked, "</property-set>"]))
    return path


def answers(net: PetriNet, bodies: dict[str, str], engine: str) -> dict[str, str]:
    with TemporaryDirectory() as folder:
        properties = read_properties(file_of(Path(folder), bodies))
    assert [asked.name for asked in properties] == list(bodies)
    found = list(answer_file(Questions(net, engine=engine), properties))  # type: ignore[arg-type]
    assert len(found) == len(bodies)
    for verdict in found:
        assert (
            str(verdict)
            == f"FORMULA {verdict.name} {verdict.value} TECHNIQUES {' '.join(verdict.techniques)}"
        )
        assert verdict.techniques
    return {verdict.name: verdict.value for verdict in found}


@fewer(0.5)
@given(PLAIN, st.data(), st.sampled_from(ASKED))
def test_files_are_answered_as_the_definitions_say(net: PetriNet, data: st.DataObject, engine: str) -> None:
    assume(graph_of(net) is not None)
    edges = edges_of(net)
    places, transitions = [p.name for p in net.places], [t.name for t in net.transitions]
    asked = {f"f{i}": data.draw(formulas(places, transitions, leaves=5)) for i in range(4)}
    sums = {f"b{i}": data.draw(st.lists(st.sampled_from(places), min_size=1, max_size=4)) for i in range(2)}
    bodies = {n: written(f) for n, f in asked.items()} | {n: bound(names) for n, names in sums.items()}

    def tokens(marking: Marking, names: list[str]) -> int:
        return sum(marking[net.place_index[name]] for name in names)

    expected = {n: str(net.initial in satisfying(f, net, edges)).upper() for n, f in asked.items()}
    expected |= {n: str(max(tokens(m, names) for m in edges)) for n, names in sums.items()}
    assert answers(net, bodies, engine) == expected


@pytest.mark.parametrize("engine", ASKED)
@pytest.mark.parametrize("tokens", [1, 2, 3, 7])
def test_the_most_tokens_of_some_places_at_the_same_time(engine: str, tokens: int) -> None:
    """Tokens that walk round: never more than there are, in any places together."""
    builder = NetBuilder("ring")
    names = [builder.place(f"p{i}", initial=tokens if i == 0 else 0) for i in range(3)]
    for i in range(3):
        builder.transition(f"t{i}", consume=[names[i]], produce=[names[(i + 1) % 3]])
    bodies = {
        "one": bound(names[1:2]),
        "two": bound(names[:2]),
        "twice": bound([names[2]] * 2),
        "none": bound([]),
    }
    expected = {"one": tokens, "two": tokens, "twice": 2 * tokens, "none": 0}
    assert answers(builder.build(), bodies, engine) == {name: str(most) for name, most in expected.items()}


def growing() -> PetriNet:
    """A place that grows without end while a switch is on; once it is off nothing fires."""
    builder = NetBuilder("grows")
    for place, initial in (("on", 1), ("off", 0), ("heap", 0)):
        builder.place(place, initial=initial)
    builder.transition("grow", read=["on"], produce=["heap"])
    builder.transition("stop", consume=["on"], produce=["off"])
    return builder.build()


def at_least(place: str, tokens: int) -> Formula:
    return Compare(Sum(tokens), "<=", Sum(0, (place,)))


def test_an_unbounded_net_is_answered_as_far_as_few_markings_decide(tmp_path: Path) -> None:
    asked: dict[str, tuple[Formula, bool]] = {
        "heaped": (Derived("EF", (at_least("heap", 3),)), True),
        "dies": (Derived("EF", (Deadlock(),)), True),
        "never both": (Derived("AG", (Not(And((at_least("on", 1), at_least("off", 1)))),)), True),
        "next": (EX(And((at_least("heap", 1), EX(at_least("off", 1))))), True),
        "something": (Derived("AF", (Or((at_least("heap", 1), at_least("off", 1))),)), True),
        "not at once": (Derived("AX", (at_least("heap", 1),)), False),
    }
    bodies = {name: written(formula) for name, (formula, _) in asked.items()}
    expected = {name: str(value).upper() for name, (_, value) in asked.items()}
    assert answers(growing(), bodies, "auto") == expected
    properties = read_properties(file_of(tmp_path, bodies | {"most": bound(["heap"])}))
    found = answer_file(Questions(growing()), properties)
    assert {verdict.name: verdict.value for verdict in islice(found, len(expected))} == expected
    with pytest.raises(UnboundedError):  # what is known comes before the error
        next(found)


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (element("negation"), "<negation> holds 0 elements, expected 1"),
        (element("implication", element("true")), "<implication> holds 1 elements, expected 2"),
        (element("hope"), "found <hope>, expected a formula on states"),
        (
            element("exists-path", element("true")),
            "found <true>, expected <finally>, <globally>, <next> or <until>",
        ),
        (element("is-fireable", element("place", "on")), "found <place>, expected <transition>"),
        (
            element("integer-le", element("integer-constant", "x"), element("integer-sum")),
            "found 'x', expected an",
        ),
        (
            element("integer-le", element("true"), element("integer-sum")),
            "found <true>, expected <tokens-count>, <integer-constant> or <integer-sum>",
        ),
        (
            element("exists-path", element("until", element("reach", "x"), element("before", "y"))),
            "found <reach>, expected <before>",
        ),
        (element("is-fireable", element("transition", "fly")), "fly"),
        (bound(["nowhere"]), "no place is named nowhere"),
        (element("conjunction", element("is-fireable", element("transition", "fly"))), "wrong: "),
    ],
)
def test_what_is_wrong_in_a_file_is_told_with_its_line(tmp_path: Path, body: str, words: str) -> None:
    path = file_of(tmp_path, {"right": element("deadlock"), "wrong": body})
    with pytest.raises(InputError) as caught:
        list(answer_file(Questions(growing()), read_properties(path)))
    (problem,) = caught.value.problems
    assert words in problem.message
    assert problem.source is not None
    assert problem.source.line == 3


@pytest.mark.parametrize("missing", ["id", "formula"])
def test_a_property_needs_a_name_and_a_formula(tmp_path: Path, missing: str) -> None:
    parts = {"id": element("id", "x"), "formula": element("formula", element("deadlock"))}
    del parts[missing]
    path = tmp_path / "p.xml"
    path.write_text(
        f'<property-set xmlns="http://mcc.lip6.fr/">{element("property", *parts.values())}</property-set>'
    )
    with pytest.raises(InputError, match=f"a property without <{missing}>"):
        read_properties(path)
    path.write_text("<property-set/>")
    with pytest.raises(InputError, match="expected <property-set> of the namespace"):
        read_properties(path)


def ahead(edges: dict[Marking, list[tuple[int, Marking]]], start: Marking) -> set[Marking]:
    found, stack = {start}, [start]
    while stack:
        for _, after in edges[stack.pop()]:
            if after not in found:
                found.add(after)
                stack.append(after)
    return found


def by_definition(net: PetriNet) -> dict[str, bool]:
    """What each examination asks, of every reachable marking."""
    edges = edges_of(net)
    everything = set(range(len(net.transitions)))
    fired = {m: {t for at in ahead(edges, m) for t, _ in edges[at]} for m in edges}
    return {
        "ReachabilityDeadlock": any(not after for after in edges.values()),
        "OneSafe": all(max(marking) <= 1 for marking in edges),
        "QuasiLiveness": fired[net.initial] == everything,
        "Liveness": all(later == everything for later in fired.values()),
        "StableMarking": any(len({m[p] for m in edges}) == 1 for p in range(len(net.places))),
    }


@fewer(0.5)
@given(PLAIN, st.sampled_from(ASKED))
def test_examinations_are_answered_as_the_definitions_say(net: PetriNet, engine: str) -> None:
    assume(graph_of(net) is not None)
    expected = by_definition(net)
    assert expected.keys() == set(EXAMINATIONS)
    for examination, value in expected.items():
        verdict = answer_examination(Questions(net, engine=engine), examination)  # type: ignore[arg-type]
        assert (verdict.name, verdict.value) == (f"{net.name}-{examination}", str(value).upper())


def test_examinations_of_an_unbounded_net() -> None:
    for examination, value in (("OneSafe", "FALSE"), ("ReachabilityDeadlock", "TRUE")):
        assert answer_examination(Questions(growing()), examination).value == value
    with pytest.raises(UnboundedError):
        answer_examination(Questions(growing()), "Liveness")
