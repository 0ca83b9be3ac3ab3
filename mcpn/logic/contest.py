"""Property files of the Model Checking Contest: CTL, linear temporal logic, reachability and upper bounds.

Read in the contest's own namespace and in that of TAPAAL, which has more relations, differences, products and
examinations among its properties. What the tables here do not have is refused.

Reference: the contest's manual of property files (https://mcc.lip6.fr/); verifypn's parser of queries
(https://github.com/TAPAAL/verifypn).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from lxml import etree

from mcpn.declared import Declared, ElementRule, ElementTable, name_of, refuse, source_of
from mcpn.errors import InputError, Problem, Source
from mcpn.logic.formulas import OPERATORS, every_path, some_path, within_limit
from mcpn.logic.ltl.formulas import Next, Until, always, eventually, is_of_paths
from mcpn.logic.polynomials import Polynomial, added, multiplied, related
from mcpn.records import record
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.goal import DEADLOCK, FALSE, TRUE, And, AtMost, Fires, Formula
from mcpn.xmlio import parse_xml

MAX_BYTES = 100_000_000
NAMESPACES = ("http://mcc.lip6.fr/", "http://tapaal.net/")


@record(frozen=True)
class Property:
    """One property of a file.

    Args:
        name: Its id.
        meaning: A formula; places, where the most tokens that they hold together is asked; or the name of an
            examination.
        source: Its line.
    """

    name: str
    meaning: Formula | tuple[int, ...] | str
    source: Source


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
_RELATIONS = {
    "integer-lt": "<",
    "integer-le": "<=",
    "integer-eq": "=",
    "integer-ne": "!=",
    "integer-ge": ">=",
    "integer-gt": ">",
}
_INTEGERS = ("integer-sum", "integer-difference", "integer-product")
_REACHED = {"invariant": "AG", "possibility": "EF", "impossibility": "EF"}
"""Elements of the contest's first years, the last with its negation."""
_EXAMINATIONS = {
    "liveness": "Liveness",
    "quasi-liveness": "QuasiLiveness",
    "stable-marking": "StableMarking",
}
_QUANTIFIERS = {"exists-path": "E", "all-paths": "A"}
_PATHS = {"finally": "F", "globally": "G", "next": "X", "until": "U"}
_ON_PATH: Mapping[str, Callable[..., Formula]] = {
    "finally": eventually,
    "globally": always,
    "next": Next,
    "until": Until,
}

_SUMS = f"integer-constant tokens-count {' '.join(_INTEGERS)}"
_FORMULAS = " ".join((*_ATOMS, *_CONNECTIVES, *_RELATIONS, *_REACHED, *_QUANTIFIERS, *_PATHS, "is-fireable"))
_TEXT = Declared(text=True)
KNOWN = {
    "property-set": Declared("", "property"),
    "property": Declared("", "id -description -tags formula"),
    "formula": Declared("", f"{_FORMULAS} place-bound k-safe {' '.join(_EXAMINATIONS)}"),
    **dict.fromkeys((*_ATOMS, *_EXAMINATIONS), Declared()),
    **dict.fromkeys((*_CONNECTIVES, *_REACHED, *_QUANTIFIERS, *_PATHS), Declared("", _FORMULAS)),
    "until": Declared("", "before reach"),
    **dict.fromkeys(("before", "reach"), Declared("", _FORMULAS)),
    **dict.fromkeys((*_RELATIONS, *_INTEGERS), Declared("", _SUMS)),
    "k-safe": Declared("", "integer-constant"),
    **dict.fromkeys(("tokens-count", "place-bound"), Declared("", "place")),
    "is-fireable": Declared("", "transition"),
    **dict.fromkeys(("id", "place", "transition", "integer-constant"), _TEXT),
}
"""What the reader knows, as :mod:`mcpn.declared` says it."""
_TABLE = ElementTable(KNOWN, "property-set")


def read_properties(path: Path, names: Names) -> list[Property]:
    """The properties of a file, in its order.

    Raises:
        InputError: The file is no property file, or names are unknown, with the lines of what was found.
        LimitError: A formula is too large, see :func:`mcpn.logic.formulas.within_limit`.
    """
    root, file = parse_xml(path, MAX_BYTES), str(path)
    space = etree.QName(root).namespace
    if name_of(root) != "property-set" or space not in NAMESPACES:
        of = f"of the namespace {space}" if space else "of no namespace"
        known = " or ".join(NAMESPACES)
        refuse(file, root, f"found <{name_of(root)}> {of}, expected <property-set> of the namespace {known}")
    rule = _TABLE.entered(file, root, None)
    if not len(root):
        refuse(file, root, "found no <property>, expected one or more")
    reader, read, problems = _ContestReader(file, names), dict[str, Property](), list[InputError]()
    for element in root:
        try:
            found = reader.property(element, rule)
            if found.name in read:
                raise reader.fail(element, "found a second property of this id, expected ids that differ")
            read[found.name] = found
        except InputError as error:
            problems.append(error)
    if problems:
        raise InputError(problem for error in problems for problem in error.problems)
    return list(read.values())


