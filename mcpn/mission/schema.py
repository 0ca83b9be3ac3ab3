"""The schema of the mission language, and its complaints in words that say what was found and expected.

libxml2 tells little of a RELAX NG failure, so elements and attributes are compared with the schema once more
to find what is wrong; the schema itself remains the one definition and the one judge.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from lxml import etree

from mcpn.mission.near import did_you_mean

RNG = "{http://relaxng.org/ns/structure/1.0}"
NAMESPACE = "urn:mcpn:mission:1"
ROOTS = ("mission", "robot", "protocols")
BLOCKS = ("objective", "parallel", "use", "each")


@dataclass
class _Rule:
    """What the schema allows on one element."""

    required: set[str] = field(default_factory=set)
    patterns: dict[str, str | None] = field(default_factory=dict)
    children: set[str] = field(default_factory=set)


@cache
def _document() -> etree._ElementTree:
    with Path(__file__).with_name("schema.rng").open("rb") as file:
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
        yield from _misplaced(element)
        if parent is not None:
            outer = etree.QName(parent).localname
            allowed = rules[outer].children if outer in rules else {tag}
            if tag not in allowed or etree.QName(element).namespace != NAMESPACE:
                expected = ", ".join(f"<{name}>" for name in sorted(allowed)) or "nothing"
                yield line, f"found <{tag}> inside <{outer}>, expected {expected}{did_you_mean(tag, allowed)}"
                continue
        rule = rules.get(tag, _Rule())
        for name, value in ((str(key), str(text)) for key, text in element.attrib.items()):
            if name not in rule.patterns:
                known = sorted(rule.patterns)
                found = f"found the attribute {name} on <{tag}>, expected one of {', '.join(known)}"
                yield line, f"{found}{did_you_mean(name, known)}"
            elif (pattern := rule.patterns[name]) and not re.fullmatch(pattern, value, re.ASCII):
                yield line, f"{name} of <{tag}> is {value!r}, expected {_expected(pattern)}"
        for name in sorted(rule.required - set(element.attrib)):
            yield line, f"<{tag}> has no attribute {name}, which is required"


def _expected(pattern: str) -> str:
    """What a pattern of the schema asks for, in words."""
    if "true" in pattern:
        return "true or false"
    if "eE" in pattern:
        return "a decimal number of at least 0, for example 12 or 2.5e-4"
    if "{1,6}" in pattern:
        return "a whole number of at most 6 digits"
    if "[A-Za-z0-9_]+(" in pattern:
        return "values of letters, digits and _, separated by spaces"
    if r"\s+" in pattern:
        return "names of letters, digits and _, separated by spaces"
    return "letters, digits and _, no digit first, at most 255 characters"


def _misplaced(element: etree._Element) -> Iterator[tuple[int, str]]:
    """What is allowed by itself, but not where or with what it stands."""
    tag, line = etree.QName(element).localname, _line(element)
    children = [etree.QName(child).localname for child in element]
    for where, text in ((element, element.text), *((child, child.tail) for child in element)):
        if text and text.strip():
            yield _line(where), f"found the text {text.strip()[:40]!r} inside <{tag}>, expected elements only"
    blocks = [child for child in children if child in BLOCKS]
    if tag in ("mission", "protocol", "parallel", "each"):
        first = children.index(blocks[0]) if blocks else len(children)
        for child, name in zip(list(element)[first:], children[first:], strict=True):
            if name not in BLOCKS and name in _rules()[tag].children:
                yield (
                    _line(child),
                    f"found <{name}> after a block of <{tag}>, expected before its first block",
                )
    rule = _rules().get(tag, _Rule())
    if any(name not in rule.children for name in children) or any(
        a not in rule.patterns for a in element.attrib
    ):
        return  # what is not known, of which something is said, may have been meant as what is missing
    if tag in ("mission", "protocol", "parallel", "each") and not blocks:
        expected = ", ".join(f"<{name}>" for name in BLOCKS if name in _rules()[tag].children)
        yield line, f"<{tag}> has no blocks, expected one of {expected} inside"
    if tag == "objective" and bool(blocks) == ("activities" in element.attrib):
        found = "both activities and blocks" if blocks else "neither activities nor blocks"
        yield line, f"<objective> has {found}, expected activities (elementary) or blocks (recursive)"
    if tag == "objective" and blocks:
        for name in ("duration", "failure_probability"):
            if name in element.attrib:
                yield (
                    line,
                    f"<objective> has {name} and blocks, expected {name} on elementary objectives only",
                )
    if tag == "activity" and "consumes" in element.attrib and "alternative" in children:
        yield line, "<activity> has both consumes and <alternative>, expected consumes on the alternatives"


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
