"""Comparisons of sums and products of tokens against arithmetic in every marking."""

from __future__ import annotations

import operator
from collections.abc import Callable
from math import prod
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.errors import InputError, Source
from mcpn.logic.answering import answer_all
from mcpn.logic.contest import Property, read_properties
from mcpn.logic.polynomials import Polynomial, added, multiplied, related
from mcpn.logic.questions import Questions
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.goal import as_goal, holds
from tests.nets.nets import token_nets
from tests.shares import returns_early
from tests.spaces.search.goals import all_markings

RELATIONS: dict[str, Callable[[int, int], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    "=": operator.eq,
    "!=": operator.ne,
    ">=": operator.ge,
    ">": operator.gt,
}
PRODUCTS = st.lists(st.integers(0, 3), max_size=3).map(lambda places: tuple(sorted(places)))
SUMS = st.dictionaries(PRODUCTS, st.integers(-2, 2), max_size=3)


def value(of: Polynomial, marking: tuple[int, ...]) -> int:
    return sum(weight * prod(marking[place] for place in places) for places, weight in of.items())


@given(token_nets(), SUMS, SUMS, st.sampled_from([*RELATIONS]))
def test_a_comparison_is_that_of_the_numbers(
    net: PetriNet, left: Polynomial, right: Polynomial, relation: str
) -> None:
    markings = all_markings(net, 200)
    assume(markings is not None and len(net.places) > 3)
    assert markings is not None
    try:
        goal = as_goal(related(left, relation, right, net), net)
    except InputError as error:
        if "of at most 1000 values together" not in str(error):
            raise
        returns_early("a product of too many values")
        return
    assert goal is not None
    for marking in markings:
        assert holds(goal, net, marking) == RELATIONS[relation](value(left, marking), value(right, marking))


@given(SUMS, SUMS, st.tuples(*[st.integers(0, 4)] * 4))
def test_sums_and_products_are_those_of_numbers(
    left: Polynomial, right: Polynomial, marking: tuple[int, ...]
) -> None:
    a, b = value(left, marking), value(right, marking)
    assert value(added([left, right]), marking) == a + b
    assert value(multiplied([left, right, left]), marking) == a * b * a


def growing() -> PetriNet:
    builder = NetBuilder("n")
    builder.place("p")
    builder.place("q")
    builder.transition("t", produce=["p", "q"])
    return builder.build()


def test_a_product_of_unbounded_places_is_refused() -> None:
    with pytest.raises(
        InputError, match="found a product with p, expected one of places with a proved bound"
    ):
        related({(0, 1): 1}, ">=", {(): 2}, growing())
    assert related({(0,): 2}, ">=", {(): 2}, growing())


def counter() -> PetriNet:
    builder = NetBuilder("counter")
    builder.place("p", initial=3)
    builder.place("q")
    builder.transition("t", consume=["p"], produce=["q"])
    return builder.build()


def file_of(folder: Path, *bodies: str) -> Path:
    path = folder / "q.xml"
    asked = (f"<property><id>x{n}</id><formula>{body}</formula></property>" for n, body in enumerate(bodies))
    path.write_text("\n".join(['<property-set xmlns="http://tapaal.net/">', *asked, "</property-set>"]))
    return path


P, Q = (f"<tokens-count><place>{name}</place></tokens-count>" for name in "pq")
TWO = "<integer-constant>2</integer-constant>"


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (f"<integer-eq>{P}<integer-constant>3</integer-constant></integer-eq>", "TRUE"),
        (f"<integer-ne>{P}{Q}</integer-ne>", "TRUE"),
        (f"<integer-lt>{P}{Q}</integer-lt>", "FALSE"),
        (f"<integer-gt>{P}{Q}</integer-gt>", "TRUE"),
        (f"<integer-ge>{Q}{P}</integer-ge>", "FALSE"),
        (f"<integer-eq><integer-difference>{P}{TWO}{TWO}</integer-difference>{Q}</integer-eq>", "FALSE"),
        (
            f"<integer-eq><integer-difference>{TWO}</integer-difference><integer-difference>{Q}{TWO}"
            "</integer-difference></integer-eq>",
            "TRUE",
        ),
        (f"<integer-gt><integer-product>{P}{TWO}</integer-product>{TWO}</integer-gt>", "TRUE"),
        (
            f"<possibility><integer-eq><integer-product>{P}{Q}</integer-product>{TWO}</integer-eq></possibility>",
            "TRUE",
        ),
        (
            f"<possibility><integer-gt><integer-product>{P}{Q}</integer-product>{TWO}</integer-gt></possibility>",
            "FALSE",
        ),
        (f"<invariant><integer-le>{P}{TWO}</integer-le></invariant>", "FALSE"),
        (f"<impossibility><integer-gt>{Q}{P}</integer-gt></impossibility>", "FALSE"),
        ("<k-safe><integer-constant>3</integer-constant></k-safe>", "TRUE"),
        (f"<k-safe>{TWO}</k-safe>", "FALSE"),
        ("<quasi-liveness/>", "TRUE"),
        ("<liveness/>", "FALSE"),
        ("<stable-marking/>", "FALSE"),
    ],
)
def test_the_words_of_tapaal(body: str, expected: str, tmp_path: Path) -> None:
    properties = read_properties(file_of(tmp_path, body), Names(counter()))
    (verdict,) = answer_all(Questions(counter()), properties)
    assert verdict.value == expected


def test_examinations_are_properties_with_names_of_their_own(tmp_path: Path) -> None:
    found = read_properties(file_of(tmp_path, "<liveness/>", "<liveness/>"), Names(counter()))
    assert found == [
        Property("x0", "Liveness", Source(str(tmp_path / "q.xml"), 2)),
        Property("x1", "Liveness", Source(str(tmp_path / "q.xml"), 3)),
    ]
    assert {verdict.name: verdict.value for verdict in answer_all(Questions(counter()), found)} == {
        "x0": "FALSE",
        "x1": "FALSE",
    }


def test_every_problem_of_a_file_is_told_with_its_property(tmp_path: Path) -> None:
    path = file_of(tmp_path, "<deadlock/>", "<integer-eq/>", f"<integer-eq>{P}<hope/></integer-eq>", P)
    with pytest.raises(InputError) as caught:
        read_properties(path, Names(counter()))
    assert [str(problem).partition(", expected")[0] for problem in caught.value.problems] == [
        f"{path}:3: x1: found 0 elements in <integer-eq>",
        f"{path}:4: x2: found <hope> in <integer-eq>",
        f"{path}:5: x3: found <tokens-count> in <formula>",
    ]