class _ContestReader:
    """Reads what fits the table; errors begin with the property's name."""

    def __init__(self, file: str, names: Names) -> None:
        self.file = file
        self.lookup = names
        self.asked = ""  # the property that is being read

    def fail(self, element: etree._Element, message: str) -> InputError:
        before = f"{self.asked}: " if self.asked else ""
        return InputError.at(source_of(self.file, element), f"{before}{message}")

    def named_errors(self, error: InputError) -> InputError:
        """An error that says which property it is about."""
        before = f"{self.asked}: " if self.asked else ""
        return InputError(Problem(source, f"{before}{message}") for source, message in error.problems)

    def only(self, element: etree._Element, count: int | None = 1) -> list[etree._Element]:
        """The elements inside one, of which there must be so many."""
        if len(element) != count and (count is not None or not len(element)):
            expected = "one or more" if count is None else count
            said = f"found {len(element)} elements in <{name_of(element)}>, expected {expected}"
            raise self.fail(element, said)
        return list(element)

    def property(self, element: etree._Element, around: ElementRule | None) -> Property:
        self.asked = next(((e.text or "").strip() for e in element if name_of(e) == "id"), "")
        try:
            _TABLE.check(self.file, element, around)
        except InputError as error:
            raise self.named_errors(error) from None
        parts = {name_of(child): child for child in element}
        for tag in ("id", "formula"):
            if tag not in parts:
                raise self.fail(element, f"found a property without <{tag}>, expected one")
            if sum(name_of(child) == tag for child in element) > 1:
                raise self.fail(parts[tag], f"found a second <{tag}> of a property, expected one")
        name = self.asked
        (body,) = self.only(parts["formula"])
        source = source_of(self.file, element)
        match name_of(body):
            case "place-bound":
                return Property(name, self.named(body, self.lookup.place_of_file), source)
            case tag if tag in _EXAMINATIONS:
                return Property(name, _EXAMINATIONS[tag], source)
            case "k-safe":
                most = self.sum(*self.only(body)).get((), 0)
                safe = And(*(AtMost(((p, 1),), most) for p in range(len(self.lookup.net.places))))
                return Property(name, OPERATORS["AG"](safe), source)
        return Property(name, within_limit(self.formula(body)), source)

    def formula(
        self, element: etree._Element, inside: Callable[[etree._Element], Formula] | None = None
    ) -> Formula:
        """A formula on states, or one that connectives make of what ``inside`` reads."""
        match name_of(element):
            case tag if tag in _ATOMS:
                return _ATOMS[tag]
            case tag if tag in _CONNECTIVES:
                operator, count = _CONNECTIVES[tag]
                return OPERATORS[operator](*map(inside or self.formula, self.only(element, count)))
            case tag if tag in _QUANTIFIERS:
                return self.path(_QUANTIFIERS[tag], *self.only(element))
            case tag if tag in _REACHED:
                reached = OPERATORS[_REACHED[tag]](*map(self.formula, self.only(element)))
                return ~reached if tag == "impossibility" else reached
            case "is-fireable":
                found = self.named(element, self.lookup.transition_of_file)
                return Fires(tuple(sorted({*found})))
            case tag if tag in _RELATIONS:
                left, right = map(self.sum, self.only(element, 2))
                try:
                    return related(left, _RELATIONS[tag], right, self.lookup.net)
                except InputError as error:
                    raise self.fail(element, str(error)) from None
        raise self.fail(element, f"found <{name_of(element)}>, expected a formula on states")

    def path(self, quantifier: str, element: etree._Element) -> Formula:
        tag = name_of(element)
        operands = [self.on_path(part) for part in self.operands(element)] if tag in _PATHS else []
        if operands and not any(map(is_of_paths, operands)):
            return OPERATORS[quantifier + _PATHS[tag]](*operands)
        of_path = _ON_PATH[tag](*operands) if operands else self.on_path(element)
        return every_path(of_path) if quantifier == "A" else some_path(of_path)

    def on_path(self, element: etree._Element) -> Formula:
        """A formula on paths, or on states."""
        tag = name_of(element)
        if tag in _PATHS:
            return _ON_PATH[tag](*map(self.on_path, self.operands(element)))
        return self.formula(element, self.on_path)

    def operands(self, element: etree._Element) -> list[etree._Element]:
        """What an operator on paths is applied to."""
        if name_of(element) != "until":
            return self.only(element)
        parts = self.only(element, 2)
        for part, expected in zip(parts, ("before", "reach"), strict=True):
            if name_of(part) != expected:
                raise self.fail(part, f"found <{name_of(part)}>, expected <{expected}>")
        return [inside for part in parts for inside in self.only(part)]

    def sum(self, element: etree._Element) -> Polynomial:
        match name_of(element):
            case "integer-constant":
                text = (element.text or "").strip()
                if not re.fullmatch(r"-?[0-9]{1,18}", text):
                    raise self.fail(element, f"found {text!r}, expected an integer of at most 18 digits")
                return {(): int(text)}
            case "tokens-count":
                tokens: Iterator[Polynomial] = (
                    {(place,): 1} for place in self.named(element, self.lookup.place_of_file)
                )
                return added(tokens)
        parts = [self.sum(child) for child in self.only(element, None)]
        match name_of(element):
            case "integer-difference":
                first = parts if len(parts) > 1 else [{}, *parts]
                return added([first[0], *({m: -w for m, w in part.items()} for part in first[1:])])
            case "integer-product":
                return multiplied(parts)
        return added(parts)

    def named(self, element: etree._Element, lookup: Callable[[str], int]) -> tuple[int, ...]:
        found = []
        for child in element:
            try:
                found.append(lookup((child.text or "").strip()))
            except InputError as error:
                raise self.fail(child, str(error)) from None
        return tuple(found)
