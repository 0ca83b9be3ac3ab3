"""Checks files as they are read back: digest, declaration, and whether numbers and names of a controller fit.

A file that passes runs without an error of Python, whatever events come. That it is the file which was
generated is what its digest says (:func:`digest_of`).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

from mcpn.robot.runtime.documents import CONTROLLER, CONTROLLER_RULES, ENDS, FORMAT, FORMS, MODES, VERSION
from mcpn.robot.runtime.shapes import JsonShape, Misfit


class DamagedFile(ValueError):
    """A file that mcpn has written is read back, and is damaged, truncated, or of something else."""


class ControllerFileError(DamagedFile):
    """A file is no controller, or no monitors, that this runtime can run."""


MOST_BITS = 1_000_000
"""Bits of a state of rules at most, so that no file can fill the memory."""


def parsed(text: bytes | str, error: type[DamagedFile] = ControllerFileError) -> dict[str, Any]:
    """The JSON object that a text is: the one way in for all that this runtime reads back.

    Args:
        text: The text; bytes are UTF-8.
        error: What is raised.

    Raises:
        DamagedFile: It is no JSON object, whatever is wrong with it.
    """
    try:
        document = json.loads(text)
    except (ValueError, RecursionError, OverflowError) as wrong:
        raise error(f"no JSON: {_misread(wrong)}, expected a JSON object") from wrong
    if not isinstance(document, dict):
        raise error(f"found {json.dumps(document)[:40]}, expected a JSON object")
    return document


def _misread(wrong: Exception) -> str:
    """What was found that is no JSON, and where."""
    if isinstance(wrong, json.JSONDecodeError):
        found = wrong.doc[wrong.pos : wrong.pos + 20].split("\n")[0] or "the end"
        return f"line {wrong.lineno}, column {wrong.colno}: found {found!r}"
    if isinstance(wrong, UnicodeDecodeError):
        return f"found bytes that are not UTF-8, at byte {wrong.start + 1}"
    return "found a number of too many digits, or lists and objects too deep in each other"


def check_digest(document: Mapping[str, Any]) -> str:
    """Holds a document against the digest in it.

    Returns:
        The digest.

    Raises:
        ControllerFileError: It has none, or one of another text.
    """
    try:
        found = digest_of(document)
    except (ValueError, RecursionError, OverflowError) as wrong:  # what no file says, but an object may
        raise ControllerFileError(f"it has no digest: {wrong}") from wrong
    if document.get("digest") != found:
        raise ControllerFileError("its digest is of another text: it has been changed since it was written")
    return found


def signed_line(document: Mapping[str, Any]) -> str:
    """An object as one line of JSON, with the digest of all else in it at its end; one in it is left out."""
    text = json.dumps({key: value for key, value in document.items() if key != "digest"})
    digest = hashlib.sha256(text.encode()).hexdigest()
    return f'{text[:-1]}, "digest": "{digest}"}}'


def _canonical(value: Any) -> Iterator[str]:
    yield _CANONICAL(value)


_CANONICAL = json.JSONEncoder(sort_keys=True, ensure_ascii=False, separators=(",", ":")).encode


def digest_of(document: Mapping[str, Any], canonical: Callable[[Any], Iterator[str]] = _canonical) -> str:
    """The digest of a controller: SHA-256 of its JSON text without ``digest``, keys sorted, no spaces.

    Args:
        document: The controller's.
        canonical: Makes this text of values, piece by piece.
    """
    found = hashlib.sha256()
    for piece in _pieces({key: value for key, value in document.items() if key != "digest"}, 2, canonical):
        found.update(piece.encode("utf-8", "surrogatepass"))
    return found.hexdigest()


def _pieces(value: Any, depth: int, canonical: Callable[[Any], Iterator[str]]) -> Iterator[str]:
    """The text piece by piece, so that the text of a large controller is never in memory as a whole."""
    if not depth or not isinstance(value, dict | list):
        yield from canonical(value)
        return
    keyed = isinstance(value, dict)
    yield "{" if keyed else "["
    for number, item in enumerate(sorted(value) if keyed else value):
        yield "," if number else ""
        if keyed:
            yield _CANONICAL(item) + ":"
        yield from _pieces(value[item] if keyed else item, depth - 1, canonical)
    yield "}" if keyed else "]"


def check_shape(document: Any) -> None:
    """Holds a controller's file against the schema.

    Args:
        document: The JSON value.

    Raises:
        ControllerFileError: Something in it is not what is expected; the message says where.
    """
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise ControllerFileError(f"expected an object whose format is {FORMAT}")
    version = document.get("version")
    if type(version) is not int or version != VERSION:
        raise ControllerFileError(f"version {version!r} found, {VERSION} expected")
    rules = document.get("form") == FORMS[-1]
    fits(document, (CONTROLLER_RULES if rules else CONTROLLER).shape)
    exits = []
    for number, row in enumerate(document["types"]):
        where = f"types[{number}]"
        (_check_rules if rules else _check_machine)(row, where)
        left = {edge["to"] for edge in row["effects" if rules else "edges"]}
        exits.append({outcome for outcome in left if type(outcome) is str})
    for number, row in enumerate(document["sections"]):
        where = f"sections[{number}]"
        _below(row["type"], len(exits), f"{where}.type")
        _check_section(row, document, where)
        for outcome in exits[row["type"]]:
            _member(outcome, row["routes"], f"{where}.routes")
    known = {section["name"] for section in document["sections"]}
    if len(known) < len(document["sections"]):
        raise ControllerFileError("sections: two have one name")
    _member(document["initial"], known, "initial")
    for key in ("out_of_service", "unrepairable", "crashing"):
        for name in document[key]:
            _member(name, document["hardware"], key)
    for name in document["late"]:
        _member(name, document["hardware"], "late")
    flags = {
        flag
        for values in document["facts"].values()
        for flags_of_value in values.values()
        for flag in flags_of_value
    }
    for event, change in document["changing"].items():
        for flag in (*change["true"], *change["false"]):
            _member(flag, flags, f"changing.{event}")
    targets = known | ENDS.keys()
    for number, row in enumerate(document["sections"]):
        for route in row["routes"].values():
            _member(route, targets, f"sections[{number}].routes")


def fits(document: Any, shape: JsonShape, error: type[DamagedFile] = ControllerFileError) -> None:
    """Holds a document against its declaration.

    Args:
        document: The JSON value.
        shape: What it must be.
        error: What is raised.

    Raises:
        DamagedFile: Something in it is not what is expected; the message says where.
    """
    try:
        shape.check(document)
    except Misfit as wrong:
        raise error(str(wrong)) from None


def _wrong(value: Any, where: str, expected: str) -> ControllerFileError:
    return ControllerFileError(f"{where}: found {repr(value)[:80]}, expected {expected}")


def _below(value: int, limit: int, where: str) -> None:
    if value >= limit:
        raise _wrong(value, where, f"a number from 0, less than {limit}")


def _member(value: str, known: Collection[str], where: str) -> None:
    if value not in known:
        raise _wrong(value, where, "a name that is there")


def _check_machine(row: Mapping[str, Any], where: str) -> None:
    states, events, once = len(row["states"]), len(row["events"]), set(row["once"])
    facts = row["facts"]
    _below(row["entering"], len(facts) + 1, f"{where}.entering")
    if len(row["entries"]) != 1 << len(row["hardware"]) + row["entering"]:
        raise _wrong(len(row["entries"]), f"{where}.entries", "one for each state of the hardware and facts")
    for number, entry in enumerate(row["entries"]):
        if entry is not None:
            _below(entry["to"], states, f"{where}.entries[{number}].to")
            for flag in (*entry["gained"], *entry["lost"]):
                _member(flag, facts, f"{where}.entries[{number}]")
    for number, edge in enumerate(row["edges"]):
        at = f"{where}.edges[{number}]"
        _below(edge["from"], states, f"{at}.from")
        _below(edge["event"], events, f"{at}.event")
        if type(edge["to"]) is not str:
            _below(edge["to"], states, f"{at}.to")
        for key in ("open", "happened"):
            for handler in edge[key]:
                _member(handler, once, f"{at}.{key}")
        for key in ("gained", "lost"):
            for flag in edge[key]:
                _member(flag, facts, f"{at}.{key}")


def _check_rules(row: Mapping[str, Any], where: str) -> None:
    bits, effects, events = row["bits"], len(row["effects"]), len(row["events"])
    _below(bits, MOST_BITS + 1, f"{where}.bits")
    changing = (*row["status"], *row["effects"])
    named_bits = [*row["idle"], *(bit for item in changing for bit in item["changes"])]
    literals = [item["when"] for item in (*row["status"], *row["shown"])]
    literals += [literal for rule in (*row["entries"], *row["rules"]) for literal in rule["if"]]
    for bit in named_bits:
        _below(bit, bits, f"{where}: a bit")
    for literal in literals:
        _below(literal, 2 * bits, f"{where}: a literal")
    for number, effect in enumerate(row["effects"]):
        for part in effect["then"]:
            _below(part, len(row["parts"]), f"{where}.effects[{number}].then")
    for number, part in enumerate(row["parts"]):
        for rule in part:
            at = f"{where}.parts[{number}]"
            _below(rule["do"], effects, f"{at}.do")
            if row["effects"][rule["do"]]["then"]:
                raise _wrong(rule["do"], f"{at}.do", "an effect that goes on with no part")
            for literal in rule["if"]:
                _below(literal, 4 * bits, f"{at}: a literal")
            _check_once(rule["if"], f"{at}.if")
    carried = len(row["hardware"]) + len(row["once"]) + len(row["facts"])
    if len(row["status"]) != carried:
        raise _wrong(len(row["status"]), f"{where}.status", "one for each of hardware, handlers, facts")
    for number, rule in enumerate((*row["entries"], *row["rules"])):
        at = f"{where}.entries and rules[{number}]"
        _below(rule["do"], effects, f"{at}.do")
        _below(rule.get("event", 0), max(events, 1), f"{at}.event")
        _check_once(rule["if"], f"{at}.if")
    for number, shown in enumerate(row["shown"]):
        if shown["kind"] in MODES and "." not in shown["name"]:
            raise _wrong(shown["name"], f"{where}.shown[{number}].name", "activity.alternative")


def _check_once(literals: Collection[int], where: str) -> None:
    if len({literal >> 1 for literal in literals}) < len(literals):
        raise _wrong(literals, where, "no bit twice")


def _check_section(row: Mapping[str, Any], document: Mapping[str, Any], where: str) -> None:
    type_ = document["types"][row["type"]]
    if len(row["events"]) != len(type_["events"]):
        raise _wrong(len(row["events"]), f"{where}.events", f"{len(type_['events'])} events, as its type has")
    for old, new in row["names"].get("alternatives", {}).items():
        if "." not in new or "." not in old:
            raise _wrong(new, f"{where}.names.alternatives", "activity.alternative")
    own = row["names"].get("hardware", {})
    for name in type_["hardware"]:
        _member(own.get(name, name), document["hardware"], f"{where}: hardware")
