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
from collections.abc import Iterable
from difflib import get_close_matches
from functools import cache, partial
from typing import TypeAlias, cast

from lark import Lark, Token, Transformer, UnexpectedCharacters, UnexpectedInput, UnexpectedToken, v_args

from mcpn.check.logic.formulas import (
    EG,
    EU,
    EX,
    WORDS,
    And,
    Compare,
    Const,
    Deadlock,
    Derived,
    Enabled,
    Formula,
    Not,
    Or,
    Relation,
    Stable,
    Sum,
    Word,
    temporal,
    walk,
)
from mcpn.errors import InputError

MAX_DEPTH = 200
MAX_LENGTH = 1_000_000
MAX_DIGITS = 18

_UNARY = ("EX", "AX", "EF", "AF", "EG", "AG")
_PLAIN: dict[str, Formula] = {
    "true": Const(True),
    "false": Const(False),
    "deadlock": Deadlock(),
    "stable": Stable(),
}

_GRAMMAR = rf"""
?start: iff
?iff: iff _IFF implies -> iff
    | implies
?implies: disjunction _IMPLIES implies -> implies
        | disjunction
?disjunction: conjunction (_OR conjunction)+ -> disjunction
            | conjunction
?conjunction: unary (_AND unary)+ -> conjunction
            | unary
?unary: _NOT unary -> negation
      | UNARY unary -> temporal
      | _EXISTS iff _UNTIL iff "]" -> exists_until
      | _ALWAYS iff _UNTIL iff "]" -> always_until
      | "(" iff ")"
      | atom
?atom: PLAIN -> plain
     | ENDING -> ending
     | _ENABLED name ("," name)* ")" -> enabled
     | WORD name ")" [EQUAL name] -> word
     | sum RELATION sum -> compare
     | sum EQUAL sum -> compare
     | name -> bare
sum: term ("+" term)*
term: INTEGER -> integer
    | _TOKENS name ("," name)* ")" -> tokens
    | name -> place
name: NAME | QUOTED

_IFF: "<->"
_IMPLIES: "->"
_OR.2: "|" | /or\b/
_AND.2: "&" | /and\b/
_NOT.2: "!" | /not\b/
_UNTIL.2: /U\b/
_EXISTS.2: /E\s*\[/
_ALWAYS.2: /A\s*\[/
_ENABLED.2: /enabled\s*\(/
_TOKENS.2: /tokens\s*\(/
UNARY.2: /({"|".join(_UNARY)})(?=[\s(!"]|$)/
PLAIN.2: /(true|false|deadlock|stable)\b(?![.])/
ENDING.2: /(success|failure)\b(?![.])/
WORD.2: /({"|".join(WORDS)})\s*\(/
RELATION: "<=" | ">=" | "!=" | "<" | ">"
EQUAL: "="
INTEGER: /[0-9]+/
NAME: /[A-Za-z_][A-Za-z0-9_.]*/
QUOTED: /"([^"\\]|\\.)*"/
%ignore /\s+/
"""

_IN_WORDS = {
    "_UNTIL": "U",
    "INTEGER": "a number",
    "NAME": "a name",
    "$END": "the end",
    "LPAR": "'('",
    "RPAR": "')'",
    "RSQB": "']'",
    "COMMA": "','",
    "PLUS": "'+'",
    "EQUAL": "'='",
    "RELATION": "a comparison",
    "_AND": "an operator",
}
_OPERAND = {"NAME", "INTEGER", "UNARY", "_NOT"}
_KEYWORDS = [*_UNARY, *_PLAIN, *WORDS, "success", "failure", "enabled", "tokens", "not", "and", "or"]
_RESERVED = {*_UNARY, *_PLAIN, "success", "failure", "not", "and", "or", "U"}


Located: TypeAlias = tuple[Sum, int | None]
"""A sum and the column of its first name."""


