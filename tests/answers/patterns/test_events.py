"""Patterns some letters of which are events, against what they mean of the moments of a run.

The judge writes a run out: a state, the event that leaves it, the next state, and so on. Formulas on states
are true at states alone, events at events alone, and the plain definitions of the patterns are asked of this
sequence. It knows nothing of how the program translates formulas.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from mcpn.answers.mission_names import MissionNames
from mcpn.answers.patterns.catalogue import PUBLISHED, SCOPES
from mcpn.answers.patterns.reading import read_pattern
from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.mission.requirement import (
    Absence,
    Avoidance,
    BoundedExistence,
    Existence,
    Pattern,
    Precedence,
    Reaction,
    Response,
    Universality,
    Wait,
)
from mcpn.mission.xml import read_mission
from tests.answers.patterns import robots
from tests.answers.patterns.scoped import MEANT, bounded, intervals
from tests.answers.patterns.words import Truths, Words, short

OF_SCOPES = {"globally": "", "before": "r", "after": "q", "between": "qr", "after_until": "qr"}
LENGTHS = {1: (5, None), 2: (5, None), 3: (4, None), 4: (3, None), 5: (3, None), 6: (3, 2)}
"""By the number of letters: how many states a run has, how many letters may be true at once (None: all)."""
STATES = {letter: f"oos({letter})" for letter in "pqrstz"}
EVENTS = {letter: f"happens({letter})" for letter in "pqrstz"}
SCOPED: dict[str, tuple[type[Pattern], dict[str, str]]] = {
    "absence": (Absence, {"p": "of"}),
    "existence": (Existence, {"p": "of"}),
    "bounded_existence": (BoundedExistence, {"p": "of"}),
    "universality": (Universality, {"p": "of"}),
    "precedence": (Precedence, {"p": "of", "s": "by"}),
    "response": (Response, {"p": "to", "s": "gives"}),
    "precedence_chain_2_1": (Precedence, {"p": "of", "s": "by", "t": "then"}),
    "precedence_chain_1_2": (Precedence, {"p": "by", "s": "of", "t": "followed_by"}),
    "response_chain_2_1": (Response, {"p": "gives", "s": "to", "t": "followed_by"}),
    "response_chain_1_2": (Response, {"p": "to", "s": "gives", "t": "then"}),
    "constrained_chain": (Response, {"p": "to", "s": "gives", "t": "then", "z": "without"}),
}
"""By pattern its element, and the attribute that each letter is."""
BOUNDS = {"globally": {}, "before": {"r": "before"}, "after": {"q": "after"}} | {
    "between": {"q": "after", "r": "before"},
    "after_until": {"q": "after", "r": "until"},
}


class Moments(Words):
    """The runs of some words, written out: each position as a state and the event that leaves it."""

    def __init__(self, words: Words, events: str, lasting: str = "") -> None:
        self.length, self.cycle = 2 * words.length, 2 * words.cycle
        self.none = words.none
        self.horizon = 2 * words.horizon
        self.of = {
            letter: [
                moment
                for here in each
                for moment in (
                    (self.none, here)
                    if letter in events
                    else (here, here if letter in lasting else self.none)
                )
            ]
            for letter, each in words.of.items()
        }


@pytest.fixture(scope="module")
def names(tmp_path_factory: pytest.TempPathFactory) -> MissionNames:
    """A robot whose hardware and events are called as the letters are."""
    path = tmp_path_factory.mktemp("letters") / "m.xml"
    robot = "".join(f'<hardware name="{each}"/>' for each in "pqrstz")
    robot += "".join(f'<event name="{each}"/>' for each in "pqrstz")
    path.write_text(
        f'<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">{robot}<activity name="a"/>'
        '</robot><objective name="o" activities="a"/></mission>'
    )
    return MissionNames(compose(read_mission(path)))


def formula_of(pattern: Pattern, names: MissionNames) -> str:
    """What the program makes of a pattern, of letters again."""
    text = read_pattern(pattern, names).formula
    for letter in "pqrstz":
        text = text.replace(STATES[letter], letter).replace(EVENTS[letter], letter)
    return text.replace("objective(o)", "p")


def attributes_of(names: dict[str, str], events: str) -> dict[str, Any]:
    """What the attributes of a pattern say, where some letters are events."""
    return {a: (EVENTS if letter in events else STATES)[letter] for letter, a in names.items()}


def kinds(letters: str) -> Iterator[str]:
    """All choices of the letters that are events, but for none."""
    for chosen in product((False, True), repeat=len(letters)):
        if any(chosen):
            yield "".join(letter for letter, event in zip(letters, chosen, strict=True) if event)


def meant(words: Words, pattern: str, scope: str, events: str) -> Truths:
    """What a pattern means of words, by moments."""
    lasting = "p" if pattern in ("bounded_existence", "universality") and "p" not in events else ""
    moments = Moments(words, events, lasting)
    found, (_, says) = ~words.none, MEANT[pattern]
    if pattern == "universality" and "p" in events:  # of states it says nothing
        moments.of["p"][::2] = [~words.none] * words.length
    for having, a, b, judged in intervals(moments, scope, later="q" in events):
        if having.any():
            found = found & (~having | says(moments, a, b, judged))
    return found


ALL = [(pattern, scope) for pattern in PUBLISHED for scope in SCOPES]


@pytest.mark.parametrize(("pattern", "scope"), ALL)
def test_each_pattern_in_each_scope_with_events(pattern: str, scope: str, names: MissionNames) -> None:
    letters = MEANT[pattern][0] + OF_SCOPES[scope]
    element, attributes = SCOPED[pattern]
    attributes = attributes | BOUNDS[scope]
    every = list(short(letters, *LENGTHS[len(letters)]))
    for events in kinds(letters):
        said = attributes_of(attributes, events)
        text = formula_of(element(**said), names)
        for words in every:
            differing = words.satisfying(text) ^ meant(words, pattern, scope, events)
            assert not differing.any(), (events, text, words.shown(differing))


@pytest.mark.parametrize("scope", SCOPES)
@pytest.mark.parametrize("most", [1, 3])
def test_any_number_may_bound_existence(scope: str, most: int, names: MissionNames) -> None:
    """Each time that an event happens counts, with no pause between; of a state each stretch does."""
    letters = "p" + OF_SCOPES[scope]
    attributes = {"p": "of"} | BOUNDS[scope]
    for events in kinds(letters):
        said = attributes_of(attributes, events)
        text = formula_of(BoundedExistence(**said, most=most), names)
        for words in short(letters, 5 if len(letters) < 3 else 4):
            moments = Moments(words, events, "" if "p" in events else "p")
            found = ~words.none
            for having, a, b, judged in intervals(moments, scope, later="q" in events):
                found = found & (~having | bounded(most)(moments, a, b, judged))
            assert not (words.satisfying(text) ^ found).any(), (events, text)


@pytest.mark.parametrize("events", ["", "q"])
def test_what_robots_keep_away_from_and_wait_for(events: str, names: MissionNames) -> None:
    other = (EVENTS if events else STATES)["q"]
    patterns = {
        formula_of(Avoidance(objectives=("o",), until=other), names): (robots.past, ""),
        formula_of(Avoidance(objectives=("o",), after=other), names): (robots.future, ""),
        formula_of(Wait(objectives=("o",), until=other), names): (robots.waiting, "p"),
    }
    assert len(patterns) == 3
    for words in short("pq", 5):
        for text, (says, lasting) in patterns.items():
            moments = Moments(words, events, lasting)
            expected = says(moments if events else words, "p", "q")
            assert not (words.satisfying(text) ^ expected).any(), text


@pytest.mark.parametrize("when", ["instantaneous", "prompt", "delayed", "bound", "bound_delay"])
def test_what_reacts_to_an_event_begins_with_the_next_state(when: str, names: MissionNames) -> None:
    text = formula_of(Reaction(to=EVENTS["p"], gives=STATES["s"], when=when), names)
    for words in short("ps", 5):
        came, there = words["p"], words["s"]
        after = ~words.none
        for j in range(words.length):
            next_, later = there[j + 1], words.any(there[j + 1 :])
            match when:
                case "instantaneous" | "prompt":
                    after = after & (~came[j] | next_)
                case "delayed":
                    after = after & (~came[j] | later)
                case _:
                    after = after & (came[j] == next_)
        if when == "bound":
            after = after & ~there[0]  # no event comes before the first state
        assert not (words.satisfying(text) ^ after).any(), text


@pytest.mark.parametrize(
    ("pattern", "holds"),
    [
        # leak pulls the robot out of rising: that it was rising as the leak came answers nothing.
        ('<response to="happens(leak)" gives="objective(rise)"/>', False),
        ('<response to="happens(leak)" gives="objective(sink)"/>', True),
        # The robot rose as the leak came, and this was before the leak.
        ('<absence of="objective(rise)" before="happens(leak)"/>', False),
        ('<absence of="objective(sink)" before="happens(leak)"/>', True),
        ('<existence of="objective(rise)" before="happens(leak)"/>', True),
        (
            '<universality of="!objective(rise)" after="happens(MISSION_EV_START)" before="happens(leak)"/>',
            False,
        ),
        ('<precedence of="objective(sink)" by="happens(leak)"/>', True),
        ('<precedence of="objective(rise)" by="happens(leak)"/>', False),
        ('<absence of="objective(rise)" after="happens(leak)"/>', True),
        ('<avoidance of="rise" until="happens(leak)"/>', False),
        ('<reaction to="happens(leak)" gives="objective(sink)" when="instantaneous"/>', True),
        ('<reaction to="happens(leak)" gives="objective(rise)" when="instantaneous"/>', False),
    ],
)
def test_a_mission_is_asked_before_and_after_an_event(pattern: str, holds: bool, tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><event name="leak"/>'
        f'<activity name="a"/></robot><requirement name="asked">{pattern}</requirement>'
        '<objective name="rise" activities="a" success="succeed" failure="succeed">'
        '<on event="leak" goto="sink"/></objective>'
        '<objective name="sink" activities="a"/></mission>'
    )
    (answer,) = check(compose(read_mission(path))).requirements
    assert answer.holds == holds, answer.asked.text
