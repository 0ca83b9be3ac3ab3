"""The formula language: text to formulas.

>>> from mcpn.nets.petri import NetBuilder
>>> builder = NetBuilder("lamp")
>>> places = builder.place("off", initial=1), builder.place("on")
>>> names = Names(builder.build())
>>> parse("AG (off | on)", names) == parse("A G (off | on)", names)
True

Connectives, loosest first: ``<->``, ``->``, ``|``, ``||`` or ``or``, ``&``, ``&&`` or ``and``, then ``U``,
``W`` and ``R`` between formulas on paths, then ``!`` or ``not`` and the temporal operators ``EX AX EF AF EG
AG`` before their operand, ``E[f U g]`` and ``A[f U g]``. ``<->`` binds to the left, the others between two
operands to the right. ``X``, ``F`` or ``<>`` and ``G`` or ``[]`` alone speak of one path; ``A`` and ``E``
before such a formula of all paths and of some, and where neither stands, all are meant. Atoms:
``true``, ``false``, ``deadlock``, ``stable``, sums of tokens compared (``tokens(p, q) + r <= 1``), a place
alone (it is marked), ``enabled(t, u)``, ``fires(t, u)`` (the next step of a path is one of them), and the
mission's words (:data:`mcpn.spaces.formula_names.WORDS`). Names that hold anything but letters, digits, ``_``
and ``.`` stand in double quotes.

Operators wait on a stack of the parser's own, so that parentheses of any depth cost no recursion. Where an
operand is expected, ``U`` and ``and`` are names; so are ``X``, ``F``, ``G``, ``A`` and ``E`` with no operand
behind. A parser generated from a grammar takes longer to load than most formulas take to answer.

Formulas as text, which :func:`mcpn.logic.syntax.parse` reads.

>>> from mcpn.logic.syntax import parse
>>> from mcpn.nets.petri import NetBuilder
>>> builder = NetBuilder("lamp")
>>> places = builder.place("off", initial=1), builder.place("on")
>>> names = Names(builder.build())
>>> from mcpn.logic.writing import show
>>> show(parse("F G (off | X on)", names), names)
'A F G (off | X on)'
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import NamedTuple, NoReturn, TypeVar

from mcpn.errors import InputError
from mcpn.logic.formulas import OPERATORS, Sum, compare, every_path, some_path, within_limit
from mcpn.logic.ltl.formulas import Happens, Next, Release, Until, always, eventually
from mcpn.spaces.formula_names import ENDINGS, WORDS, Names
from mcpn.spaces.search.goal import (
    DEADLOCK,
    FALSE,
    TRUE,
    Fires,
    Formula,
    Or,
    Stable,
    marked,
)

MAX_DEPTH = 200
MAX_LENGTH = 1_000_000
MAX_DIGITS = 18


def parse(text: str, names: Names, *, fair: bool = False) -> Formula:
    """Reads a formula.

    Args:
        text: For example ``AG EF (success | failure)``.
        names: Look up what the text names.
        fair: Whether it is asked of some paths only, which need not begin in each state.

    Raises:
        InputError: The text is no formula, or names are unknown; the messages have the columns.
        LimitError: The formula is too large, see :func:`mcpn.logic.formulas.within_limit`.

    Examples:
        >>> from mcpn.testing.nets import philosophers
        >>> names = Names(philosophers(2))
        >>> parse("EF deadlock", names)
        EU(operands=(And(operands=()), Deadlock()))
    """
    if len(text) > MAX_LENGTH:
        raise InputError.at(None, f"formula of more than {MAX_LENGTH} characters: the limit was hit")
    formula, on_path = _Parser(text, names, fair=fair).formula()
    return within_limit(every_path(formula, fair=fair) if on_path else formula)


def parse_open(text: str, names: Names) -> Formula:
    """Reads a formula as :func:`parse` does; one that speaks of one path is not asked of every path."""
    return within_limit(_Parser(text, names).formula()[0])


PLAIN: dict[str, Formula] = {"true": TRUE, "false": FALSE, "deadlock": DEADLOCK, "stable": Stable()}
_UNARY = ("EX", "AX", "EF", "AF", "EG", "AG")
ON_PATH: Mapping[str, Callable[..., Formula]] = {
    "X": Next,
    "F": eventually,
    "G": always,
    "A": every_path,
    "E": some_path,
    "U": Until,
    "R": Release,
    "W": lambda a, b: Release(b, Or(a, b)),
}
"""By operator on one path, or quantifier of paths, the function that makes a formula of its operands."""
_BEFORE = ("X", "F", "G", "A", "E")
"""Those of them that stand before their operand; elsewhere they are names."""
RESERVED = {*_UNARY, *PLAIN, *ENDINGS, "not", "and", "or", "U"}
_KEYWORDS = {*RESERVED, *WORDS, "enabled", "fires", "tokens"} - {"U"}

_BINARY = {"<->": 0, "->": 1, "|": 2, "&": 3, "U": 4, "R": 4, "W": 4}
TIGHT = 5
BINDING = {**_BINARY, **dict.fromkeys(("!", *_UNARY, *_BEFORE), TIGHT)}
"""How tight operators bind."""
_CLOSING = {"": "", "(": ")", "E[": "U", "A[": "U", "EU": "]", "AU": "]"}
"""What stands behind the formula that each opening begins; nothing behind the whole."""

_QUOTED = r'"(?:[^"\\]|\\.)*"'
_SIGN = r"<->|->|<=>|=>|=<|<=|>=|!=|==|&&|\|\||\[\]|<>|[][<>=!&|+,()]"
_TOKEN = re.compile(
    rf"\s*(?:(?P<name>[A-Za-z_][A-Za-z0-9_.]*)|(?P<quoted>{_QUOTED})|(?P<integer>[0-9]+)"
    rf"|(?P<sign>{_SIGN})|(?P<end>\Z)|(?P<other>\S))"
)
_SHOWN = re.compile(rf"{_QUOTED}|{_SIGN}|[\w.]+|\S")
_ROLES = {
    "and": "&",
    "&&": "&",
    "or": "|",
    "||": "|",
    "==": "=",
    **dict.fromkeys(("<=", ">=", "!=", ">"), "<"),
}
"""The role of some tokens behind an operand, by their text: all comparisons have one role."""
_BOXES = {"[]": "G", "<>": "F"}
"""Operators on one path before their operand, as signs."""
_INSTEAD = {
    "=>": "write -> for 'implies', >= for 'at least'",
    "=<": "write <= for 'at most'",
    "<=>": "write <-> for 'equivalent'",
    "<>": "write != for 'not equal'; <> stands before what holds some time",
    "[]": "[] stands before what always holds",
    "/": "write & for 'and', | for 'or'",
    "\\": "write & for 'and', | for 'or'",
    "~": "write ! for 'not'",
    "¬": "write ! for 'not'",
    "∧": "write & for 'and'",
    "∨": "write | for 'or'",
    "→": "write -> for 'implies'",
    "^": "write !(f <-> g) where one alone holds",
    "-": "write the sums so that no number is negative, and names with - in double quotes",
    "*": "write a sum, as tokens(p, p) for twice p",
    ";": "write one formula in each argument",
    "AND": "write & or and",
    "OR": "write | or or",
    "NOT": "write ! or not",
    "always": "write G on one path, AG on all paths from a state",
    "never": "write G ! on one path, AG ! on all paths from a state",
    "eventually": "write F on one path, AF on all paths from a state",
    "until": "write U for 'until'",
    "implies": "write -> for 'implies'",
}
"""What people write that is no sign or word of ours, and what to write instead."""
_IN_WORDS = {"U": "U", "": "the end", ")": "')'", "]": "']'", ",": "','", "+": "'+'", "=": "'='"}
_IN_WORDS |= {"<": "a comparison", "&": "an operator"}


_MEANT: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("running", "runs", "active", "executing"), ("objective", "activity")),
    **dict.fromkeys(("lost", "broken", "failed", "faulty", "fails"), ("oos",)),
    **dict.fromkeys(("works", "ready", "in_service"), ("available",)),
    **dict.fromkeys(("occurs", "occurred", "happened"), ("happens",)),
    **dict.fromkeys(("succeeded", "finished", "ended"), ("done",)),
    **dict.fromkeys(("mode", "runs_as"), ("alternative",)),
}
"""Words that are said for those of missions."""


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
    """Parses by operator precedence (Dijkstra's shunting yard): a stack of operands and one of operators."""

    def __init__(self, text: str, names: Names, *, fair: bool = False) -> None:
        self._text = text
        self._lookup = names
        self._fair = fair
        # With the number of operators, one in the other, and whether the operand speaks of a path.
        self._operands: list[tuple[Formula, int, bool]] = []
        self._operators: list[str] = []  # openings among them
        self._unknown: list[InputError] = []  # names: what is wrong with the text itself is said before
        self._longer: tuple[str, ...] = ()  # what the last atom could have gone on with
        self._next = _Token("", "", 0)
        self._step()

    def formula(self) -> tuple[Formula, bool]:
        """The formula of the whole text, and whether it speaks of a path."""
        while True:
            self._operand()
            while (sign := self._next.role) not in _BINARY or self._closes(sign):
                self._reduce(0)
                opening = self._operators.pop() if self._operators else ""
                self._take(_CLOSING[opening], "&")
                self._longer = ()
                if not opening:
                    return self._checked(*self._operands.pop())
                if sign == "U":
                    self._operators.append(f"{opening[0]}U")
                    break
                if sign == "]":
                    self._apply(opening, 2)
            else:
                self._step()
                self._reduce(BINDING[sign] + (sign != "<->"))
                self._operators.append(sign)

    def _closes(self, sign: str) -> bool:
        """Whether the token is the ``U`` that belongs to the innermost ``E[`` or ``A[``."""
        opening = next((operator for operator in reversed(self._operators) if operator in _CLOSING), "")
        return sign == "U" and _CLOSING[opening] == "U"

    def _checked(self, formula: Formula, depth: int, on_path: bool) -> tuple[Formula, bool]:
        if depth > MAX_DEPTH:
            raise InputError.at(None, f"formula more than {MAX_DEPTH} operators deep: the limit was hit")
        if self._unknown:
            raise InputError(dict.fromkeys(problem for error in self._unknown for problem in error.problems))
        return within_limit(formula) if on_path else formula, on_path

    def _reduce(self, least: int) -> None:
        """Applies the operators on top that bind at least so tight."""
        operators = self._operators
        while operators and BINDING.get(operators[-1], -1) >= least:
            operator, count = operators.pop(), 2
            while operator in "&|" and operators and operators[-1] == operator:
                operators.pop()
                count += 1
            self._apply(operator, count if operator in _BINARY else 1)

    def _apply(self, operator: str, count: int) -> None:
        formulas, depths, speaking = zip(*self._operands[-count:], strict=True)
        of_path, quantified = operator in ON_PATH or any(speaking), operator in ("A", "E")
        if of_path and operator not in ON_PATH and operator[0] in "AE":
            said = f"{operator[0]}[ U ]" if operator[1] == "U" else operator
            message = f"{said} is of states, and here of a path: write A(...) or E(...) around what is inside"
            raise InputError.at(None, f"formula: {message}")
        make = {**OPERATORS, **ON_PATH}[operator]
        if quantified:
            formulas, make = tuple(map(within_limit, formulas)), partial(make, fair=self._fair)
        made: Formula = make(*formulas)
        self._operands[-count:] = [(made, max(depths) + 1, of_path and not quantified)]

    def _operand(self) -> None:
        """Reads up to the end of an atom, with what stands before it."""
        while True:
            token = self._term("a formula", "integer", "!", "(", *_BOXES)
            text, end = token.text, token.at + len(token.text)
            behind = self._text[end : end + 1]
            if text in ("!", "not"):
                self._operators.append("!")
            elif text in _BOXES:
                self._operators.append(_BOXES[text])
            elif text == "(" or (
                text in _UNARY and (behind in '(!"' or behind.isspace() or self._next.text in _BOXES)
            ):
                self._operators.append(text)
            elif text in ("E", "A") and self._next.text == "[":
                self._step()
                self._operators.append(f"{text}[")
            elif text in _BEFORE and self._operand_follows():
                self._operators.append(text)
            else:
                self._longer = ()
                atom = self._atom(token)
                self._operands.append((atom, 0, isinstance(atom, Happens)))
                return

    def _operand_follows(self) -> bool:
        """Whether what comes next begins an operand."""
        behind = self._next
        named = behind.kind in ("name", "quoted", "integer") and behind.role not in _BINARY
        return named or behind.text in ("(", "!", *_BOXES)

    def _atom(self, token: _Token) -> Formula:
        text, behind, longer = token.text, self._next, ("+", "=", "<")
        if text in PLAIN:
            return PLAIN[text]
        if text in self._lookup.endings:
            return self._named(self._lookup.word, FALSE, token)
        if behind.text == "(" and text == "enabled":
            return Fires(tuple(sorted({*self._listed(self._lookup.transition)})))
        if behind.text == "(" and text == "fires":
            return Happens(tuple(sorted({*self._listed(self._lookup.transition)})))
        if behind.text == "(" and text in WORDS:
            return self._word(text)
        if behind.text == "(" and token.kind == "name" and text != "tokens":
            from difflib import get_close_matches

            known = (*WORDS, "enabled", "fires", "tokens")
            near = _MEANT.get(text) or get_close_matches(text, (*_UNARY, *PLAIN, *ENDINGS, *known), n=1)
            hint = f"did you mean {' or '.join(near)}?" if near else f"expected one of {', '.join(known)}"
            hint = _INSTEAD.get(text, hint)
            raise self._error(token.at, f"no word is named {text}; {hint}")
        if token.kind != "integer" and (text, behind.text) != ("tokens", "(") and behind.role not in longer:
            self._longer = longer
            return marked(self._named(self._lookup.place, 0, token))
        left = self._sum(token)
        relation = self._take(*longer).text.replace("==", "=")
        right = self._sum(self._term("a sum of tokens", "integer"))
        self._longer = ("+",)
        return compare(left, relation, right)

    def _word(self, kind: str) -> Formula:
        self._take("(")
        token = self._term("a name")
        self._take(")")
        value: list[str] = []
        if self._next.role == "=":
            self._step()
            value = [self._named(str, "", self._term("a name", *(["integer"] if kind == "fact" else [])))]
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
                return constant, Counter(places)
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

    def _error(self, at: int, message: str) -> InputError:
        line, column = self._text.count("\n", 0, at) + 1, at - self._text.rfind("\n", 0, at)
        where = f"column {column}" if line == 1 else f"line {line}, column {column}"
        return InputError.at(None, f"formula, {where}: {message}")

    def _fail(self, roles: Iterable[str], expected: str = "") -> NoReturn:
        text, word = self._text, _SHOWN.match(self._text, self._next.at)
        found, at = (repr(word.group()), word.start()) if word else ("the end", len(text.rstrip()))
        fitting = [words for role, words in _IN_WORDS.items() if role in (*roles, *self._longer)]
        if not expected:
            expected = " or ".join(fitting)
            if len(fitting) > 2:
                expected = ", ".join(fitting[:-1]) + " or " + fitting[-1]
        begin = text.rfind("\n", 0, at) + 1
        shown = text[begin:].split("\n", 1)[0]
        instead = _INSTEAD.get(word.group()) if word else None
        hint = f"; {instead}" if instead else _hint(text, at)
        message = f"found {found}, expected {expected}{hint}"
        raise self._error(at, f"{message}\n  {shown}\n  {' ' * (at - begin)}^")


def _hint(text: str, at: int) -> str:
    """What the word here, or the one before it, may have been meant to be."""
    from difflib import get_close_matches

    for word in (*re.findall(r"^\w+", text[at:]), *re.findall(r"(?<!\w)\w++(?=\s*$)", text[:at])):
        if word in _INSTEAD:
            return f"; {_INSTEAD[word]}"
        if word not in _KEYWORDS and (near := get_close_matches(word, _KEYWORDS, n=1)):
            return f"; did you mean {near[0]}?"
    return ""
