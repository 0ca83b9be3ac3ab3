"""Reads a file of drivers, and says in which line what is wrong with it."""

from __future__ import annotations

import json
import re
import signal
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mcpn.drivers.mapping import (
    FAILURE,
    KINDS,
    OTHER,
    REPEATS,
    SUCCESS,
    DriverSpec,
    Kind,
    Place,
    Plan,
    Repeat,
    Topics,
    endings,
)
from mcpn.errors import InputError, Problem, Source
from mcpn.files import read_bounded
from mcpn.mission.did_you_mean import did_you_mean
from mcpn.runtime.tables import START, Tables

MAX_BYTES = 1 << 20
MOST_SECONDS = 86_400
MOST_SHOWN = 100
TOP = ("activities", "sources", "release", "never", "mqtt", "zenoh")
COMMON = (*KINDS, "lines", "ends", "stop", "grace", "repeat")
MQTT: Mapping[str, type] = {
    "host": str,
    "port": int,
    "keepalive": int,
    "qos": int,
    "version": int,
    "username": str,
    "password": str,
}
ZENOH = ("mode", "connect", "listen", "multicast")
WORDS: Mapping[type, str] = {
    str: "a text",
    int: "a whole number",
    bool: "true or false",
    dict: "a table",
    list: "a list of texts",
}


def read_drivers(path: Path) -> Plan:
    """Reads a file of drivers.

    Raises:
        InputError: It is not valid TOML, or says what no such file says: every mistake with its line.
    """
    data = read_bounded(path, MAX_BYTES)
    try:
        text = data.decode()
        said = tomllib.loads(text)
        lines = lines_of(text)
    except UnicodeDecodeError as error:
        raise InputError.at(Source(str(path), data.count(b"\n", 0, error.start) + 1), "not UTF-8") from None
    except (ValueError, RecursionError) as error:  # ValueError also of a number with too many digits
        at = re.search(r"\(at line (\d+)", str(error))
        end = text.count("\n") + 1 if "end of document" in str(error) else None
        why, _, _ = str(error).partition("; use sys.")  # advice to who writes Python
        raise InputError.at(Source(str(path), int(at[1]) if at else end), f"not valid TOML: {why}") from None
    reader = _DriversReader(lines)
    plan = reader.plan(path, said)
    if reader.problems:
        raise InputError(
            sorted(Problem(Source(str(path), line), message) for line, message in reader.problems)
        )
    return plan


def lines_of(text: str) -> dict[Place, int]:
    """By the keys that lead to a value, the line that it begins in.

    Each statement is read by itself, below the head of the table that it stands in: time is linear.

    Args:
        text: Of a TOML file.
    """
    found: dict[Place, int] = {}
    head = ""
    for begun, statement in _statements(text):
        top = statement.lstrip().startswith("[")
        if top:
            head = statement
        for place in _places(tomllib.loads(statement if top else head + statement)):
            found.setdefault(place, begun)
    return found


_TOKEN = re.compile(
    r'#[^\n]*|"""(?:[^\\]|\\.)*?"""(?!")|\'\'\'.*?\'\'\'(?!\')|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'|[][{}\n]',
    re.DOTALL,
)
"""Comments, texts, brackets, ends of lines."""


def _statements(text: str) -> Iterator[tuple[int, str]]:
    """The statements of a file with their lines: brackets and texts may hold several lines together."""
    begin = depth = 0
    number = begun = 1
    for token in _TOKEN.finditer(text + "\n"):
        if token[0] in "[{":
            depth += 1
        elif token[0] in "]}":
            depth -= 1
        number += token[0].count("\n")
        if token[0] == "\n" and not depth:
            yield begun, text[begin : token.end()]
            begin, begun = token.end(), number


def _places(said: Any, above: Place = ()) -> Iterator[Place]:
    for key, value in said.items():
        yield (*above, key)
        if isinstance(value, dict):
            yield from _places(value, (*above, key))


