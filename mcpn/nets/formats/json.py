"""Nets as JSON: the one reader and the one writer.

One object, which :data:`SHAPE` declares: other keys are refused. Places and transitions of missions carry
``from``: the ``kind``, ``name``, ``file`` and ``line`` of the element that made them. Numbers are exact up to
:data:`MAX_DIGITS` digits.
"""

from __future__ import annotations

import json
import re
from bisect import bisect
from collections.abc import Callable
from json.scanner import py_make_scanner  # type: ignore[attr-defined]
from pathlib import Path
from typing import Any

from mcpn.errors import InputError, Source
from mcpn.events import Event
from mcpn.nets.formats.counts import check_counts, rank_without_use
from mcpn.nets.petri import EVENTS, Arcs, NetBuilder, PetriNet
from mcpn.nets.provenance import Provenance
from mcpn.robot.runtime.shapes import (
    Boolean,
    Integer,
    ListOf,
    MapOf,
    Misfit,
    Nullable,
    ObjectOf,
    OneOf,
    String,
)
from mcpn.sentences import quoted

MAX_DIGITS = 4_000
"""Of a number: Python reads no more without being asked to."""

_WEIGHTS = MapOf("Weights by place.", Integer("A weight.", least=1))
_LABEL = Nullable(String("What people call it."))
_MADE_BY = Nullable(
    ObjectOf(
        "The element of the mission that made it.",
        {
            "kind": String("Its kind."),
            "name": String("Its name."),
            "file?": Nullable(String("Its file.")),
            "line?": Nullable(Integer("Its line.", least=1)),
        },
    )
)
SHAPE = ObjectOf(
    "A Petri net with priorities; read and written by mcpn convert.",
    {
        "format": OneOf("Always this.", "mcpn-net"),
        "version": OneOf("Always this.", 1),
        "name": String("Its name."),
        "priorities": Boolean("Internal transitions come before events."),
        "places": ListOf(
            "Places, whose names differ.",
            ObjectOf(
                "One place.",
                {
                    "name": String("Its name."),
                    "initial": Integer("Its tokens at first."),
                    "label?": _LABEL,
                    "from?": _MADE_BY,
                },
            ),
        ),
        "transitions": ListOf(
            "Transitions, whose names differ.",
            ObjectOf(
                "One transition.",
                {
                    "name": String("Its name."),
                    "event": Nullable(String("Its event; null for an internal one.")),
                    "rank?": Nullable(
                        Integer(
                            "Of an internal transition: those of a lower rank fire before it. 0 where it is "
                            "left out."
                        )
                    ),
                    "label?": _LABEL,
                    "consume": _WEIGHTS,
                    "produce": _WEIGHTS,
                    "read": _WEIGHTS,
                    "from?": _MADE_BY,
                },
            ),
        ),
        "units": ListOf(
            "Groups of places of which one is marked at most.", ListOf("Places.", String("A place."))
        ),
    },
)
"""What the file may be, and what that means."""


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
        return _net(json.loads(data, object_pairs_hook=_object))
    except json.JSONDecodeError as error:
        line, said = error.lineno, _misread(error)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        said = "not JSON: found bytes that are not UTF-8, expected UTF-8"
    except RecursionError:
        line, said = 1, "not JSON: found lists or objects too deep in each other: the limit was hit"
    except _GivenTwice as error:
        line, said = _line_of(data), f"not JSON: found {error}, expected keys that differ"
    except (Misfit, InputError) as error:
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


def _net(document: Any) -> PetriNet:
    SHAPE.check(document)
    builder = NetBuilder(document["name"], priorities=document["priorities"])
    known, named = set[str](), set[str]()
    for number, place in enumerate(document["places"]):
        name, at = place["name"], f"places[{number}]"
        _one(name not in known, f"{at}.name", name, "a name that no other place has")
        known.add(name)
        builder.place(name, initial=place["initial"], provenance=_provenance(place), label=place.get("label"))
    for number, t in enumerate(document["transitions"]):
        name, event, rank, at = t["name"], t["event"], t.get("rank") or 0, f"transitions[{number}]"
        _one(name not in named, f"{at}.name", name, "a name that no other transition has")
        named.add(name)
        _one(event != "", f"{at}.event", event, "a name, or null")
        _one(rank < EVENTS, f"{at}.rank", rank, f"less than {EVENTS}")
        why = rank_without_use(event, priorities=builder.priorities) if rank else ""
        _one(not why, f"{at}.rank", rank, why.removeprefix("expected "))
        for side in _SIDES:
            for place in t[side].keys() - known:
                _one(False, f"{at}.{side}", place, "the name of a place")
        event = None if event is None else Event.parse(event)
        sides = {side: t[side] for side in _SIDES}
        builder.transition(name, **sides, event=event, rank=rank, provenance=_provenance(t))
        builder.label(name, t.get("label"))
    for number, unit in enumerate(document["units"]):
        for place in unit:
            _one(place in known, f"units[{number}]", place, "the name of a place")
        builder.unit(unit)
    return builder.build()


_SIDES = ("consume", "produce", "read")


def _one(holds: bool, where: str, found: object, expected: str) -> None:
    if not holds:
        raise Misfit(found, expected).below(where)


def _provenance(node: dict[str, Any]) -> Provenance | None:
    if (origin := node.get("from")) is None:
        return None
    file = origin.get("file")
    source = None if file is None else Source(file, origin.get("line"))
    return Provenance(origin["kind"], origin["name"], source)
