"""The patterns of robotic missions: the published formulas, and those used where locations are objectives.

Source: Menghi, Tsigkanos, Pelliccione, Ghezzi, Berger, *Specification patterns for robotic missions*, IEEE
TSE 2019, and its catalogue: 22 patterns. Their locations are objectives here. In the traces of the catalogue
a robot is at a location for one state; an objective runs for many. So what says that a location is not
visited *again* speaks here of entries: from the end of one stay to the beginning of the next.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise

Texts = Sequence[str]
"""For each location the formula that the robot is there, in parentheses where an operand needs them."""


def _all(parts: Iterator[str]) -> str:
    return " & ".join(f"({part})" for part in parts)


def _ring(of: Texts) -> Iterator[tuple[str, str]]:
    """Each location and the next one; after the last the first."""
    return zip(of, [*of[1:], of[0]], strict=True)


def _sequence(of: Texts) -> str:
    """The locations are visited one after the other, the first at any time."""
    said = ""
    for each in reversed(of):
        said = f"F ({each} & {said})" if said else f"F {each}"
    return said


def _ordered(of: Texts) -> Iterator[str]:
    yield _sequence(of)
    yield from (f"!{after} U {each}" for each, after in pairwise(of))


def _patrolled(of: Texts) -> Iterator[str]:
    yield f"G {_sequence(of)}"
    yield from (f"!{after} U {each}" for each, after in pairwise(of))


def _nested(each: str, times: int) -> str:
    """At least so many states of the path are at the location."""
    return f"F ({each} & X {_nested(each, times - 1)})" if times > 1 else f"F {each}"


def _exact(each: str, times: int) -> str:
    """Exactly so many states of the path are at the location."""
    inside = f"X G !{each}"
    for _ in range(times):
        inside = f"X (!{each} U ({each} & {inside}))"
    return inside.removeprefix("X ")


PUBLISHED_MOVEMENTS: Mapping[str, Callable[[Texts], str]] = {
    "visit any": lambda of: _all(f"F {each}" for each in of),
    "visit sequenced": _sequence,
    "visit ordered": lambda of: _all(_ordered(of)),
    "visit strict": lambda of: _all(
        iter([*_ordered(of), *(f"!{a} U ({a} & X (!{a} U {b}))" for a, b in pairwise(of))])
    ),
    "visit fair": lambda of: _all(
        iter([*(f"F {each}" for each in of), *(f"G ({a} -> X (!{a} W {b}))" for a, b in _ring(of))])
    ),
    "patrolling any": lambda of: _all(f"G F {each}" for each in of),
    "patrolling sequenced": lambda of: f"G {_sequence(of)}",
    "patrolling ordered": lambda of: _all(
        iter([*_patrolled(of), *(f"G ({b} -> X (!{b} U {a}))" for a, b in _ring(of))])
    ),
    "patrolling strict": lambda of: _all(
        iter(
            [
                *_patrolled(of),
                *(f"G ({b} -> X (!{b} U {a}))" for a, b in _ring(of)),
                *(f"G ({a} -> X (!{a} U {b}))" for a, b in pairwise(of)),
            ]
        )
    ),
    "patrolling fair": lambda of: _all(
        iter([*(f"G F {each}" for each in of), *(f"G ({a} -> X (!{a} W {b}))" for a, b in _ring(of))])
    ),
}
"""By pattern the formula that is published, of any number of locations."""

PUBLISHED_COUNTS: Mapping[str, Callable[[str, int], str]] = {
    "at_most": lambda each, times: f"!{_nested(each, times)}",  # which says: less often
    "at_least": _nested,
    "exactly": _exact,
}
"""By what is said of a number of visits, the formula that is published."""

REACTIONS: Mapping[str, str] = {
    "instantaneous": "G ({to} -> {gives})",
    "prompt": "G ({to} -> X {gives})",
    "delayed": "G ({to} -> F {gives})",
    "bound": "G ({to} <-> {gives})",
    "bound_delay": "G ({to} <-> X {gives})",
}
"""By ``when`` of a reaction, the formula that is published."""
PAST, FUTURE, GLOBAL, WAIT = "!{each} U {until}", "G ({after} -> G !{each})", "G !{each}", "{each} U {until}"
"""Avoidance up to a moment, from a moment, always; and waiting: as they are published."""
AFTER_EVENT = "G ({after} -> X G !{each})"
"""Avoidance from the reaction to an event on."""


def movement(kind: str, order: str, of: Texts) -> str:
    """The formula of a visit or a patrol.

    Args:
        kind: ``visit`` or ``patrolling``.
        order: In which order.
        of: The locations.
    """
    begin = "F" if kind == "visit" else "G F"
    once: Iterator[str]
    match kind, order:
        case "visit", "strict":
            once = (f"!{a} U ({a} U (!{a} U {b}))" for a, b in pairwise(of))
            return _all(iter([*_ordered(of), *once]))
        case "patrolling", "ordered" | "strict":
            once = (_not_again(b, "U", a) for a, b in _ring(of))
            more = (_not_again(a, "U", b) for a, b in pairwise(of)) if order == "strict" else ()
            return _all(iter([*_patrolled(of), *once, *more]))
        case _, "fair":
            once = (_not_again(a, "W", b) for a, b in _ring(of))
            return _all(iter([*(f"{begin} {each}" for each in of), *once]))
    return PUBLISHED_MOVEMENTS[f"{kind} {order}"](of)


def _not_again(left: str, until: str, other: str) -> str:
    """When a location has been left it is not entered again before another one is visited."""
    return f"G ({left} & X !{left} -> X (!{left} {until} {other}))"


def entries(said: str, each: str, times: int) -> str:
    """The formula that a location is entered so often.

    Args:
        said: ``at_most``, ``at_least`` or ``exactly``.
        each: The location.
        times: How often.
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
