"""The patterns of robotic missions: the published formulas, and those used where locations are objectives.

Source: Menghi, Tsigkanos, Pelliccione, Ghezzi, Berger, *Specification patterns for robotic missions*, IEEE
TSE 2019, and its catalogue: 22 patterns. Their locations are objectives here. In the traces of the
catalogue a robot is at a location for one state; an objective runs for many. So what says that a location
is not visited *again* speaks here of entries: from the end of one stay to the beginning of the next.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise

Texts = Sequence[str]
"""For each location the formula that the robot is there, in parentheses where an operand needs them."""


def _all(parts: Iterator[str]) -> str:
    return " & ".join(f"({part})" for part in parts)


def _ring(texts: Texts) -> Iterator[tuple[str, str]]:
    """Each location and the next one; after the last the first."""
    return zip(texts, [*texts[1:], texts[0]], strict=True)


def _sequence(texts: Texts) -> str:
    """The locations are visited one after the other, the first at any time."""
    said = ""
    for each in reversed(texts):
        said = f"F ({each} & {said})" if said else f"F {each}"
    return said


def _ordered(texts: Texts) -> Iterator[str]:
    yield _sequence(texts)
    yield from (f"!{after} U {each}" for each, after in pairwise(texts))


def _patrolled(texts: Texts) -> Iterator[str]:
    yield f"G {_sequence(texts)}"
    yield from (f"!{after} U {each}" for each, after in pairwise(texts))


PUBLISHED_MOVEMENTS: Mapping[str, Callable[[Texts], str]] = {
    "visit any": lambda places: _all(f"F {each}" for each in places),
    "visit sequenced": _sequence,
    "visit ordered": lambda places: _all(_ordered(places)),
    "visit strict": lambda places: _all(
        iter([*_ordered(places), *(f"!{a} U ({a} & X (!{a} U {b}))" for a, b in pairwise(places))])
    ),
    "visit fair": lambda places: _all(
        iter([*(f"F {each}" for each in places), *(f"G ({a} -> X (!{a} W {b}))" for a, b in _ring(places))])
    ),
    "patrolling any": lambda places: _all(f"G F {each}" for each in places),
    "patrolling sequenced": lambda places: f"G {_sequence(places)}",
    "patrolling ordered": lambda places: _all(
        iter([*_patrolled(places), *(f"G ({b} -> X (!{b} U {a}))" for a, b in _ring(places))])
    ),
    "patrolling strict": lambda places: _all(
        iter(
            [
                *_patrolled(places),
                *(f"G ({b} -> X (!{b} U {a}))" for a, b in _ring(places)),
                *(f"G ({a} -> X (!{a} U {b}))" for a, b in pairwise(places)),
            ]
        )
    ),
    "patrolling fair": lambda places: _all(
        iter([*(f"G F {each}" for each in places), *(f"G ({a} -> X (!{a} W {b}))" for a, b in _ring(places))])
    ),
}
"""By pattern the formula that is published, of any number of locations."""

REACTIONS: Mapping[str, str] = {
    "instantaneous": "G ({to} -> {gives})",
    "prompt": "G ({to} -> X {gives})",
    "delayed": "G ({to} -> F {gives})",
    "bound": "G ({to} <-> {gives})",
    "bound_delay": "G ({to} <-> X {gives})",
}
"""By ``when`` of a reaction, the formula that is published."""
REACTIONS_TO_EVENTS: Mapping[str, str] = {
    "instantaneous": "G ({to} -> X {gives})",
    "delayed": "G ({to} -> X F {gives})",
    "bound": "!{gives} & G ({to} <-> X {gives})",
}
"""The same of an event and a state, where it is another: what an event gives holds of the reaction first."""
PAST, FUTURE, GLOBAL, WAIT = "!{each} U {until}", "G ({after} -> G !{each})", "G !{each}", "{each} U {until}"
"""Avoidance up to a moment, from a moment, always; and waiting: as they are published."""


def movement(kind: str, order: str, places: Texts) -> str:
    """The formula of a visit or a patrol.

    Args:
        kind: ``visit`` or ``patrolling``.
        order: In which order.
        places: The locations.

    Examples:
        >>> movement("visit", "sequenced", ["a", "b"])
        'F (a & F b)'
        >>> movement("patrolling", "any", ["a", "b"])
        '(G F a) & (G F b)'
    """
    begin = "F" if kind == "visit" else "G F"
    once: Iterator[str]
    match kind, order:
        case "visit", "strict":
            once = (f"!{a} U ({a} U (!{a} U {b}))" for a, b in pairwise(places))
            return _all(iter([*_ordered(places), *once]))
        case "patrolling", "ordered" | "strict":
            once = (_not_again(b, "U", a) for a, b in _ring(places))
            more = (_not_again(a, "U", b) for a, b in pairwise(places)) if order == "strict" else ()
            return _all(iter([*_patrolled(places), *once, *more]))
        case _, "fair":
            once = (_not_again(a, "W", b) for a, b in _ring(places))
            return _all(iter([*(f"{begin} {each}" for each in places), *once]))
    return PUBLISHED_MOVEMENTS[f"{kind} {order}"](places)


def _not_again(left: str, until: str, other: str) -> str:
    """When a location has been left it is not entered again before another one is visited."""
    return f"G ({left} & X !{left} -> X (!{left} {until} {other}))"


def entries(said: str, each: str, times: int) -> str:
    """The formula that a location is entered so often.

    Args:
        said: ``at_most``, ``at_least`` or ``exactly``.
        each: The location.
        times: How often.

    Examples:
        >>> entries("at_least", "a", 2)
        'F (a & F (!a & F (a)))'
        >>> entries("at_most", "a", 1)
        '!F (a & F (!a & F (a)))'
    """
    least, more = each, each
    for _ in range(times - 1):
        least = f"{each} & F (!{each} & F ({least}))"
    more = f"{each} & F (!{each} & F ({least}))"
    return {
        "at_most": f"!F ({more})",
        "at_least": f"F ({least})",
        "exactly": f"F ({least}) & !F ({more})",
    }[said]
