"""The schema of the mission language, and its complaints in words that say what was found and expected.

libxml2 tells little of a RELAX NG failure, so elements and attributes are compared with the schema once more
to find what is wrong; the schema itself remains the one definition and the one judge.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from importlib import resources

from lxml import etree

RNG = "{http://relaxng.org/ns/structure/1.0}"
NAMESPACE = "urn:mcpn:mission:1"
ROOTS = ("mission", "robot", "protocols")


@dataclass
class _Rule:
    """What the schema allows on one element."""

    required: set[str] = field(default_factory=set)
    patterns: dict[str, str | None] = field(default_factory=dict)
    children: set[str] = field(default_factory=set)


@cache
def _document() -> etree._ElementTree:
    with resources.files("mcpn.mission").joinpath("schema.rng").open("rb") as file:
        return etree.parse(file)


@cache
def _validator() -> etree.RelaxNG:
    return etree.RelaxNG(_document())


def find_misfits(root: etree._Element) -> list[tuple[int, str]]:
    """What in a document does not fit the schema.

    Args:
        root: The root element of a mission, robot or protocols file.

    Returns:
        Lines and messages; empty where the document is valid.
    """
    name = etree.QName(root)
    if name.namespace != NAMESPACE or name.localname not in ROOTS:
        found = f"expected a mission file (namespace {NAMESPACE}), found the root element {root.tag}"
        return [(_line(root), found)]
    validator = _validator()
    if validator.validate(root):
        return []
    told = list(_misfits(root))
    if told:
        return told
    lines = {entry.line for entry in validator.error_log} or {_line(root)}
    return [(_line(e), _contents(e)) for e in root.iter() if _line(e) in lines][:1] or [
        (min(lines), "does not fit the mission language")
    ]


def _line(element: etree._Element) -> int:
    line = element.sourceline
    return line if isinstance(line, int) else 1


@cache
def _rules() -> dict[str, _Rule]:
    grammar = _document().getroot()
    defines = {define.get("name", ""): define for define in grammar.iter(f"{RNG}define")}
    rules: dict[str, _Rule] = {}
    for element in grammar.iter(f"{RNG}element"):
        rule = rules[element.get("name", "")] = _Rule()
        for child in element:
            _collect(child, defines, rule, optional=False)
    return rules


def _collect(
    node: etree._Element, defines: dict[str, etree._Element], rule: _Rule, *, optional: bool
) -> None:
    kind = etree.QName(node).localname
    if kind == "element":
        rule.children.add(node.get("name", ""))
    elif kind == "attribute":
        name = node.get("name", "")
        rule.patterns[name] = _pattern(node, defines)
        if not optional:
            rule.required.add(name)
    elif kind == "ref":
        for child in defines[node.get("name", "")]:
            _collect(child, defines, rule, optional=optional)
    else:
        for child in node:
            _collect(child, defines, rule, optional=optional or kind in ("optional", "choice"))


def _pattern(node: etree._Element, defines: dict[str, etree._Element]) -> str | None:
    for reference in node.iter(f"{RNG}ref"):
        return _pattern(defines[reference.get("name", "")], defines)
    for data in node.iter(f"{RNG}data"):
        if data.get("type") == "boolean":
            return r"\s*(true|false|1|0)\s*"
        return next((param.text for param in data.iter(f"{RNG}param")), None)
    return None


def _misfits(root: etree._Element) -> Iterator[tuple[int, str]]:
    rules = _rules()
    for element in root.iter():
        tag, line = etree.QName(element).localname, _line(element)
        parent = element.getparent()
        if parent is not None:
            outer = etree.QName(parent).localname
            allowed = rules[outer].children if outer in rules else {tag}
            if tag not in allowed or etree.QName(element).namespace != NAMESPACE:
                expected = ", ".join(f"<{name}>" for name in sorted(allowed)) or "nothing"
                yield line, f"found <{tag}> inside <{outer}>, expected {expected}"
                continue
        rule = rules.get(tag, _Rule())
        for name, value in ((str(key), str(text)) for key, text in element.attrib.items()):
            if name not in rule.patterns:
                known = ", ".join(sorted(rule.patterns))
                yield line, f"found the attribute {name} on <{tag}>, expected one of {known}"
            elif (pattern := rule.patterns[name]) and not re.fullmatch(pattern, value):
                expected = "true or false" if "true" in pattern else "letters, digits and _, no digit first"
                yield line, f"{name} of <{tag}> is {value!r}, expected {expected}"
        for name in sorted(rule.required - set(element.attrib)):
            yield line, f"<{tag}> has no attribute {name}, which is required"


def _contents(element: etree._Element) -> str:
    tag = etree.QName(element).localname
    rule = _rules().get(tag, _Rule())
    found = (
        ", ".join(dict.fromkeys(f"<{etree.QName(child).localname}>" for child in element)) or "no children"
    )
    expected = ", ".join(f"<{name}>" for name in sorted(rule.children))
    optional = ", ".join(sorted(rule.patterns.keys() - rule.required))
    return (
        f"<{tag}> with {', '.join(map(str, element.attrib)) or 'no attributes'} and {found} does not fit; "
        f"expected children among {expected or 'none'}, or an attribute among {optional or 'none'}"
    )
