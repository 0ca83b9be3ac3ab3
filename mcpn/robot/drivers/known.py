"""What a file of drivers may say: a table of its keys, each with what it means and what reads its value.

All that is in no table is refused. ``docs/drivers.md`` shows the table of drivers.
"""

from __future__ import annotations

import re
import signal
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from mcpn.robot.drivers.mapping import KINDS, OTHER, REPEATS, Kind, Repeat, Topics
from mcpn.robot.drivers.processes import NOT_STARTED

MOST_SECONDS = 86_400
MOST_SHOWN = 100
WORDS: Mapping[type, str] = {
    str: "a text",
    int: "a whole number",
    bool: "true or false",
    dict: "a table",
    list: "a list of texts",
}


def typed(key: str, value: Any, kind: type) -> Any:
    """The value, if it is of a type.

    Raises:
        ValueError: It is of another.
    """
    if type(value) is not kind:
        raise ValueError(f"{key}: expected {WORDS[kind]}, found {shown(value)}")
    return value


def texts(key: str, value: Any) -> tuple[str, ...]:
    """A list of texts.

    Raises:
        ValueError: It is something else.
    """
    if not isinstance(value, list) or not all(isinstance(text, str) for text in value):
        raise ValueError(f"{key}: expected {WORDS[list]}, found {shown(value)}")
    return tuple(value)


def _of(kind: type) -> Callable[[str, Any], Any]:
    return lambda key, value: typed(key, value, kind)


def _up_to(most: int) -> Callable[[str, Any], int]:
    def read(key: str, value: Any) -> int:
        number: int = typed(key, value, int)
        if not 0 <= number <= most:
            raise ValueError(f"{key}: expected 0 to {most}, found {shown(value)}")
        return number

    return read


def _version(key: str, value: Any) -> int:
    if typed(key, value, int) not in (3, 5):
        raise ValueError(f"{key}: expected 5, or 3 for MQTT 3.1.1, found {shown(value)}")
    return int(value)


def _command(key: str, value: Any) -> tuple[str, ...]:
    command = texts(key, value)
    if not command or not command[0] or any("\0" in text for text in command):
        raise ValueError(f"{key}: expected a command and its arguments, found {shown(value)}")
    return command


def _function(key: str, value: Any) -> str:
    text: str = typed(key, value, str)
    if not re.fullmatch(r"[^\W\d][\w.]*:[^\W\d]\w*", text):
        raise ValueError(f"{key}: expected 'module:function', found {shown(text)}")
    return text


def _nothing(key: str, value: Any) -> bool:
    if value is not True:
        raise ValueError(f"{key}: expected true, found {shown(value)}")
    return True


def _topics(key: str, value: Any) -> Topics:
    table: dict[str, Any] = typed(key, value, dict)
    if not table or table.keys() - {"start", "stop", "says"}:
        raise ValueError(f"{key}: expected some of start, stop, says, found {', '.join(table) or 'none'}")
    return Topics(**{name: typed(f"{key}.{name}", text, str) for name, text in table.items()})


def _lines(key: str, value: Any) -> dict[str, str]:
    table: dict[str, Any] = typed(key, value, dict)
    for text, event in table.items():
        typed(f"{key}.{text!r}", event, str)
        try:
            re.compile(text)
        except (re.error, RecursionError) as error:
            column = (getattr(error, "pos", None) or 0) + 1
            said = f"found {text!r}, wrong at column {column}, expected a regular expression of Python"
            raise ValueError(f"{key}: {said}") from None
    return table


def _ends(key: str, value: Any) -> dict[str, str]:
    table: dict[str, Any] = typed(key, value, dict)
    return {how: typed(f"{key}.{how}", event, str) for how, event in table.items()}


def _repeat(key: str, value: Any) -> Repeat:
    for known in REPEATS:
        if value == known:
            return known
    raise ValueError(f"{key}: expected one of {', '.join(REPEATS)}, found {value!r}")


