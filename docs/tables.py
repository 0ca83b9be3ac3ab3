"""Writes tables of docs: of language.md from the schema of missions, of formats.md from JSON Schemas.

``python docs/tables.py`` renews them; a test says whether they are up to date.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

from lxml import etree

RNG = "{http://relaxng.org/ns/structure/1.0}"
NOTE = "{http://relaxng.org/ns/compatibility/annotations/1.0}documentation"
SHARED = ("common", "routing", "description")
"""Attributes that several elements have stand in tables of their own."""
VALUES = {
    "name": "name",
    "names": "names",
    "values": "values",
    "number": "number",
    "count": "whole number",
    "boolean": "true or false",
}
PAGES = [Path(__file__).with_name(name) for name in ("language.md", "formats.md")]


def schema() -> dict[str, etree._Element]:
    """The definitions of the schema by name."""
    with resources.files("mcpn.mission").joinpath("schema.rng").open("rb") as file:
        root = etree.parse(file).getroot()
    return {define.get("name", ""): define for define in root.iter(f"{RNG}define")}


def note(element: etree._Element) -> str:
    """The documentation of an element or attribute, on one line."""
    found = element.find(NOTE)
    return " ".join((found.text or "").split()) if found is not None else ""


def attributes(node: etree._Element, optional: bool = False) -> Iterator[tuple[str, bool, str, str]]:
    """Name, whether it may be left out, kind of value and meaning of each attribute written in a node."""
    for child in node:
        if child.tag == f"{RNG}attribute":
            reference = child.find(f"{RNG}ref")
            value = VALUES[reference.get("name", "")] if reference is not None else "text"
            yield child.get("name", ""), optional, value, note(child)
        elif child.tag in (f"{RNG}optional", f"{RNG}choice"):
            yield from attributes(child, True)
        elif isinstance(child.tag, str) and child.tag != f"{RNG}element":
            yield from attributes(child, optional)


def children(node: etree._Element, defines: dict[str, etree._Element]) -> Iterator[str]:
    """Names of the elements that may stand in one."""
    for reference in node.iter(f"{RNG}ref"):
        define = defines[reference.get("name", "")]
        if define.find(f"{RNG}element") is not None:
            yield reference.get("name", "")
        elif define.get("name") not in (*SHARED, *VALUES):
            yield from children(define, defines)


def table(name: str) -> str:
    """The table of an element, or of attributes that several elements share."""
    defines = schema()
    define = defines[name]
    element = define.find(f"{RNG}element")
    lines = []
    if element is not None:
        lines += [note(element), ""]
    rows = list(attributes(define if element is None else element))
    if name == "common":
        rows += attributes(defines["description"])
    if rows:
        lines += ["| attribute | | value | meaning |", "|---|---|---|---|"]
        lines += [
            f"| `{attribute}` | {'optional' if optional else 'required'} | {value} | {meaning} |"
            for attribute, optional, value, meaning in rows
        ]
    if element is not None:
        inside = ", ".join(f"`<{child}>`" for child in dict.fromkeys(children(element, defines)))
        lines += [""] * bool(rows) + [f"Inside: {inside}." if inside else "Inside: nothing."]
    return "\n".join(lines)


def formats() -> dict[str, dict[str, Any]]:
    """The JSON Schemas of what commands print and write, by name."""
    folder = resources.files("mcpn.report").joinpath("schemas")
    files = sorted(folder.iterdir(), key=lambda file: file.name)
    return {file.name.removesuffix(".json"): json.loads(file.read_text("utf-8")) for file in files}


def kind(node: dict[str, Any]) -> str:
    """The kind of value that a JSON Schema allows, in words."""
    if "$ref" in node:
        return f"*{node['$ref'].rpartition('/')[2]}*"
    if "const" in node:
        return f"`{json.dumps(node['const'])}`"
    if "enum" in node:
        return ", ".join(f"`{json.dumps(value)}`" for value in node["enum"])
    types = node.get("type", "any")
    names = [types] if isinstance(types, str) else types
    return " or ".join("list" if name == "array" else name for name in names)


def keys(node: dict[str, Any], way: str, optional: bool) -> Iterator[str]:
    """A row for each key of a JSON value, those inside others too."""
    if way and "description" in node:
        yield f"| `{way}` | {'optional' if optional else ''} | {kind(node)} | {node['description']} |"
    for key, inner in node.get("properties", {}).items():
        yield from keys(inner, f"{way}.{key}".lstrip("."), key not in node.get("required", ()))
    if isinstance(inner := node.get("additionalProperties"), dict):
        yield from keys(inner, f"{way}.*".lstrip("."), False)
    if isinstance(inner := node.get("items"), dict):
        yield from keys(inner, f"{way}[]", False)


def format_table(name: str) -> str:
    """The tables of one JSON format, parts that it names after it."""
    schema = formats()[name]
    head = ["| key | | value | meaning |", "|---|---|---|---|"]
    lines = [f"`{schema['title']}`: {schema['description']}", "", *head, *keys(schema, "", False)]
    for part, node in schema.get("$defs", {}).items():
        lines += ["", f"*{part}*: {node['description']}", "", *head]
        lines += list(keys(node, "", False)) or [f"| | | {kind(node)} | {node['description']} |"]
    return "\n".join(lines)


def renewed(page: str) -> str:
    """The page with its tables written anew."""
    for word, name, make in (("table", r"\w+", table), ("format", r"[\w-]+", format_table)):
        page = re.sub(
            rf"(<!-- {word} ({name}) -->\n).*?(<!-- end -->)",
            lambda match, make=make: f"{match[1]}{make(match[2])}\n{match[3]}",  # type: ignore[misc]
            page,
            flags=re.DOTALL,
        )
    return page


if __name__ == "__main__":
    for path in PAGES:
        path.write_text(renewed(path.read_text()))
