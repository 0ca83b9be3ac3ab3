"""TINA's textual nets (``.net``): the one reader and the one writer.

Supported: ``net``, ``pl`` with labels, markings and arcs, ``tr`` with labels and arcs, weights (``p*3``),
read arcs (``p?1``), names in braces, notes (``nt``) and positions skipped, priorities (``pr a b > c d``) that
amount to two levels. Priorities make the upper level internal and the lower one events, named by the
transition's label, or by the transition itself. Without priorities a label is kept as the event.

Reference: the formats page of the TINA toolbox (Berthomieu, Ribet, Vernadat 2004).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NoReturn

from mcpn.errors import InputError, Source
from mcpn.net.petri import NetBuilder, PetriNet

_TOKEN = re.compile(
    r"""(?P<brace>\{(?:[^{}\\]|\\.)*\})"""
    r"""|(?P<marking>\([^()\s]*\))"""
    r"""|(?P<interval>[\[\]][0-9.]+,\s*(?:[0-9.]+|w|oo)[\[\]])"""
    r"""|(?P<word>(?:->|[:>]|[^\s{}()\[\]:>\-]|-(?!>))+?(?=->|[\s{}()\[\]:>]|$)|->|[:>])""",
    re.ASCII,
)
_PLAIN = re.compile(r"[A-Za-z_'][A-Za-z0-9_'.]*\Z", re.ASCII)
_WEIGHT = re.compile(r"(?P<kind>\*|\?-?)(?P<count>[0-9]+[KM]?)\Z")
_SCALE = {"K": 1000, "M": 1_000_000}
MAX_TOKENS = 1 << 62


class _Reader:
    """Reads line by line: TINA's declarations do not span lines."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.line = 0
        self.name = ""
        self.places: dict[str, int] = {}
        self.labels: dict[str, str] = {}
        self.arcs: dict[str, dict[str, dict[str, int]]] = {}
        self.priorities: list[tuple[list[str], list[str], int]] = []

    def fail(self, message: str) -> NoReturn:
        raise InputError.at(Source(self.path, self.line), message)

    def tokens(self, text: str) -> list[str]:
        """Words of a line; names in braces unescaped, with a mark that tells them from syntax."""
        found, at = [], 0
        while at < len(text):
            if text[at].isspace():
                at += 1
                continue
            if text[at] == "#":
                break
            match = _TOKEN.match(text, at)
            if not match:
                self.fail(f"column {at + 1}: found {text[at]!r}, expected a name, an arc or an arrow")
            token = match.group()
            at = match.end()
            if match.lastgroup == "brace":
                token = "\0" + re.sub(r"\\(.)", r"\1", token[1:-1])
                suffix = re.compile(r"[*?][-0-9KM]+").match(text, at)
                if suffix:
                    token += "\0" + suffix.group()
                    at = suffix.end()
            found.append(token)
        return found

    def read(self, lines: Iterable[str]) -> PetriNet:
        handlers = {"tr": self.transition, "pl": self.place, "pr": self.priority}
        for self.line, text in enumerate(lines, 1):
            words = self.tokens(text)
            if not words:
                continue
            keyword, rest = words[0], words[1:]
            if keyword == "net":
                self.name = self.plain(rest[0]) if rest else ""
            elif keyword in handlers:
                if not rest:
                    self.fail(f"{keyword} without a name")
                handlers[keyword](rest)
            elif keyword not in ("nt", "lb", "an"):
                self.fail(f"found {self.plain(keyword)!r}, expected one of net, pl, tr, pr, nt, lb")
        return self.build()

    def plain(self, token: str) -> str:
        return token.strip("\0")

    def label(self, rest: list[str]) -> tuple[str | None, list[str]]:
        if rest and rest[0] == ":":
            if len(rest) < 2:
                self.fail("a label is missing after ':'")
            return self.plain(rest[1]), rest[2:]
        return None, rest

    def place(self, words: list[str]) -> None:
        name = self.plain(words[0])
        _, rest = self.label(words[1:])
        tokens = 0
        if rest and rest[0].startswith("("):
            tokens = self.number(rest[0][1:-1], "a marking")
            rest = rest[1:]
        self.places[name] = self.places.get(name, 0) + tokens
        if "->" in rest:
            arrow = rest.index("->")
            for side, arcs in (("produce", rest[:arrow]), ("consume", rest[arrow + 1 :])):
                for arc in arcs:
                    transition, kind, weight = self.arc(arc)
                    self.add(transition, "read" if kind == "?" else side, name, weight)
        elif rest:
            self.fail(f"found {self.plain(rest[0])!r} after place {name}, expected a marking or arcs")

    def transition(self, words: list[str]) -> None:
        name = self.plain(words[0])
        self.arcs.setdefault(name, {})
        label, rest = self.label(words[1:])
        if label is not None:
            self.labels[name] = label
        if rest and rest[0][0] in "[]" and not rest[0].startswith("\0"):
            if not re.match(r"\[0,\s*(w|oo)\[\Z", rest[0]):
                self.fail(f"transition {name} has the time interval {rest[0]}; only untimed nets are read")
            rest = rest[1:]
        if rest.count("->") != 1:
            self.fail(f"transition {name} needs one '->' between what it consumes and what it produces")
        arrow = rest.index("->")
        for side, arcs in (("consume", rest[:arrow]), ("produce", rest[arrow + 1 :])):
            for arc in arcs:
                place, kind, weight = self.arc(arc)
                self.places.setdefault(place, 0)
                if kind == "?" and side == "produce":
                    self.fail(f"transition {name} has a read arc among its outputs")
                self.add(name, "read" if kind == "?" else side, place, weight)

    def arc(self, token: str) -> tuple[str, str, int]:
        """Name, kind and weight of an arc."""
        if token.startswith("\0"):
            name, _, suffix = token[1:].partition("\0")
        else:
            found = re.search(r"[*?]", token)
            cut = found.start() if found else len(token)
            name, suffix = token[:cut], token[cut:]
        if not suffix:
            return name, "*", 1
        match = _WEIGHT.match(suffix)
        if not match or not name:
            self.fail(f"found the arc {self.plain(token)!r}, expected PLACE, PLACE*WEIGHT or PLACE?WEIGHT")
        if match["kind"] == "?-":
            self.fail(f"inhibitor arc {self.plain(token)!r}: inhibitor arcs are not supported")
        weight = self.number(match["count"], "a weight")
        if weight == 0:
            self.fail(f"the arc {self.plain(token)!r} has weight 0")
        return name, match["kind"], weight

    def number(self, text: str, what: str) -> int:
        scale = _SCALE.get(text[-1:], 1)
        digits = text[:-1] if scale > 1 else text
        if not digits.isascii() or not digits.isdigit() or len(digits) > 18:
            self.fail(f"found {text!r}, expected {what}: a number below 10^18")
        return int(digits) * scale

    def add(self, transition: str, side: str, place: str, weight: int) -> None:
        weights = self.arcs.setdefault(transition, {}).setdefault(side, {})
        weights[place] = weights.get(place, 0) + weight

    def priority(self, words: list[str]) -> None:
        relation = next((word for word in words if word in (">", "<")), None)
        if relation is None:
            self.fail("pr needs '>' between the transitions with priority and the others")
        cut = words.index(relation)
        sides = [self.plain(w) for w in words[:cut]], [self.plain(w) for w in words[cut + 1 :]]
        upper, lower = sides if relation == ">" else sides[::-1]
        self.priorities.append((upper, lower, self.line))

    def build(self) -> PetriNet:
        lower = self.lower_level()
        builder = NetBuilder(self.name, priorities=bool(self.priorities))
        for place, tokens in self.places.items():
            builder.place(place, initial=tokens)
        for name, sides in self.arcs.items():
            label = self.labels.get(name)
            event = label if not self.priorities else (label or name) if name in lower else None
            builder.transition(
                name,
                consume=sides.get("consume", {}),
                produce=sides.get("produce", {}),
                read=sides.get("read", {}),
                event=event,
            )
        return builder.build()

    def lower_level(self) -> set[str]:
        """The transitions of the lower of two levels."""
        pairs: dict[str, set[str]] = {}
        for upper, lower, line in self.priorities:
            self.line = line
            for name in (*upper, *lower):
                if name not in self.arcs:
                    self.fail(f"pr names the transition {name}, which is not declared")
            for name in upper:
                pairs.setdefault(name, set()).update(lower)
        below = set[str]().union(*pairs.values())
        complete = all(lower == below for lower in pairs.values())
        if pairs and not (complete and below.isdisjoint(pairs) and below | pairs.keys() == self.arcs.keys()):
            self.fail("priorities must amount to two levels that hold every transition: upper > lower")
        return below