class _DriversReader:
    def __init__(self, lines: Mapping[Place, int]) -> None:
        self.lines = lines
        self.problems: list[tuple[int, str]] = []

    def _wrong(self, place: Place, message: str) -> None:
        self.problems.append((_line(self.lines, place), message))

    @contextmanager
    def _at(self, place: Place) -> Iterator[None]:
        """Notes what is wrong with one value, and lets the next one be read."""
        try:
            yield
        except ValueError as error:
            self._wrong(place, str(error))

    def plan(self, path: Path, said: dict[str, Any]) -> Plan:
        self._known((), said, TOP)
        activities: dict[tuple[str, str | None], DriverSpec] = {}
        for name, table in self._tables(said, "activities"):
            place: Place = ("activities", name)
            ways = self._tables(table, "alternatives", place)
            if spec := self._spec(place, table, ("alternatives",), needed=not ways):
                activities[name, None] = spec
            for way, inner in ways:
                own = {key: value for key, value in table.items() if key != "alternatives"}
                if any(kind in inner for kind in KINDS):
                    own = {key: value for key, value in own.items() if key not in KINDS}
                if spec := self._spec((*place, "alternatives", way), inner, (), around=own):
                    activities[name, way] = spec
        sources = self._specs(said, "sources")
        releases = self._specs(said, "release")
        never: tuple[str, ...] = ()
        with self._at(("never",)):
            never = _texts("never", said.get("never", []))
        return Plan(
            path, self.lines, activities, sources, releases, never, self._mqtt(said), self._zenoh(said)
        )

    def _specs(self, said: dict[str, Any], key: str) -> dict[str, DriverSpec]:
        found = ((name, self._spec((key, name), table, ())) for name, table in self._tables(said, key))
        return {name: spec for name, spec in found if spec is not None}

    def _tables(self, said: Any, key: str, above: Place = ()) -> list[tuple[str, dict[str, Any]]]:
        """The tables inside of one, which must all be tables."""
        found = said.get(key, {})
        if not isinstance(found, dict):
            self._wrong((*above, key), f"{key}: expected a table, found {_shown(found)}")
            return []
        tables = []
        for name, table in found.items():
            if isinstance(table, dict):
                tables.append((name, table))
            else:
                self._wrong((*above, key, name), f"{key}.{name}: expected a table, found {_shown(table)}")
        return tables

    def _known(self, place: Place, table: Mapping[str, Any], known: tuple[str, ...]) -> None:
        for key in table:
            if key not in known:
                hint = did_you_mean(key, known) or f", expected one of {', '.join(known)}"
                self._wrong((*place, key), f"unknown key {key!r}{hint}")

    def _spec(
        self,
        place: Place,
        own: dict[str, Any],
        more: tuple[str, ...],
        *,
        around: Mapping[str, Any] | None = None,
        needed: bool = True,
    ) -> DriverSpec | None:
        """A driver, with what the table around it says and its own does not."""
        self._known(place, own, (*COMMON, *more))
        table = {**(around or {}), **own}
        kinds: list[Kind] = [kind for kind in KINDS if kind in table]
        if len(kinds) != 1:
            if kinds or needed:
                said = " and ".join(kinds) or "none"
                self._wrong(place, f"{'.'.join(place)}: expected one of {', '.join(KINDS)}, found {said}")
            return None
        (kind,) = kinds
        values: dict[str, Any] = {}

        def read(key: str, name: str, make: Callable[[str, Any], Any]) -> None:
            if key in table:
                with self._at((*place, key) if key in own else place[:2]):
                    values[name] = make(key, table[key])

        read("process", "command", _command)
        read("python", "function", _function)
        read("nothing", "nothing", _nothing)
        read(kind if kind in ("mqtt", "zenoh") else "", "topics", _topics)
        read("lines", "lines", _lines)
        read("ends", "ends", _ends)
        read("stop", "stop", _signal)
        read("grace", "grace", _seconds)
        read("repeat", "repeat", _repeat)
        if "stop" in table and kind != "process":
            self._wrong((*place, "stop"), f"stop: a signal is for a process, not for {kind}")
        if "ends" in table and kind not in ("process", "python"):
            self._wrong((*place, "ends"), f"ends: {kind} does not end by itself")
        values.pop("nothing", None)
        return DriverSpec(place, kind, **values)

    def _mqtt(self, said: dict[str, Any]) -> dict[str, str | int]:
        table, found = said.get("mqtt", {}), dict[str, str | int]()
        with self._at(("mqtt",)):
            self._known(("mqtt",), _typed("mqtt", table, dict), tuple(MQTT))
            for key, value in table.items():
                with self._at(("mqtt", key)):
                    if key in MQTT:
                        found[key] = _typed(key, value, MQTT[key])
        for key, most in (("port", 65535), ("qos", 2), ("keepalive", 65535)):
            if isinstance(found.get(key), int) and not 0 <= int(found[key]) <= most:
                self._wrong(("mqtt", key), f"{key}: expected 0 to {most}, found {_shown(found[key])}")
        if isinstance(found.get("version"), int) and found["version"] not in (3, 5):
            shown = _shown(found["version"])
            self._wrong(("mqtt", "version"), f"version: expected 5, or 3 for MQTT 3.1.1, found {shown}")
        return found

    def _zenoh(self, said: dict[str, Any]) -> dict[str, bool | str | tuple[str, ...]]:
        table, found = said.get("zenoh", {}), dict[str, bool | str | tuple[str, ...]]()
        with self._at(("zenoh",)):
            self._known(("zenoh",), _typed("zenoh", table, dict), ZENOH)
            for key, value in table.items():
                with self._at(("zenoh", key)):
                    kind = {"mode": str, "multicast": bool}.get(key)
                    found[key] = _texts(key, value) if kind is None else _typed(key, value, kind)
        return found


