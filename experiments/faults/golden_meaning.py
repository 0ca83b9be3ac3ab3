"""What two answers of one command differ in: by text, and by meaning where their text may change."""

from __future__ import annotations

import csv
import json
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from experiments.faults.golden_trees import fault_tree

PURPOSE = Path(__file__).with_name("golden_purpose.toml")
VOLATILE = {"seconds", "version", "memory", "digest", "nodes", "peak", "peak_nodes", "order", "generator"}
"""Keys of JSON objects whose values are no answers."""
UNTOLD = re.compile(r"\d+(\.\d+)? (s|ms|seconds)\b|/\S+/|TIME\S*|TECHNIQUES.*|\d{4}-\d\d-\d\dT\S+")
"""Words of texts that are no answers: times and folders."""
PLAYED = re.compile(r"(^|/)controller/")
"""Files whose text may change while what they do does not: ``golden_play.py`` plays them."""
NEAR = 1e-9
"""Numbers that differ by less, relative to the larger, are equal."""


@dataclass(frozen=True)
class Renamed:
    """Words of older answers that newer ones say in others.

    Args:
        pattern: The older words.
        by: The newer ones.
        page: Words of the changelog that say so.
        file: Of which files, by a regular expression.
        side: ``old``, or ``new`` where words are left out of the newer answers.
    """

    pattern: re.Pattern[str]
    by: str
    page: str
    file: re.Pattern[str]
    side: str = "old"


@dataclass(frozen=True)
class Purpose:
    """Places that differ on purpose.

    Args:
        command: Of which commands, by a regular expression, as all but the page are.
        subject: Of which missions and nets.
        where: At which places of which files.
        old: What was answered.
        new: What is.
        page: Words of the changelog that say so.
    """

    command: re.Pattern[str]
    subject: re.Pattern[str]
    where: re.Pattern[str]
    old: re.Pattern[str]
    new: re.Pattern[str]
    page: str

    def holds(self, found: Difference) -> bool:
        """Whether a difference is such a place."""
        return bool(
            self.command.match(found.command)
            and self.subject.match(found.subject)
            and self.where.match(found.where)
            and self.old.match(str(found.old))
            and self.new.match(str(found.new))
        )


@dataclass(frozen=True)
class Difference:
    """One place where two answers differ.

    Args:
        subject: The mission or net.
        command: What was asked, as the folder of its answer is called.
        where: The file, and the place in it.
        old: What was answered there.
        new: What is.
    """

    subject: str
    command: str
    where: str
    old: Any
    new: Any

    @property
    def kind(self) -> str:
        """The command and the place, without numbers."""
        asked = re.match(r"[a-z]+", self.command)
        return f"{asked[0] if asked else ''} {re.sub(r'[0-9]+', 'N', self.where)}"

    def __str__(self) -> str:
        old, new = str(self.old)[:150], str(self.new)[:150]
        return f"{self.subject}/{self.command}/{self.where}: {old!r} -> {new!r}"


@lru_cache
def expected(path: Path = PURPOSE) -> tuple[tuple[Renamed, ...], tuple[Purpose, ...]]:
    """What a file says of words that are others now, and of places that differ on purpose."""
    said = tomllib.loads(path.read_text())
    renamed = tuple(
        Renamed(
            re.compile(each["pattern"]),
            each["by"],
            each["page"],
            re.compile(each.get("file", "")),
            each.get("side", "old"),
        )
        for each in said.get("renamed", ())
    )
    keys = ("command", "subject", "where", "old", "new")
    purposes = tuple(
        Purpose(**{key: re.compile(each.get(key, ""), re.DOTALL) for key in keys}, page=each["page"])
        for each in said.get("purpose", ())
    )
    return renamed, purposes


def plain(value: Any) -> Any:
    """A JSON value without what is no answer."""
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items() if key not in VOLATILE}
    if isinstance(value, str):
        return re.sub(r"/\S+/", "", value)
    return [plain(inner) for inner in value] if isinstance(value, list) else value


def read(file: Path, renamed: Sequence[Renamed] = ()) -> Any:
    """What a file says: a JSON value, a fault tree, the rows of a table by their keys, or lines of text.

    Args:
        file: The file.
        renamed: Words that are said in others now.
    """
    text, words = file.read_text(), [each for each in renamed if each.file.search(file.name)]
    if text.startswith(("{", "[")):
        try:
            return said(plain(json.loads(text)), words)
        except ValueError:
            pass
    if file.name == "openpsa.xml":
        return fault_tree(file)
    if file.suffix == ".csv":
        rows = csv.DictReader(text.splitlines())
        return [{key: _alternatives(said(cell, words)) for key, cell in row.items()} for row in rows]
    return [said(UNTOLD.sub("", line), words) for line in text.splitlines()]


def said(value: Any, renamed: Sequence[Renamed]) -> Any:
    """A value in the words that are said now.

    >>> said({"x_EV": ["x_EV", 1]}, [Renamed(re.compile("_EV$"), "", "", re.compile(""))])
    {'x': ['x', 1]}
    """
    if isinstance(value, dict):
        return {said(key, renamed): said(inner, renamed) for key, inner in value.items()}
    if isinstance(value, list):
        return [said(inner, renamed) for inner in value]
    for each in renamed if isinstance(value, str) else ():
        value = each.pattern.sub(each.by, value)
    return value


def _alternatives(cell: str) -> str:
    """A cell whose alternatives are each said once, in one order."""
    return "; or ".join(sorted({*cell.split("; or ")}))


def differences(old: Any, new: Any, where: str = "") -> Iterator[tuple[str, Any, Any]]:
    """All places where two values differ; objects may have more keys than before.

    >>> list(differences({"a": [1, 2]}, {"a": [1, 3], "b": 0}))
    [('.a[1]', 2, 3)]
    >>> list(differences([0.1 + 0.2, {"a": 1}], [0.3, {}]))
    [('[1].a', 1, None)]
    """
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for key in old:
            yield from differences(old[key], new.get(key), f"{where}.{key}")
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for number, (one, other) in enumerate(zip(old, new, strict=True)):
            yield from differences(one, other, f"{where}[{number}]")
    elif old != new and not _near(old, new):
        yield where, old, new


def _near(old: Any, new: Any) -> bool:
    numbers = all(isinstance(each, int | float) and not isinstance(each, bool) for each in (old, new))
    return numbers and abs(old - new) <= NEAR * max(1.0, abs(old), abs(new))


def of_answers(old: Path, new: Path, subject: str, renamed: Sequence[Renamed] = ()) -> Iterator[Difference]:
    """Where two answers differ that one command has given: what is printed, the exit code, files.

    Args:
        old: The folder of the older answer.
        new: That of the newer.
        subject: Of what it was asked.
        renamed: Words of the older one that are others now.
    """
    codes = [(folder / "code").read_text() for folder in (old, new)]
    if codes[0] != codes[1]:
        yield Difference(subject, new.name, "code", *codes)
        return
    names = {str(path.relative_to(of)) for of in (old, new) for path in of.rglob("*") if path.is_file()}
    for name in sorted(names):
        if PLAYED.search(name):
            continue
        if not (old / name).exists() or not (new / name).exists():
            yield Difference(subject, new.name, name, (old / name).exists(), (new / name).exists())
            continue
        before, now = ([each for each in renamed if each.side == side] for side in ("old", "new"))
        for where, one, other in differences(read(old / name, before), read(new / name, now)):
            yield Difference(subject, new.name, name + where, one, other)