def read_tina(path: Path, data: bytes) -> PetriNet:
    """Reads a ``.net`` text.

    Args:
        path: For errors.
        data: The file's bytes, UTF-8.

    Returns:
        The net.

    Raises:
        InputError: With file and line.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError.at(Source(str(path), line), "not UTF-8 text") from error
    return _Reader(str(path)).read(re.split(r"\r\n|\r|\n", text))


def write_tina(net: PetriNet) -> str:
    """A net as ``.net`` text; priorities as one ``pr`` line.

    Args:
        net: The net.

    Returns:
        The text, a line for each place and transition.

    Raises:
        InputError: A name holds a line break, which the format cannot say.
    """
    for name in (net.name, *(p.name for p in net.places), *(t.name for t in net.transitions)):
        if re.search(r"[\r\n\0]", name):
            raise InputError.at(None, f"the name {name!r} holds a line break, which .net files cannot say")
    return "\n".join(_lines(net)) + "\n"


def _lines(net: PetriNet) -> Iterator[str]:
    yield f"net {_quote(net.name)}" if net.name else "net {}"
    for place in net.places:
        yield f"pl {_quote(place.name)}" + (f" ({place.initial})" if place.initial else "")
    for t in net.transitions:
        label = f" : {_quote(t.event)}" if t.event is not None else ""
        inputs = [_arc(net, arc, "*") for arc in t.consume] + [_arc(net, arc, "?") for arc in t.read]
        outputs = [_arc(net, arc, "*") for arc in t.produce]
        yield " ".join([f"tr {_quote(t.name)}{label}", *inputs, "->", *outputs])
    if net.priorities:
        upper = [_quote(t.name) for t in net.transitions if t.internal]
        lower = [_quote(t.name) for t in net.transitions if not t.internal]
        if upper and lower:
            yield f"pr {' '.join(upper)} > {' '.join(lower)}"


def _arc(net: PetriNet, arc: tuple[int, int], kind: str) -> str:
    name = _quote(net.places[arc[0]].name)
    return name if arc[1] == 1 and kind == "*" else f"{name}{kind}{arc[1]}"


def _quote(name: str) -> str:
    if _PLAIN.match(name):
        return name
    return "{" + re.sub(r"([{}\\])", r"\\\1", name) + "}"
