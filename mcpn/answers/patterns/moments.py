"""Formulas of patterns in which some letters speak of events.

A run is a sequence of moments: a state, the event that leaves it, the next state, and so on. A pattern speaks
of this sequence: what comes before an event is the state that it leaves, what comes after it begins with the
next state, the reaction. Formulas are evaluated at states, and ``happens(e)`` is true of the state that ``e``
leaves. So a formula on moments is translated into two on states: what it says at the state, and what it says
at the event that leaves it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TypeAlias

from mcpn.records import record

At: TypeAlias = tuple[bool | None, bool | None]
"""What a letter is at states, and at events: true, false, or what is written for it (``None``)."""
OF_STATES: At = (None, False)
OF_EVENTS: At = (False, None)
LASTING: At = (None, None)
"""A formula on states that goes on while the event that leaves a state happens."""
EVERY_EVENT: At = (True, None)
"""A formula on events that must be true of each of them."""


@record(frozen=True)
class _OfMoments:
    """A formula: a letter, ``true``, ``false``, or an operator with its operands."""

    word: str
    operands: tuple[_OfMoments, ...] = ()


_TRUE, _FALSE = _OfMoments("true"), _OfMoments("false")
_TOKEN = re.compile(r"->|<->|[!&|()]|\w+")
_BINARY = ({"<->"}, {"->"}, {"|"}, {"&"}, {"U", "W"})
"""Operators by how closely they bind, the loosest first; those of one letter stand in parentheses."""


def on_states(formula: str, letters: Mapping[str, At]) -> str:
    """A formula on moments as one on states that says the same at the first state.

    >>> on_states("G (p -> F s)", {"p": OF_EVENTS, "s": OF_STATES})
    'G (p -> X F s)'
    >>> on_states("!p U r", {"p": OF_STATES, "r": OF_EVENTS})
    '!p U (r & !p)'

    Args:
        formula: Of letters, with ``! & | -> <-> X F G U W``.
        letters: What each letter is at states and at events.
    """
    return _shown(_Translation(letters).of(_read(formula))[0])


class _Translation:
    """Translates formulas on moments: what they say at a state, and at the event that leaves it."""

    def __init__(self, letters: Mapping[str, At]) -> None:
        self._letters = letters
        self._known: dict[_OfMoments, tuple[_OfMoments, _OfMoments]] = {}

    def of(self, node: _OfMoments) -> tuple[_OfMoments, _OfMoments]:
        if node not in self._known:
            self._known[node] = self._made(node)
        return self._known[node]

    def _made(self, node: _OfMoments) -> tuple[_OfMoments, _OfMoments]:
        if node in (_TRUE, _FALSE):
            return node, node
        if not node.operands:
            first, second = (
                node if value is None else (_TRUE if value else _FALSE) for value in self._letters[node.word]
            )
            return first, second
        at_state, at_event = zip(*map(self.of, node.operands), strict=True)
        if node.word == "X":
            return at_event[0], _next(at_state[0])
        if node.word not in "UW":
            return _joined(node.word, at_state), _joined(node.word, at_event)
        (left, right), (left_then, right_then) = at_state, at_event
        both, ending = _joined("&", (left, left_then)), _joined("&", (right_then, left))
        found = _until(node.word, both, _joined("|", (right, ending)))
        if left == _TRUE and right == _FALSE:  # the state changes nothing
            return found, found
        return found, _joined("|", (right_then, _joined("&", (left_then, _next(found)))))


def _next(operand: _OfMoments) -> _OfMoments:
    return operand if operand in (_TRUE, _FALSE) else _OfMoments("X", (operand,))


def _until(word: str, left: _OfMoments, right: _OfMoments) -> _OfMoments:
    if right in (_TRUE, _FALSE) and (right == _TRUE or word == "U" or left == _TRUE):
        return _TRUE if right == _TRUE or word == "W" else _FALSE
    if left == _FALSE:
        return right
    if left == _TRUE and word == "W":
        return _TRUE
    return _OfMoments(word, (left, right))


def _joined(word: str, operands: tuple[_OfMoments, ...]) -> _OfMoments:
    """An operator of propositional logic, without what ``true`` and ``false`` decide."""
    match word, operands:
        case "!", (inside,):
            if inside in (_TRUE, _FALSE):
                return _FALSE if inside == _TRUE else _TRUE
            return inside.operands[0] if inside.word == "!" else _OfMoments("!", operands)
        case "->", (left, right):
            if left == _TRUE or right == _FALSE:
                return right if left == _TRUE else _joined("!", (left,))
            return _TRUE if left == _FALSE or right == _TRUE else _OfMoments("->", operands)
        case "<->", (left, right):
            for one, other in ((left, right), (right, left)):
                if one in (_TRUE, _FALSE):
                    return other if one == _TRUE else _joined("!", (other,))
            return _OfMoments("<->", operands)
    neutral, ends = (_TRUE, _FALSE) if word == "&" else (_FALSE, _TRUE)
    kept = tuple(dict.fromkeys(each for each in operands if each != neutral))
    if ends in kept:
        return ends
    return _OfMoments(word, kept) if len(kept) > 1 else (kept or (neutral,))[0]


def _read(text: str) -> _OfMoments:
    tokens = _TOKEN.findall(text)[::-1]

    def binary(level: int) -> _OfMoments:
        if level == len(_BINARY):
            return unary()
        left = binary(level + 1)
        if not tokens or tokens[-1] not in _BINARY[level]:
            return left
        word, associates = tokens.pop(), level in (2, 3)
        parts = [left, binary(level + 1 if associates else level)]
        while associates and tokens and tokens[-1] in _BINARY[level]:
            tokens.pop()
            parts.append(binary(level + 1))
        return _OfMoments(word, tuple(parts))

    def unary() -> _OfMoments:
        word = tokens.pop()
        if word == "(":
            inside = binary(0)
            assert tokens.pop() == ")", f"{text}: expected ')'"
            return inside
        if word == "F":
            return _OfMoments("U", (_TRUE, unary()))
        if word == "G":
            return _OfMoments("W", (unary(), _FALSE))
        return _OfMoments(word, (unary(),)) if word in "!X" else _OfMoments(word)

    found = binary(0)
    assert not tokens, f"{text}: not read to its end"
    return found


def _shown(node: _OfMoments, inside: bool = False) -> str:
    match node.word, node.operands:
        case word, ():
            return word
        case ("!" | "X") as word, (operand,):
            return f"{word}{'' if word == '!' else ' '}{_shown(operand, True)}"
        case "U", (left, operand) if left == _TRUE:
            return f"F {_shown(operand, True)}"
        case "W", (operand, right) if right == _FALSE:
            return f"G {_shown(operand, True)}"
    said = f" {node.word} ".join(_shown(each, True) for each in node.operands)
    return f"({said})" if inside else said
