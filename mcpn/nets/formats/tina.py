"""TINA's textual nets (``.net``): the one reader and the one writer.

A net is the superposition of declarations: ``net``, ``tr`` and ``pl`` with labels, markings and arcs, ``lb``,
``pr``. Supported: weights (``p*3``), read arcs (``p?1``), names in braces with backslashes, comments,
priorities (``pr a b > c d``, on several lines too) that amount to levels. Priorities make the last level
events and the others internal, ranked in their order; an event is named by the transition's label, or by the
transition itself. Without priorities a label is kept as the event. Notes and labels of places are skipped.
Inhibitor and stopwatch arcs and time intervals other than ``[0,w[`` change the meaning of the net: they are
refused.

A declaration starts with its keyword at the start of a line; indented lines continue it.

Reference: the manual page "formats" of the TINA toolbox (Berthomieu, Ribet, Vernadat, The tool TINA, Int. J.
of Production Research 42(14), 2004).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import NoReturn

from mcpn.errors import InputError, Source
from mcpn.nets.events import Event
from mcpn.nets.formats.counts import MAX_COUNT, MAX_DIGITS, check_counts, read_count
from mcpn.nets.petri import NetBuilder, PetriNet

# Each alternative starts with other characters and none backtracks: the scan takes linear time.
_TOKEN = re.compile(
    r"(?P<space>\s+)|(?P<comment>\#.*)|(?P<braces>\{(?:[^{}\\]|\\.)*\})"
    r"|(?P<symbol>->|\?-?|!-?|[:<>()\[\],*])|(?P<word>(?:[^\s{}()\[\]:<>,*?!\#-]|-(?!>))+)"
)
_PLAIN = re.compile(r"[A-Za-z_'][A-Za-z0-9_']*\Z")
_KEYWORDS = ("net", "pl", "tr", "pr", "lb", "nt")
_SCALE = {"K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12, "P": 10**15, "E": 10**18}
_REFUSED = {"?-": "inhibitor", "!": "stopwatch", "!-": "stopwatch inhibitor"}


@dataclass(frozen=True, slots=True)
class _TinaToken:
    kind: str
    text: str
    line: int
    column: int

    def shown(self) -> str:
        return "the end of the declaration" if self.kind == "end" else repr(self.text)


class _Declaration:
    """The tokens of one declaration, read from left to right."""

    def __init__(self, path: str, keyword: _TinaToken) -> None:
        self.path = path
        self.keyword = keyword
        self.tokens: list[_TinaToken] = []
        self.at = 0

    def fail(self, message: str, token: _TinaToken | None = None) -> NoReturn:
        token = token or self.keyword
        raise InputError.at(Source(self.path, token.line), f"column {token.column}: {message}")

    def peek(self) -> _TinaToken:
        if self.at < len(self.tokens):
            return self.tokens[self.at]
        last = self.tokens[-1] if self.tokens else self.keyword
        return _TinaToken("end", "", last.line, last.column + len(last.text))

    def skip(self, *symbols: str) -> _TinaToken | None:
        """The next token if it is one of these symbols, which it then leaves behind."""
        token = self.peek()
        if token.kind != "symbol" or token.text not in symbols:
            return None
        self.at += 1
        return token

    def name(self, what: str) -> str:
        token = self.peek()
        if token.kind not in ("word", "braces"):
            self.fail(f"found {token.shown()}, expected {what}", token)
        self.at += 1
        return re.sub(r"\\(.)", r"\1", token.text[1:-1]) if token.kind == "braces" else token.text

    def number(self, what: str) -> int:
        token = self.peek()
        scale = _SCALE.get(token.text[-1:], 1)
        number = read_count(token.text[:-1] if scale > 1 else token.text)
        if token.kind != "word" or number is None or number * scale > MAX_COUNT:
            self.fail(f"found {token.shown()}, expected {what}: a number below 10^{MAX_DIGITS}", token)
        self.at += 1
        return number * scale

    def label(self) -> str | None:
        return self.name("a label") if self.skip(":") else None

    def sides(self, what: str) -> tuple[list[tuple[str, str, int]], list[tuple[str, str, int]]]:
        """The arcs before and after the arrow, each with its other end, its kind and its weight."""
        sides: tuple[list[tuple[str, str, int]], list[tuple[str, str, int]]] = ([], [])
        arrows = 0
        while (token := self.peek()).kind != "end":
            if self.skip("->"):
                arrows += 1
            else:
                sides[min(arrows, 1)].append(self.arc())
            if arrows > 1:
                self.fail(f"{what} needs one '->' between its inputs and its outputs, found two", token)
        if arrows == 0 and sides[0]:
            self.fail(f"{what} needs one '->' between its inputs and its outputs")
        return sides

    def arc(self) -> tuple[str, str, int]:
        shape = "an arc PLACE, PLACE*WEIGHT or PLACE?WEIGHT"
        name = self.name(shape)
        kind = self.skip("*", "?", "?-", "!", "!-")
        if kind is None:
            return name, "*", 1
        if kind.text in _REFUSED:
            self.fail(f"{_REFUSED[kind.text]} arcs are not supported", kind)
        weight = self.number("PLACE*WEIGHT or PLACE?WEIGHT")
        if weight == 0:
            self.fail(f"the arc {name}{kind.text}0 has weight 0", kind)
        return name, kind.text, weight


class _TinaReader:
    """Collects declarations, then makes the net of them."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.name = ""
        self.places: dict[str, int] = {}
        self.arcs: dict[str, dict[str, dict[str, int]]] = {}
        self.labels: dict[str, str] = {}
        self.late_labels: list[tuple[_Declaration, str, str]] = []
        self.priorities: list[tuple[_Declaration, list[str], list[str]]] = []

    def read(self, lines: Iterable[str]) -> PetriNet:
        for declaration in self.declarations(lines):
            keyword = declaration.keyword.text
            if keyword == "net":
                self.name = declaration.name("the net's name")
            elif keyword == "pl":
                self.place(declaration)
            elif keyword == "tr":
                self.transition(declaration)
            elif keyword == "lb":
                node = declaration.name("a place or a transition")
                self.late_labels.append((declaration, node, declaration.name("a label")))
            elif keyword == "pr":
                self.priority(declaration)
            else:
                continue  # a note
            rest = declaration.peek()
            if rest.kind != "end":
                declaration.fail(f"found {rest.shown()} where the declaration should end", rest)
        return self.build()

    def declarations(self, lines: Iterable[str]) -> Iterator[_Declaration]:
        current: _Declaration | None = None
        for number, text in enumerate(lines, 1):
            tokens = self.tokens(text, number)
            if not tokens:
                continue
            first = tokens[0]
            if first.kind == "word" and first.text in _KEYWORDS:
                if current:
                    yield current
                current = _Declaration(self.path, first)
                tokens = tokens[1:]
            elif current is None or first.column == 1:
                expected = f"expected one of {', '.join(_KEYWORDS)}"
                _Declaration(self.path, first).fail(f"found {first.shown()}, {expected}")
            current.tokens += tokens
        if current:
            yield current

    def tokens(self, text: str, line: int) -> list[_TinaToken]:
        words, position = [], 0
        while position < len(text):
            match = _TOKEN.match(text, position)
            if not match:
                character = text[position]
                wrong = "'{' without its '}' on the same line" if character == "{" else repr(character)
                here = _TinaToken("symbol", character, line, position + 1)
                _Declaration(self.path, here).fail(f"found {wrong}, expected a name, an arc or an arrow")
            kind = match.lastgroup or ""
            if kind not in ("space", "comment"):
                words.append(_TinaToken(kind, match.group(), line, position + 1))
            position = match.end()
        return words

    def place(self, declaration: _Declaration) -> None:
        if declaration.peek().kind == "end":
            declaration.fail("pl without a name")
        name = declaration.name("a place")
        declaration.label()
        tokens = 0
        if declaration.skip("("):
            tokens = declaration.number("a marking")
            if not declaration.skip(")"):
                token = declaration.peek()
                declaration.fail(f"found {token.shown()}, expected ')' after the marking", token)
        self.places[name] = self.places.get(name, 0) + tokens
        inputs, outputs = declaration.sides(f"place {name}")
        for transition, kind, weight in inputs:
            if kind == "?":
                declaration.fail(f"place {name} has a read arc among its inputs")
            self.add(transition, "produce", name, weight)
        for transition, kind, weight in outputs:
            self.add(transition, "read" if kind == "?" else "consume", name, weight)

    def transition(self, declaration: _Declaration) -> None:
        if declaration.peek().kind == "end":
            declaration.fail("tr without a name")
        name = declaration.name("a transition")
        self.arcs.setdefault(name, {})
        label = declaration.label()
        if label is not None:
            self.set_label(declaration, name, label)
        if declaration.peek().text in ("[", "]") and declaration.peek().kind == "symbol":
            interval = "".join(
                token.text for token in declaration.tokens[declaration.at : declaration.at + 5]
            )
            if interval != "[0,w[":
                what = f"transition {name} has a time interval other than [0,w["
                declaration.fail(f"{what}: only untimed nets are supported", declaration.peek())
            declaration.at += 5
        inputs, outputs = declaration.sides(f"transition {name}")
        for place, kind, weight in inputs:
            self.add(name, "read" if kind == "?" else "consume", place, weight)
        for place, kind, weight in outputs:
            if kind == "?":
                declaration.fail(f"transition {name} has a read arc among its outputs")
            self.add(name, "produce", place, weight)

    def add(self, transition: str, side: str, place: str, weight: int) -> None:
        self.places.setdefault(place, 0)
        weights = self.arcs.setdefault(transition, {}).setdefault(side, {})
        weights[place] = weights.get(place, 0) + weight

    def set_label(self, declaration: _Declaration, name: str, label: str) -> None:
        if self.labels.setdefault(name, label) != label:
            declaration.fail(f"transition {name} has two labels, {self.labels[name]} and {label}")

    def priority(self, declaration: _Declaration) -> None:
        left: list[str] = [declaration.name("a transition")]
        right: list[str] = []
        while not (relation := declaration.skip(">", "<")):
            left.append(declaration.name("a transition, '>' or '<'"))
        while declaration.peek().kind != "end" or not right:
            right.append(declaration.name("a transition"))
        upper, lower = (left, right) if relation.text == ">" else (right, left)
        self.priorities.append((declaration, upper, lower))

    def build(self) -> PetriNet:
        for declaration, node, label in self.late_labels:
            if node in self.arcs:
                self.set_label(declaration, node, label)
            elif node not in self.places:
                declaration.fail(f"lb names {node}, which is neither a place nor a transition")
        ranks = self.ranks()
        events = max(ranks.values(), default=0)
        builder = NetBuilder(self.name, priorities=bool(self.priorities))
        for place, tokens in self.places.items():
            builder.place(place, initial=tokens)
        for name, sides in self.arcs.items():
            event, rank = self.labels.get(name), 0
            if self.priorities:
                event, rank = None, ranks[name]
                if rank == events:
                    event, rank = self.labels.get(name, name), 0
            consume, produce, read = (sides.get(side, {}) for side in ("consume", "produce", "read"))
            typed = None if event is None else Event.parse(event)
            builder.transition(name, consume=consume, produce=produce, read=read, event=typed, rank=rank)
        return builder.build()

    def ranks(self) -> dict[str, int]:
        """By transition the number of its level of priority, from 0 for the highest; without any, none."""
        if not self.priorities:
            return {}
        lines_of: dict[str, list[int]] = {name: [] for name in self.arcs}
        for line, (declaration, above, below) in enumerate(self.priorities):
            for name in (*above, *below):
                if name not in self.arcs:
                    declaration.fail(f"pr names the transition {name}, which is not declared")
            for name in above:
                lines_of[name].append(line)
        # Each transition must stand above all those of later levels, by one line or by several together. A
        # level is known by the lines that its transitions stand above on.
        levels: dict[tuple[int, ...], list[str]] = {}
        for name, lines in lines_of.items():
            levels.setdefault(tuple(lines), []).append(name)
        below_of = {
            above_on: frozenset(n for line in above_on for n in self.priorities[line][2])
            for above_on in levels
        }
        rank_of: dict[str, int] = {}
        later, last = frozenset[str](), 0
        for above_on in sorted(levels, key=lambda above_on: len(below_of[above_on])):
            if below_of[above_on] != later:
                if below_of[above_on] != frozenset(rank_of):
                    self.partial(levels[above_on][0], below_of[above_on] ^ frozenset(rank_of))
                later, last = below_of[above_on], last + 1
            rank_of |= dict.fromkeys(levels[above_on], last)
        return {name: last - level for name, level in rank_of.items()}

    def partial(self, name: str, others: frozenset[str]) -> NoReturn:
        """Refuses priorities that are no levels, of a transition and others that should be below it."""
        other = min(others, key=lambda n: (n == name, list(self.arcs).index(n)))
        self.priorities[-1][0].fail(
            f"the priorities are a partial order: they leave open how {name} and {other} stand to each other;"
            " expected levels, where each transition is above all of the levels after its own"
            " (docs/formats.md, priorities of TINA, says what to write instead)"
        )


