"""Property files of the contest: what they say, and what is answered of nets that have no end."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch
from xml.sax.saxutils import escape

import numpy as np
import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from mcpn.errors import InputError, LimitError, Source, UnboundedError
from mcpn.logic.answering import _Answers, answer_all
from mcpn.logic.contest import Property, read_properties
from mcpn.logic.evaluate import largest
from mcpn.logic.questions import Questions
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.diagrams import symbolic
from mcpn.spaces.diagrams.bounded import reach_markings
from mcpn.spaces.diagrams.race_entrants import OneByOne
from mcpn.spaces.engine_names import Asked
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.equation import Ceiling, Proof, Solution, StateEquation
from mcpn.spaces.search.goal import Goal
from mcpn.testing.nets import FAMILIES
from mcpn.turns import Pausing
from tests.draws import fewer
from tests.logic.formulas import RELATIONS, Written, edges_of, formulas, read, satisfying
from tests.nets.nets import graph_of, nets, state_machines, token_nets
from tests.spaces.search.goals import all_markings
from tests.spaces.search.test_equation import assert_proved
from tests.spaces.search.test_home import leading_back

PLAIN = (
    token_nets()
    | nets(max_places=5, max_transitions=6, max_weight=2, events=False)
    | state_machines().map(lambda drawn: drawn[0])
)
ENGINES: tuple[Asked, ...] = ("auto", "explicit", "symbolic")
TAGS = {"!": "negation", "&": "conjunction", "|": "disjunction", "->": "implication", "<->": "equivalence"}
QUANTIFIERS = {"E": "exists-path", "A": "all-paths"}
OPERATORS = {"X": "next", "F": "finally", "G": "globally"}


def element(tag: str, *inside: str) -> str:
    return f"<{tag}>{''.join(inside)}</{tag}>"


def named(tag: str, names: Iterable[str]) -> list[str]:
    return [element(tag, escape(name)) for name in names]


def written(formula: Written) -> str:
    """A formula in the contest's XML, which has one relation between sums."""
    operator, *operands = formula
    if operator in ("true", "false", "deadlock"):
        return element(operator)
    if operator == "stable":
        return element("true")  # of nets without priorities
    if operator == "place":
        return written((">=", (0, *operands), (1,)))
    if operator == "enabled":
        return element("is-fireable", *named("transition", operands))
    if operator in RELATIONS:
        return related(operator, *operands)
    inside = list(map(written, operands))
    if operator in TAGS:
        return element(TAGS[operator], *inside)
    if operator[1] == "U":
        before, reach = inside
        path = element("until", element("before", before), element("reach", reach))
    else:
        path = element(OPERATORS[operator[1]], *inside)
    return element(QUANTIFIERS[operator[0]], path)


def related(relation: str, a: Written, b: Written) -> str:
    at_most, at_least = (element("integer-le", total(*one), total(*other)) for one, other in ((a, b), (b, a)))
    match relation:
        case "<=":
            return at_most
        case ">=":
            return at_least
        case "<":
            return element("negation", at_least)
        case ">":
            return element("negation", at_most)
        case "=":
            return element("conjunction", at_most, at_least)
    return element("exclusive-disjunction", at_most, at_least)  # one is less


def total(constant: int, *places: str) -> str:
    counts = [element("tokens-count", name) for name in named("place", places)]
    return element("integer-sum", element("integer-constant", str(constant)), *counts)


def bound(places: Sequence[str]) -> str:
    return element("place-bound", *named("place", places))


def file_of(folder: Path, bodies: dict[str, str]) -> Path:
    path = folder / "properties.xml"
    asked = [element("property", element("id", n), element("formula", body)) for n, body in bodies.items()]
    path.write_text("\n".join(['<property-set xmlns="http://mcc.lip6.fr/">', *asked, "</property-set>"]))
    return path


def answers(net: PetriNet, bodies: dict[str, str], engine: Asked) -> dict[str, str]:
    with TemporaryDirectory() as folder:
        properties = read_properties(file_of(Path(folder), bodies), Names(net))
    assert [asked.name for asked in properties] == list(bodies)
    found = list(answer_all(Questions(net, engine=engine), properties))
    assert len(found) == len(bodies)
    for verdict in found:
        told = f"FORMULA {verdict.name} {verdict.value} TECHNIQUES {' '.join(verdict.techniques)}"
        assert str(verdict) == told
        assert verdict.techniques
    return {verdict.name: verdict.value for verdict in found}


@fewer(0.5)
@given(PLAIN, st.data(), st.sampled_from(ENGINES))
def test_files_are_answered_as_the_definitions_say(net: PetriNet, data: st.DataObject, engine: Asked) -> None:
    assume(graph_of(net) is not None)
    edges = edges_of(net)
    drawn = formulas([p.name for p in net.places], [t.name for t in net.transitions], leaves=5)
    asked = {f"f{i}": data.draw(drawn) for i in range(4)}
    expected = {n: str(net.initial in satisfying(f, net, edges)).upper() for n, f in asked.items()}
    assert answers(net, {n: written(f) for n, f in asked.items()}, engine) == expected


