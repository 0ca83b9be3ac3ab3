"""Reads a file of drivers, and says in which line what is wrong with it."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mcpn.did_you_mean import did_you_mean
from mcpn.errors import InputError, Problem, Source
from mcpn.files import read_bounded
from mcpn.misread import of_toml
from mcpn.robot.drivers.known import EXIT, KNOWN, OF_DRIVERS, OPTIONS, shown, texts, typed
from mcpn.robot.drivers.mapping import KINDS, OTHER, DriverSpec, Kind, Place, Plan
from mcpn.robot.drivers.processes import NOT_STARTED

MAX_BYTES = 1 << 20


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
        line = data.count(b"\n", 0, error.start) + 1
        why = "found bytes that are not UTF-8, expected text in UTF-8"
        raise InputError.at(Source(str(path), line), why) from None
    except (ValueError, RecursionError) as error:  # ValueError also of a number with too many digits
        at = re.search(r"\(at line (\d+)", str(error))
        end = text.count("\n") + 1 if "end of document" in str(error) else None
        raise InputError.at(Source(str(path), int(at[1]) if at else end), of_toml(str(error))) from None
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
        self._known((), said, KNOWN)
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
            never = texts("never", said.get("never", []))
        return Plan(
            path,
            self.lines,
            activities,
            sources,
            releases,
            never,
            self._options(said, "mqtt"),
            self._options(said, "zenoh"),
        )

    def _specs(self, said: dict[str, Any], key: str) -> dict[str, DriverSpec]:
        found = ((name, self._spec((key, name), table, ())) for name, table in self._tables(said, key))
        return {name: spec for name, spec in found if spec is not None}

    def _tables(self, said: Any, key: str, above: Place = ()) -> list[tuple[str, dict[str, Any]]]:
        """The tables inside of one, which must all be tables."""
        found = said.get(key, {})
        if not isinstance(found, dict):
            self._wrong((*above, key), f"{key}: expected a table, found {shown(found)}")
            return []
        tables = []
        for name, table in found.items():
            if isinstance(table, dict):
                tables.append((name, table))
            else:
                self._wrong((*above, key, name), f"{key}.{name}: expected a table, found {shown(table)}")
        return tables

    def _known(self, place: Place, table: Mapping[str, Any], known: Collection[str]) -> None:
        for key in table:
            if key not in known:
                expected = f"expected one of {', '.join(known)}{did_you_mean(key, known)}"
                self._wrong((*place, key), f"found the key {key!r}, {expected}")

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
        self._known(place, own, (*OF_DRIVERS, *more))
        table = {**(around or {}), **own}
        kinds: list[Kind] = [kind for kind in KINDS if kind in table]
        if len(kinds) != 1:
            if kinds or needed:
                said = " and ".join(kinds) or "none"
                self._wrong(place, f"{'.'.join(place)}: expected one of {', '.join(KINDS)}, found {said}")
            return None
        (kind,) = kinds
        values: dict[str, Any] = {}
        for key, row in OF_DRIVERS.items():
            if key in table:
                here = (*place, key) if key in own else place[:2]
                with self._at(here):
                    values[row.field] = row.read(key, table[key])
                if kind not in row.kinds and key in own:
                    self._wrong(here, f"{key}: found it of {kind}, expected it of {' or '.join(row.kinds)}")
        if (
            kind == "process"
            and "ends" in own
            and (strange := [how for how in values.get("ends", ()) if not EXIT.fullmatch(how)])
        ):
            expected = f"an exit status, {OTHER} or {NOT_STARTED}"
            self._wrong((*place, "ends", strange[0]), f"ends: expected {expected}, found {strange[0]}")
        values.pop("", None)
        return DriverSpec(place, kind, **values)

    def _options(self, said: dict[str, Any], name: str) -> dict[str, Any]:
        """What a table of options says."""
        table, found = said.get(name, {}), dict[str, Any]()
        with self._at((name,)):
            self._known((name,), typed(name, table, dict), OPTIONS[name])
            for key in table.keys() & OPTIONS[name].keys():
                with self._at((name, key)):
                    found[key] = OPTIONS[name][key](key, table[key])
        return found


def _line(lines: Mapping[Place, int], place: Place) -> int:
    while place and place not in lines:
        place = place[:-1]
    return lines.get(place, 1)
