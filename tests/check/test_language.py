"""The formula language: what reads back, and how errors are told."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.check.logic.formulas import EU, And, Compare, Formula, Not, Or, Sum, Word
from mcpn.check.logic.language import MAX_DEPTH, MAX_LENGTH, parse, show
from mcpn.check.logic.resolve import resolve
from mcpn.errors import InputError, LimitError
from mcpn.net.compose import MissionNet
from mcpn.net.petri import NetBuilder
from tests.check.formulas import formulas

NAMES = ["p", "E", "U", "A", "EX", "and", "true", "success", "a b", 'quo"te', "x.y", "é", "1", "tokens"]
WORDS = st.builds(
    Word,
    st.sampled_from(["objective", "activity", "waiting", "refused", "oos", "available", "event"]),
    st.sampled_from(NAMES),
) | st.builds(Word, st.just("alternative"), st.sampled_from(NAMES), st.none() | st.sampled_from(NAMES))


@given(formulas(NAMES, NAMES) | WORDS)
def test_what_is_shown_reads_back(formula: Formula) -> None:
    text = show(formula)
    assert parse(text) == formula
    assert show(parse(text)) == text


def marked(name: str) -> Compare:
    return Compare(Sum(0, (name,)), ">=", Sum(1))


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("a & b | c", Or((And((marked("a"), marked("b"))), marked("c")))),
        ("not a and b", And((Not(marked("a")), marked("b")))),
        ("E [ a U b ]", EU(marked("a"), marked("b"))),
        ("2 + tokens(p, q) + p < 3", Compare(Sum(2, ("p", "q", "p")), "<", Sum(3))),
        ("( ( p ) )", marked("p")),
        ("success", Word("success")),
        ("success_p", marked("success_p")),
        ("oos (GPS)", Word("oos", "GPS")),
    ],
)
def test_texts(text: str, formula: Formula) -> None:
    assert parse(text) == formula


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
        ("oss(GPS)", "did you mean oos?"),
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
        parse(text)
    assert told in str(caught.value)


def test_limits_are_exact() -> None:
    assert parse("p <= " + "9" * 18) != parse("p <= " + "9" * 17)
    with pytest.raises(InputError, match="column 6: a number of more than 18 digits"):
        parse("p <= " + "9" * 19)
    assert parse("!" * MAX_DEPTH + "p") != parse("!" * (MAX_DEPTH - 1) + "p")
    with pytest.raises(InputError, match=f"more than {MAX_DEPTH} operators deep"):
        parse("!" * (MAX_DEPTH + 1) + "p")
    assert parse("p".rjust(MAX_LENGTH)) == parse("p")
    with pytest.raises(InputError, match=f"more than {MAX_LENGTH} characters"):
        parse("p".rjust(MAX_LENGTH + 1))


def test_what_is_said_twice_is_bounded() -> None:
    builder = NetBuilder("n")
    builder.place("p")
    for text in ("p" + " <-> p" * 30, "A[p U " * 30 + "p" + "]" * 30):
        with pytest.raises(LimitError, match="operators in full"):
            resolve(parse(text), builder.build())


def test_parentheses_of_any_depth_are_read() -> None:
    assert parse("(" * 20_000 + "p" + ")" * 20_000) == marked("p")


def test_unknown_names_are_told_with_what_is_near(ulysse_net: MissionNet) -> None:
    builder = NetBuilder("n")
    builder.place("left")
    with pytest.raises(InputError, match=r"column 8: no place is named lift; did you mean left\?"):
        resolve(parse("AG EF !lift"), builder.build())
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
            resolve(parse(text), ulysse_net.net, ulysse_net)
        assert told in str(caught.value)
    for text in ("objective(diving)", "available(location)", "available(GPS_sensor)", "waiting(diving)"):
        resolve(parse(text), ulysse_net.net, ulysse_net)
