"""Nets as JSON: the one reader and the one writer.

One object: ``format`` (``mcpn-net``), ``version`` (1), ``name``, ``priorities``, ``places`` (each with
``name``, ``initial``), ``transitions`` (each with ``name``, ``event`` or null, and ``consume``, ``produce``,
``read``: weights by place) and ``units`` (lists of places). Places and transitions of missions carry
``from``: the ``kind``, ``name``, ``file`` and ``line`` of the element that made them.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from mcpn.errors import InputError, Source
from mcpn.net.petri import Arcs, NetBuilder, PetriNet, Provenance


def write_json(net: PetriNet) -> str:
    """A net as JSON that reads back as the same net.

    Args:
        net: The net.

    Returns:
        The text.
    """
    document = {
        "format": "mcpn-net",
        "version": 1,
        "name": net.name,
        "priorities": net.priorities,
        "places": [{"name": p.name, "initial": p.initial, **_origin(p.provenance)} for p in net.places],
        "transitions": [
            {
                "name": t.name,
                "event": t.event,
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
        InputError: It is no JSON, or not of this format.
    """
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        line = getattr(error, "lineno", 1)
        raise InputError.at(Source(str(path), line), f"not JSON: {error}") from error
    if not isinstance(document, dict) or document.get("format") != "mcpn-net" or document.get("version") != 1:
        raise InputError.at(Source(str(path)), 'expected an object with "format": "mcpn-net", "version": 1')
    try:
        return _build(document)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise InputError.at(Source(str(path)), f"not a net: {type(error).__name__} {error}") from error
    except InputError as error:
        raise InputError.at(Source(str(path)), str(error)) from error


def _build(document: dict[str, Any]) -> PetriNet:
    builder = NetBuilder(_text(document["name"]), priorities=document["priorities"] is True)
    for place in document["places"]:
        builder.place(_text(place["name"]), initial=_count(place["initial"]), provenance=_provenance(place))
    for t in document["transitions"]:
        sides = ({p: _count(w) for p, w in t[side].items()} for side in ("consume", "produce", "read"))
        consume, produce, read = sides
        event = None if t["event"] is None else _text(t["event"])
        builder.transition(
            _text(t["name"]),
            consume=consume,
            produce=produce,
            read=read,
            event=event,
            provenance=_provenance(t),
        )
    for unit in document["units"]:
        builder.unit(unit)
    return builder.build()


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"expected a text, found {value!r}")
    return value


def _count(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise TypeError(f"expected a number from 0, found {value!r}")
    return value


def _provenance(node: dict[str, Any]) -> Provenance | None:
    origin = node.get("from")
    if origin is None:
        return None
    source = None if origin["file"] is None else Source(origin["file"], origin["line"])
    return Provenance(origin["kind"], origin["name"], source)
