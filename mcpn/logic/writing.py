"""Formulas as text, which :func:`mcpn.logic.syntax.parse` reads."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable

from mcpn.logic.formulas import EG, EU, EX
from mcpn.logic.ltl.formulas import Happens, Next, Release, SomePath, Until, normal
from mcpn.logic.syntax import BINDING, PLAIN, RESERVED, TIGHT
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.goal import (
    And,
    AtMost,
    Fires,
    Formula,
    Not,
    Or,
)

_ON_PATHS = {EX: ("EX", "AX"), EG: ("EG", "AF"), EU: ("EF", "AG")}
"""How an operator with one operand is written, and its negation."""


def show(formula: Formula, names: Names, around: int = 0) -> str:
    """Writes a formula so that :func:`parse` reads it.

    Args:
        formula: The formula.
        names: Know which words about the mission people have used.
        around: How tight the operator around it binds.

    Examples:
        >>> from mcpn.testing.nets import philosophers
        >>> names = Names(philosophers(2))
        >>> from mcpn.logic.syntax import parse
        >>> show(parse("!EF (deadlock and think1)", names), names)
        'AG !(deadlock & think1)'
    """

    def tight(operator: str, operand: Formula) -> str:
        return operator + show(operand, names, TIGHT + 1)

    if word := _word(formula, names):
        return word
    match formula:
        case And(operands) | Or(operands):
            operator = "&" if isinstance(formula, And) else "|"
            strength = BINDING[operator]
            text = f" {operator} ".join(show(operand, names, strength + 1) for operand in operands)
            return f"({text})" if strength < around else text
        case EX() | EG() | EU((And(()), _)):
            return tight(f"{_ON_PATHS[type(formula)][0]} ", formula.operands[-1])
        case Not((EX() | EG() | EU((And(()), _)) as path,)):
            return tight(f"{_ON_PATHS[type(path)][1]} ", ~path.operands[-1])
        case Not((SomePath((path,)),)):
            return tight("A ", normal(path, wanted=False))
        case Not((operand,)):
            return tight("!", operand)
        case SomePath((path,)):
            return tight("E ", path)
        case Until((And(()), operand)):
            return tight("F ", operand)
        case Release((Or(()), operand)):
            return tight("G ", operand)
        case Next((operand,)):
            return tight("X ", operand)
        case Until((left, right)) | Release((left, right)):
            sign = "U" if isinstance(formula, Until) else "R"
            text = f"{show(left, names, TIGHT)} {sign} {show(right, names, TIGHT)}"
            return f"({text})" if around > BINDING["&"] else text
        case Happens(transitions):
            return f"fires({', '.join(_quoted(names.net.transitions[t].name) for t in transitions)})"
        case EU((left, right)):
            return f"E[{show(left, names)} U {show(right, names)}]"
        case AtMost(((place, -1),), -1):
            return _quoted(names.net.places[place].name)
        case AtMost(weights, bound):
            small = _sum(((place, weight) for place, weight in weights if weight > 0), -bound, names)
            large = _sum(((place, -weight) for place, weight in weights if weight < 0), bound, names)
            return f"({small} <= {large})" if around > TIGHT else f"{small} <= {large}"
        case Fires(transitions):
            return f"enabled({', '.join(_quoted(names.net.transitions[t].name) for t in transitions)})"
    raise TypeError(f"no formula: {formula!r}")


def _sum(places: Iterable[tuple[int, int]], constant: int, names: Names) -> str:
    """Tokens of places, each as often as it counts, and what a constant adds to them."""
    terms = [_quoted(names.net.places[p].name) for p, weight in places for _ in range(weight)]
    if len(terms) > 1:
        terms = [f"tokens({', '.join(terms)})"]
    return " + ".join([*terms, str(constant)] if constant > 0 else terms or ["0"])


def _word(formula: Formula, names: Names) -> str:
    """The word for a formula or its negation: a constant, or looked up in ``names``; else empty."""
    for word, meaning in (*PLAIN.items(), ("false", Fires(()))):
        if formula == meaning:
            return word
    if not isinstance(formula.operands[0] if isinstance(formula, Not) else formula, AtMost | Fires | Happens):
        return ""
    for sign, meant in (("", formula), ("!", ~formula)):
        if meant in names.said:
            kind, *about = names.said[meant]
            argument = f"({_quoted(about[0])})" if about else ""
            return sign + kind + argument + "".join(f"={_quoted(value)}" for value in about[1:])
    return ""


def _quoted(name: str) -> str:
    plain = re.fullmatch(r"[A-Za-z_][A-Za-z0-9_.]*", name) and name not in RESERVED
    return name if plain else json.dumps(name, ensure_ascii=False)
