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

Operators wait on a stack of the parser's own, so that parentheses of any depth cost no recursion. Where an
operand is expected, ``U`` and ``and`` are names. A parser generated from a grammar takes longer to load than
most formulas take to answer.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator
from difflib import get_close_matches
from typing import NamedTuple, NoReturn, TypeVar

from mcpn.check.logic.formulas import EG, EU, EX, OPERATORS, Sum, compare, within_limit
from mcpn.check.logic.names import ENDINGS, WORDS, Names
from mcpn.errors import InputError
from mcpn.space.search.goal import DEADLOCK, FALSE, TRUE, And, AtMost, Fires, Formula, Not, Or, Stable, marked

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


_PLAIN: dict[str, Formula] = {"true": TRUE, "false": FALSE, "deadlock": DEADLOCK, "stable": Stable()}
_UNARY = ("EX", "AX", "EF", "AF", "EG", "AG")
_RESERVED = {*_UNARY, *_PLAIN, *ENDINGS, "not", "and", "or", "U"}
_KEYWORDS = {*_RESERVED, *WORDS, "enabled", "tokens"} - {"U"}

_BINARY = {"<->": 0, "->": 1, "|": 2, "&": 3}
_TIGHT = len(_BINARY)
_BINDING = {**_BINARY, **dict.fromkeys(("!", *_UNARY), _TIGHT)}
"""How tight operators bind."""
_CLOSING = {"": "", "(": ")", "E": "U", "A": "U", "EU": "]", "AU": "]"}
"""What stands behind the formula that each opening begins; nothing behind the whole."""

_QUOTED = r'"(?:[^"\\]|\\.)*"'
_SIGN = r"<->|->|<=|>=|!=|[][<>=!&|+,()]"
_TOKEN = re.compile(
    rf"\s*(?:(?P<name>[A-Za-z_][A-Za-z0-9_.]*)|(?P<quoted>{_QUOTED})|(?P<integer>[0-9]+)"
    rf"|(?P<sign>{_SIGN})|(?P<end>\Z)|(?P<other>\S))"
)
_SHOWN = re.compile(rf"{_QUOTED}|<->|->|<=|>=|!=|[\w.]+|\S")
_ROLES = {"and": "&", "or": "|", **dict.fromkeys(("<=", ">=", "!=", ">"), "<")}
"""What some tokens are behind an operand: comparisons are of one kind."""
_IN_WORDS = {"U": "U", "": "the end", ")": "')'", "]": "']'", ",": "','", "+": "'+'", "=": "'='"}
_IN_WORDS |= {"<": "a comparison", "&": "an operator"}


class _Token(NamedTuple):
    kind: str
    text: str
    at: int

    @property
    def role(self) -> str:
        """What it is behind an operand; before one it may be a name."""
        return _ROLES.get(self.text, self.text)


Found = TypeVar("Found")


