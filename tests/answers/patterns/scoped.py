"""What the patterns of Dwyer, Avrunin and Corbett mean, said of positions of words."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from tests.answers.patterns.words import Truths, Words

Interval = tuple[Truths, int, int, int]
"""The words that have it, its first position, the one behind its last, and that behind the last to judge."""


def intervals(words: Words, scope: str, later: int = 0) -> Iterator[Interval]:
    """The intervals of a scope. Of endless ones the first rounds are judged, as far as the horizon tells.

    Args:
        words: The words.
        scope: The scope.
        later: So many positions after ``q`` an interval begins.
    """
    end = words.horizon
    judged = 2 * words.length - words.cycle
    everywhere = ~words.none
    if scope == "globally":
        yield everywhere, 0, end, judged
    elif scope == "before":
        none_yet = everywhere
        for b, r in enumerate(words["r"]):
            yield none_yet & r, 0, b, b
            none_yet = none_yet & ~r
    elif scope == "after":
        none_yet = everywhere
        for a, q in enumerate(words["q"][: words.length]):
            yield none_yet & q, a + later, end, judged + later
            none_yet = none_yet & ~q
    else:
        ends = words["r"]
        for a, q in enumerate(words["q"][: words.length]):
            begin = a + later
            going_on = q & ~ends[begin]
            for b in range(begin + 1, min(2 * words.length + later, end)):
                yield going_on & ends[b], begin, b, b
                going_on = going_on & ~ends[b]
            if scope == "after_until":
                yield going_on, begin, end, judged + later


def absence(w: Words, a: int, b: int, judged: int) -> Truths:
    p = w["p"]
    return ~w.any(p[a:b])


def existence(w: Words, a: int, b: int, judged: int) -> Truths:
    return w.any(w["p"][a:b])


def universality(w: Words, a: int, b: int, judged: int) -> Truths:
    return w.all(w["p"][a:b])


def bounded(most: int) -> Callable[[Words, int, int, int], Truths]:
    def said(w: Words, a: int, b: int, judged: int) -> Truths:
        p, count = w["p"], np.zeros(len(w.none), dtype=np.int8)
        for j in range(a, b):
            count += p[j] if j == a else p[j] & ~p[j - 1]
        return np.asarray(count <= most)

    return said


def precedence(w: Words, a: int, b: int, judged: int) -> Truths:
    p, s, seen, holds = w["p"], w["s"], w.none, ~w.none
    for j in range(a, b):
        seen = seen | s[j]
        holds = holds & (~p[j] | seen)
    return holds


def response(w: Words, a: int, b: int, judged: int) -> Truths:
    p, s, later, holds = w["p"], w["s"], w.none, ~w.none
    for j in reversed(range(a, b)):
        later = later | s[j]
        if j < judged:
            holds = holds & (~p[j] | later)
    return holds


def precedence_2_1(w: Words, a: int, b: int, judged: int) -> Truths:
    """Before each p, or with it, there is a t, and an s before that t."""
    p, s, t = w["p"], w["s"], w["t"]
    had_s, chain, holds = w.none, w.none, ~w.none
    for j in range(a, b):
        chain = chain | (t[j] & had_s)
        holds = holds & (~p[j] | chain)
        had_s = had_s | s[j]
    return holds


def _later(of: list[Truths], a: int, b: int, none: Truths) -> dict[int, Truths]:
    """By position whether it is true at some later one."""
    found, later = {}, none
    for j in reversed(range(a, b)):
        found[j] = later
        later = later | of[j]
    return found


def precedence_1_2(w: Words, a: int, b: int, judged: int) -> Truths:
    """Before each s that a t follows, or with it, there is a p."""
    p, s, later_t = w["p"], w["s"], _later(w["t"], a, b, w.none)
    seen, holds = w.none, ~w.none
    for j in range(a, min(b, judged)):
        seen = seen | p[j]
        holds = holds & (~(s[j] & later_t[j]) | seen)
    return holds


def response_2_1(w: Words, a: int, b: int, judged: int) -> Truths:
    """With the first t after each s, or after that t, there is a p."""
    p, s, t = w["p"], w["s"], w["t"]
    some_t, first_answered, later_p, holds = w.none, w.none, w.none, ~w.none
    for j in reversed(range(a, b)):
        if j < judged:
            holds = holds & (~(s[j] & some_t) | first_answered)
        later_p = later_p | p[j]
        some_t = some_t | t[j]
        first_answered = np.where(t[j], later_p, first_answered)
    return holds


def response_1_2(w: Words, a: int, b: int, judged: int) -> Truths:
    """With each p, or after it, there is an s that a t follows."""
    p, s, later_t = w["p"], w["s"], _later(w["t"], a, b, w.none)
    chain, holds = w.none, ~w.none
    for j in reversed(range(a, b)):
        chain = chain | (s[j] & later_t[j])
        if j < judged:
            holds = holds & (~p[j] | chain)
    return holds


def constrained(w: Words, a: int, b: int, judged: int) -> Truths:
    """With each p, or after it, there is an s that a t follows, without z from that s up to that t."""
    p, s, t, z = w["p"], w["s"], w["t"], w["z"]
    to_t, chain, holds = w.none, w.none, ~w.none
    for j in reversed(range(a, b)):
        chain = chain | (s[j] & ~z[j] & to_t)
        if j < judged:
            holds = holds & (~p[j] | chain)
        to_t = t[j] | (~z[j] & to_t)
    return holds


MEANT: dict[str, tuple[str, Callable[[Words, int, int, int], Truths]]] = {
    "absence": ("p", absence),
    "existence": ("p", existence),
    "bounded_existence": ("p", bounded(2)),
    "universality": ("p", universality),
    "precedence": ("ps", precedence),
    "response": ("ps", response),
    "precedence_chain_2_1": ("pst", precedence_2_1),
    "precedence_chain_1_2": ("pst", precedence_1_2),
    "response_chain_2_1": ("pst", response_2_1),
    "response_chain_1_2": ("pst", response_1_2),
    "constrained_chain": ("pstz", constrained),
}
"""By pattern its atoms and what it says of an interval."""


def meant(words: Words, scope: str, of: Callable[[Words, int, int, int], Truths], later: int = 0) -> Truths:
    """The words each of whose intervals are as a pattern says."""
    found = ~words.none
    for having, a, b, judged in intervals(words, scope, later):
        if having.any():
            found = found & (~having | of(words, a, b, judged))
    return found
