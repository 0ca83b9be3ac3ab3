"""Property files of the Model Checking Contest: CTL, reachability and upper bounds.

Reference: the contest's manual of property files (https://mcc.lip6.fr/); namespace ``http://mcc.lip6.fr/``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from lxml import etree

from mcpn.check.logic.formulas import (
    And,
    Compare,
    Const,
    Deadlock,
    Derived,
    Enabled,
    Formula,
    Not,
    Or,
    Sum,
    temporal,
)
from mcpn.errors import InputError, Source
from mcpn.xmlio import parse_xml

MAX_BYTES = 100_000_000
_NAMESPACE = "{http://mcc.lip6.fr/}"


@dataclass(frozen=True)
class Property:
    """One property of a file.

    Args:
        name: Its id.
        formula: What is asked, or ``None`` where a bound is.
        bound: Places, where the most tokens that they hold together is asked.
        source: Its line.
    """

    name: str
    formula: Formula | None
    bound: tuple[str, ...]
    source: Source


def read_properties(path: Path) -> list[Property]:
    """Reads a property file.

    Args:
        path: The file.

    Returns:
        Its properties, in its order; names of places and transitions are not looked up yet.

    Raises:
        InputError: The file is no property file, with the line of what was found.
    """
    root = parse_xml(path, MAX_BYTES)
    reader = _Reader(str(path))
    reader.expect(root, "property-set")
    return [reader.property(element) for element in root]


_QUANTIFIERS = {"exists-path": "E", "all-paths": "A"}
_OPERATORS = {"finally": "F", "globally": "G", "next": "X"}
_CONNECTIVES = {"implication": "->", "equivalence": "<->"}


class _Reader:
    def __init__(self, file: str) -> None:
        self.file = file

    def source(self, element: etree._Element) -> Source:
        return Source(self.file, cast(int, element.sourceline))

    def wrong(self, element: etree._Element, expected: str) -> InputError:
        found = etree.QName(element).localname
        return InputError.at(self.source(element), f"found <{found}>, expected {expected}")

    def tag(self, element: etree._Element) -> str:
        name = str(element.tag)
        return name.removeprefix(_NAMESPACE) if name.startswith(_NAMESPACE) else ""

    def expect(self, element: etree._Element, tag: str) -> None:
        if self.tag(element) != tag:
            raise self.wrong(element, f"<{tag}> of the namespace {_NAMESPACE[1:-1]}")

    def only(self, element: etree._Element, count: int = 1) -> list[etree._Element]:
        children = list(element)
        if len(children) != count:
            found = etree.QName(element).localname
            message = f"<{found}> holds {len(children)} elements, expected {count}"
            raise InputError.at(self.source(element), message)
        return children

    def property(self, element: etree._Element) -> Property:
        self.expect(element, "property")
        parts = {self.tag(child): child for child in element}
        for tag in ("id", "formula"):
            if tag not in parts:
                raise InputError.at(self.source(element), f"a property without <{tag}>")
        name, (body,) = (parts["id"].text or "").strip(), self.only(parts["formula"])
        if self.tag(body) == "place-bound":
            return Property(name, None, self.names(body, "place"), self.source(element))
        return Property(name, self.formula(body), (), self.source(element))

    def formula(self, element: etree._Element) -> Formula:
        match self.tag(element):
            case "true" | "false" as value:
                return Const(value == "true")
            case "negation":
                return Not(self.formula(*self.only(element)))
            case "conjunction":
                return And(tuple(map(self.formula, element)))
            case "disjunction":
                return Or(tuple(map(self.formula, element)))
            case "implication" | "equivalence" as connective:
                return Derived(_CONNECTIVES[connective], tuple(map(self.formula, self.only(element, 2))))
            case "exclusive-disjunction":
                return Not(Derived("<->", tuple(map(self.formula, self.only(element, 2)))))
            case "exists-path" | "all-paths" as quantifier:
                return self.path(_QUANTIFIERS[quantifier], *self.only(element))
            case "is-fireable":
                return Enabled(self.names(element, "transition"))
            case "deadlock":
                return Deadlock()
            case "integer-le":
                small, large = map(self.sum, self.only(element, 2))
                return Compare(small, "<=", large)
        raise self.wrong(element, "a formula on states")

    def path(self, quantifier: str, element: etree._Element) -> Formula:
        tag = self.tag(element)
        if tag == "until":
            before, reach = self.only(element, 2)
            self.expect(before, "before")
            self.expect(reach, "reach")
            inside = (self.formula(*self.only(part)) for part in (before, reach))
            return temporal(f"{quantifier}U", *inside)
        if tag in _OPERATORS:
            return temporal(quantifier + _OPERATORS[tag], self.formula(*self.only(element)))
        raise self.wrong(element, "<finally>, <globally>, <next> or <until>")

    def sum(self, element: etree._Element) -> Sum:
        match self.tag(element):
            case "integer-constant":
                text = (element.text or "").strip()
                if not re.fullmatch(r"-?[0-9]{1,18}", text):
                    raise InputError.at(
                        self.source(element), f"found {text!r}, expected an integer of at most 18 digits"
                    )
                return Sum(int(text))
            case "tokens-count":
                return Sum(0, self.names(element, "place"))
            case "integer-sum":
                parts = [self.sum(child) for child in element]
                return Sum(sum(p.constant for p in parts), tuple(n for p in parts for n in p.places))
        raise self.wrong(element, "<tokens-count>, <integer-constant> or <integer-sum>")

    def names(self, element: etree._Element, tag: str) -> tuple[str, ...]:
        for child in element:
            self.expect(child, tag)
        return tuple((child.text or "").strip() for child in element)