@fewer(0.5)
@given(nets(max_places=5, max_transitions=6, events=False), st.data())
def test_what_was_listed_before_a_diagram_held_it_answers_the_same(
    net: PetriNet, data: st.DataObject
) -> None:
    assume(graph_of(net) is not None and max(map(max, graph_of(net) or [(0,)]), default=0) <= 1)
    edges = edges_of(net)
    drawn = formulas([p.name for p in net.places], [t.name for t in net.transitions], leaves=5)

    def exploring(net: PetriNet, *_: object) -> Iterator[OneByOne]:
        yield OneByOne(net, "file", tuple(range(len(net.places))), 1 << 30, edges=True)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(symbolic, "runners", exploring)
        questions = Questions(net)
        assert isinstance(questions.space, ArraySpace)
        assert questions.choice.engine == "explicit"
        listed = reach_markings(net, edges=True)
    assert listed.listed is not None
    assert {listed.encoding.marking(levels) for levels in listed.reachable} == set(graph_of(net) or ())
    for formula in (data.draw(drawn) for _ in range(4)):
        asked = read(formula, net)
        assert questions.evaluation.holds(asked) == (net.initial in satisfying(formula, net, edges))
        assert {
            questions.space.marking(int(s)) for s in np.flatnonzero(questions.evaluation.states(asked).mask)
        } == (satisfying(formula, net, edges))
    sums = [Counter(data.draw(st.lists(st.sampled_from(range(len(net.places)))))) for _ in range(2)]
    for weights in sums:
        expected = max(sum(m[p] * n for p, n in weights.items()) for m in graph_of(net) or ())
        assert largest(questions.space, weights) == expected


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("tokens", [1, 2, 3, 7])
def test_the_most_tokens_of_some_places_at_the_same_time(engine: Asked, tokens: int) -> None:
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


@pytest.mark.parametrize("engine", ENGINES)
def test_sums_are_compared_up_to_the_most_that_they_come_to(engine: Asked) -> None:
    """Three tokens in two places: a sum of twice one of them and the other is from three to six."""
    builder = NetBuilder("pair")
    builder.place("a", initial=3)
    builder.place("b")
    builder.transition("to", consume=["a"], produce=["b"])
    builder.transition("fro", consume=["b"], produce=["a"])
    asked: dict[str, tuple[Written, bool]] = {}
    for k in range(2, 8):
        twice = (0, "a", "a", "b")
        asked[f"AG at most {k}"] = ("AG", ("<=", twice, (k,))), k >= 6
        asked[f"AG at least {k}"] = ("AG", (">=", twice, (k,))), k <= 3
        asked[f"EF equal {k}"] = ("EF", ("=", twice, (k,))), 3 <= k <= 6
        asked[f"EF more {k}"] = ("EF", (">", (0, "a", "a"), (0, *["b"] * k))), True
        asked[f"AG differ {k}"] = ("AG", ("!=", (0, "a"), (k, "b"))), k != 3
    expected = {name: str(value).upper() for name, (_, value) in asked.items()}
    assert answers(builder.build(), {name: written(f) for name, (f, _) in asked.items()}, engine) == expected


def growing() -> PetriNet:
    """A place that grows without end while a switch is on; once it is off nothing fires."""
    builder = NetBuilder("grows")
    for place, initial in (("on", 1), ("off", 0), ("heap", 0)):
        builder.place(place, initial=initial)
    builder.transition("grow", read=["on"], produce=["heap"])
    builder.transition("stop", consume=["on"], produce=["off"])
    return builder.build()


