"""The formula language: what reads back, and how errors are told."""

from __future__ import annotations

import pytest
from hypothesis import given

from mcpn.answers.mission_names import MissionNames
from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError, LimitError
from mcpn.logic.formulas import EU
from mcpn.logic.syntax import MAX_DEPTH, MAX_LENGTH, parse
from mcpn.logic.writing import show
from mcpn.nets.petri import NetBuilder
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.goal import And, AtMost, Fires, Formula, Not, Or, marked
from tests.logic.formulas import Written, formulas
from tests.logic.formulas import text as text_of

PLACES = ["a", "b", "c", "p", "q", "U", "E", "A", "EX", "and", "true", "success", "success_p"]
PLACES += ["a b", 'quo"te', "x.y", "é", "1", "tokens"]


def names_of(places: list[str]) -> Names:
    builder = NetBuilder("n")
    for place in places:
        builder.place(place)
    for number, place in enumerate(places):
        builder.transition(f"{place}{number}", consume=[place], produce=[place])
    return Names(builder.build())


NAMES = names_of(PLACES)
TRANSITIONS = [t.name for t in NAMES.net.transitions]


def read(text: str) -> Formula:
    return parse(text, NAMES)


def place(name: str) -> Formula:
    return marked(PLACES.index(name))


@given(formulas(PLACES, TRANSITIONS))
def test_what_is_shown_reads_back(formula: Written) -> None:
    found = read(text_of(formula))
    shown = show(found, NAMES)
    assert read(shown) == found
    assert show(read(shown), NAMES) == shown


def implied(left: Formula, right: Formula) -> Formula:
    return Or(~left, right)


def same(left: Formula, right: Formula) -> Formula:
    return Or(And(left, right), And(~left, ~right))


A, B, C, P, Q = map(PLACES.index, "abcpq")


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("a & b | c", Or(And(place("a"), place("b")), place("c"))),
        ("a | b & !c | p", Or(place("a"), And(place("b"), Not(place("c"))), place("p"))),
        ("a & b & c", And(place("a"), place("b"), place("c"))),
        ("a & (b & c)", And(place("a"), And(place("b"), place("c")))),
        ("not a and b", And(Not(place("a")), place("b"))),
        ("a -> b -> c", implied(place("a"), implied(place("b"), place("c")))),
        ("a <-> b <-> c", same(same(place("a"), place("b")), place("c"))),
        ("a -> b <-> c | p", same(implied(place("a"), place("b")), Or(place("c"), place("p")))),
        ("E [ a U b ]", EU(place("a"), place("b"))),
        ("E[a U b] & c", And(EU(place("a"), place("b")), place("c"))),
        ("E[a -> b U (c)]", EU(implied(place("a"), place("b")), place("c"))),
        ("E[U U U]", EU(place("U"), place("U"))),
        ("2 + tokens(p, q) + p < 3", AtMost(((P, 2), (Q, 1)), 0)),
        ("a + 1 <= tokens(b, c)", AtMost(((A, 1), (B, -1), (C, -1)), -1)),
        ("a > b", AtMost(((A, -1), (B, 1)), -1)),
        ("a != b", Not(And(AtMost(((A, 1), (B, -1)), 0), AtMost(((A, -1), (B, 1)), 0)))),
        ("( ( p ) )", place("p")),
        ('"success"', place("success")),
        ("success_p", place("success_p")),
        ("enabled(b1, a0, b1)", Fires((0, 1))),
    ],
)
def test_texts(text: str, formula: Formula) -> None:
    assert read(text) == formula


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "column 1: found the end, expected a formula"),
        ("AG", "column 3: found the end, expected a formula"),
        ("AG (p", "column 6: found the end, expected ')'"),
        ("p &", "column 4: found the end, expected a formula"),
        ("p q", "column 3: found 'q', expected the end"),
        ("p <= ", "column 5: found the end, expected a sum of tokens"),
        ("E[p V q]", "column 5: found 'V', expected U"),
        ("EFF p", "did you mean EF?"),
        ('"tokens"(GPS)', "column 9: found '('"),
        ("oss(GPS)", "column 1: no word is named oss; did you mean oos?"),
        ("p & running(dive)", "column 5: no word is named running; did you mean objective or activity?"),
        ("p & zzz(dive)", "no word is named zzz; expected one of objective, block, "),
        ("lift q", "column 6: found 'q', expected the end"),
        ("a + lift < 2", "column 5: no place is named lift"),
        ("p &\n enabled(a0,\n  lift)", "line 3, column 3: no transition is named lift"),
        ("p &\n  (q | )", "line 2, column 8: found ')', expected a formula"),
        ("p @ q", "column 3: found '@'"),
        ("tokens(p,) < 1", "column 10: found ')', expected a name"),
        ('"a\\q"', "column 1: "),
        ("p < " + "9" * 5000, "a number of more than 18 digits"),
        ("!" * (MAX_DEPTH + 1) + "p", f"more than {MAX_DEPTH} operators deep"),
    ],
)
def test_errors_say_where_and_what(text: str, told: str) -> None:
    with pytest.raises(InputError) as caught:
        read(text)
    assert told in str(caught.value)


