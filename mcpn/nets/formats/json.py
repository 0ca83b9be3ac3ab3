"""Nets as JSON: the one reader and the one writer.

One object, whose keys :data:`KNOWN` declares: any other is refused. Places and transitions of missions carry
``from``: the ``kind``, ``name``, ``file`` and ``line`` of the element that made them. Numbers are exact up to
:data:`MAX_DIGITS` digits.
"""

from __future__ import annotations

import json
import re
from bisect import bisect
from collections.abc import Callable, Container, Iterator
from dataclasses import dataclass
from json.scanner import py_make_scanner  # type: ignore[attr-defined]
from math import inf
from pathlib import Path
from typing import Any, NoReturn

from mcpn.errors import InputError, Source
from mcpn.nets.events import Event
from mcpn.nets.formats.counts import check_counts
from mcpn.nets.petri import EVENTS, Arcs, NetBuilder, PetriNet, Provenance
from mcpn.sentences import quoted

MAX_DIGITS = 4_000
"""Of a number: Python reads no more without being asked to."""

KNOWN = {
    "net": "format version name priorities places transitions units",
    "place": "name initial label? from?",
    "transition": "name event rank? label? consume produce read from?",
    "origin": "kind name file? line?",
}
"""By object its keys; one with a question mark may be missing."""


