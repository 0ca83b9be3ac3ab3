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

from mcpn.answers.claims import KINDS
from mcpn.drawing.templates.interface import MEETINGS
from mcpn.logic.contest import KNOWN as OF_PROPERTIES
from mcpn.mission.language.forms import GROUPS, Field, form_of, inside, language
from mcpn.mission.language.relax_ng import relax_ng
from mcpn.mission.misfits import SCHEMA
from mcpn.mission.model import BlockElement
from mcpn.mission.requirement import Absence
from mcpn.mission.robot import Described, Element
from mcpn.nets.formats.pnml import KNOWN as OF_PNML
from mcpn.nets.formats.pnml import REMARKS
from mcpn.nets.formats.tina import ARCS, DECLARATIONS
from mcpn.report.documents import FORMATS, json_schema
from mcpn.report.documents.asked import NAMED
from mcpn.report.documents.bench import ESTIMATED
from mcpn.report.documents.graphs import ANSWERED
from mcpn.report.documents.nets import ENGINE
from mcpn.robot.drivers.known import OF_DRIVERS
from mcpn.robot.drivers.mapping import KINDS as KINDS_OF_DRIVERS
from mcpn.robot.runtime.documents import PLACE, REQUIREMENT, STATE
from mcpn.robot.runtime.shapes import Document, ObjectOf
from mcpn.trees.nodes.table import TABLE
from mcpn.trees.nodes.versions import NAMES