class _Parser:
    def __init__(self, text: str, names: Names) -> None:
        self._text = text
        self._lookup = names
        self._operands: list[tuple[Formula, int]] = []  # with the number of operators, one in the other
        self._operators: list[str] = []  # openings among them
        self._unknown: list[InputError] = []  # names: what is wrong with the text itself is said before
        self._longer: tuple[str, ...] = ()  # what the last atom could have gone on with
        self._next = _Token("", "", 0)
        self._step()

    def formula(self) -> Formula:
        """The formula of the whole text."""
        while True:
            self._operand()
            while (sign := self._next.role) not in _BINARY:
                self._reduce(0)
                opening = self._operators.pop() if self._operators else ""
                self._take(_CLOSING[opening], "&")
                self._longer = ()
                if not opening:
                    return self._checked(*self._operands.pop())
                if sign == "U":
                    self._operators.append(f"{opening}U")
                    break
                if sign == "]":
                    self._apply(opening, 2)
            else:
                self._step()
                self._reduce(_BINDING[sign] + (sign != "<->"))
                self._operators.append(sign)

    def _checked(self, formula: Formula, depth: int) -> Formula:
        if depth > MAX_DEPTH:
            raise InputError.at(None, f"formula more than {MAX_DEPTH} operators deep: the limit was hit")
        if self._unknown:
            raise self._unknown[0]
        return formula

    def _reduce(self, least: int) -> None:
        """Applies the operators on top that bind at least so tight."""
        operators = self._operators
        while operators and _BINDING.get(operators[-1], -1) >= least:
            operator, count = operators.pop(), 2
            while operator in "&|" and operators and operators[-1] == operator:
                operators.pop()
                count += 1
            self._apply(operator, count if operator in _BINARY else 1)

    def _apply(self, operator: str, count: int) -> None:
        formulas, depths = zip(*self._operands[-count:], strict=True)
        self._operands[-count:] = [(OPERATORS[operator](*formulas), max(depths) + 1)]

    # --- operands ---

    def _operand(self) -> None:
        """Reads up to the end of an atom, with what stands before it."""
        while True:
            token = self._term("a formula", "integer", "!", "(")
            text, end = token.text, token.at + len(token.text)
            behind = self._text[end : end + 1]
            if text in ("!", "not"):
                self._operators.append("!")
            elif text == "(" or (text in _UNARY and (behind in '(!"' or behind.isspace())):
                self._operators.append(text)
            elif text in ("E", "A") and self._next.text == "[":
                self._step()
                self._operators.append(text)
            else:
                self._longer = ()
                self._operands.append((self._atom(token), 0))
                return

    def _atom(self, token: _Token) -> Formula:
        text, behind, longer = token.text, self._next, ("+", "=", "<")
        if text in _PLAIN:
            return _PLAIN[text]
        if text in ENDINGS:
            return self._named(self._lookup.word, FALSE, token)
        if behind.text == "(" and text == "enabled":
            return Fires(tuple(sorted({*self._listed(self._lookup.transition)})))
        if behind.text == "(" and text in WORDS:
            return self._word(text)
        if token.kind != "integer" and (text, behind.text) != ("tokens", "(") and behind.role not in longer:
            self._longer = longer
            return marked(self._named(self._lookup.place, 0, token))
        left = self._sum(token)
        relation = self._take(*longer).text
        right = self._sum(self._term("a sum of tokens", "integer"))
        self._longer = ("+",)
        return compare(left, relation, right)

    def _word(self, kind: str) -> Formula:
        self._take("(")
        token = self._term("a name")
        self._take(")")
        value: list[str] = []
        if self._next.text == "=":
            self._step()
            value = [self._named(str, "", self._term("a name"))]
        self._longer = () if value else ("=",)
        return self._named(lambda name: self._lookup.word(kind, name, *value), FALSE, token)

    def _sum(self, token: _Token) -> Sum:
        """A sum of tokens, from its first term on."""
        constant, places = 0, list[int]()
        while True:
            if token.kind == "integer":
                if len(token.text) > MAX_DIGITS:
                    message = f"a number of more than {MAX_DIGITS} digits: the limit was hit"
                    raise self._error(token.at, message)
                constant += int(token.text)
            elif token.text == "tokens" and self._next.text == "(":
                places += self._listed(self._lookup.place)
            else:
                places.append(self._named(self._lookup.place, 0, token))
            if self._next.text != "+":
                return constant, tuple(places)
            self._step()
            token = self._term("a sum of tokens", "integer")

    def _listed(self, lookup: Callable[[str], int]) -> Iterator[int]:
        """What the names in parentheses stand for."""
        sign = self._take("(")
        while sign.text != ")":
            yield self._named(lookup, 0, self._term("a name"))
            sign = self._take(")", ",")

    def _named(self, lookup: Callable[[str], Found], default: Found, token: _Token) -> Found:
        """What a name stands for; a default where it is unknown."""
        try:
            return lookup(json.loads(token.text) if token.kind == "quoted" else token.text)
        except InputError as error:
            self._unknown.append(self._error(token.at, str(error)))
            return default
        except ValueError:
            raise self._error(token.at, f"{token.text} is no quoted name") from None

    # --- tokens ---

    def _step(self) -> _Token:
        """The next token; goes on to the one behind it."""
        token = self._next
        match = _TOKEN.match(self._text, token.at + len(token.text))
        assert match, "the end or any character is a token"
        kind = match.lastgroup or ""
        self._next = _Token(kind, match[kind], match.start(kind))
        return token

    def _take(self, *roles: str) -> _Token:
        """The next token, which plays one of some roles."""
        return self._step() if self._next.role in roles else self._fail(roles)

    def _term(self, expected: str, *more: str) -> _Token:
        """The next token: a name, or of another kind or text."""
        fits = {self._next.kind, self._next.text}.intersection(("name", "quoted", *more))
        return self._step() if fits else self._fail((), expected)

    # --- errors ---

    def _error(self, at: int, message: str) -> InputError:
        line, column = self._text.count("\n", 0, at) + 1, at - self._text.rfind("\n", 0, at)
        where = f"column {column}" if line == 1 else f"line {line}, column {column}"
        return InputError.at(None, f"formula, {where}: {message}")

    def _fail(self, roles: Iterable[str], expected: str = "") -> NoReturn:
        text, word = self._text, _SHOWN.match(self._text, self._next.at)
        found, at = (repr(word.group()), word.start()) if word else ("the end", len(text.rstrip()))
        told = [words for role, words in _IN_WORDS.items() if role in (*roles, *self._longer)]
        if not expected:
            expected = " or ".join(told) if len(told) < 3 else ", ".join(told[:-1]) + " or " + told[-1]
        begin = text.rfind("\n", 0, at) + 1
        shown = text[begin:].split("\n", 1)[0]
        message = f"found {found}, expected {expected}{_hint(text, at)}"
        raise self._error(at, f"{message}\n  {shown}\n  {' ' * (at - begin)}^")


