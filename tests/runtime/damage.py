"""Damaged files of controllers: bytes that changed, and values that changed."""

from __future__ import annotations

import copy
import json
import random
from contextlib import suppress
from typing import Any

from mcpn.robot.runtime import Controller, ControllerFileError, Refused, SnapshotError
from mcpn.robot.runtime.file_schema import digest_of

WRONG: tuple[Any, ...] = (
    None,
    True,
    -1,
    0,
    1,
    7,
    10**6,
    10**30,
    0.5,
    "",
    "x",
    "a.b",
    [],
    [0],
    [[]],
    {},
    {"x": 1},
)


def bytes_changed(text: bytes, rng: random.Random) -> bytes:
    """A file with a few bytes lost, doubled, changed or put in, or cut short."""
    at = rng.randrange(len(text))
    length = rng.choice((1, 1, 2, 8, 64))
    kind = rng.randrange(5)
    if kind == 0:
        return text[:at] + text[at + length :]
    if kind == 1:
        return text[: at + length] + text[at:]
    if kind == 2:
        return text[:at] + bytes(rng.randrange(32, 127) for _ in range(length)) + text[at + length :]
    if kind == 3:
        return text[:at] + bytes([text[at] ^ 1 << rng.randrange(8)]) + text[at + 1 :]
    return text[:at]


def value_changed(document: dict[str, Any], rng: random.Random) -> dict[str, Any]:
    """A controller in which one value is another one, is missing, or stands twice."""
    changed = copy.deepcopy(document)
    holder: Any = changed
    key: Any = rng.choice(["types", "types", "types", "sections", *changed])
    while isinstance(holder[key], dict | list) and holder[key] and rng.random() < 0.9:
        holder = holder[key]
        key = rng.choice(list(holder)) if isinstance(holder, dict) else rng.randrange(len(holder))
    kind = rng.randrange(6)
    if kind == 0:
        del holder[key]
    elif kind == 1 and isinstance(holder, list):
        holder.insert(key, copy.deepcopy(rng.choice(holder)))
    elif kind == 2 and type(holder[key]) is int:
        holder[key] += rng.choice((-1, 1))
    elif kind == 3 and isinstance(holder, dict):
        holder[str(key) + "x"] = holder.pop(key)
    else:
        holder[key] = copy.deepcopy(rng.choice(WRONG))
    return changed


def signed(document: dict[str, Any]) -> dict[str, Any]:
    """A controller with the digest that it ought to have."""
    return document | {"digest": digest_of(document)}


def text_of(document: Any) -> str:
    """What it says, told from all else: 1 is not true here."""
    return json.dumps(document, sort_keys=True)


def runs(document: dict[str, Any], rng: random.Random, events: int) -> bool:
    """Whether it is loaded; then it runs on events at random, without an error of Python.

    A section that has no entry for the hardware of the moment may still be told while it runs: which
    hardware can be out of service there is a question to the mission, not to the file.
    """
    try:
        controller = Controller.from_document(document)
    except ControllerFileError:
        return False
    every = sorted(controller._tables.known)
    for _ in range(events):
        possible = controller.possible
        try:
            controller.handle(rng.choice(possible) if possible and rng.random() < 0.9 else rng.choice(every))
        except Refused:
            pass
        except ControllerFileError:
            break
        str(controller.state)
    with suppress(SnapshotError):  # a state may say of hardware what its events do not
        controller.restore(controller.snapshot())
    return True