def test_limits_are_exact() -> None:
    assert read("p <= " + "9" * 18) != read("p <= " + "9" * 17)
    with pytest.raises(InputError, match="column 6: a number of more than 18 digits"):
        read("p <= " + "9" * 19)
    deep = "EX !" * (MAX_DEPTH // 2)
    assert read(f"{deep}p") != read("EX !" * (MAX_DEPTH // 2 - 1) + "p")
    for too_deep in (
        f"{deep}!p",
        "!" * (MAX_DEPTH + 1) + "p",
        "(" * MAX_DEPTH + f"p{' <-> p)' * MAX_DEPTH} -> p",
    ):
        with pytest.raises(InputError, match=f"more than {MAX_DEPTH} operators deep"):
            read(too_deep)
    assert read("p".rjust(MAX_LENGTH)) == read("p")
    with pytest.raises(InputError, match=f"more than {MAX_LENGTH} characters"):
        read("p".rjust(MAX_LENGTH + 1))


def test_what_is_said_twice_is_bounded() -> None:
    for text in ("p" + " <-> p" * 30, "A[p U " * 30 + "p" + "]" * 30):
        with pytest.raises(LimitError, match="operators in full"):
            read(text)


def test_parentheses_of_any_depth_are_read() -> None:
    assert read("(" * 20_000 + "p" + ")" * 20_000) == place("p")


def test_unknown_names_are_told_with_what_is_near(ulysse_net: MissionNet) -> None:
    with pytest.raises(InputError, match=r"column 8: no place is named lift; did you mean left\?"):
        parse("AG EF !lift", names_of(["left"]))
    names = MissionNames(ulysse_net)
    for text, told in (
        ("objective(divng)", "column 11: no objective is named divng; did you mean transect.diving?"),
        (
            "objective(crossing.diving)",
            "named crossing.diving; did you mean transect.diving?",
        ),
        ("oos(GPS)", "column 5: no resource is named GPS"),
        ("oos(xyz)", "named xyz; expected one of GPS_sensor, IMU_sensor, thruster_actuator"),
        ("alternative(localisation)=gps", "no alternative of localisation is named gps"),
        ("event(GPS_sensor_EV_OS)", "did you mean GPS_sensor_EV_OOS"),
        ("enabled(GPS_sensor_EV_OOS)", "no transition is named GPS_sensor_EV_OOS; did you mean"),
        ("available(nothing_like_it)", "no resource is named nothing_like_it"),
    ):
        with pytest.raises(InputError) as caught:
            parse(text, names)
        assert told in str(caught.value)
    for text in ("objective(diving)", "available(location)", "available(GPS_sensor)", "waiting(diving)"):
        parse(text, names)


def test_what_stands_behind_an_operator_need_not_be_a_space() -> None:
    for text in ("EF(p)", "EF!!p", "EF\tp", "EF\np", 'EF"p"', "EF EF p"):
        assert read(text) == read("EF p") or text == "EF EF p", text
    assert read("EX&p") == read('"EX" & p')  # a name


def test_a_mistake_is_shown_in_its_own_line() -> None:
    with pytest.raises(InputError) as caught:
        read("p &\n  (q | )  \n& a")
    assert str(caught.value).splitlines()[-2:] == ["    (q | )  ", "         ^"]
    with pytest.raises(InputError) as caught:
        read("p & q &   ")
    assert "found the end" in str(caught.value)
    assert str(caught.value).splitlines()[-1] == " " * 2 + " " * len("p & q &") + "^"


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("a && b || !c", "(a & b) | !c"),
        ("a == 1", "a = 1"),
        ("tokens(a) + b == p", "a + b = p"),
        ("[] a", "G a"),
        ("<>a", "F a"),
        ("[]<>a", "G F a"),
        ("[](a -> <> b)", "G (a -> F b)"),
        ("![]a", "!(G a)"),
        ("A[] a", "AG a"),
        ("A[](a)", "AG a"),
        ("E<> a", "EF a"),
        ("A<>a", "AF a"),
        ("E[] a", "EG a"),
        ("AG(a&&b)", "AG (a & b)"),
        # Precedence and associativity, as docs/commands.md says them.
        ("p U q & c", "(p U q) & c"),
        ("p U q U c", "p U (q U c)"),
        ("p R q W c", "p R (q W c)"),
        ("a -> b -> c", "a -> (b -> c)"),
        ("a <-> b <-> c", "(a <-> b) <-> c"),
        ("a | b & c", "a | (b & c)"),
        ("a <-> b -> c", "a <-> (b -> c)"),
        ("a -> b | c", "a -> (b | c)"),
        ("AG a -> b", "(AG a) -> b"),
        ("!a & b", "(!a) & b"),
    ],
)
def test_operators_that_people_type(text: str, same: str) -> None:
    assert read(text) == read(same)


def test_to_the_left_and_to_the_right_differ() -> None:
    assert read("a -> b -> c") != read("(a -> b) -> c")
    assert read("p U q U c") != read("(p U q) U c")
    assert read("AG a -> b") != read("AG (a -> b)")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a => b", "column 3: found '=>', .*; write -> for 'implies', >= for 'at least'"),
        ("a =< 1", "found '=<', .*; write <= for 'at most'"),
        ("a <=> b", "found '<=>', .*; write <-> for 'equivalent'"),
        ("a <> b", "found '<>', .*; write != for 'not equal'"),
        ("a AND b", "found 'AND', .*; write & or and"),
        ("NOT a", "found 'a', .*; write ! or not"),
        ("~a", "found '~', expected a formula; write ! for 'not'"),
        ("a - b >= 0", "found '-', .*; write the sums so that no number is negative"),
        ("2 * a = 2", r"found '\*', .*; write a sum, as tokens\(p, p\) for twice p"),
        ("a /\\ b", "found '/', .*; write & for 'and', | for 'or'"),
    ],
)
def test_other_signs_are_told_with_what_to_write(text: str, told: str) -> None:
    with pytest.raises(InputError, match=told.replace("|", r"\|")):
        read(text)
