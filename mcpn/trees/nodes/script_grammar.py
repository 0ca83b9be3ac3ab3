"""The two grammars of scripts of BehaviorTree.CPP, up to 4.9 and from 4.10 on: where a script breaks them.

Nothing is evaluated, and nothing kept: data is not modelled. Up to 4.9 statements stand between ``;``,
``:=`` and ``?`` are not chained, and outside of parentheses operators of numbers, of bits and of texts do not
mix. From 4.10 on statements may follow each other without ``;``, texts stand between ``'`` alone, names are
ASCII, and a number has no sign of its own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import NamedTuple, NoReturn

MAX_NESTED = 100
"""How deep a script may be nested to be read."""
_ASSIGN = {":=", "=", "+=", "-=", "*=", "/="}
_COMPARE = {"==", "!=", "<", ">", "<=", ">="}
_BITS, _NUMBERS, _TEXTS = "operators of bits", "operators of numbers", "operators of texts"
_GROUPS = dict.fromkeys("&|^", _BITS) | dict.fromkeys("+-*/", _NUMBERS) | {"..": _TEXTS}
_PREFIXES = {"-": _NUMBERS, "~": _BITS, "!": _BITS}
_POWERS = {
    **dict.fromkeys(_ASSIGN, 2),
    "?": 4,
    "||": 6,
    "&&": 8,
    **dict.fromkeys(_COMPARE, 10),
    **dict.fromkeys("|^", 12),
    "&": 14,
    **dict.fromkeys(("+", "-", ".."), 16),
    **dict.fromkeys("*/", 18),
}
_SIGNS = re.compile(r"\.\.|&&|\|\||[=!<>:+\-*/]=|[-+*/&|^~!<>=?:();]")
_HEX = re.compile(r"0[xX]([0-9a-fA-F]+)")
_DECIMAL = re.compile(r"[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?")
_LATER_NAME = re.compile(r"[A-Za-z_@][A-Za-z0-9_]*")
_OPERAND = "expected an operand"


class BrokenAt(NamedTuple):
    """Where a script breaks its grammar.

    Args:
        column: The column in the script, from 1.
        what: What was expected, and what was found.
    """

    column: int
    what: str


class _ScriptToken(NamedTuple):
    """A part of a script: a kind (name, number, text, sign, end, wrong), what is written, and its place."""

    kind: str
    text: str
    place: int


class _BrokenError(Exception):
    def __init__(self, misread: BrokenAt) -> None:
        self.misread = misread


def misread(script: str, *, later: bool) -> BrokenAt | None:
    """The first place where a script breaks the grammar, or ``None``.

    Args:
        script: The script.
        later: By the grammar from 4.10 on.
    """
    if not script.strip(" \t\r\n"):
        return BrokenAt(1, "expected a script, found none")
    try:
        (_Later if later else _Earlier)(list(_tokens(script, later=later))).script()
    except _BrokenError as error:
        return error.misread
    return None


def _tokens(script: str, *, later: bool) -> Iterator[_ScriptToken]:
    at, end = 0, len(script)
    while at < end:
        each = script[at]
        if each in " \t\r\n":
            at += 1
            continue
        if each == "'" or (each == '"' and not later):
            token = _text(script, at, later=later)
        elif each in "0123456789":
            token = _number(script, at, later=later)
        elif (name := _name(script, at, later=later)) is not None:
            token = _ScriptToken("name", name, at)
        elif (sign := _SIGNS.match(script, at)) is not None:
            token = _ScriptToken("sign", sign[0], at)
        else:
            token = _ScriptToken("wrong", each, at)
        yield token
        at = token.place + len(token.text)
    yield _ScriptToken("end", "", end)


def _text(script: str, at: int, *, later: bool) -> _ScriptToken:
    close = script.find(script[at], at + 1)
    if close < 0:
        return _ScriptToken("wrong", script[at:], at)
    written = script[at : close + 1]
    return _ScriptToken("text" if later or written.isascii() else "wrong", written, at)


def _number(script: str, at: int, *, later: bool) -> _ScriptToken:
    found = _HEX.match(script, at) or _DECIMAL.match(script, at)
    assert found is not None  # it begins with a digit
    base, end = 16 if found.re is _HEX else 10, found.end()
    whole = base == 16 or not any(found.groups())
    if later:
        joined = base == 10 and (not whole or script.startswith("..", end))  # by ``..``
        wrong = re.compile("[A-Za-z_@]" if joined else "[A-Za-z_.]" if base == 16 else "[A-Za-z_@.]")
    else:
        wrong = re.compile("[A-Za-z_.]")
    large = (not later and int(found[0], base) >> 63 > 0) if whole else math.isinf(float(found[0]))
    if (after := wrong.match(script, end)) is not None or large:
        return _ScriptToken("wrong", script[at:end] + ("" if after is None else after[0]), at)
    return _ScriptToken("number", found[0], at)


def _name(script: str, at: int, *, later: bool) -> str | None:
    if later:
        found = _LATER_NAME.match(script, at)
        return None if found is None else found[0]
    if script[at] != "@" and not script[at].isidentifier():
        return None
    for literal in ("true", "false"):
        if script.startswith(literal, at):  # what follows is no part of it, whatever it is
            return literal
    end = at + 1
    while end < len(script) and f"a{script[end]}".isidentifier():
        end += 1
    return script[at:end]


class _ScriptParser:
    """What both grammars share: the tokens one after the other."""

    def __init__(self, tokens: list[_ScriptToken]) -> None:
        self.tokens, self.at, self.depth = tokens, 0, 0

    @property
    def next(self) -> _ScriptToken:
        return self.tokens[self.at]

    def is_sign(self, *signs: str) -> bool:
        """Whether one of some signs is next."""
        return self.next.kind == "sign" and self.next.text in signs

    def take(self) -> _ScriptToken:
        """The next token, which is then behind."""
        token = self.next
        self.at += token.kind != "end"
        return token

    def expect(self, sign: str) -> None:
        """Takes a sign that must be next."""
        if not self.is_sign(sign):
            self.broken(f"expected {sign!r}")
        self.take()

    def broken(self, expected: str) -> NoReturn:
        """The next token is not what the grammar has there."""
        kind, text, place = self.next
        found = "found the end" if kind == "end" else f"found {text[:40]!r}"
        raise _BrokenError(BrokenAt(place + 1, f"{expected}, {found}"))

    def deeper(self) -> None:
        """One level further in."""
        self.depth += 1
        if self.depth > MAX_NESTED:
            self.broken(f"expected at most {MAX_NESTED} levels")


class _Earlier(_ScriptParser):
    """The grammar up to 4.9, by descent: each level is one loop."""

    def script(self) -> None:
        """Statements with ``;`` between them."""
        self.expression()
        while self.next.kind != "end":
            self.expect(";")
            self.expression()

    def expression(self) -> None:
        """An assignment, or less; operators outside of its parentheses are of one group."""
        self.deeper()
        group = self.choice("")
        if self.is_sign(*_ASSIGN):
            self.take()
            self.choice(group)
            if self.is_sign(*_ASSIGN):
                self.broken("expected no second assignment")
        self.depth -= 1

    def choice(self, group: str) -> str:
        group = self.comparisons(group)
        if self.is_sign("?"):
            self.take()
            self.expression()
            self.expect(":")
            group = self.comparisons(group)
            if self.is_sign("?"):
                self.broken("expected no second '?' without parentheses")
        return group

    def comparisons(self, group: str) -> str:
        group = self.operand(group)
        while self.is_sign(*_POWERS) and not self.is_sign("?", *_ASSIGN):
            group = self.grouped(group, _GROUPS)
            self.take()
            group = self.operand(group)
        return group

    def grouped(self, group: str, groups: dict[str, str]) -> str:
        """The group of operators, with that which is next."""
        own = groups.get(self.next.text, "")
        if group and own and own != group:
            self.broken(f"expected no {own} beside {group} without parentheses")
        return group or own

    def operand(self, group: str) -> str:
        while self.is_sign(*_PREFIXES):
            group = self.grouped(group, _PREFIXES)
            self.take()
        after = self.tokens[min(self.at + 1, len(self.tokens) - 1)]
        if self.is_sign("+") and after.kind == "number" and after.place == self.next.place + 1:
            if after.text[:2].lower() == "0x":
                self.broken(_OPERAND)
            self.take()
        if self.is_sign("("):
            self.take()
            self.expression()
            self.expect(")")
        elif self.next.kind in ("name", "number", "text"):
            self.take()
        else:
            self.broken(_OPERAND)
        return group


class _Later(_ScriptParser):
    """The grammar from 4.10 on, by powers of operators."""

    def script(self) -> None:
        """Statements, each with any number of ``;`` behind it."""
        while self.next.kind != "end":
            self.expression(0)
            while self.is_sign(";"):
                self.take()

    def expression(self, least: int) -> None:
        """An expression of operators that bind as much as a power, or more."""
        self.deeper()
        self.operand()
        while self.is_sign(*_POWERS) and _POWERS[self.next.text] >= least:
            sign = self.take().text
            if sign in _ASSIGN:
                self.expression(0)
                break
            if sign == "?":
                self.expression(0)
                self.expect(":")
                self.expression(_POWERS[sign])
                break
            self.expression(_POWERS[sign] + 1)
        self.depth -= 1

    def operand(self) -> None:
        while self.is_sign(*_PREFIXES):
            self.take()
        if self.is_sign("("):
            self.take()
            self.expression(0)
            self.expect(")")
        elif self.next.kind in ("name", "number", "text"):
            self.take()
        else:
            self.broken(_OPERAND)
