"""Property files of the Model Checking Contest: CTL, linear temporal logic, reachability and upper bounds.

Reference: the contest's manual of property files (https://mcc.lip6.fr/); namespace ``http://mcc.lip6.fr/``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from lxml import etree

from mcpn.errors import InputError, Source
from mcpn.logic.formulas import OPERATORS, Sum, compare, every_path, some_path, within_limit
from mcpn.logic.ltl.formulas import Next, Until, always, eventually, is_of_paths
from mcpn.spaces.names import Names
from mcpn.spaces.search.goal import DEADLOCK, FALSE, TRUE, Fires, Formula
from mcpn.xmlio import parse_xml

MAX_BYTES = 100_000_000
_NAMESPACE = "{http://mcc.lip6.fr/}"


@dataclass(frozen=True)
class Property:
    """One property of a file.

    Args:
        name: Its id.
        meaning: A formula; or places, where the most tokens that they hold together is asked.
        source: Its line.
    """

    name: str
    meaning: Formula | tuple[int, ...]
    source: Source


def read_properties(path: Path, names: Names) -> list[Property]:
    """The properties of a file, in its order.

    Raises:
        InputError: The file is no property file, or a name is unknown, with the line of what was found.
        LimitError: A formula is too large, see :func:`mcpn.logic.formulas.within_limit`.
    """
    root = parse_xml(path, MAX_BYTES)
    reader = _ContestReader(str(path), names)
    reader.expect(root, "property-set")
    return [reader.property(element) for element in root]


_ATOMS = {"true": TRUE, "false": FALSE, "deadlock": DEADLOCK}
_CONNECTIVES = {
    "negation": ("!", 1),
    "conjunction": ("&", None),
    "disjunction": ("|", None),
    "implication": ("->", 2),
    "equivalence": ("<->", 2),
    "exclusive-disjunction": ("xor", 2),
}
"""By element the operator, and the number of its operands where not any will do."""
_QUANTIFIERS = {"exists-path": "E", "all-paths": "A"}
_PATHS = {"finally": "F", "globally": "G", "next": "X", "until": "U"}
_ON_PATH: Mapping[str, Callable[..., Formula]] = {
    "finally": eventually,
    "globally": always,
    "next": Next,
    "until": Until,
}


class _ContestReader:
    def __init__(self, file: str, names: Names) -> None:
        self.file = file
        self.lookup = names
        self.asked = "", Source(file)  # the property that is being read

    def source(self, element: etree._Element) -> Source:
        return Source(self.file, cast(int, element.sourceline))

    def error(self, element: etree._Element, before: str, after: str) -> InputError:
        return InputError.at(self.source(element), f"{before}<{etree.QName(element).localname}>{after}")

    def tag(self, element: etree._Element) -> str:
        name = str(element.tag)
        return name.removeprefix(_NAMESPACE) if name.startswith(_NAMESPACE) else ""

    def expect(self, element: etree._Element, tag: str) -> None:
        if self.tag(element) != tag:
            raise self.error(element, "found ", f", expected <{tag}> of the namespace {_NAMESPACE[1:-1]}")

    def only(self, element: etree._Element, count: int | None = 1) -> list[etree._Element]:
        """The elements inside one, of which there must be so many."""
        if count not in (None, len(element)):
            raise self.error(element, "", f" holds {len(element)} elements, expected {count}")
        return list(element)

    def property(self, element: etree._Element) -> Property:
        self.expect(element, "property")
        parts = {self.tag(child): child for child in element}
        for tag in ("id", "formula"):
            if tag not in parts:
                raise InputError.at(self.source(element), f"a property without <{tag}>")
        name, (body,) = (parts["id"].text or "").strip(), self.only(parts["formula"])
        self.asked = name, self.source(element)
        if self.tag(body) == "place-bound":
            return Property(name, self.named(body, "place", self.lookup.place), self.source(element))
        return Property(name, within_limit(self.formula(body)), self.source(element))

    def formula(
        self, element: etree._Element, inside: Callable[[etree._Element], Formula] | None = None
    ) -> Formula:
        """A formula on states, or one that connectives make of what ``inside`` reads."""
        match self.tag(element):
            case tag if tag in _ATOMS:
                return _ATOMS[tag]
            case tag if tag in _CONNECTIVES:
                operator, count = _CONNECTIVES[tag]
                return OPERATORS[operator](*map(inside or self.formula, self.only(element, count)))
            case tag if tag in _QUANTIFIERS:
                return self.path(_QUANTIFIERS[tag], *self.only(element))
            case "is-fireable":
                return Fires(tuple(sorted({*self.named(element, "transition", self.lookup.transition)})))
            case "integer-le":
                small, large = map(self.sum, self.only(element, 2))
                return compare(small, "<=", large)
        raise self.error(element, "found ", ", expected a formula on states")

    def path(self, quantifier: str, element: etree._Element) -> Formula:
        tag = self.tag(element)
        operands = [self.on_path(part) for part in self.operands(element)] if tag in _PATHS else []
        if operands and not any(map(is_of_paths, operands)):
            return OPERATORS[quantifier + _PATHS[tag]](*operands)
        of_path = _ON_PATH[tag](*operands) if operands else self.on_path(element)
        return every_path(of_path) if quantifier == "A" else some_path(of_path)

    def on_path(self, element: etree._Element) -> Formula:
        """A formula on paths, or on states."""
        tag = self.tag(element)
        if tag in _PATHS:
            return _ON_PATH[tag](*map(self.on_path, self.operands(element)))
        return self.formula(element, self.on_path)

    def operands(self, element: etree._Element) -> list[etree._Element]:
        """What an operator on paths is applied to."""
        if self.tag(element) != "until":
            return self.only(element)
        parts = self.only(element, 2)
        for part, expected in zip(parts, ("before", "reach"), strict=True):
            self.expect(part, expected)
        return [inside for part in parts for inside in self.only(part)]

    def sum(self, element: etree._Element) -> Sum:
        match self.tag(element):
            case "integer-constant":
                text = (element.text or "").strip()
                if not re.fullmatch(r"-?[0-9]{1,18}", text):
                    message = f"found {text!r}, expected an integer of at most 18 digits"
                    raise InputError.at(self.source(element), message)
                return int(text), ()
            case "tokens-count":
                return 0, self.named(element, "place", self.lookup.place)
            case "integer-sum":
                parts = [self.sum(child) for child in element]
                return sum(constant for constant, _ in parts), tuple(p for _, places in parts for p in places)
        expected = "<tokens-count>, <integer-constant> or <integer-sum>"
        raise self.error(element, "found ", f", expected {expected}")

    def named(self, element: etree._Element, tag: str, lookup: Callable[[str], int]) -> tuple[int, ...]:
        for child in element:
            self.expect(child, tag)
        try:
            return tuple(lookup((child.text or "").strip()) for child in element)
        except InputError as error:
            name, source = self.asked
            raise InputError.at(source, f"{name}: {error}") from None
