"""The patterns of Dwyer, Avrunin and Corbett as they are published, and what is used in their place.

Source: *Patterns in property specifications for finite-state verification*, ICSE 1999, and the pages of its
authors, as revised: eleven patterns in five scopes. ``p`` is what the pattern is about, ``s`` and ``t`` are
what precedes or responds, ``z`` is what must not be between, ``q`` begins a scope and ``r`` ends it.

A scope is an interval, closed at its beginning and open at its end: before ``r`` up to the first ``r``, if
there is one; after ``q`` from the first ``q`` on; between ``q`` and ``r`` from each ``q`` that is no ``r`` to
the next ``r``; after ``q`` until ``r`` the same, and for ever where no ``r`` follows.

Where a letter says that an event happens, it is true of the state that the event leaves. What comes after
``q`` begins with the next state then, the reaction (:func:`after_step`); the rest is said by
:mod:`mcpn.answers.patterns.moments`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

SCOPES = ("globally", "before", "after", "between", "after_until")


def bounded(most: int, *, of_events: bool = False, to_event: bool = False) -> dict[str, str]:
    """Bounded existence by scope: ``p`` holds in at most ``most`` intervals.

    Args:
        most: How many.
        of_events: ``p`` is an event: each time that it happens counts.
        to_event: ``r`` is an event: the state that it leaves counts too.
    """
    if of_events:
        apart, ends, until = "G !p", "!p U r", "!p W r"
        for _ in range(most):
            apart = f"!p W (p & X ({apart}))"
            ends, until = f"!p U (r | (p & X ({ends})))", f"!p W (r | (p & X ({until})))"
    else:
        last = "(r & !p)" if to_event else "r"
        apart, ends, until = "G !p", f"!p U {last}", f"(!p W {last}) | G p"
        for _ in range(most):
            apart = f"!p W (p W ({apart}))"
            ends, until = (f"(!p & !r) U (r | ((p & !r) U (r | ({end}))))" for end in (ends, until))
    return {
        "globally": apart,
        "before": f"F r -> ({ends})",
        "after": f"F q -> (!q U (q & ({apart})))",
        "between": f"G ((q & F r) -> ({ends}))",
        "after_until": f"G (q -> ({until}))",
    }


_1_2_INSIDE = "p -> (!r U (s & !r & X (!r U t)))"
_CONSTRAINED_INSIDE = "p -> (!r U (s & !r & !z & X ((!r & !z) U t)))"
_2_1_INSIDE = "s & X (!r U t) -> X (!r U (t & F p))"
PUBLISHED: Mapping[str, Mapping[str, str]] = {
    "absence": {
        "globally": "G !p",
        "before": "F r -> (!p U r)",
        "after": "G (q -> G !p)",
        "between": "G ((q & !r & F r) -> (!p U r))",
        "after_until": "G (q & !r -> (!p W r))",
    },
    "existence": {
        "globally": "F p",
        "before": "!r W (p & !r)",
        "after": "G !q | F (q & F p)",
        "between": "G (q & !r -> (!r W (p & !r)))",
        "after_until": "G (q & !r -> (!r U (p & !r)))",
    },
    "bounded_existence": bounded(2),
    "universality": {
        "globally": "G p",
        "before": "F r -> (p U r)",
        "after": "G (q -> G p)",
        "between": "G ((q & !r & F r) -> (p U r))",
        "after_until": "G (q & !r -> (p W r))",
    },
    "precedence": {
        "globally": "!p W s",
        "before": "F r -> (!p U (s | r))",
        "after": "G !q | F (q & (!p W s))",
        "between": "G ((q & !r & F r) -> (!p U (s | r)))",
        "after_until": "G (q & !r -> (!p W (s | r)))",
    },
    "response": {
        "globally": "G (p -> F s)",
        "before": "F r -> ((p -> (!r U (s & !r))) U r)",
        "after": "G (q -> G (p -> F s))",
        "between": "G ((q & !r & F r) -> ((p -> (!r U (s & !r))) U r))",
        "after_until": "G (q & !r -> ((p -> (!r U (s & !r))) W r))",
    },
    "precedence_chain_2_1": {
        "globally": "F p -> (!p U (s & !p & X (!p U t)))",
        "before": "F r -> (!p U (r | (s & !p & X (!p U t))))",
        "after": "G !q | (!q U (q & (F p -> (!p U (s & !p & X (!p U t))))))",
        "between": "G ((q & F r) -> (!p U (r | (s & !p & X (!p U t)))))",
        "after_until": "G (q -> (F p -> (!p U (r | (s & !p & X (!p U t))))))",
    },
    "precedence_chain_1_2": {
        "globally": "F (s & X F t) -> (!s U p)",
        "before": "F r -> (!(s & !r & X (!r U (t & !r))) U (r | p))",
        "after": "G !q | (!q U (q & (F (s & X F t) -> (!s U p))))",
        "between": "G ((q & F r) -> (!(s & !r & X (!r U (t & !r))) U (r | p)))",
        "after_until": "G (q -> ((!(s & !r & X (!r U (t & !r))) U (r | p)) | G !(s & X F t)))",
    },
    "response_chain_2_1": {
        "globally": "G (s & X F t -> X F (t & F p))",
        "before": f"F r -> (({_2_1_INSIDE}) U r)",
        "after": "G (q -> G (s & X F t -> X (!t U (t & F p))))",
        "between": f"G ((q & F r) -> (({_2_1_INSIDE}) U r))",
        "after_until": f"G (q -> (({_2_1_INSIDE}) U (r | G ({_2_1_INSIDE}))))",
    },
    "response_chain_1_2": {
        "globally": "G (p -> F (s & X F t))",
        "before": f"F r -> (({_1_2_INSIDE}) U r)",
        "after": "G (q -> G (p -> (s & X F t)))",
        "between": f"G ((q & F r) -> (({_1_2_INSIDE}) U r))",
        "after_until": f"G (q -> (({_1_2_INSIDE}) U (r | G (p -> (s & X F t)))))",
    },
    "constrained_chain": {
        "globally": "G (p -> F (s & !z & X (!z U t)))",
        "before": f"F r -> (({_CONSTRAINED_INSIDE}) U r)",
        "after": "G (q -> G (p -> (s & !z & X (!z U t))))",
        "between": f"G ((q & F r) -> (({_CONSTRAINED_INSIDE}) U r))",
        "after_until": f"G (q -> (({_CONSTRAINED_INSIDE}) U (r | G (p -> (s & !z & X (!z U t))))))",
    },
}
"""By pattern and scope the formula that is published."""


def _within(inside: str) -> dict[str, str]:
    """For the scopes that end with ``r``: each state of the interval satisfies ``inside``."""
    return {
        "before": f"F r -> (({inside}) U r)",
        "between": f"G ((q & !r & F r) -> (({inside}) U r))",
        "after_until": f"G (q & !r -> (({inside}) W r))",
    }


MENDED: Mapping[str, Mapping[str, str]] = {
    # Published: after some q, not after the first.
    "precedence": {"after": "G !q | (!q U (q & (!p W s)))"},
    # Published: t may come with r, and p after r, though the scope has ended there.
    "response_chain_2_1": _within("s & X (!r U (t & !r)) -> X (!r U (t & !r & (!r U (p & !r))))"),
    # Published: t may come with r; after q, s must come with p.
    "response_chain_1_2": {
        **_within("p -> (!r U (s & !r & X (!r U (t & !r))))"),
        "after": "G (q -> G (p -> F (s & X F t)))",
    },
    "constrained_chain": {
        **_within("p -> (!r U (s & !r & !z & X ((!r & !z) U (t & !r))))"),
        "after": "G (q -> G (p -> F (s & !z & X (!z U t))))",
    },
}
"""Formulas that are used where the published one does not say what its pattern and scope say."""


def after_step(formula: str) -> str:
    """The formula of a scope that ``q`` begins, where the interval begins one state later.

    >>> after_step("G ((q & !r & F r) -> (!p U r))")
    'G (q -> X ((!r & F r) -> (!p U r)))'
    >>> after_step("F q -> (!q U (q & (G !p)))")
    'F q -> (!q U (q & X ((G !p))))'

    Args:
        formula: As :func:`used` gives it, of one of the last three of :data:`SCOPES`.
    """
    for begin, repeated in _BEGINNINGS:
        if (found := begin.fullmatch(formula)) is not None:
            return found.expand(repeated)
    raise AssertionError(f"{formula} begins as no formula of a scope does")


_BEGINNINGS = tuple(
    (re.compile(begin), repeated)
    for begin, repeated in (
        (r"G \(\(q & ([^()]+)\) -> (.*)\)", r"G (q -> X ((\1) -> \2))"),
        (r"G \(q & ([^()]+) -> (.*)\)", r"G (q -> X ((\1) -> \2))"),
        (r"G \(q -> (.*)\)", r"G (q -> X (\1))"),
        (r"(.*!q U) \(q & (.*)\)\)", r"\1 (q & X (\2)))"),
        (r"G !q \| F \(q & (.*)\)", r"G !q | F (q & X (\1))"),
    )
)


def used(pattern: str, scope: str) -> str:
    """The formula of a pattern in a scope; of bounded existence that of twice, see :func:`bounded`.

    Args:
        pattern: One of :data:`PUBLISHED`.
        scope: One of :data:`SCOPES`.
    """
    return MENDED.get(pattern, {}).get(scope) or PUBLISHED[pattern][scope]