def read_tina(path: Path, data: bytes) -> PetriNet:
    """Reads a ``.net`` text.

    Args:
        path: For errors.
        data: The file's bytes, UTF-8.

    Returns:
        The net. Takes time linear in the size of the file, but for priorities declared line by line.

    Raises:
        InputError: With file, line and column.

    Examples:
        >>> lamp = read_tina(Path("lamp.net"), b"tr press off -> on")
        >>> lamp
        <net : 2 places, 1 transitions>
        >>> lamp.marked(lamp.fire((1, 0), 0))
        frozenset({'on'})
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError.at(Source(str(path), line), "not UTF-8 text") from error
    return _TinaReader(str(path)).read(re.split(r"\r\n|\r|\n", text))


def write_tina(net: PetriNet) -> str:
    """A net as ``.net`` text that reads back as the same net; priorities as a ``pr`` line for each rank.

    Where all transitions are internal, or all are events, there is no ``pr`` line to say that the net has
    priorities, which then are of no effect. Ranks are written by their order. Units and provenance are not
    written.

    Args:
        net: The net.

    Returns:
        The text, a line for each place and transition.

    Raises:
        InputError: A name holds a line break, which the format cannot say, or a number is beyond what files
            may say; or internal transitions have ranks and there are no events, which have the last level.

    Examples:
        >>> print(write_tina(read_tina(Path("lamp.net"), b"tr press off -> on")), end="")
        net {}
        pl off
        pl on
        tr press off -> on
    """
    check_counts(net)
    if net.priorities and len(net.internal_ranks) > 1 and all(t.internal for t in net.transitions):
        raise InputError.at(None, "ranks of a net without events cannot be written as .net")
    events = (str(t.event) for t in net.transitions if t.event is not None)
    for name in (net.name, *net.place_index, *net.transition_index, *events):
        if re.search(r"[\r\n]", name):
            raise InputError.at(None, f"the name {name!r} holds a line break, which .net files cannot say")
    return "\n".join(_lines(net)) + "\n"


def _lines(net: PetriNet) -> Iterator[str]:
    yield f"net {quote(net.name)}"
    for place in net.places:
        yield f"pl {quote(place.name)}" + (f" ({place.initial})" if place.initial else "")
    for t in net.transitions:
        label = f" : {quote(str(t.event))}" if t.event is not None else ""
        inputs = [_arc(net, arc, "*") for arc in t.consume] + [_arc(net, arc, "?") for arc in t.read]
        outputs = [_arc(net, arc, "*") for arc in t.produce]
        yield " ".join([f"tr {quote(t.name)}{label}", *inputs, "->", *outputs])
    levels = [[quote(net.transitions[t].name) for t in rank] for rank in net.internal_ranks]
    events = [quote(t.name) for t in net.transitions if not t.internal]
    if net.priorities and events:
        for number, level in enumerate(levels, 1):
            yield f"pr {' '.join(level)} > {' '.join(chain(*levels[number:], events))}"


def _arc(net: PetriNet, arc: tuple[int, int], kind: str) -> str:
    name = quote(net.places[arc[0]].name)
    return name if arc[1] == 1 and kind == "*" else f"{name}{kind}{arc[1]}"


def quote(name: str) -> str:
    """A name as TINA's text formats write it: in braces unless it is plain.

    Examples:
        >>> quote("off"), quote("on air")
        ('off', '{on air}')
    """
    if _PLAIN.match(name) and name not in _KEYWORDS:
        return name
    return "{" + re.sub(r"([{}\\])", r"\\\1", name) + "}"