@v_args(inline=True)
class _Build(Transformer[Token, Formula]):
    """Makes formulas while the parser runs, so that depth costs no recursion."""

    temporal = staticmethod(temporal)
    negation = Not
    exists_until = EU
    iff = partial(temporal, "<->")
    implies = partial(temporal, "->")
    always_until = partial(temporal, "AU")

    def disjunction(self, *operands: Formula) -> Formula:
        return Or(operands)

    def conjunction(self, *operands: Formula) -> Formula:
        return And(operands)

    def plain(self, token: Token) -> Formula:
        return _PLAIN[token]

    def ending(self, token: Token) -> Formula:
        return Word(str(token), column=token.column)

    def enabled(self, *names: Token) -> Formula:
        return Enabled(tuple(map(str, names)), names[0].column)

    def word(self, kind: Token, argument: Token, _: Token | None, value: Token | None) -> Formula:
        word = kind[:-1].rstrip()
        return Word(word, str(argument), None if value is None else str(value), argument.column)

    def name(self, token: Token) -> Token:
        if token.type != "QUOTED":
            return token
        try:
            return token.update(value=json.loads(token))
        except ValueError:
            message = f"formula, column {token.column}: {token} is no quoted name"
            raise InputError.at(None, message) from None

    def integer(self, token: Token) -> tuple[int, tuple[Token, ...]]:
        if len(token) > MAX_DIGITS:
            message = f"formula, column {token.column}: a number of more than {MAX_DIGITS} digits"
            raise InputError.at(None, f"{message}: the limit was hit")
        return int(token), ()

    def tokens(self, *names: Token) -> tuple[int, tuple[Token, ...]]:
        return 0, names

    def place(self, name: Token) -> tuple[int, tuple[Token, ...]]:
        return 0, (name,)

    def sum(self, *terms: tuple[int, tuple[Token, ...]]) -> Located:
        names = [name for _, inside in terms for name in inside]
        total = Sum(sum(number for number, _ in terms), tuple(map(str, names)))
        return total, names[0].column if names else None

    def compare(self, left: Located, relation: Token, right: Located) -> Formula:
        column = left[1] or right[1] or relation.column
        return Compare(left[0], cast(Relation, str(relation)), right[0], column)

    def bare(self, name: Token) -> Formula:
        return Compare(Sum(0, (str(name),)), ">=", Sum(1), name.column)


@cache
def _parser() -> Lark:
    return Lark(_GRAMMAR, parser="lalr", transformer=_Build(), maybe_placeholders=True)


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
    try:
        formula: Formula = _parser().parse(text)  # type: ignore[assignment]
    except UnexpectedInput as error:
        raise _syntax_error(text, error) from None
    if any(depth > MAX_DEPTH for _, depth in walk(formula)):
        raise InputError.at(None, f"formula more than {MAX_DEPTH} operators deep: the limit was hit")
    return formula


def _syntax_error(text: str, error: UnexpectedInput) -> InputError:
    if isinstance(error, UnexpectedToken):
        ended = error.token.type == "$END"
        found, expected = "the end" if ended else repr(str(error.token)), error.accepts or error.expected
        at = len(text.rstrip()) if ended else error.token.start_pos or 0
    else:
        assert isinstance(error, UnexpectedCharacters)
        at, expected = error.pos_in_stream or 0, error.allowed
        word = re.match(r"[\w.]+|.", text[at:])
        found = repr(word.group() if word else "")
    line = text.count("\n", 0, at) + 1
    begin = text.rfind("\n", 0, at) + 1
    shown = text[begin:].split("\n", 1)[0]
    where = f"column {at - begin + 1}" if line == 1 else f"line {line}, column {at - begin + 1}"
    message = f"formula, {where}: found {found}, expected {_expectation(expected)}{_hint(text, at)}"
    return InputError.at(None, f"{message}\n  {shown}\n  {' ' * (at - begin)}^")


def _expectation(terminals: Iterable[str]) -> str:
    names = set(terminals)
    if names >= _OPERAND:
        return "a formula"
    if {"NAME", "INTEGER"} <= names:
        return "a sum of tokens"
    told = [words for name, words in _IN_WORDS.items() if name in names]
    return " or ".join(told) if len(told) < 3 else ", ".join(told[:-1]) + " or " + told[-1]


def _hint(text: str, at: int) -> str:
    """What the word here, or the one before it, may have been meant to be."""
    for word in (re.match(r"\w+", text[at:]), re.search(r"\w+(?=\s*$)", text[:at])):
        near = get_close_matches(word.group(), _KEYWORDS, n=1) if word else []
        if word and near and word.group() not in _KEYWORDS:
            return f"; did you mean {near[0]}?"
    return ""


# --- printing ------------------------------------------------------------------------------------------

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
            return next(text for text, plain in _PLAIN.items() if plain == formula)
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
