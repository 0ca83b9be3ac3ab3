"""Nets as JSON: the one reader and the one writer.

One object: ``format`` (``mcpn-net``), ``version`` (1), ``name``, ``priorities``, ``places`` (each with
``name``, ``initial``), ``transitions`` (each with ``name``, ``event`` or null, and ``consume``, ``produce``,
``read``: weights by place) and ``units`` (lists of places). Places and transitions of missions carry
``from``: the ``kind``, ``name``, ``file`` and ``line`` of the element that made them.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from mcpn.errors import InputError, Source
from mcpn.nets.events import Event
from mcpn.nets.formats.counts import MAX_COUNT, MAX_DIGITS, check_counts
from mcpn.nets.petri import Arcs, NetBuilder, PetriNet, Provenance


def write_json(net: PetriNet) -> str:
    """A net as JSON that reads back as the same net.

    Args:
        net: The net.

    Returns:
        The text.

    Raises:
        InputError: A number is beyond what files may say.
    """
    check_counts(net)
    document = {
        "format": "mcpn-net",
        "version": 1,
        "name": net.name,
        "priorities": net.priorities,
        "places": [{"name": p.name, "initial": p.initial, **_origin(p.provenance)} for p in net.places],
        "transitions": [
            {
                "name": t.name,
                "event": None if t.event is None else str(t.event),
                **({"rank": t.rank} if t.rank else {}),
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
        document = json.loads(data, object_pairs_hook=_object)
    except json.JSONDecodeError as error:
        raise InputError.at(Source(str(path), error.lineno), f"not JSON: {error}") from error
    except (ValueError, RecursionError) as error:  # also bytes that are not UTF-8, and endless numbers
        raise InputError.at(Source(str(path), 1), f"not JSON: {error}") from error
    try:
        return _net(_Value(document, "the document"))
    except InputError as error:
        raise InputError.at(Source(str(path)), str(error)) from error


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    members: dict[str, Any] = {}
    for key, value in pairs:
        if key in members:
            raise ValueError(f"the key {key!r} is given twice")
        members[key] = value
    return members


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
        raise InputError.at(None, f"{self.way} is {kind}, expected {expected}")

    def get(self, key: str, *, optional: bool = False) -> _Value:
        if not isinstance(self.value, dict):
            self.fail("an object")
        if key not in self.value and not optional:
            raise InputError.at(None, f"{self.way} has no {key!r}")
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

    def count(self, least: int) -> int:
        number = self.value
        if not isinstance(number, int) or isinstance(number, bool) or not least <= number <= MAX_COUNT:
            self.fail(f"a whole number from {least} of at most {MAX_DIGITS} digits")
        return number

    def weights(self) -> dict[str, int]:
        if not isinstance(self.value, dict):
            self.fail("an object of weights by place")
        return {place: self.get(place).count(1) for place in self.value}


def _net(document: _Value) -> PetriNet:
    if (document.get("format").value, document.get("version").value) != ("mcpn-net", 1):
        document.fail('an object with "format": "mcpn-net", "version": 1')
    builder = NetBuilder(document.get("name").text(), priorities=document.get("priorities").truth())
    for place in document.get("places").items():
        name, initial = place.get("name").text(), place.get("initial").count(0)
        builder.place(name, initial=initial, provenance=_provenance(place))
    for t in document.get("transitions").items():
        event = t.get("event")
        builder.transition(
            t.get("name").text(),
            consume=t.get("consume").weights(),
            produce=t.get("produce").weights(),
            read=t.get("read").weights(),
            event=None if event.value is None else Event.parse(event.text()),
            rank=0 if (rank := t.get("rank", optional=True)).value is None else rank.count(0),
            provenance=_provenance(t),
        )
    for unit in document.get("units").items():
        builder.unit(place.text() for place in unit.items())
    return builder.build()


def _provenance(node: _Value) -> Provenance | None:
    origin = node.get("from", optional=True)
    if origin.value is None:
        return None
    file, line = origin.get("file"), origin.get("line")
    source = None
    if file.value is not None:
        source = Source(file.text(), None if line.value is None else line.count(1))
    return Provenance(origin.get("kind").text(), origin.get("name").text(), source)