def _line(lines: Mapping[Place, int], place: Place) -> int:
    while place and place not in lines:
        place = place[:-1]
    return lines.get(place, 1)


def _typed(key: str, value: Any, kind: type) -> Any:
    if type(value) is not kind:
        raise ValueError(f"{key}: expected {WORDS[kind]}, found {_shown(value)}")
    return value


def _texts(key: str, value: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(text, str) for text in value):
        raise ValueError(f"{key}: expected {WORDS[list]}, found {_shown(value)}")
    return tuple(value)


def _command(key: str, value: Any) -> tuple[str, ...]:
    command = _texts(key, value)
    if not command or not command[0] or any("\0" in text for text in command):
        raise ValueError(f"{key}: expected a command and its arguments, found {_shown(value)}")
    return command


def _function(key: str, value: Any) -> str:
    text: str = _typed(key, value, str)
    if not re.fullmatch(r"[^\W\d][\w.]*:[^\W\d]\w*", text):
        raise ValueError(f"{key}: expected 'module:function', found {_shown(text)}")
    return text


def _nothing(key: str, value: Any) -> bool:
    if value is not True:
        raise ValueError(f"{key}: expected true, found {_shown(value)}")
    return True


def _topics(key: str, value: Any) -> Topics:
    table: dict[str, Any] = _typed(key, value, dict)
    if not table or table.keys() - {"start", "stop", "says"}:
        raise ValueError(f"{key}: expected some of start, stop, says, found {', '.join(table) or 'none'}")
    return Topics(**{name: _typed(f"{key}.{name}", text, str) for name, text in table.items()})


def _lines(key: str, value: Any) -> dict[str, str]:
    table: dict[str, Any] = _typed(key, value, dict)
    for text, event in table.items():
        _typed(f"{key}.{text!r}", event, str)
        try:
            re.compile(text)
        except (re.error, RecursionError) as error:
            raise ValueError(f"{key}: {text!r} is no regular expression: {error}") from None
    return table