def _signal(key: str, value: Any) -> signal.Signals:
    try:
        return signal.Signals[typed(key, value, str)]
    except KeyError:
        raise ValueError(
            f"{key}: expected the name of a signal such as SIGTERM, found {shown(value)}"
        ) from None


def _seconds(key: str, value: Any) -> float:
    if type(value) not in (int, float) or not 0 <= value <= MOST_SECONDS:
        raise ValueError(f"{key}: expected seconds, from 0 to {MOST_SECONDS}, found {shown(value)}")
    return float(value)


def shown(value: Any) -> str:
    """A value in an error: not all of a long one, which Python may refuse to write."""
    try:
        text = repr(value)
    except ValueError:
        return "a number of too many digits"
    return text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]}..."


class DriverKey(NamedTuple):
    """What a key of a driver means.

    Args:
        value: How it is written.
        says: What it says.
        read: Makes what it says of its value.
        field: Of :class:`DriverSpec`, which it gives; ``""`` where it gives none.
        kinds: The drivers that it has a meaning for.
    """

    value: str
    says: str
    read: Callable[[str, Any], Any]
    field: str
    kinds: tuple[Kind, ...] = KINDS


OF_DRIVERS = {
    "process": DriverKey(
        '["program", "argument"]',
        "it is a process: started in the folder of the file, each in a group of its own",
        _command,
        "command",
    ),
    "python": DriverKey(
        '"module:function"',
        "a function, on a thread of its own, or a coroutine; modules beside the file are found",
        _function,
        "function",
    ),
    "mqtt": DriverKey(
        '{ start = "topic", stop = "topic", says = "topic" }',
        "something behind a broker: a message when it starts and one when it stops",
        _topics,
        "topics",
    ),
    "zenoh": DriverKey(
        '{ start = "key", stop = "key", says = "key" }', "the same with zenoh", _topics, "topics"
    ),
    "nothing": DriverKey("true", "nothing runs: other drivers tell its events", _nothing, ""),
    "lines": DriverKey(
        '{ "expression" = "event" }',
        "what a whole line tells: on a process's standard output, of `call.say`, of a message to `says`; the "
        "first regular expression that matches counts",
        _lines,
        "lines",
        ("process", "python", "mqtt", "zenoh"),
    ),
    "ends": DriverKey(
        '{ 0 = "event", other = "event" }',
        "what its end tells: the exit status of a process (negative: the signal), what a function returned "
        "(`true`, `none`, any text in small letters), `raised`, `not_started` (no such program, or it cannot "
        "be run)",
        _ends,
        "ends",
        ("process", "python"),
    ),
    "stop": DriverKey(
        '"SIGTERM"', "the signal that ends it, `SIGTERM` by default", _signal, "stop", ("process",)
    ),
    "grace": DriverKey(
        "5",
        f"the seconds after which its whole group is killed, 5 by default, {MOST_SECONDS:,} at most",
        _seconds,
        "grace",
    ),
    "repeat": DriverKey(
        '"fail"',
        "what becomes of an objective for which the driver had begun when a run was interrupted that is "
        '[gone on with](#going-on): `"fail"` (the default), `"safe"`, `"ask"`',
        _repeat,
        "repeat",
    ),
}
"""By key of a driver, what it means; in ``activities`` there may be ``alternatives``, too, each a driver."""

OPTIONS: Mapping[str, Mapping[str, Callable[[str, Any], Any]]] = {
    "mqtt": {
        "host": _of(str),
        "port": _up_to(65535),
        "keepalive": _up_to(65535),
        "qos": _up_to(2),
        "version": _version,
        "username": _of(str),
        "password": _of(str),
    },
    "zenoh": {"mode": _of(str), "connect": texts, "listen": texts, "multicast": _of(bool)},
}
"""By table of options their keys, each with what reads it."""

KNOWN = ("activities", "sources", "release", "never", *OPTIONS)
"""Keys of the whole file: tables of drivers by name, a list of events, options."""
EXIT = re.compile(rf"-?[0-9]+|{OTHER}|{NOT_STARTED}")
"""Ends of a process."""
