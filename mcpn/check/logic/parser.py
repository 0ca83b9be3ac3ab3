"""The parser of the formula language: operator precedence with a stack of its own.

Parentheses and operators of any depth cost no recursion. The lexer is contextual: where an operand is
expected, ``U`` and ``and`` are names. A parser generated from a grammar takes longer to load than most
formulas take to answer.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from difflib import get_close_matches
from typing import NoReturn, TypeAlias, cast

from mcpn.check.logic.formulas import (
    EU,
    WORDS,
    And,
    Compare,
    Const,
    Deadlock,
    Enabled,
    Formula,
    Not,
    Or,
    Relation,
    Stable,
    Sum,
    Word,
    temporal,
)
from mcpn.errors import InputError

MAX_DIGITS = 18

UNARY = ("EX", "AX", "EF", "AF", "EG", "AG")
PLAIN: dict[str, Formula] = {
    "true": Const(True),
    "false": Const(False),
    "deadlock": Deadlock(),
    "stable": Stable(),
}
_KEYWORDS = [*UNARY, *PLAIN, *WORDS, "success", "failure", "enabled", "tokens", "not", "and", "or"]

_NAME = r'(?P<name>[A-Za-z_][A-Za-z0-9_.]*)|(?P<quoted>"(?:[^"\\]|\\.)*")'
_TERM = rf"(?P<tokens>tokens\s*\()|(?P<integer>[0-9]+)|{_NAME}"
_OPERAND = re.compile(
    r"(?P<not>!|not\b)|(?P<exists>E\s*\[)|(?P<always>A\s*\[)|(?P<enabled>enabled\s*\()"
    rf'|(?P<unary>(?:{"|".join(UNARY)})(?=[\s(!"]|$))|(?P<plain>(?:{"|".join(PLAIN)})\b(?![.]))'
    rf"|(?P<ending>(?:success|failure)\b(?![.]))|(?P<word>(?:{'|'.join(WORDS)})\s*\()|(?P<open>\()|{_TERM}"
)
_AFTER = re.compile(
    r"(?P<iff><->)|(?P<implies>->)|(?P<or>\||or\b)|(?P<and>&|and\b)|(?P<until>U\b)|(?P<relation><=|>=|!=|<|>)"
    r"|(?P<equal>=)|(?P<plus>\+)|(?P<comma>,)|(?P<close>\))|(?P<bracket>\])"
)
_NAMES, _TERMS, _SPACE = re.compile(_NAME), re.compile(_TERM), re.compile(r"\s*")
_ANY = re.compile(r'"(?:[^"\\]|\\.)*"|<->|->|<=|>=|!=|[\w.]+|.', re.DOTALL)

_IN_WORDS = {
    "until": "U",
    "end": "the end",
    "close": "')'",
    "bracket": "']'",
    "comma": "','",
    "plus": "'+'",
    "equal": "'='",
    "relation": "a comparison",
    "and": "an operator",
}
_BINDING = {"iff": 0, "implies": 1, "or": 2, "and": 3}
_GROUP = {
    "open": "close",
    "exists": "until",
    "always": "until",
    "exists_until": "bracket",
    "always_until": "bracket",
}
"""What each opening is followed by, behind its formula."""

Token: TypeAlias = tuple[str, str, int]
"""Kind, text, and where it begins."""


class Parser:
    """Reads one formula.

    Args:
        text: The formula.
    """

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._operands: list[Formula] = []
        self._operators: list[str] = []
        self._groups: list[str] = []
        self._longer: tuple[str, ...] = ()  # what the last atom could have gone on with

    def formula(self) -> Formula:
        """The formula of the whole text.

        Raises:
            InputError: The text is none.
        """
        while True:
            self._operand()
            while True:
                self._apply_unary()
                closing = _GROUP[self._groups[-1]] if self._groups else "end"
                kind, _, _ = self._take(_AFTER, (*_BINDING, closing))
                if kind in _BINDING:
                    self._reduce(_BINDING[kind] + (kind != "iff"))
                    self._operators.append(kind)
                    break
                self._reduce(0)
                if kind == "end":
                    return self._operands.pop()
                group = self._groups.pop()
                self._operators.pop()
                self._longer = ()
                if kind == "until":
                    self._open(f"{group}_until")
                    break
                if kind == "bracket":
                    right, left = self._operands.pop(), self._operands.pop()
                    until = EU(left, right) if group == "exists_until" else temporal("AU", left, right)
                    self._operands.append(until)

    # --- operators ---

    def _open(self, group: str) -> None:
        self._groups.append(group)
        self._operators.append(group)

    def _apply_unary(self) -> None:
        operators, operands = self._operators, self._operands
        while operators and operators[-1] in ("not", *UNARY):
            operator, operand = operators.pop(), operands.pop()
            operands.append(Not(operand) if operator == "not" else temporal(operator, operand))

    def _reduce(self, least: int) -> None:
        """Applies the operators on top that bind at least so tight."""
        operators, operands = self._operators, self._operands
        while operators and _BINDING.get(operators[-1], -1) >= least:
            kind = operators.pop()
            count = 2
            if kind in ("and", "or"):
                while operators and operators[-1] == kind:
                    operators.pop()
                    count += 1
            parts = operands[-count:]
            del operands[-count:]
            operands.append(_joined(kind, parts))

    # --- operands ---

    def _operand(self) -> None:
        """Reads up to the end of an atom, with what stands before it."""
        while True:
            kind, text, at = self._take(_OPERAND, (), "a formula")
            if kind in ("not", "unary"):
                self._operators.append(text if kind == "unary" else kind)
            elif kind in ("open", "exists", "always"):
                self._open(kind)
            else:
                self._operands.append(self._atom(kind, text, at))
                return

    def _atom(self, kind: str, text: str, at: int) -> Formula:
        self._longer = ()
        match kind:
            case "plain":
                return PLAIN[text]
            case "ending":
                return Word(text, column=self._column(at))
            case "enabled":
                names = self._names()
                return Enabled(tuple(name for name, _ in names), names[0][1])
            case "word":
                return self._word(text[:-1].rstrip())
        left, column, alone = self._sum(kind, text, at)
        if self._comes() not in ("equal", "relation"):
            if alone:
                self._longer = ("plus", "equal", "relation")
                return Compare(Sum(0, left.places), ">=", Sum(1), column)
            self._fail(("plus", "equal", "relation"))
        _, relation, begin = self._take(_AFTER, ("equal", "relation"))
        right, right_column, _ = self._sum(*self._take(_TERMS, (), "a sum of tokens"))
        column = column or right_column or self._column(begin)
        self._longer = ("plus",)
        return Compare(left, cast(Relation, relation), right, column)

    def _word(self, kind: str) -> Formula:
        argument, column = self._name()
        self._take(_AFTER, ("close",))
        value = None
        if self._comes() == "equal":
            self._take(_AFTER, ("equal",))
            value = self._name()[0]
        self._longer = () if value else ("equal",)
        return Word(kind, argument, value, column)

    def _sum(self, kind: str, text: str, at: int) -> tuple[Sum, int | None, bool]:
        """A sum from its first token on, the column of its first name, and whether it is a place alone."""
        constant, names, terms = 0, list[tuple[str, int]](), 0
        while True:
            terms += 1
            if kind == "integer":
                if len(text) > MAX_DIGITS:
                    raise self._error(at, f"a number of more than {MAX_DIGITS} digits: the limit was hit")
                constant += int(text)
            elif kind == "tokens":
                names += self._names()
            else:
                names.append(self._named(kind, text, at))
            if self._comes() != "plus":
                alone = terms == 1 and kind in ("name", "quoted")
                total = Sum(constant, tuple(name for name, _ in names))
                return total, names[0][1] if names else None, alone
            self._take(_AFTER, ("plus",))
            kind, text, at = self._take(_TERMS, (), "a sum of tokens")

    def _names(self) -> list[tuple[str, int]]:
        """Names up to the closing parenthesis, each with its column."""
        found = [self._name()]
        while self._take(_AFTER, ("close", "comma"))[0] == "comma":
            found.append(self._name())
        return found

    def _name(self) -> tuple[str, int]:
        return self._named(*self._take(_NAMES, (), "a name"))

    def _named(self, kind: str, text: str, at: int) -> tuple[str, int]:
        if kind == "name":
            return text, self._column(at)
        try:
            return json.loads(text), self._column(at)
        except ValueError:
            raise self._error(at, f"{text} is no quoted name") from None

    # --- tokens ---

    def _skip_space(self) -> None:
        match = _SPACE.match(self._text, self._at)
        assert match is not None, "nothing is a space"
        self._at = match.end()

    def _comes(self) -> str | None:
        """The kind of the next token, behind an operand."""
        self._skip_space()
        match = _AFTER.match(self._text, self._at)
        return match.lastgroup if match else None

    def _take(self, pattern: re.Pattern[str], kinds: tuple[str, ...], expected: str = "") -> Token:
        """The next token, of one of some kinds; of any that the pattern knows where none is given."""
        self._skip_space()
        at = self._at
        if at == len(self._text) and "end" in kinds:
            return "end", "", at
        match = pattern.match(self._text, at)
        if match is None or (kinds and match.lastgroup not in kinds):
            self._fail((*kinds, *self._longer), expected)
        self._at = match.end()
        return match.lastgroup or "", match.group(), at

    # --- errors ---

    def _column(self, at: int) -> int:
        return at - self._text.rfind("\n", 0, at)

    def _error(self, at: int, message: str) -> InputError:
        return InputError.at(None, f"formula, column {self._column(at)}: {message}")

    def _fail(self, kinds: Iterable[str], expected: str = "") -> NoReturn:
        text, at = self._text, self._at
        word = _ANY.match(text, at)
        found = repr(word.group()) if word else "the end"
        at = at if word else len(text.rstrip())
        told = [words for kind, words in _IN_WORDS.items() if kind in set(kinds)]
        if not expected:
            expected = " or ".join(told) if len(told) < 3 else ", ".join(told[:-1]) + " or " + told[-1]
        line, column = text.count("\n", 0, at) + 1, self._column(at)
        begin = at - column + 1
        where = f"column {column}" if line == 1 else f"line {line}, column {column}"
        message = f"formula, {where}: found {found}, expected {expected}{_hint(text, at)}"
        shown = text[begin:].split("\n", 1)[0]
        raise InputError.at(None, f"{message}\n  {shown}\n  {' ' * (at - begin)}^")


def _joined(kind: str, parts: list[Formula]) -> Formula:
    if kind in ("and", "or"):
        return (And if kind == "and" else Or)(tuple(parts))
    return temporal("<->" if kind == "iff" else "->", *parts)


def _hint(text: str, at: int) -> str:
    """What the word here, or the one before it, may have been meant to be."""
    for word in (re.match(r"\w+", text[at:]), re.search(r"\w+(?=\s*$)", text[:at])):
        near = get_close_matches(word.group(), _KEYWORDS, n=1) if word else []
        if word and near and word.group() not in _KEYWORDS:
            return f"; did you mean {near[0]}?"
    return ""
