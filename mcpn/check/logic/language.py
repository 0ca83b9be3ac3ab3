r"""The formula language: text to formulas, and formulas to text.

>>> from mcpn.net.petri import NetBuilder
>>> builder = NetBuilder("lamp")
>>> places = builder.place("off", initial=1), builder.place("on")
>>> names = Names(builder.build())
>>> show(parse("AG (off | E [!deadlock U tokens(off, on) <= 1])", names), names)
'AG (off | E[!deadlock U tokens(off, on) <= 1])'

Connectives, loosest first: ``<->``, ``->``, ``|`` or ``or``, ``&`` or ``and``, then ``!`` or ``not`` and the
temporal operators ``EX AX EF AF EG AG`` before their operand, ``E[f U g]`` and ``A[f U g]``. Atoms:
``true``, ``false``, ``deadlock``, ``stable``, sums of tokens compared (``tokens(p, q) + r <= 1``), a place
alone (it is marked), ``enabled(t, u)``, and the mission's words (:data:`mcpn.check.logic.names.WORDS`). Names
that hold anything but letters, digits, ``_`` and ``.`` stand in double quotes.

Operators wait on a stack of the parser's own, so that parentheses of any depth cost no recursion. The lexer
is contextual: where an operand is expected, ``U`` and ``and`` are names. A parser generated from a grammar
takes longer to load than most formulas take to answer.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator
from difflib import get_close_matches
from typing import NoReturn, TypeAlias, TypeVar

from mcpn.check.logic.formulas import (
    EG,
    EU,
    EX,
    FALSE,
    OPERATORS,
    TRUE,
    And,
    Const,
    Deadlock,
    Fires,
    Formula,
    Not,
    Or,
    Stable,
    Sum,
    compare,
    negation,
    within_limit,
)
from mcpn.check.logic.names import WORDS, Names, marked
from mcpn.errors import InputError
from mcpn.space.search.goal import AtMost

MAX_DEPTH = 200
MAX_LENGTH = 1_000_000
MAX_DIGITS = 18


def parse(text: str, names: Names) -> Formula:
    """Reads a formula.

    Args:
        text: For example ``AG EF (success | failure)``.
        names: Look up what the text names.

    Raises:
        InputError: The text is no formula, or a name is unknown; the message has the column.
        LimitError: The formula is too large, see :func:`mcpn.check.logic.formulas.within_limit`.
    """
    if len(text) > MAX_LENGTH:
        raise InputError.at(None, f"formula of more than {MAX_LENGTH} characters: the limit was hit")
    return within_limit(_Parser(text, names).formula())


def _lexer(tokens: str) -> re.Pattern[str]:
    return re.compile(rf"\s*(?:{tokens})")


_UNARY = ("EX", "AX", "EF", "AF", "EG", "AG")
_PLAIN: dict[str, Formula] = {"true": TRUE, "false": FALSE, "deadlock": Deadlock(), "stable": Stable()}
_KEYWORDS = [*_UNARY, *_PLAIN, *WORDS, "success", "failure", "enabled", "tokens", "not", "and", "or"]

_NAME = r'(?P<name>[A-Za-z_][A-Za-z0-9_.]*)|(?P<quoted>"(?:[^"\\]|\\.)*")'
_TERM = rf"(?P<tokens>tokens\s*\()|(?P<integer>[0-9]+)|{_NAME}"
_OPERAND = _lexer(
    r"(?P<not>!|not\b)|(?P<until>[EA]\s*\[)|(?P<enabled>enabled\s*\()"
    rf'|(?P<unary>(?:{"|".join(_UNARY)})(?=[\s(!"]|$))|(?P<plain>(?:{"|".join(_PLAIN)})\b(?![.]))'
    rf"|(?P<ending>(?:success|failure)\b(?![.]))|(?P<word>(?:{'|'.join(WORDS)})\s*\()|(?P<open>\()|{_TERM}"
)
_AFTER = _lexer(
    r"(?P<iff><->)|(?P<implies>->)|(?P<or>\||or\b)|(?P<and>&|and\b)|(?P<until>U\b)|(?P<relation><=|>=|!=|<|>)"
    r"|(?P<equal>=)|(?P<plus>\+)|(?P<comma>,)|(?P<close>\))|(?P<bracket>\])|(?P<end>\Z)"
)
_NAMES, _TERMS = _lexer(_NAME), _lexer(_TERM)
_ANY = _lexer(r'(?P<any>"(?:[^"\\]|\\.)*"|<->|->|<=|>=|!=|[\w.]+|\S)')

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
_BINARY = {"iff": "<->", "implies": "->", "or": "|", "and": "&"}
_BINDING = {operator: strength for strength, operator in enumerate(_BINARY.values())}
_BINDING |= dict.fromkeys(("!", *_UNARY), len(_BINDING))
_CLOSING = {"(": "close", "E": "until", "A": "until", "EU": "bracket", "AU": "bracket"}
"""What each opening is followed by, behind its formula."""

Token: TypeAlias = tuple[str, str, int]
"""Kind, text, and where it begins."""
Found = TypeVar("Found")
_UNKNOWN: Formula = FALSE


class _Parser:
    def __init__(self, text: str, names: Names) -> None:
        self._text = text
        self._lookup = names
        self._at = 0
        self._operands: list[tuple[Formula, int]] = []  # with the number of operators, one in the other
        self._operators: list[str] = []  # openings among them
        self._groups: list[str] = []
        self._unknown: list[InputError] = []  # names: what is wrong with the text itself is said before
        self._longer: tuple[str, ...] = ()  # what the last atom could have gone on with

    def formula(self) -> Formula:
        """The formula of the whole text."""
        while True:
            self._operand()
            while True:
                closing = _CLOSING[self._groups[-1]] if self._groups else "end"
                kind, _, _ = self._take(_AFTER, (*_BINARY, closing))
                if operator := _BINARY.get(kind):
                    self._reduce(_BINDING[operator] + (operator != "<->"))
                    self._operators.append(operator)
                    break
                self._reduce(0)
                if kind == "end":
                    formula, depth = self._operands.pop()
                    if depth > MAX_DEPTH:
                        message = f"formula more than {MAX_DEPTH} operators deep: the limit was hit"
                        raise InputError.at(None, message)
                    if self._unknown:
                        raise self._unknown[0]
                    return formula
                self._operators.pop()
                group = self._groups.pop()
                self._longer = ()
                if kind == "until":
                    self._open(f"{group}U")
                    break
                if kind == "bracket":
                    self._apply(group, 2)

    def _open(self, group: str) -> None:
        self._groups.append(group)
        self._operators.append(group)

    def _reduce(self, least: int) -> None:
        """Applies the operators on top that bind at least so tight."""
        operators = self._operators
        while operators and _BINDING.get(operators[-1], -1) >= least:
            operator, count = operators.pop(), 2
            while operator in "&|" and operators and operators[-1] == operator:
                operators.pop()
                count += 1
            self._apply(operator, 1 if operator == "!" or operator in _UNARY else count)

    def _apply(self, operator: str, count: int) -> None:
        formulas, depths = zip(*self._operands[-count:], strict=True)
        self._operands[-count:] = [(OPERATORS[operator](*formulas), max(depths) + 1)]

    # --- operands ---

    def _operand(self) -> None:
        """Reads up to the end of an atom, with what stands before it."""
        while True:
            kind, text, at = self._take(_OPERAND, (), "a formula")
            if kind in ("not", "unary"):
                self._operators.append(text if kind == "unary" else "!")
            elif kind in ("open", "until"):
                self._open(text[0])
            else:
                self._longer = ()
                self._operands.append((self._atom(kind, text, at), 0))
                return

    def _atom(self, kind: str, text: str, at: int) -> Formula:
        match kind:
            case "plain":
                return _PLAIN[text]
            case "ending":
                return self._named(self._lookup.word, _UNKNOWN, kind, text, at)
            case "enabled":
                return Fires(tuple(sorted({*self._listed(self._lookup.transition)})))
            case "word":
                return self._word(text[:-1].rstrip())
        longer = ("plus", "equal", "relation")
        if kind in ("name", "quoted") and self._comes() not in longer:
            self._longer = longer
            return marked([self._named(self._lookup.place, 0, kind, text, at)])
        left = self._sum(kind, text, at)
        if self._comes() not in ("equal", "relation"):
            self._fail(longer)
        _, relation, _ = self._take(_AFTER, ("equal", "relation"))
        right = self._sum(*self._take(_TERMS, (), "a sum of tokens"))
        self._longer = ("plus",)
        return compare(left, relation, right)

    def _word(self, kind: str) -> Formula:
        token = self._take(_NAMES, (), "a name")
        self._take(_AFTER, ("close",))
        value: tuple[str, ...] = ()
        if self._comes() == "equal":
            self._take(_AFTER, ("equal",))
            value = (self._named(str, "", *self._take(_NAMES, (), "a name")),)
        self._longer = () if value else ("equal",)
        return self._named(lambda name: self._lookup.word(kind, name, *value), _UNKNOWN, *token)

    def _sum(self, kind: str, text: str, at: int) -> Sum:
        """A sum of tokens, from its first term on."""
        constant, places = 0, list[int]()
        while True:
            if kind == "integer":
                if len(text) > MAX_DIGITS:
                    raise self._error(at, f"a number of more than {MAX_DIGITS} digits: the limit was hit")
                constant += int(text)
            elif kind == "tokens":
                places += self._listed(self._lookup.place)
            else:
                places.append(self._named(self._lookup.place, 0, kind, text, at))
            if self._comes() != "plus":
                return constant, tuple(places)
            self._take(_AFTER, ("plus",))
            kind, text, at = self._take(_TERMS, (), "a sum of tokens")

    def _listed(self, lookup: Callable[[str], int]) -> Iterator[int]:
        """What names stand for, up to the closing parenthesis."""
        yield self._named(lookup, 0, *self._take(_NAMES, (), "a name"))
        while self._take(_AFTER, ("close", "comma"))[0] == "comma":
            yield self._named(lookup, 0, *self._take(_NAMES, (), "a name"))

    def _named(self, lookup: Callable[[str], Found], default: Found, kind: str, text: str, at: int) -> Found:
        """What a name stands for; a default where it is unknown."""
        try:
            return lookup(json.loads(text) if kind == "quoted" else text)
        except InputError as error:
            self._unknown.append(self._error(at, str(error)))
            return default
        except ValueError:
            raise self._error(at, f"{text} is no quoted name") from None

    # --- tokens ---

    def _comes(self) -> str | None:
        """The kind of the next token, behind an operand."""
        match = _AFTER.match(self._text, self._at)
        return match and match.lastgroup

    def _take(self, lexer: re.Pattern[str], kinds: tuple[str, ...], expected: str = "") -> Token:
        """The next token, of one of some kinds; of any that the lexer knows where none is given."""
        match = lexer.match(self._text, self._at)
        kind = match and match.lastgroup
        if match is None or kind is None or (kinds and kind not in kinds):
            self._fail((*kinds, *self._longer), expected)
        self._at = match.end()
        return kind, match[kind], match.start(kind)

    # --- errors ---

    def _column(self, at: int) -> int:
        return at - self._text.rfind("\n", 0, at)

    def _error(self, at: int, message: str) -> InputError:
        line = self._text.count("\n", 0, at) + 1
        where = f"column {self._column(at)}" if line == 1 else f"line {line}, column {self._column(at)}"
        return InputError.at(None, f"formula, {where}: {message}")

    def _fail(self, kinds: Iterable[str], expected: str = "") -> NoReturn:
        text, word = self._text, _ANY.match(self._text, self._at)
        found, at = (repr(word["any"]), word.start("any")) if word else ("the end", len(text.rstrip()))
        told = [words for kind, words in _IN_WORDS.items() if kind in set(kinds)]
        if not expected:
            expected = " or ".join(told) if len(told) < 3 else ", ".join(told[:-1]) + " or " + told[-1]
        before = self._column(at) - 1
        shown = text[at - before :].split("\n", 1)[0]
        message = f"found {found}, expected {expected}{_hint(text, at)}"
        raise self._error(at, f"{message}\n  {shown}\n  {' ' * before}^")


def _hint(text: str, at: int) -> str:
    """What the word here, or the one before it, may have been meant to be."""
    for word in (re.match(r"\w+", text[at:]), re.search(r"\w+(?=\s*$)", text[:at])):
        near = get_close_matches(word.group(), _KEYWORDS, n=1) if word else []
        if word and near and word.group() not in _KEYWORDS:
            return f"; did you mean {near[0]}?"
    return ""


# --- printing ------------------------------------------------------------------------------------------

_IFF, _, _OR, _AND, _ATOM, _TIGHT = range(6)


def show(formula: Formula, names: Names, around: int = _IFF) -> str:
    """Writes a formula so that :func:`parse` reads it.

    Args:
        formula: The formula.
        names: Name places and transitions, and know which words about the mission people have used.
        around: How tight the operator around it binds.
    """

    def bind(strength: int, text: str) -> str:
        return f"({text})" if strength < around else text

    def tight(operator: str, operand: Formula) -> str:
        return f"{operator} {show(operand, names, _TIGHT)}"

    def listed(places: Iterable[tuple[int, int]], constant: int) -> str:
        named = [_quoted(names.net.places[p].name) for p, weight in places for _ in range(weight)]
        if len(named) > 1:
            named = [f"tokens({', '.join(named)})"]
        return " + ".join([*named, *([str(constant)] if constant or not named else [])])

    match formula:
        case AtMost() | Fires() | Not(AtMost() | Fires()) if word := _said(formula, names):
            return word
        case Const() | Deadlock() | Stable():
            return next(text for text, plain in _PLAIN.items() if plain == formula)
        case Or(operands) if operands:
            return bind(_OR, " | ".join(show(o, names, _AND) for o in operands))
        case And(operands) if operands:
            return bind(_AND, " & ".join(show(o, names, _ATOM) for o in operands))
        case And() | Or() | Fires(()):
            return str(isinstance(formula, And)).lower()
        case Not(EX(a)):
            return tight("AX", negation(a))
        case Not(EG(a)):
            return tight("AF", negation(a))
        case Not(EU(Const(True), a)):
            return tight("AG", negation(a))
        case EU(Const(True), a):
            return tight("EF", a)
        case Not(a):
            return f"!{show(a, names, _TIGHT)}"
        case EX(a) | EG(a):
            return tight(type(formula).__name__, a)
        case EU(a, b):
            return f"E[{show(a, names)} U {show(b, names)}]"
        case AtMost(((place, -1),), -1):
            return _quoted(names.net.places[place].name)
        case AtMost(weights, bound):
            small = listed(((place, weight) for place, weight in weights if weight > 0), max(-bound, 0))
            large = listed(((place, -weight) for place, weight in weights if weight < 0), max(bound, 0))
            return bind(_ATOM, f"{small} <= {large}")
        case Fires(transitions):
            return f"enabled({', '.join(_quoted(names.net.transitions[t].name) for t in transitions)})"


def _said(formula: Formula, names: Names) -> str:
    """The word about the mission that people have used for a formula or for its negation."""
    for sign, meant in (("", formula), ("!", negation(formula))):
        if meant in names.said:
            kind, *about = names.said[meant]
            argument = f"({_quoted(about[0])})" if about else ""
            return sign + kind + argument + "".join(f"={_quoted(value)}" for value in about[1:])
    return ""


def _quoted(name: str) -> str:
    plain = re.fullmatch(r"[A-Za-z_][A-Za-z0-9_.]*", name) and name not in _RESERVED
    return name if plain else json.dumps(name, ensure_ascii=False)


_RESERVED = {*_UNARY, *_PLAIN, "success", "failure", "not", "and", "or", "U"}