SHARED = {"common": (Element, Described), "routing": (BlockElement,)}
"""Attributes that several elements have, in tables of their own: by table, the classes that declare them."""
SCOPED = next(a.owner for a in form_of(Absence).attributes if a.tag == "until")
"""Declares the scope of a pattern, which the page on patterns tells of all together."""
GROUPED = {
    of: json_schema(Document("", "", ObjectOf("", keys)))["properties"]
    for of, keys in (
        ("answer", ANSWERED),
        ("requirement", REQUIREMENT),
        ("state", STATE),
        ("named", NAMED),
        ("estimate", ESTIMATED),
        ("place", PLACE),
        ("engine", ENGINE.keys),
    )
}
"""Keys that several formats share, by what they are told as."""
MOST_PLAIN = 3
"""Words that say of a member no more than what it is."""
KNOWN = {"pnml": OF_PNML, "remarks": REMARKS, "properties": OF_PROPERTIES}
"""Tables of what readers of XML know, by what pages call them."""
HEAD = ("| key | meaning |", "|---|---|")
PAGES = [
    Path(__file__).with_name(name)
    for name in (
        "language.md",
        "patterns.md",
        "from-a-tree.md",
        "formats.md",
        "nets.md",
        "drivers.md",
        "templates.md",
        "claims.md",
    )
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
    own = rows((a for a in tag.attributes.values() if a.owner not in (*GROUPS, SCOPED)), tag.required)
    children = ", ".join(dict.fromkeys(f"`<{child.TAG}>`" for of in tag.forms for child in inside(of)))
    return "\n".join([tag.words, "", *own, *(["", f"Inside: {children}."] if children else [])])


def kind(node: dict[str, Any], many: bool = False) -> str:
    """The kind of value that a JSON Schema allows, in words.

    Args:
        node: The schema.
        many: Whether several are spoken of.
    """
    if "$ref" in node:
        return f"*{node['$ref'].rpartition('/')[2]}*"
    if "const" in node:
        return f"`{json.dumps(node['const'])}`"
    if "enum" in node:
        return ", ".join(f"`{json.dumps(value)}`" for value in node["enum"])
    if "anyOf" in node:
        return " or ".join(kind(each, many) for each in node["anyOf"])
    types = node.get("type", "any")
    names = [types] if isinstance(types, str) else types
    plural = "s" if many else ""
    said = [f"{'list' if name == 'array' else name}{plural if name != 'null' else ''}" for name in names]
    inner, _ = inner_of(node)
    of = "" if inner is None else kind(inner, many=True)
    if of not in ("", "strings"):
        said[0] += f" of {of}"
    return " or ".join(said)


def has_keys(node: dict[str, Any]) -> bool:
    """Whether rows of its own keys follow it, so that they say what it is."""
    inner, _ = inner_of(node)
    return "properties" in node or (inner is not None and has_keys(inner))


def inner_of(node: dict[str, Any]) -> tuple[dict[str, Any] | None, str]:
    """What the members of a list or a map are, and what its key is called; nothing of other values."""
    for word, called in (("items", "[]"), ("additionalProperties", ".*")):
        if isinstance(inner := node.get(word), dict):
            return inner, called
    return None, ""


def meaning(node: dict[str, Any]) -> str:
    """What a value means, and what its members do where that is more than what they are."""
    inner, _ = inner_of(node)
    said = node.get("description", "")
    own = meaning(inner) if inner else ""
    return " ".join(filter(None, (said, own if len(own.split()) > MOST_PLAIN or not said else "")))


def keys(node: dict[str, Any], way: str, optional: bool) -> Iterator[str]:
    """A row for each key of a JSON value, those inside others too; members of lists and maps have none."""
    properties, shared = node.get("properties", {}), list[str]()
    for name, group in GROUPED.items():
        if (way or len(group) < len(properties)) and group.items() <= properties.items():
            shared.append(f"The keys of *{name}*.")
            properties = {key: of for key, of in properties.items() if key not in group}
    said = "" if not way or way.endswith(("]", "*")) else meaning(node)
    alone = way and not way.endswith(("]", "*")) and not has_keys(node)
    if said or shared or alone:
        told = " ".join(filter(None, (said, *shared)))
        of = "null too" * ("null" in node["type"]) if shared or has_keys(node) else kind(node)
        of = ": ".join(part for part in ("" if of == "string" else of, told) if part)
        yield f"| {f'`{way}`' * bool(way)}{'?' * optional} | {of} |"
    for key, of in properties.items():
        yield from keys(of, f"{way}.{key}".lstrip("."), key not in node.get("required", ()))
    for each in node.get("anyOf", ()):
        yield from keys(each, way, False)
    inner, called = inner_of(node)
    if inner is not None:
        yield from keys(inner, f"{way}{called}".lstrip("."), False)


def format_table(name: str) -> str:
    """The tables of one JSON format, parts that it names after it."""
    if name == "many":
        return "\n\n".join("\n".join((f"*{of}*", "", *HEAD, *plain(group))) for of, group in GROUPED.items())
    schema = json_schema(FORMATS[name])
    lines = [f"`{schema['title']}`: {meaning(schema)}"]
    for each in schema.get("anyOf", [schema]):
        lines += ["", *([meaning(each), ""] if each is not schema else []), *HEAD, *keys(each, "", False)]
    for part, node in schema.get("$defs", {}).items():
        lines += ["", f"*{part}*: {'' if (of := kind(node)) == 'object' else f'{of}: '}{meaning(node)}"]
        if inside := [*keys(node, "", False)]:
            lines += ["", *HEAD, *inside]
    return "\n".join(lines)


def plain(group: dict[str, Any]) -> Iterator[str]:
    """The rows of keys that several formats share."""
    for key, of in group.items():
        yield from keys(of, key, False)


def contract(kind: str) -> str:
    """Who may do what to the parts of a kind of element that others touch."""
    lines = [f"| part of {kind} | says | who may |", "|---|---|---|"]
    for part, meeting in MEETINGS[kind].items():
        who = ", ".join(f"{side} {letters}" for side, letters in meeting.allowed.items())
        lines.append(f"| *{part}* | {meeting.says} | {who} |")
    return "\n".join(lines)


def known(name: str) -> str:
    """What a reader of XML knows: by element what it reads, what may only say so, what is without meaning."""
    lines = ["| element | read | with these values alone | without meaning |", "|---|---|---|---|"]
    for element, row in KNOWN[name].items():
        read, only, ignored = list[str](), list[str](), list[str]()
        for sign, words in (("{}", row.attributes), ("<{}>", row.inside)):
            for word in words.split():
                inner, _, values = word.removeprefix("-").partition("=")
                told = f"`{sign.format(inner)}`"
                if word.startswith("-"):
                    ignored.append(told)
                elif values:
                    allowed = " or ".join(f"`{value.replace('_', ' ')}`" for value in values.split("|"))
                    only.append(f"{told}: {allowed}")
                else:
                    read.append(told)
        if not row.text:
            cells = (f"`<{element}>`", *(", ".join(each) for each in (read, only, ignored)))
            lines.append(f"| {' | '.join(cells)} |".replace("  ", " "))
    return "\n".join(lines)


def nodes(library: str) -> str:
    """The table of the nodes of a library; those that are alike share a row."""
    alike: dict[tuple[str, ...], list[str]] = {}
    for row in (row for row in TABLE if row.library == library):
        ports = "not checked" if row.ports is None else ", ".join(map(str, row.ports.values()))
        versions = row.where.removeprefix(f"{NAMES[library]} ")
        refused = f"refused: {row.rule}" if row.exact == "refused" else row.exact
        alike.setdefault((versions, ports, row.outcome, refused), []).append(f"`{row.node}`")
    lines = ["| node | versions | ports | outcome | translation |", "|---|---|---|---|---|"]
    lines += [f"| {' | '.join((', '.join(names), *cells))} |" for cells, names in alike.items()]
    return "\n".join(lines)


def claims(_: str) -> str:
    """The table of the kinds of claims."""
    heads = ("kind", "formula", "where it holds", "where it fails", "shown by", "told by")
    rows_ = [heads, ("---",) * len(heads)]
    for each in KINDS.values():
        formula = f"`{each.formula}`".replace("|", "\\|") if each.formula else f"none: {each.why}"
        rows_.append(
            (
                f"`{each.name}`",
                formula,
                each.holds.replace("{given}", ","),
                each.fails,
                each.evidence,
                ", ".join(each.shown),
            )
        )
    return "\n".join(f"| {' | '.join(row)} |" for row in rows_)


def drivers(_: str) -> str:
    """The table of what a driver may say in a file of drivers."""
    lines = ["| key | says | of drivers |", "|---|---|---|"]
    for key, row in OF_DRIVERS.items():
        which = "" if row.kinds == KINDS_OF_DRIVERS or key in KINDS_OF_DRIVERS else ", ".join(row.kinds)
        lines.append(f"| `{key} = {row.value}` | {row.says} | {which} |")
    return "\n".join(lines)


def declarations(_: str) -> str:
    """The declarations and the arcs of TINA's nets."""
    lines = ["| declaration | means |", "|---|---|"]
    lines += [f"| `{how}` | {says} |" for how, says in DECLARATIONS.values()]
    lines += ["", "| arc | means |", "|---|---|"]
    lines += [f"| `NAME{sign}{'WEIGHT' if sign else ''}` | {says} |" for sign, says in ARCS.items()]
    return "\n".join(lines)


def renewed(page: str) -> str:
    """The page with its tables written anew."""
    kinds = (
        ("table", r"\w+", table),
        ("format", r"[\w-]+", format_table),
        ("contract", r"\w+", contract),
        ("known", r"\w+", known),
        ("nodes", r"\w+", nodes),
        ("claims", r"\w+", claims),
        ("drivers", r"\w+", drivers),
        ("declarations", r"\w+", declarations),
    )
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