def _ends(key: str, value: Any) -> dict[str, str]:
    table: dict[str, Any] = _typed(key, value, dict)
    return {how: _typed(f"{key}.{how}", event, str) for how, event in table.items()}


def _repeat(key: str, value: Any) -> Repeat:
    for known in REPEATS:
        if value == known:
            return known
    raise ValueError(f"{key}: expected one of {', '.join(REPEATS)}, found {value!r}")


def _signal(key: str, value: Any) -> signal.Signals:
    try:
        return signal.Signals[_typed(key, value, str)]
    except KeyError:
        raise ValueError(
            f"{key}: expected the name of a signal such as SIGTERM, found {_shown(value)}"
        ) from None


def _seconds(key: str, value: Any) -> float:
    if type(value) not in (int, float) or not 0 <= value <= MOST_SECONDS:
        raise ValueError(f"{key}: expected seconds, from 0 to {MOST_SECONDS}, found {_shown(value)}")
    return float(value)


def _shown(value: Any) -> str:
    """A value in an error: not all of a long one, which Python may refuse to write."""
    try:
        text = repr(value)
    except ValueError:
        return "a number of too many digits"
    return text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]}..."


# A file of drivers to start from: each activity of a mission is a program that is still to be written.

HEAD = """# What each activity of {mission} is, and where each event comes from: see docs/drivers.md.
# Write the programs, or name what there is (python = "module:function", mqtt = {{ ... }}); then
#   mcpn run MISSION --drivers FILE --check
# says what is still missing.

# Events that nothing on this robot tells. One that a driver tells is taken out here and named there,
# in its lines = {{ "what it prints" = "event" }} or ends = {{ other = "event" }}.
never = [{never}]
"""


def skeleton(tables: Tables) -> str:
    """The text of a file of drivers for a mission's controller; what is missing are the programs."""
    events = sorted(e for e in tables.known if not e.startswith("OBJ_") and e != START)
    never = "".join(f"\n    {_text(event)}," for event in events)
    rows = [HEAD.format(mission=tables.mission, never=f"{never}\n" if never else "")]
    ends = endings(tables.known)
    activities = ("\n".join(_activity(tables, name, ends)) + "\n" for name in tables.laws.activities)
    return "\n".join((*rows, *activities))


def _activity(tables: Tables, name: str, ends: Mapping[str, Mapping[str, str]]) -> Iterator[str]:
    laws = tables.laws
    row = laws.activities[name]
    objectives = [objective for objective, said in laws.objectives.items() if name in said["activities"]]
    given = [
        {value.name for value in laws.of(name, way, objective)}
        for way in row["alternatives"]
        for objective in (*objectives,) or (None,)
    ]
    command = [f"./{name}", *(("{alternative}",) if len(row["alternatives"]) > 1 else ())]
    # "--x={x}", not "{x}": a value such as -1.5 would be an option of the program.
    command += [
        f"--{hole}={{{hole}}}" for hole in sorted(set.intersection(*given)) if re.fullmatch(r"\w+", hole)
    ]
    yield f"[activities.{_key(name)}]"
    if objectives:
        shown = ", ".join(objectives[:5]) + (f" and {len(objectives) - 5} others" if objectives[5:] else "")
        yield f"# of the objectives {shown}"
    if consumed := sorted({what for way in row["alternatives"].values() for what in way["consumes"]}):
        yield f"# consumes {', '.join(consumed)}"
    yield f"process = [{', '.join(map(_text, command))}]"
    if objectives:
        words = {word for objective in objectives for word in ends.get(objective, {}).values()}
        reasons = enumerate(sorted(words - {SUCCESS, FAILURE}), 3)
        named = "".join(f', {number} = "{word}"' for number, word in reasons)
        yield f'ends = {{ 0 = "{SUCCESS}"{named}, {OTHER} = "{FAILURE}" }}'
        yield 'repeat = "fail" # or "safe": it may be begun again when a run that was interrupted goes on'


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
