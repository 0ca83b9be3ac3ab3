r"""The formula language: text to formulas and back.

>>> show(parse("AG (oos(GPS_sensor) -> E [!failure U success | tokens(p, q) <= 1])"))
'AG (oos(GPS_sensor) -> E[!failure U success | tokens(p, q) <= 1])'

Connectives, loosest first: ``<->``, ``->``, ``|`` or ``or``, ``&`` or ``and``, then ``!`` or ``not`` and the
temporal operators ``EX AX EF AF EG AG`` before their operand, ``E[f U g]`` and ``A[f U g]``. Atoms:
``true``, ``false``, ``deadlock``, ``stable``, sums of tokens compared (``tokens(p, q) + r <= 1``), a place
alone (it is marked), ``enabled(t, u)``, and the mission's words
(:data:`mcpn.check.logic.formulas.WORDS`). Names that hold anything but
letters, digits, ``_`` and ``.`` stand in double quotes.
"""

from __future__ import annotations

import json
import re

from mcpn.check.logic.formulas import (
    EG,
    EU,
    EX,
    And,
    Compare,
    Const,
    Deadlock,
    Derived,
    Enabled,
    Formula,
    Not,
    Or,
    Stable,
    Sum,
    Word,
    walk,
)
from mcpn.check.logic.parser import PLAIN, UNARY, Parser
from mcpn.errors import InputError

MAX_DEPTH = 200
MAX_LENGTH = 1_000_000


def parse(text: str) -> Formula:
    """Reads a formula.

    Args:
        text: For example ``AG EF (success | failure)``.

    Returns:
        The formula; names are not looked up yet (see :func:`mcpn.check.logic.resolve.resolve`).

    Raises:
        InputError: The text is no formula; the message has the column, what was found and what was expected.
    """
    if len(text) > MAX_LENGTH:
        raise InputError.at(None, f"formula of more than {MAX_LENGTH} characters: the limit was hit")
    formula = Parser(text).formula()
    if any(around > MAX_DEPTH for _, around in walk(formula)):
        raise InputError.at(None, f"formula more than {MAX_DEPTH} operators deep: the limit was hit")
    return formula


# --- printing ------------------------------------------------------------------------------------------

_RESERVED = {*UNARY, *PLAIN, "success", "failure", "not", "and", "or", "U"}
_IFF, _IMPLIES, _OR, _AND, _ATOM, _TIGHT = range(6)


def show(formula: Formula) -> str:
    """Writes a formula so that :func:`parse` reads the same one.

    Args:
        formula: As written, not of the core.
    """
    return _show(formula, _IFF)


def _show(formula: Formula, around: int) -> str:
    def bind(strength: int, text: str) -> str:
        return f"({text})" if strength < around else text

    match formula:
        case Const() | Deadlock() | Stable():
            return next(text for text, plain in PLAIN.items() if plain == formula)
        case Derived("<->", (a, b)):
            return bind(_IFF, f"{_show(a, _IFF)} <-> {_show(b, _IMPLIES)}")
        case Derived("->", (a, b)):
            return bind(_IMPLIES, f"{_show(a, _OR)} -> {_show(b, _IMPLIES)}")
        case And(operands) | Or(operands) if len(operands) < 2:
            return _show(operands[0], around) if operands else _show(Const(isinstance(formula, And)), around)
        case Or(operands):
            return bind(_OR, " | ".join(_show(o, _AND) for o in operands))
        case And(operands):
            return bind(_AND, " & ".join(_show(o, _ATOM) for o in operands))
        case Not(a):
            return f"!{_show(a, _TIGHT)}"
        case EU(a, b) | Derived("AU", (a, b)):
            return f"{'E' if isinstance(formula, EU) else 'A'}[{_show(a, _IFF)} U {_show(b, _IFF)}]"
        case EX(a) | EG(a):
            return f"{type(formula).__name__} {_show(a, _TIGHT)}"
        case Derived(operator, (a,)):
            return f"{operator} {_show(a, _TIGHT)}"
        case Compare(Sum(0, (place,)), ">=", Sum(1, ())):
            return _name(place)
        case Compare(left, relation, right):
            return bind(_ATOM, f"{_sum(left)} {relation} {_sum(right)}")
        case Enabled(()):
            return "false"
        case Enabled(names):
            return f"enabled({', '.join(map(_name, names))})"
        case Word(kind, None, _):
            return kind
        case Word(kind, str(argument), value):
            return f"{kind}({_name(argument)})" + (f"={_name(value)}" if value is not None else "")
    raise TypeError(f"a formula of the core has no text: {formula!r}")


def _sum(total: Sum) -> str:
    if not total.places:
        return str(total.constant)
    names = ", ".join(map(_name, total.places))
    places = names if len(total.places) == 1 else f"tokens({names})"
    return f"{places} + {total.constant}" if total.constant else places


def _name(name: str) -> str:
    plain = re.fullmatch(r"[A-Za-z_][A-Za-z0-9_.]*", name) and name not in _RESERVED
    return name if plain else json.dumps(name, ensure_ascii=False)