def test_an_unbounded_net_is_answered_as_far_as_few_markings_decide(tmp_path: Path) -> None:
    def some(place: str, tokens: int = 1) -> Written:
        return "<=", (tokens,), (0, place)

    asked: dict[str, tuple[Written, bool]] = {
        "heaped": (("EF", some("heap", 3)), True),
        "dies": (("EF", ("deadlock",)), True),
        "never both": (("AG", ("!", ("&", some("on"), some("off")))), True),
        "next": (("EX", ("&", some("heap"), ("EX", some("off")))), True),
        "something": (("AF", ("|", some("heap"), some("off"))), True),
        "not at once": (("AX", some("heap")), False),
    }
    bodies = {name: written(formula) for name, (formula, _) in asked.items()}
    expected = {name: str(value).upper() for name, (_, value) in asked.items()}
    net = growing()
    assert answers(net, bodies, "auto") == expected
    properties = read_properties(file_of(tmp_path, bodies | {"most": bound(["heap"])}), Names(net))
    found = answer_all(Questions(net), properties, ["OneSafe", "ReachabilityDeadlock"])
    expected |= {"grows-OneSafe": "FALSE", "grows-ReachabilityDeadlock": "TRUE", "most": "INF"}
    assert {verdict.name: verdict.value for verdict in found} == expected
    with patch("mcpn.spaces.search.facts.growing", side_effect=lambda *_: iter(())):
        found = answer_all(Questions(net), properties, ["OneSafe"])
        known = [next(found) for _ in range(len(bodies) + 1)]
        assert {verdict.name for verdict in known} == {*bodies, "grows-OneSafe"}
        with pytest.raises(UnboundedError):  # what is known comes before the error
            next(found)
    (live,) = answer_all(
        Questions(net), (), ["Liveness"]
    )  # a siphon without a marked trap: no space is asked
    assert live.value == "FALSE"


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (element("negation"), "found 0 elements in <negation>, expected 1"),
        (element("implication", element("true")), "found 1 elements in <implication>, expected 2"),
        (element("conjunction"), "found 0 elements in <conjunction>, expected one or more"),
        (
            element("k-safe", element("tokens-count")),
            "found <tokens-count> in <k-safe>, expected <integer-constant>",
        ),
        (element("hope"), "wrong: found <hope> in <formula>, expected <true>, "),
        (element("exists-path", element("hope")), "wrong: found <hope> in <exists-path>, expected"),
        (
            element("is-fireable", element("place", "on")),
            "found <place> in <is-fireable>, expected <transition>",
        ),
        (
            element("integer-le", element("integer-constant", "x"), element("integer-sum")),
            "found 'x', expected an",
        ),
        (
            element("integer-le", element("true"), element("integer-sum")),
            "found <true> in <integer-le>, expected <integer-constant>, <tokens-count>, <integer-sum>, ",
        ),
        (
            element("exists-path", element("until", element("reach"), element("before"))),
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
        read_properties(path, Names(growing()))
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
        read_properties(path, Names(growing()))
    path.write_text('<property-set xmlns="http://tapaal.net/"/>')
    with pytest.raises(InputError, match=r":1: found no <property>, expected one or more"):
        read_properties(path, Names(growing()))
    path.write_text("<property-set/>")
    with pytest.raises(InputError, match="found <property-set> of no namespace, expected"):
        read_properties(path, Names(growing()))


def test_a_small_space_is_asked_before_anything_else(monkeypatch: pytest.MonkeyPatch) -> None:
    net = FAMILIES["component_ring"].net(4)
    often = read(("AG", ("EF", ("place", net.places[0].name))), net)
    asked = [Property("most", (0, 1), Source("ring")), Property("often", often, Source("ring"))]
    monkeypatch.setattr("mcpn.logic.answering.FIRST_SLICE", 1e9)  # however slow the machine is
    with patch("mcpn.spaces.search.facts.Facts", side_effect=AssertionError):
        told = list(answer_all(Questions(net), asked, ["Liveness"]))
    assert {answer.name.removeprefix("ring-4-"): answer.techniques[-1] for answer in told} == {
        "most": "DECISION_DIAGRAMS",
        "often": "EXPLICIT",
        "Liveness": "DECISION_DIAGRAMS",
    }


def test_what_a_search_leaves_open_is_named_and_no_space_is_built() -> None:
    net = FAMILIES["component_ring"].net(12)
    asked = [
        Property("pair", (0, 1), Source("ring")),
        Property("stays", read(("EG", ("place", net.places[0].name)), net), Source("ring")),
    ]
    examinations = ["OneSafe", "QuasiLiveness", "StableMarking", "Liveness"]
    given: dict[str, str] = {}

    def search() -> None:
        for verdict in answer_all(Questions(net, engine="search"), asked, examinations):
            given[verdict.name.removeprefix("ring-12-")] = verdict.value

    with (
        patch("mcpn.spaces.registry.Spaces.space", side_effect=AssertionError),
        patch("mcpn.spaces.registry.Spaces.going_on", side_effect=AssertionError),
        pytest.raises(LimitError, match=r"engine search leaves open: ring-12-Liveness$"),
    ):
        search()
    expected = {verdict.name: verdict.value for verdict in answer_all(Questions(net), asked)}
    assert {name: given[name] for name in expected} == expected
    assert given.keys() - expected.keys() == {"OneSafe", "QuasiLiveness", "StableMarking"}


@fewer(0.5)
@given(PLAIN | leading_back(), st.data())
def test_what_is_answered_without_a_space_is_right(net: PetriNet, data: st.DataObject) -> None:
    assume(graph_of(net) is not None)
    edges = edges_of(net)
    drawn = formulas([p.name for p in net.places], [t.name for t in net.transitions], leaves=5)
    again = drawn.flatmap(lambda f: st.sampled_from([("AG", ("EF", f)), ("EF", ("AG", f)), ("AF", f), f]))
    asked = {f"f{i}": data.draw(again) for i in range(4)}
    expected = {n: str(net.initial in satisfying(f, net, edges)).upper() for n, f in asked.items()}
    properties = [Property(name, read(f, net), Source("drawn")) for name, f in asked.items()]
    examinations = ["Liveness", "ReachabilityDeadlock"]
    explicit = answer_all(Questions(net, engine="explicit"), (), examinations)
    expected |= {verdict.name: verdict.value for verdict in explicit}
    with suppress(LimitError):
        for verdict in answer_all(Questions(net, engine="search"), properties, examinations):
            event(f"by {'+'.join(verdict.techniques)}")
            assert verdict.value == expected[verdict.name], verdict


@contextmanager
def proofs_given() -> Iterator[list[tuple[Proof, PetriNet, dict[int, int], Fraction]]]:
    """The proofs of the state equation meanwhile, each with its net and the bound that it shows of a sum."""
    given: list[tuple[Proof, PetriNet, dict[int, int], Fraction]] = []
    solve, most = StateEquation.solving, StateEquation.bounding
    less = Fraction(1, 10**9)

    def solved(self: StateEquation, goal: Goal, *cases: int) -> Pausing[Solution]:
        found = yield from solve(self, goal, *cases)
        assert bool(found.proofs) == (found.kind == "unreachable")
        given.extend((proof, self.net, {}, -less) for proof in found.proofs)
        return found

    def bounded(
        self: StateEquation, weights: Mapping[int, int], empty: Iterable[int] = ()
    ) -> Pausing[Ceiling]:
        found = yield from most(self, weights, empty)
        if found.bound is not None:
            assert found.proof is not None
            given.append((found.proof, self.net, dict(weights), found.bound + 1 - less))
        return found

    with patch.object(StateEquation, "solving", solved), patch.object(StateEquation, "bounding", bounded):
        yield given


@pytest.mark.parametrize(
    ("family", "size"),
    [("kanban", 30), ("fms", 12), ("philosophers", 12), ("token_ring", 12), ("eratosthenes", 24)],
)
def test_whatever_the_state_equation_answers_is_proved_in_fractions(family: str, size: int) -> None:
    net = FAMILIES[family].net(size)
    sums = [(p,) if p % 2 else (p, (7 * p + 3) % len(net.places)) for p in range(9)]
    asked = [Property(f"most-{i}", places, Source(net.name)) for i, places in enumerate(sums)]
    by_equation = []
    with proofs_given() as given, suppress(LimitError):
        for verdict in answer_all(
            Questions(net, engine="search"), asked, ["OneSafe", "QuasiLiveness", "StableMarking", "Liveness"]
        ):
            if "STATE_EQUATION" in verdict.techniques:
                assert given
                by_equation.append(verdict.name)
    assert {f"most-{i}" for i in range(len(sums))} <= set(by_equation)
    for proof, of, weights, bound in given:
        assert_proved(proof, of, weights, bound)


@given(PLAIN)
def test_examinations_that_imply_each_other_are_answered_as_by_the_space(net: PetriNet) -> None:
    assume(all_markings(net, 500) is not None)
    examinations = ["Liveness", "QuasiLiveness", "StableMarking", "OneSafe", "ReachabilityDeadlock"]
    fires = [
        Property(t.name, read(("EF", ("enabled", t.name)), net), Source("fires")) for t in net.transitions
    ]
    expected = {v.name: v.value for v in answer_all(Questions(net, engine="explicit"), fires, examinations)}
    with patch(
        "mcpn.spaces.registry.Spaces.going_on", lambda *_: iter(())
    ):  # what is known without the space first
        for asked in (examinations, examinations[:1], examinations[1:2]):
            searched = {v.name: v.value for v in answer_all(Questions(net), fires, asked)}
            assert searched.items() <= expected.items()
            assert len(searched) == len(fires) + len(asked)


@pytest.mark.parametrize("fires", [False, True])
def test_a_dead_transition_refutes_liveness_and_in_a_quasi_live_net_all_fire(fires: bool) -> None:
    net = FAMILIES["kanban"].net(6)  # which of its transitions fire is not looked at
    asked = {t.name: read(("EF", ("enabled", t.name)), net) for t in net.transitions}
    answers = _Answers(Questions(net), {**asked, "QuasiLiveness": "QuasiLiveness", "Liveness": "Liveness"})
    first, part = next(iter(asked.items()))
    told = {verdict.name for verdict in answers.learn("QuasiLiveness" if fires else part, fires, "EXPLICIT")}
    assert told == ({"QuasiLiveness", *asked} if fires else {first, "QuasiLiveness", "Liveness"})
    assert answers.waiting.keys() == ({"Liveness"} if fires else asked.keys() - {first})
