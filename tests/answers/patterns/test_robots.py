"""The 22 patterns of robotic missions against what they mean: on all short words, on their own traces."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from mcpn.answers.patterns.robot_patterns import (
    FUTURE,
    GLOBAL,
    PAST,
    PUBLISHED_MOVEMENTS,
    REACTIONS,
    WAIT,
    entries,
    movement,
)
from tests.answers.patterns import robots as meant
from tests.answers.patterns.words import Truths, Words, short

LOCATIONS = "pqr"
SHORT = {number: list(short(LOCATIONS[:number], length)) for number, length in ((2, 6), (3, 5))}


def agree(words: Words, text: str, expected: Truths, among: Truths | None = None) -> None:
    differing = words.satisfying(text) ^ expected
    if among is not None:
        differing = differing & among
    assert not differing.any(), words.shown(differing)


@pytest.mark.parametrize("number", SHORT)
@pytest.mark.parametrize("pattern", PUBLISHED_MOVEMENTS)
def test_movements(pattern: str, number: int) -> None:
    """What is used, on all words; what is published, on those that the catalogue speaks of."""
    kind, order = pattern.split()
    of = LOCATIONS[:number]
    for words in SHORT[number]:
        expected = meant.movement(words, kind, order, of)
        agree(words, movement(kind, order, list(of)), expected)
        agree(words, PUBLISHED_MOVEMENTS[pattern](list(of)), expected, meant.traces(words, of))


def nested(each: str, times: int) -> str:
    """At least so many states of the path are at the location."""
    return f"F ({each} & X {nested(each, times - 1)})" if times > 1 else f"F {each}"


def exact(each: str, times: int) -> str:
    """Exactly so many states of the path are at the location."""
    inside = f"X G !{each}"
    for _ in range(times):
        inside = f"X (!{each} U ({each} & {inside}))"
    return inside.removeprefix("X ")


PUBLISHED_COUNTS: Mapping[str, Callable[[str, int], str]] = {
    "at_most": lambda each, times: f"!{nested(each, times)}",  # which says: less often
    "at_least": nested,
    "exactly": exact,
}
"""By what is said of a number of visits, the formula that is published."""


@pytest.mark.parametrize("times", [1, 2, 3])
def test_numbers_of_entries(times: int) -> None:
    for words in short("p", 8):
        count, traces = meant.entries(words, "p"), meant.traces(words, "p")
        for said, expected in (
            ("at_most", count <= times),
            ("at_least", count >= times),
            ("exactly", count == times),
        ):
            agree(words, entries(said, "p", times), expected)
            # Of upper restriction the formula and its own example are off by one.
            published = count < times if said == "at_most" else expected
            agree(words, PUBLISHED_COUNTS[said]("p", times), published, traces)


def test_the_rest_is_used_as_it_is_published() -> None:
    for words in SHORT[2]:
        agree(words, PAST.format(each="p", until="q"), meant.past(words, "p", "q"))
        agree(words, FUTURE.format(each="p", after="q"), meant.future(words, "p", "q"))
        agree(words, GLOBAL.format(each="p"), ~meant.some(words, "p"))
        agree(words, WAIT.format(each="p", until="q"), meant.waiting(words, "p", "q"))
        for when, text in REACTIONS.items():
            agree(words, text.format(to="p", gives="q"), meant.reaction(words, when, "p", "q"))


class Trace(Words):
    """One word of the catalogue: locations by number, ``#`` for any other; what repeats in parentheses."""

    def __init__(self, text: str) -> None:
        before, _, cycle = text.partition("(")
        steps = [*before.split(), *cycle.removesuffix(")").split()]
        self.length, self.cycle = len(steps), len(before.split())
        self.of = {
            atom: [np.array([step == number]) for step in steps]
            for atom, number in zip(LOCATIONS, "123", strict=True)
        }
        self.none = np.zeros(1, dtype=bool)
        self.horizon = self.length + 5 * (self.length - self.cycle)


TRACES = [
    # pattern, trace, what the catalogue says of it, what its formula says, what is used
    ("visit any", "1 4 3 1 4 2 (#)", True, True, True),
    ("visit sequenced", "1 4 3 1 4 2 (#)", False, False, False),
    ("visit sequenced", "1 3 1 2 4 3 (#)", True, True, True),
    ("visit ordered", "1 3 1 2 3 (#)", False, False, False),
    ("visit ordered", "1 4 1 2 4 3 (#)", True, True, True),
    ("visit strict", "1 4 1 2 4 3 (#)", False, False, False),
    ("visit strict", "1 4 2 4 3 (#)", True, True, True),
    ("visit fair", "1 4 1 3 1 4 2 (#)", False, False, False),
    ("visit fair", "1 4 3 1 4 2 2 4 (#)", True, False, False),
    ("patrolling any", "1 4 3 1 4 2 (2 3 1)", True, True, True),
    ("patrolling any", "1 2 3 (1 3)", False, False, False),
    ("patrolling sequenced", "1 4 3 1 4 2 (1 2 3)", True, True, True),
    ("patrolling sequenced", "1 4 3 1 4 2 (1 3)", False, False, False),
    ("patrolling ordered", "1 4 3 1 4 2 (1 2 3)", False, False, False),
    ("patrolling ordered", "1 1 2 4 4 3 (1 2 3)", True, False, True),
    ("patrolling strict", "1 4 1 2 4 3 (1 2 3)", False, False, False),
    ("patrolling strict", "1 4 2 4 3 (1 2 3)", True, True, True),
    ("patrolling fair", "1 4 3 1 4 2 (1 2 1 3)", False, False, False),
    ("patrolling fair", "1 4 3 4 2 4 (1 2 3)", True, False, False),
]


@pytest.mark.parametrize(("pattern", "trace", "said", "published", "used"), TRACES)
def test_traces_of_the_catalogue(pattern: str, trace: str, said: bool, published: bool, used: bool) -> None:
    """Three contradict their formulas; one of the three holds where a stay is one visit."""
    word = Trace(trace)
    assert bool(word.satisfying(PUBLISHED_MOVEMENTS[pattern](list(LOCATIONS)))[0]) == published
    kind, order = pattern.split()
    assert bool(word.satisfying(movement(kind, order, list(LOCATIONS)))[0]) == used
    assert said == published or pattern in ("visit fair", "patrolling fair", "patrolling ordered")


@pytest.mark.parametrize(
    ("said", "trace", "holds"),
    [
        ("at_most", "1 4 1 3 1 4 1 (3)", False),
        ("at_most", "4 3 1 2 4 (3)", True),
        ("exactly", "4 3 2 2 4 (3)", False),
        ("exactly", "1 4 3 1 4 1 (3)", True),
        ("at_least", "4 3 2 2 4 (3)", False),
        ("at_least", "1 4 3 1 4 1 (3)", True),
    ],
)
def test_traces_of_the_catalogue_with_three_visits(said: str, trace: str, holds: bool) -> None:
    word = Trace(trace)
    assert bool(word.satisfying(entries(said, "p", 3))[0]) == holds