def write_json(net: PetriNet) -> str:
    """A net as JSON that reads back as the same net.

    Args:
        net: The net.

    Returns:
        The text.

    Raises:
        InputError: A number is beyond what files may say.
    """
    check_counts(net, MAX_DIGITS)
    document = {
        "format": "mcpn-net",
        "version": 1,
        "name": net.name,
        "priorities": net.priorities,
        "places": [
            {"name": p.name, "initial": p.initial, **_label(p.label), **_origin(p.provenance)}
            for p in net.places
        ],
        "transitions": [
            {
                "name": t.name,
                "event": None if t.event is None else str(t.event),
                **({"rank": t.rank} if t.rank else {}),
                **_label(t.label),
                "consume": _weights(net, t.consume),
                "produce": _weights(net, t.produce),
                "read": _weights(net, t.read),
                **_origin(t.provenance),
            }
            for t in net.transitions
        ],
        "units": [[net.places[p].name for p in unit] for unit in net.units],
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def _weights(net: PetriNet, arcs: Arcs) -> dict[str, int]:
    return {net.places[place].name: weight for place, weight in arcs}


def _label(label: str | None) -> dict[str, str]:
    return {} if label is None else {"label": label}


def _origin(provenance: Provenance | None) -> dict[str, Any]:
    if provenance is None:
        return {}
    source = provenance.source
    return {
        "from": {
            "kind": provenance.kind,
            "name": provenance.name,
            "file": source.file if source else None,
            "line": source.line if source else None,
        }
    }


def read_json(path: Path, data: bytes) -> PetriNet:
    """Reads a net.

    Args:
        path: For errors.
        data: The file's bytes.

    Returns:
        The net.

    Raises:
        InputError: It is no JSON, or not of this format; says where in the document.
    """
    try:
        return _net(_Value(json.loads(data, object_pairs_hook=_object), "the document"))
    except json.JSONDecodeError as error:
        line, said = error.lineno, _misread(error)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        said = "not JSON: found bytes that are not UTF-8, expected UTF-8"
    except RecursionError:
        line, said = 1, "not JSON: found lists or objects too deep in each other: the limit was hit"
    except _GivenTwice as error:
        line, said = _line_of(data), f"not JSON: found {error}, expected keys that differ"
    except InputError as error:
        line, said = _line_of(data, str(error)), str(error)
    except ValueError:
        line = _line_of(data)
        said = f"not JSON: found a number of more digits, expected at most {MAX_DIGITS}"
    raise InputError.at(Source(str(path), line), said)


def _line_of(data: bytes, message: str = "") -> int:
    """The line of the innermost object or list that cannot be read, or that a message names by the way to it.

    The text is read again, by the scanner of the library that is written in Python, which tells where each
    begins: only where there is an error.
    """
    text = data.decode(json.detect_encoding(data))
    breaks = [match.start() for match in re.finditer("\n", text)]
    begins: dict[int, int] = {}
    kept = []  # so that no two have one id
    wrong = []  # lines of what cannot be read, from the innermost
    decoder: Any = json.JSONDecoder(object_pairs_hook=_object)

    def noting(read: Callable[..., tuple[Any, int]]) -> Callable[..., tuple[Any, int]]:
        def noted(at: tuple[str, int], *rest: Any) -> tuple[Any, int]:
            line = bisect(breaks, at[1] - 1) + 1
            try:
                value, end = read(at, *rest)
            except ValueError:
                wrong.append(line)
                raise
            begins[id(value)] = line
            kept.append(value)
            return value, end

        return noted

    decoder.parse_object = noting(decoder.parse_object)
    decoder.parse_array = noting(decoder.parse_array)
    decoder.scan_once = py_make_scanner(decoder)
    try:
        here: Any = decoder.decode(text)
    except (ValueError, RecursionError):
        return wrong[0] if wrong else 1
    line = begins.get(id(here), 1)
    for key, number in re.findall(r"(\w+)|\[(\d+)\]", message.partition(" ")[0]):
        try:
            here = here[int(number) if number else key]
        except (KeyError, IndexError, TypeError):
            break
        line = begins.get(id(here), line)
    return line


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    members: dict[str, Any] = {}
    for key, value in pairs:
        if key in members:
            raise _GivenTwice(f"the key {key!r} twice in an object")
        members[key] = value
    return members


class _GivenTwice(ValueError):
    """An object has two members of one key."""


_EXPECTED = {
    "Expecting value": "a value",
    "Expecting property name": "a key in double quotes",
    "Expecting ':'": "':' after a key",
    "Expecting ','": "',' or the end of the list or object",
    "Extra data": "the end of the file",
    "Unterminated string": "a text that ends with a double quote",
    "Invalid control character": "a text without line breaks and control characters",
    "Invalid \\": "an escape of JSON after the backslash",
    "Illegal trailing comma": "no comma before the end of the list or object",
}
"""By how the parser begins its message, what it expected."""


def _misread(error: json.JSONDecodeError) -> str:
    """What is wrong with a text that is no JSON, with its column."""
    expected = next((words for begin, words in _EXPECTED.items() if error.msg.startswith(begin)), "JSON")
    rest = error.doc[error.pos :].split(maxsplit=1)
    found = quoted(rest[0], 20) if rest else "the end of the file"
    return f"not JSON: column {error.colno}: found {found}, expected {expected}"


@dataclass(frozen=True, slots=True)
class _Value:
    """A value with the way to it, for messages; each method is one expectation."""

    value: Any
    way: str

    def fail(self, expected: str) -> NoReturn:
        if isinstance(self.value, dict | list):
            kind = "an object" if isinstance(self.value, dict) else "a list"
        else:
            shown = json.dumps(self.value)
            kind = shown if len(shown) < 40 else f"{shown[:40]}…"
        raise InputError.at(None, f"{self.way}: found {kind}, expected {expected}")

    def known(self, kind: str) -> _Value:
        """Itself, an object of some kind with the keys that it must have and no others."""
        if not isinstance(self.value, dict):
            self.fail("an object")
        words = KNOWN[kind].split()
        names = [word.removesuffix("?") for word in words]
        for key in self.value:
            if key not in names:
                said = f"{self.way}: found the key {quoted(key, 40)}, expected one of {', '.join(names)}"
                raise InputError.at(None, said)
        for word in words:
            if word not in self.value and not word.endswith("?"):
                raise InputError.at(None, f"{self.way}: found no key {word!r}, expected it")
        return self

    def get(self, key: str) -> _Value:
        if not isinstance(self.value, dict):
            self.fail("an object")
        return _Value(self.value.get(key), f"{self.way}.{key}".removeprefix("the document."))

    def items(self) -> Iterator[_Value]:
        if not isinstance(self.value, list):
            self.fail("a list")
        return (_Value(item, f"{self.way}[{number}]") for number, item in enumerate(self.value))

    def text(self) -> str:
        if not isinstance(self.value, str):
            self.fail("a text")
        return self.value

    def truth(self) -> bool:
        if not isinstance(self.value, bool):
            self.fail("true or false")
        return self.value

    def count(self, least: int, below: float = inf) -> int:
        number = self.value
        if not isinstance(number, int) or isinstance(number, bool) or not least <= number < below:
            self.fail(f"a whole number from {least}" + (f", less than {below}" if below < inf else ""))
        return number

    def label(self) -> str | None:
        return None if self.value is None else self.text()

    def new(self, names: Container[str]) -> str:
        """A name that none before has."""
        if self.text() in names:
            self.fail("a name that no other has")
        return self.text()

    def place(self, known: NetBuilder) -> str:
        if not known.has_place(self.text()):
            self.fail("the name of a place")
        return self.text()

    def weights(self, known: NetBuilder) -> dict[str, int]:
        if not isinstance(self.value, dict):
            self.fail("an object of weights by place")
        return {_Value(p, self.way).place(known): self.get(p).count(1) for p in self.value}


def _net(document: _Value) -> PetriNet:
    if document.get("format").value != "mcpn-net":
        document.fail('an object with "format": "mcpn-net"')
    if type(version := document.get("version").value) is not int or version != 1:
        document.get("version").fail("1")
    document.known("net")
    builder = NetBuilder(document.get("name").text(), priorities=document.get("priorities").truth())
    named = set[str]()
    for place in document.get("places").items():
        name = place.known("place").get("name").new(named)
        initial, label = place.get("initial").count(0), place.get("label").label()
        named.add(builder.place(name, initial=initial, provenance=_provenance(place), label=label))
    named.clear()
    for t in document.get("transitions").items():
        event = t.known("transition").get("event")
        rank = t.get("rank")
        builder.transition(
            name := t.get("name").new(named),
            consume=t.get("consume").weights(builder),
            produce=t.get("produce").weights(builder),
            read=t.get("read").weights(builder),
            event=None if event.value is None else Event.parse(event.text() or event.fail("a name")),
            rank=0 if rank.value is None else rank.count(0, EVENTS),
            provenance=_provenance(t),
        )
        builder.label(name, t.get("label").label())
        named.add(name)
    for unit in document.get("units").items():
        builder.unit(place.place(builder) for place in unit.items())
    return builder.build()


def _provenance(node: _Value) -> Provenance | None:
    origin = node.get("from")
    if origin.value is None:
        return None
    file, line = origin.known("origin").get("file"), origin.get("line")
    source = None
    if file.value is not None:
        source = Source(file.text(), None if line.value is None else line.count(1))
    return Provenance(origin.get("kind").text(), origin.get("name").text(), source)
