"""TINA's textual nets (``.net``): the one reader and the one writer.

A net is the superposition of declarations, in the grammar of the tool's manual::

    net         = { "net" NAME | place | transition | priority | label | note }
    place       = "pl" NAME [":" NAME] ["(" NUMBER ")"] [arcs]
    transition  = "tr" NAME [":" NAME] [interval] [arcs]
    arcs        = {arc} "->" {arc}
    arc         = NAME [("*" | "?" | "?-" | "!" | "!-") NUMBER]
    interval    = ("[" | "]") NUMBER "," (NUMBER ("[" | "]") | "w" "[")
    priority    = "pr" NAME {NAME} (">" | "<") NAME {NAME}
    label       = "lb" NAME NAME
    note        = "nt" NAME ("0" | "1") NAME

Any white space separates tokens, line breaks too; ``#`` begins a comment. A keyword is a name in braces
alone, where a backslash stands before braces and backslashes. A number may end in a power of ten (``2K``).

Priorities (``pr``) are read where they amount to levels. They make the last level events and the others
internal, ranked in their order; an event is named by the transition's label, or by the transition itself.
Without priorities a label is kept as the event. Of several labels the last counts; ``{}`` is none. Notes are
without meaning. Inhibitor arcs (``?-``) are read
of places with a proved bound. Stopwatch arcs (``!``, ``!-``) and intervals other than ``[0,w[`` are refused.

Reference: the manual page "formats" of the TINA toolbox (Berthomieu, Ribet, Vernadat, The tool TINA, Int. J.
of Production Research 42(14), 2004).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import NamedTuple, NoReturn

from mcpn.errors import InputError, Source
from mcpn.events import Event
from mcpn.nets.formats.counts import MAX_COUNT, MAX_DIGITS, check_counts, read_count
from mcpn.nets.inhibitors import Inhibitor, without_inhibitors
from mcpn.nets.petri import NetBuilder, PetriNet

# Each alternative starts with other characters and none backtracks: the scan takes linear time.
_TOKEN = re.compile(
    r"(?P<space>\s+)|(?P<comment>\#.*)|(?P<braces>\{(?:[^{}\\]|\\.)*\})"
    r"|(?P<symbol>->|\?-?|!-?|[:<>()\[\],*])|(?P<word>(?:[^\s{}()\[\]:<>,*?!\#-]|-(?!>))+)"
)
_PLAIN = re.compile(r"[A-Za-z_'][A-Za-z0-9_']*\Z")
DECLARATIONS = {
    "net": ("net NAME", "the name of the net"),
    "pl": ("pl NAME : LABEL (MARKING) INPUTS -> OUTPUTS", "a place; all but its name may be left out"),
    "tr": ("tr NAME : LABEL [0,w[ INPUTS -> OUTPUTS", "a transition; no other interval of time is read"),
    "pr": ("pr NAMES > NAMES, pr NAMES < NAMES", "transitions that have priority over others"),
    "lb": ("lb NAME LABEL", "the label of a place or a transition; the last one counts"),
    "nt": ("nt NAME 0 TEXT, nt NAME 1 TEXT", "a note: without meaning"),
}
"""By keyword how a declaration is written, and what it means: there are no others."""
ARCS = {
    "": "of weight 1",
    "*": "takes or gives as many tokens",
    "?": "reads: needs them and leaves them, into transitions alone",
    "?-": "inhibitor arc: needs fewer, of a place with a proved bound",
    "!": "stopwatch arc: refused",
    "!-": "stopwatch inhibitor arc: refused",
}
"""By the sign between a name and a weight, what the arc does."""
_KEYWORDS = tuple(DECLARATIONS)
_SCALE = {"K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12, "P": 10**15, "E": 10**18}
_REFUSED = {sign: said.removesuffix(" arc: refused") for sign, said in ARCS.items() if "refused" in said}


class _TinaToken(NamedTuple):
    kind: str
    text: str
    line: int
    column: int

    def shown(self) -> str:
        return "the end of the declaration" if self.kind in ("end", "keyword") else repr(self.text)


class _Tokens:
    """The tokens of a text, taken from left to right; a keyword ends the declaration before it."""

    def __init__(self, path: str, text: str) -> None:
        self.path = path
        self.all: list[_TinaToken] = []
        self.at = 0
        for line, words in enumerate(re.split(r"\r\n|\r|\n", text), 1):
            self.all += self.of_line(words, line)
        last = self.all[-1] if self.all else _TinaToken("end", "", 1, 1)
        self.all.append(_TinaToken("end", "", last.line, last.column + len(last.text)))

    def of_line(self, text: str, line: int) -> Iterator[_TinaToken]:
        position = 0
        while position < len(text):
            match = _TOKEN.match(text, position)
            if not match:
                character = text[position]
                wrong = "'{' without its '}' on the same line" if character == "{" else repr(character)
                here = _TinaToken("symbol", character, line, position + 1)
                self.fail(f"found {wrong}, expected a name, an arc or an arrow", here)
            kind = match.lastgroup or ""
            if kind == "word" and match.group() in _KEYWORDS:
                kind = "keyword"
            if kind not in ("space", "comment"):
                yield _TinaToken(kind, match.group(), line, position + 1)
            position = match.end()

    def fail(self, message: str, token: _TinaToken | None = None) -> NoReturn:
        token = token or self.peek()
        raise InputError.at(Source(self.path, token.line), f"column {token.column}: {message}")

    def peek(self) -> _TinaToken:
        return self.all[self.at]

    @property
    def ended(self) -> bool:
        """Whether the declaration ends here."""
        return self.peek().kind in ("end", "keyword")

    def keyword(self) -> _TinaToken | None:
        """The keyword that begins a declaration here; ``None`` at the end of the text."""
        token = self.peek()
        if token.kind == "end":
            return None
        if token.kind != "keyword":
            after = " where the declaration should end" if self.at else ""
            self.fail(f"found {token.shown()}{after}, expected one of {', '.join(_KEYWORDS)}")
        self.at += 1
        return token

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
            before = self.all[self.at - 1]
            if token.kind == "keyword" and before.line != token.line:
                self.fail(f"found {token.shown()}, expected {what}", before)
            hint = f"; as a name write {{{token.text}}}" if token.kind == "keyword" else ""
            self.fail(f"found {token.shown()}, expected {what}{hint}")
        self.at += 1
        return re.sub(r"\\(.)", r"\1", token.text[1:-1]) if token.kind == "braces" else token.text

    def number(self, what: str) -> int:
        token = self.peek()
        scale = _SCALE.get(token.text[-1:], 1)
        number = read_count(token.text[:-1] if scale > 1 else token.text)
        if token.kind != "word" or number is None or number * scale > MAX_COUNT:
            self.fail(f"found {token.shown()}, expected {what}: a number below 10^{MAX_DIGITS}")
        self.at += 1
        return number * scale

    def label(self) -> str | None:
        return self.name("a label") if self.skip(":") else None

    def untimed(self, name: str) -> None:
        """Leaves the interval [0,w[ behind; any other is refused."""
        if self.peek().kind == "symbol" and self.peek().text in ("[", "]"):
            interval = "".join(token.text for token in self.all[self.at : self.at + 5])
            if interval != "[0,w[":
                found = f"found {interval!r}, expected no time interval of transition {name}, or [0,w["
                self.fail(f"{found}: only untimed nets are supported")
            self.at += 5

    def sides(self, what: str, of: str) -> tuple[list[tuple[str, str, int]], list[tuple[str, str, int]]]:
        """The arcs before and after the arrow, each with its other end, its kind and its weight."""
        sides: tuple[list[tuple[str, str, int]], list[tuple[str, str, int]]] = ([], [])
        arrows = 0
        while not self.ended:
            token = self.peek()
            if self.skip("->"):
                arrows += 1
            else:
                sides[min(arrows, 1)].append(self.arc(of))
            if arrows > 1:
                self.fail(
                    f"found a second '->', expected one between the inputs and the outputs of {what}", token
                )
        if arrows == 0 and sides[0]:
            self.fail(
                f"found {self.peek().shown()}, expected '->' between the inputs and the outputs of {what}"
            )
        return sides

    def arc(self, of: str) -> tuple[str, str, int]:
        name = self.name(f"an arc {of}, {of}*WEIGHT, {of}?WEIGHT or {of}?-WEIGHT")
        kind = self.skip(*ARCS)
        if kind is None:
            return name, "*", 1
        if kind.text in _REFUSED:
            said = f"found a {_REFUSED[kind.text]} arc, expected {of}*WEIGHT, {of}?WEIGHT or {of}?-WEIGHT"
            self.fail(f"{said}: {_REFUSED[kind.text]} arcs are not supported", kind)
        weight = self.number(f"{of}*WEIGHT, {of}?WEIGHT or {of}?-WEIGHT")
        if weight == 0:
            self.fail(f"found the arc {name}{kind.text}0, expected a weight from 1", kind)
        return name, kind.text, weight


class _TinaReader:
    """Collects declarations, then makes the net of them."""

    def __init__(self, path: str, text: str) -> None:
        self.tokens = _Tokens(path, text)
        self.name = ""
        self.places: dict[str, int] = {}
        self.arcs: dict[str, dict[str, dict[str, int]]] = {}
        self.inhibitors: list[Inhibitor] = []
        self.labelled: list[tuple[_TinaToken, str, str]] = []
        self.priorities: list[tuple[_TinaToken, list[str], list[str]]] = []

    def read(self) -> PetriNet:
        declared: Mapping[str, Callable[[_TinaToken], None]] = {
            "net": self.net,
            "pl": self.place,
            "tr": self.transition,
            "lb": self.label,
            "pr": self.priority,
            "nt": self.note,
        }
        while keyword := self.tokens.keyword():
            declared[keyword.text](keyword)
        return self.build()

    def net(self, keyword: _TinaToken) -> None:
        self.name = self.tokens.name("the net's name")

    def label(self, keyword: _TinaToken) -> None:
        node = self.tokens.name("a place or a transition")
        self.labelled.append((keyword, node, self.tokens.name("a label")))

    def note(self, keyword: _TinaToken) -> None:
        self.tokens.name("a note's name")
        if (way := self.tokens.name("0 or 1")) not in ("0", "1"):
            self.tokens.fail(f"found {way!r} after the name of a note, expected 0 or 1", keyword)
        self.tokens.name("a note's text")

    def place(self, keyword: _TinaToken) -> None:
        tokens = self.tokens
        if tokens.ended:
            tokens.fail("found pl without a name, expected one of a place", keyword)
        name = tokens.name("a place")
        if (label := tokens.label()) is not None:
            self.labelled.append((keyword, name, label))
        held = 0
        if tokens.skip("("):
            held = tokens.number("a marking")
            if not tokens.skip(")"):
                tokens.fail(f"found {tokens.peek().shown()}, expected ')' after the marking")
        self.places[name] = self.places.get(name, 0) + held
        inputs, outputs = tokens.sides(f"place {name}", "TRANSITION")
        for transition, kind, weight in inputs:
            self.plain(keyword, f"place {name}", "inputs", kind)
            self.add(transition, "produce", name, weight)
        for transition, kind, weight in outputs:
            self.taken(keyword, transition, kind, name, weight)

    def transition(self, keyword: _TinaToken) -> None:
        tokens = self.tokens
        if tokens.ended:
            tokens.fail("found tr without a name, expected one of a transition", keyword)
        name = tokens.name("a transition")
        self.arcs.setdefault(name, {})
        if (label := tokens.label()) is not None:
            self.labelled.append((keyword, name, label))
        tokens.untimed(name)
        inputs, outputs = tokens.sides(f"transition {name}", "PLACE")
        for place, kind, weight in inputs:
            self.taken(keyword, name, kind, place, weight)
        for place, kind, weight in outputs:
            self.plain(keyword, f"transition {name}", "outputs", kind)
            self.add(name, "produce", place, weight)

    def plain(self, keyword: _TinaToken, what: str, side: str, kind: str) -> None:
        if kind != "*":
            arc = "a read arc" if kind == "?" else "an inhibitor arc"
            self.tokens.fail(f"found {arc} among the {side} of {what}, expected arcs *WEIGHT alone", keyword)

    def taken(self, keyword: _TinaToken, transition: str, kind: str, place: str, weight: int) -> None:
        """An arc from a place to a transition."""
        if kind == "?-":
            self.places.setdefault(place, 0)
            self.arcs.setdefault(transition, {})
            source = Source(self.tokens.path, keyword.line)
            self.inhibitors.append(Inhibitor(place, transition, weight, source))
        else:
            self.add(transition, "read" if kind == "?" else "consume", place, weight)

    def add(self, transition: str, side: str, place: str, weight: int) -> None:
        self.places.setdefault(place, 0)
        weights = self.arcs.setdefault(transition, {}).setdefault(side, {})
        weights[place] = weights.get(place, 0) + weight

    def priority(self, keyword: _TinaToken) -> None:
        tokens = self.tokens
        left: list[str] = [tokens.name("a transition")]
        right: list[str] = []
        while not (relation := tokens.skip(">", "<")):
            left.append(tokens.name("a transition, '>' or '<'"))
        while not tokens.ended or not right:
            right.append(tokens.name("a transition"))
        upper, lower = (left, right) if relation.text == ">" else (right, left)
        self.priorities.append((keyword, upper, lower))

    def build(self) -> PetriNet:
        labels = self.labels()
        ranks = self.ranks()
        events = max(ranks.values(), default=0)
        builder = NetBuilder(self.name, priorities=bool(self.priorities))
        for place, tokens in self.places.items():
            builder.place(place, initial=tokens, label=labels.get(("pl", place)))
        for name, sides in self.arcs.items():
            event, rank = labels.get(("tr", name)), 0
            if self.priorities:
                last = ranks[name] == events
                event, rank = (event or name, 0) if last else (None, ranks[name])
            consume, produce, read = (sides.get(side, {}) for side in ("consume", "produce", "read"))
            typed = None if event is None else Event.parse(event)
            builder.transition(name, consume=consume, produce=produce, read=read, event=typed, rank=rank)
        return without_inhibitors(builder.build(), self.inhibitors)

    def labels(self) -> dict[tuple[str, str], str]:
        """By kind and name of a node its label: of several the last one counts, and an empty one is none."""
        found: dict[tuple[str, str], str] = {}
        for keyword, name, label in self.labelled:
            kind = keyword.text
            if kind == "lb":
                kind = "tr" if name in self.arcs else "pl"
                if kind == "pl" and name not in self.places:
                    said = f"lb names {name!r}, expected a place or a transition that is declared"
                    self.tokens.fail(said, keyword)
            found[kind, name] = label
        return {node: label for node, label in found.items() if label}

    def ranks(self) -> dict[str, int]:
        """By transition the number of its level of priority, from 0 for the highest; without any, none."""
        if not self.priorities:
            return {}
        lines_of: dict[str, list[int]] = {name: [] for name in self.arcs}
        for line, (keyword, above, below) in enumerate(self.priorities):
            for name in (*above, *below):
                if name not in self.arcs:
                    self.tokens.fail(f"pr names {name!r}, expected a transition that is declared", keyword)
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
        self.tokens.fail(
            f"the priorities are a partial order: they leave open how {name} and {other} stand to each other;"
            " expected levels, where each transition is above all of the levels after its own"
            " (docs/nets.md, priorities of TINA, says what to write instead)",
            self.priorities[-1][0],
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
        raise InputError.at(
            Source(str(path), line), "found bytes that are not UTF-8, expected text in UTF-8"
        ) from error
    return _TinaReader(str(path), text).read()


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
    for name in (net.name, *net.place_index, *net.place_labels, *net.transition_index, *events):
        if re.search(r"[\r\n]", name):
            raise InputError.at(None, f"the name {name!r} holds a line break, which .net files cannot say")
    return "\n".join(_lines(net)) + "\n"


def _lines(net: PetriNet) -> Iterator[str]:
    yield f"net {quote(net.name)}"
    for place in net.places:
        label = "" if place.label is None else f" : {quote(place.label)}"
        yield f"pl {quote(place.name)}{label}" + (f" ({place.initial})" if place.initial else "")
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
