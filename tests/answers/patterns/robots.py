"""What the patterns of robotic missions mean, said of positions of words; locations are their atoms."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from tests.answers.patterns.words import Truths, Words


def ring(of: str) -> list[tuple[str, str]]:
    return list(zip(of, of[1:] + of[0], strict=True))


def some(w: Words, atom: str) -> Truths:
    return w.any(w[atom])


def again(w: Words, atom: str) -> Truths:
    """It is true at some position that is repeated."""
    return w.any(w[atom][w.cycle : w.length])


def in_sequence(w: Words, of: str, begin: int = 0) -> Truths:
    reached = [~w.none, *(w.none for _ in of)]
    for j in range(begin, w.horizon):
        for k, atom in enumerate(of):
            reached[k + 1] = reached[k + 1] | (reached[k] & w[atom][j])
    return reached[-1]


def none_before(w: Words, first: str, second: str) -> Truths:
    """The second is at no position before the first one of the first."""
    seen, holds = w.none, ~w.none
    for a, b in zip(w[first], w[second], strict=True):
        seen = seen | a
        holds = holds & (~b | seen)
    return holds


def entries(w: Words, atom: str, before: str = "") -> np.ndarray[tuple[int], np.dtype[np.int8]]:
    """How often a location is entered, or how often before another is visited for the first time."""
    count, open_, was = np.zeros(len(w.none), dtype=np.int8), ~w.none, w.none
    for j, here in enumerate(w[atom]):
        if before:
            open_ = open_ & ~w[before][j]
        count += here & ~was & open_
        was = here
    return count


def not_again(w: Words, left: str, other: str) -> Truths:
    """Between the end of each stay and the next entry the other location is visited, or with that entry."""
    out, met, holds = w.none, w.none, ~w.none
    here, there = w[left], w[other]
    for j in range(1, w.horizon):
        leaving = here[j - 1] & ~here[j]
        out, met = out | leaving, (met & ~leaving) | there[j]
        entering = here[j] & ~here[j - 1]
        holds = holds & ~(entering & out & ~met)
        out = out & ~entering
    return holds


def met_again(w: Words, left: str, other: str) -> Truths:
    """As :func:`not_again`, and the other is visited after each stay."""
    return not_again(w, left, other) & (again(w, other) | ~ends(w, left))


def ends(w: Words, atom: str) -> Truths:
    """Some stay has an end after which only the repeated part is certain."""
    return w.any([a & ~b for a, b in pairwise(w[atom])])


def movement(w: Words, kind: str, order: str, of: str) -> Truths:
    each = some if kind == "visit" else again
    holds = w.all([each(w, atom) for atom in of])
    pairs = list(pairwise(of))
    if order in ("sequenced", "ordered", "strict"):
        begins = range(1 if kind == "visit" else w.length)
        holds = holds & w.all([in_sequence(w, of, begin) for begin in begins])
    if order in ("ordered", "strict"):
        holds = holds & w.all([none_before(w, a, b) for a, b in pairs])
        if kind == "patrolling":
            holds = holds & w.all([met_again(w, b, a) for a, b in ring(of)])
    if order == "strict" and kind == "visit":
        holds = holds & w.all([entries(w, a, b) <= 1 for a, b in pairs])
    if order == "strict" and kind == "patrolling":
        holds = holds & w.all([met_again(w, a, b) for a, b in pairs])
    if order == "fair":
        holds = holds & w.all([not_again(w, a, b) for a, b in ring(of)])
    return holds


def past(w: Words, location: str, until: str) -> Truths:
    """It is not visited before something comes to hold, which it does."""
    return none_before(w, until, location) & some(w, until)


def future(w: Words, location: str, after: str) -> Truths:
    seen, holds = w.none, ~w.none
    for here, now in zip(w[location], w[after], strict=True):
        seen = seen | now
        holds = holds & ~(here & seen)
    return holds


def waiting(w: Words, location: str, until: str) -> Truths:
    """The robot is there at each position before the first at which something holds, and there is one."""
    found, there = w.none, ~w.none
    for here, now in zip(w[location], w[until], strict=True):
        found = found | (there & now)
        there = there & here
    return found


def reaction(w: Words, when: str, to: str, gives: str) -> Truths:
    holds = ~w.none
    for j in range(w.length):
        now, then, after = w[to][j], w[gives][j], w[gives][j + 1]
        later = w.any(w[gives][j:])
        match when:
            case "instantaneous":
                holds = holds & (~now | then)
            case "prompt":
                holds = holds & (~now | after)
            case "delayed":
                holds = holds & (~now | later)
            case "bound":
                holds = holds & (now == then)
            case "bound_delay":
                holds = holds & (now == after)
    return holds


def traces(w: Words, of: str) -> Truths:
    """Words as the catalogue writes them: one location at a time at most, none twice in a row."""
    found = ~w.none
    for j in range(w.length + 1):
        for a in of:
            found = found & ~w.any(w[a][j] & w[b][j] for b in of if b != a)
            found = found & ~(w[a][j] & w[a][j + 1])
    return found
