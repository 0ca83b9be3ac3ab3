"""Writes the tables of docs/language.md from the schema of the mission language.

``python docs/tables.py`` renews them; a test says whether they are up to date.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

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
PAGE = Path(__file__).with_name("language.md")


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


def renewed(page: str) -> str:
    """The page with its tables written anew."""
    return re.sub(
        r"(<!-- table (\w+) -->\n).*?(<!-- end -->)",
        lambda match: f"{match[1]}{table(match[2])}\n{match[3]}",
        page,
        flags=re.DOTALL,
    )


if __name__ == "__main__":
    PAGE.write_text(renewed(PAGE.read_text()))
