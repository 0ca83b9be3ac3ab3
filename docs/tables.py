"""Writes what follows from declarations: the schema of missions, the tables of three pages.

The model of missions declares their language, :mod:`mcpn.report.documents` declares formats.
``python docs/tables.py`` renews what follows; a test says whether it is up to date.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import Any

from mcpn.drawing.templates.interface import MEETINGS
from mcpn.mission.language.forms import GROUPS, Field, form_of, inside, language, relax_ng
from mcpn.mission.model import BlockElement
from mcpn.mission.robot import Described, Element
from mcpn.mission.xml import SCHEMA
from mcpn.report.documents import FORMATS, json_schema

SHARED = {"common": (Element, Described), "routing": (BlockElement,)}
"""Attributes that several elements have, in tables of their own: by table, the classes that declare them."""
PAGES = [
    Path(__file__).with_name(name)
    for name in ("language.md", "patterns.md", "from-a-tree.md", "formats.md", "templates.md")
]


def rows(attributes: Iterable[Field], required: Collection[str]) -> list[str]:
    """The table of some attributes, with its head."""
    needed = {True: ", required", False: ""}
    lines = [
        f"| `{a.tag}` | {a.datatype.words}{needed[a.tag in required]} | {a.meaning} |" for a in attributes
    ]
    return ["| attribute | value | meaning |", "|---|---|---|", *lines] if lines else []


def table(name: str) -> str:
    """The table of an element, or of attributes that several elements have."""
    if owners := SHARED.get(name):
        shared = [a for a in form_of(owners[0]).attributes if a.owner in owners]
        return "\n".join(rows(shared, [a.tag for a in shared if a.required]))
    tag = language()[name]
    own = rows((a for a in tag.attributes.values() if a.owner not in GROUPS), tag.required)
    children = ", ".join(dict.fromkeys(f"`<{child.TAG}>`" for of in tag.forms for child in inside(of)))
    return "\n".join([tag.words, "", *own, *(["", f"Inside: {children}."] if children else [])])


def kind(node: dict[str, Any]) -> str:
    """The kind of value that a JSON Schema allows, in words."""
    if "$ref" in node:
        return f"*{node['$ref'].rpartition('/')[2]}*"
    if "const" in node:
        return f"`{json.dumps(node['const'])}`"
    if "enum" in node:
        return ", ".join(f"`{json.dumps(value)}`" for value in node["enum"])
    if "anyOf" in node:
        return " or ".join(kind(each) for each in node["anyOf"])
    types = node.get("type", "any")
    names = [types] if isinstance(types, str) else types
    return " or ".join("list" if name == "array" else name for name in names)


def keys(node: dict[str, Any], way: str, optional: bool) -> Iterator[str]:
    """A row for each key of a JSON value, those inside others too."""
    if way and "description" in node:
        yield f"| `{way}`{' (optional)' if optional else ''} | {kind(node)} | {node['description']} |"
    for key, inner in node.get("properties", {}).items():
        yield from keys(inner, f"{way}.{key}".lstrip("."), key not in node.get("required", ()))
    if isinstance(inner := node.get("additionalProperties"), dict):
        yield from keys(inner, f"{way}.*".lstrip("."), False)
    if isinstance(inner := node.get("items"), dict):
        yield from keys(inner, f"{way}[]", False)


def format_table(name: str) -> str:
    """The tables of one JSON format, parts that it names after it."""
    schema = json_schema(FORMATS[name])
    head = ["| key | value | meaning |", "|---|---|---|"]
    lines = [f"`{schema['title']}`: {schema['description']}", "", *head, *keys(schema, "", False)]
    for part, node in schema.get("$defs", {}).items():
        lines += ["", f"*{part}*: {node['description']}", "", *head]
        lines += list(keys(node, "", False)) or [f"| | {kind(node)} | {node['description']} |"]
    return "\n".join(lines)


def contract(kind: str) -> str:
    """Who may do what to the parts of a kind of element that others touch."""
    lines = [f"| part of {kind} | says | who may |", "|---|---|---|"]
    for part, meeting in MEETINGS[kind].items():
        who = ", ".join(f"{side} {letters}" for side, letters in meeting.allowed.items())
        lines.append(f"| *{part}* | {meeting.says} | {who} |")
    return "\n".join(lines)


def renewed(page: str) -> str:
    """The page with its tables written anew."""
    kinds = (("table", r"\w+", table), ("format", r"[\w-]+", format_table), ("contract", r"\w+", contract))
    for word, name, make in kinds:
        page = re.sub(
            rf"(<!-- {word} ({name}) -->\n).*?(<!-- end -->)",
            lambda match, make=make: f"{match[1]}{make(match[2])}\n{match[3]}",  # type: ignore[misc]
            page,
            flags=re.DOTALL,
        )
    return page


if __name__ == "__main__":
    SCHEMA.write_text(relax_ng())
    for path in PAGES:
        path.write_text(renewed(path.read_text()))