def _hint(text: str, at: int) -> str:
    """What the word here, or the one before it, may have been meant to be."""
    for word in (*re.findall(r"^\w+", text[at:]), *re.findall(r"\w+(?=\s*$)", text[:at])):
        if word not in _KEYWORDS and (near := get_close_matches(word, _KEYWORDS, n=1)):
            return f"; did you mean {near[0]}?"
    return ""


# --- printing ------------------------------------------------------------------------------------------

_ON_PATHS = {EX: ("EX", "AX"), EG: ("EG", "AF"), EU: ("EF", "AG")}
"""How an operator with one operand is written, and its negation."""


def show(formula: Formula, names: Names, around: int = 0) -> str:
    """Writes a formula so that :func:`parse` reads it.

    Args:
        formula: The formula.
        names: Know which words about the mission people have used.
        around: How tight the operator around it binds.
    """

    def tight(operator: str, operand: Formula) -> str:
        return operator + show(operand, names, _TIGHT + 1)

    if word := _word(formula, names):
        return word
    match formula:
        case And(operands) | Or(operands):
            operator = "&" if isinstance(formula, And) else "|"
            strength = _BINARY[operator]
            text = f" {operator} ".join(show(operand, names, strength + 1) for operand in operands)
            return f"({text})" if strength < around else text
        case EX() | EG() | EU((And(()), _)):
            return tight(f"{_ON_PATHS[type(formula)][0]} ", formula.operands[-1])
        case Not((EX() | EG() | EU((And(()), _)) as path,)):
            return tight(f"{_ON_PATHS[type(path)][1]} ", ~path.operands[-1])
        case Not((operand,)):
            return tight("!", operand)
        case EU((left, right)):
            return f"E[{show(left, names)} U {show(right, names)}]"
        case AtMost(((place, -1),), -1):
            return _quoted(names.net.places[place].name)
        case AtMost(weights, bound):
            small = _sum(((place, weight) for place, weight in weights if weight > 0), -bound, names)
            large = _sum(((place, -weight) for place, weight in weights if weight < 0), bound, names)
            return f"({small} <= {large})" if around > _TIGHT else f"{small} <= {large}"
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
    """The word for a formula; one about the mission that people have used for it or for its negation."""
    for word, meaning in (*_PLAIN.items(), ("false", Fires(()))):
        if formula == meaning:
            return word
    if not isinstance(formula.operands[0] if isinstance(formula, Not) else formula, AtMost | Fires):
        return ""
    for sign, meant in (("", formula), ("!", ~formula)):
        if meant in names.said:
            kind, *about = names.said[meant]
            argument = f"({_quoted(about[0])})" if about else ""
            return sign + kind + argument + "".join(f"={_quoted(value)}" for value in about[1:])
    return ""


def _quoted(name: str) -> str:
    plain = re.fullmatch(r"[A-Za-z_][A-Za-z0-9_.]*", name) and name not in _RESERVED
    return name if plain else json.dumps(name, ensure_ascii=False)
