"""Missions that are valid but for one change, each with the error that it must give, and where.

>>> from hypothesis import HealthCheck, given, settings
>>> from mcpn.errors import InputError
>>> @settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.too_slow])
... @given(broken_missions(max_objectives=2))
... def is_refused(broken):
...     try:
...         broken.read()
...     except InputError as error:
...         assert broken.is_told(error)
>>> is_refused()
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from hypothesis import assume
from hypothesis import strategies as st
from lxml import etree

from mcpn.errors import InputError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.testing import missions
from mcpn.testing.printing import as_xml
from mcpn.testing.shape import Shape
from mcpn.xmlio import line_of

NAMESPACE = "urn:mcpn:mission:1"
FILE = Path("broken.xml")

Element: TypeAlias = "etree._Element"
Break: TypeAlias = Callable[[Element], tuple[Element, str]]
"""Changes an element in place, and says which element the error is told of, and a part of its message."""


@dataclass(frozen=True)
class BrokenMission:
    """A file that holds a mission which is valid but for one change.

    Args:
        text: The file.
        fault: What is wrong, one of :data:`FAULTS`.
        line: Where the error must say that it is.
        message: What it must say, among other words.
    """

    text: str
    fault: str
    line: int
    message: str

    def __repr__(self) -> str:
        return f"{self.fault}: line {self.line} is to be told with {self.message!r}\n{self.text}"

    def read(self) -> Mission:
        """Reads the file.

        Raises:
            InputError: As it must be; :meth:`is_told` says whether that is the expected one.
        """
        return read_mission(FILE, unsaved={FILE.resolve(): self.text})

    def is_told(self, error: InputError) -> bool:
        """Whether an error says what is wrong, and in which line."""
        return any(
            p.source is not None and p.source.line == self.line and self.message in p.message
            for p in error.problems
        )


def broken_missions(
    shape: Shape | None = None, *, fault: str | None = None, **bounds: int | bool
) -> st.SearchStrategy[BrokenMission]:
    """Missions with one fault each.

    Args:
        shape: Bounds on the missions, as for :func:`mcpn.testing.missions`.
        fault: The fault, one of :data:`FAULTS`; any by default.
        **bounds: Bounds to replace in it.
    """
    return st.composite(_broken)(missions(shape, **bounds), [fault] if fault else list(FAULTS))


def _broken(draw: st.DrawFn, valid: st.SearchStrategy[Mission], asked: list[str]) -> BrokenMission:
    text = as_xml(draw(valid))
    root = etree.fromstring(text)
    places = {fault: _found(root, FAULTS[fault][0]) for fault in asked}
    possible = [fault for fault, found in places.items() if found]
    assume(possible)
    fault = draw(st.sampled_from(possible))
    element = draw(st.sampled_from(places[fault]))
    told, message = FAULTS[fault][1](element)
    etree.indent(root)
    path = root.getroottree().getpath(told)
    text = etree.tostring(root, encoding="unicode")
    (again,) = _found(etree.fromstring(text), path)
    return BrokenMission(text, fault, line_of(again), message)


def _found(root: Element, where: str) -> list[Element]:
    found = root.xpath(where, namespaces={"m": NAMESPACE})
    assert isinstance(found, list), "an expression of elements"
    return [element for element in found if isinstance(element, etree._Element)]


def _more(element: Element, attribute: str, name: str) -> None:
    element.set(attribute, f"{element.get(attribute, '')} {name}".strip())


def _adds(attribute: str, name: str, message: str) -> Break:
    def change(element: Element) -> tuple[Element, str]:
        _more(element, attribute, name)
        return element, message

    return change


def _sets(attribute: str, value: str, message: str) -> Break:
    def change(element: Element) -> tuple[Element, str]:
        element.set(attribute, value)
        return element, message

    return change


def _takes(attribute: str, message: str, instead: str = "") -> Break:
    def change(element: Element) -> tuple[Element, str]:
        value = element.attrib.pop(attribute)
        if instead:
            element.set(instead, value)
        return element, message

    return change


def _twice(kind: str) -> Break:
    def change(element: Element) -> tuple[Element, str]:
        again = deepcopy(element)
        element.addnext(again)
        return again, f"{kind} {element.get('name')} is declared twice"

    return change


def _holds(tag: str, message: str, first: bool = False, **attributes: str) -> Break:
    def change(element: Element) -> tuple[Element, str]:
        inner = etree.Element(f"{{{NAMESPACE}}}{tag}", attributes)
        element.insert(0 if first else len(element), inner)
        return inner, message

    return change


def _names_one_twice(element: Element) -> tuple[Element, str]:
    first = element.get("activities", "").split()[0]
    _more(element, "activities", first)
    return element, f"names {first} 2 times"


def _starts_a_producer(element: Element) -> tuple[Element, str]:
    producer = _found(element.getroottree().getroot(), "//m:activity[@produces]")[0].get("name")
    _more(element, "activities", str(producer))
    return element, "an activity that produces is started by request, not by an objective"


def _needs_itself(element: Element) -> tuple[Element, str]:
    name, product = element.get("name"), element.get("produces", "").split()[0]
    _more(next(iter(_found(element, "m:alternative")), element), "consumes", product)
    return element, f"activities need each other's resources: {name} -> {name}"


def _needs_nobody(element: Element) -> tuple[Element, str]:
    for child in _found(element, _BLOCKS.replace("//", "")):
        child.set("mandatory", "false")
    return element, f"parallel block {element.get('name')} has no mandatory child"


def _orphan(element: Element) -> tuple[Element, str]:
    inner = etree.Element(f"{{{NAMESPACE}}}software", {"name": "orphan"})
    element.addnext(inner)
    return inner, "software orphan needs exactly one activity that produces it, found none"


_BLOCKS = "//m:objective | //m:parallel | //m:use | //m:each"
_STARTING = "//m:objective[@activities]"
_IN_A_ROW = " | ".join(f"{tag.strip()}[not(parent::m:parallel)]" for tag in _BLOCKS.split("|"))

FAULTS: Mapping[str, tuple[str, Break]] = {
    "an alternative consumes what nobody declares": (
        "//m:alternative | //m:activity[not(m:alternative)]",
        _adds("consumes", "nowhere", "consumes nowhere, which is not declared"),
    ),
    "an objective runs what nobody declares": (
        _STARTING,
        _adds("activities", "nobody", "runs nobody, which is not declared"),
    ),
    "an objective names an activity twice": (_STARTING, _names_one_twice),
    "an objective starts a producer": (f"{_STARTING}[//m:activity[@produces]]", _starts_a_producer),
    "an objective of nothing": (_STARTING, _takes("activities", "neither activities nor blocks")),
    "an attribute is misspelt": (
        _STARTING,
        _takes("activities", "did you mean activities?", instead="activites"),
    ),
    "a route leads nowhere": (_IN_A_ROW, _sets("success", "nowhere", "leads to nowhere; expected one of")),
    "a block in a row is not mandatory": (
        _IN_A_ROW,
        _sets("mandatory", "false", "is not mandatory, though it is no child of a parallel block"),
    ),
    "a parallel block needs none of its children": ("//m:parallel", _needs_nobody),
    "a block has no name": (_BLOCKS, _takes("name", "name")),
    "a name that is none": ("//m:hardware | //m:activity", _sets("name", "1st", "name of <")),
    "a truth value that is none": (
        "//m:hardware",
        _sets("faulty", "maybe", "faulty of <hardware> is 'maybe'"),
    ),
    "an element that there is not": ("//m:robot", _holds("nothing", "nothing")),
    "hardware is declared twice": ("//m:hardware", _twice("resource")),
    "an activity is declared twice": ("//m:activity[not(@produces)]", _twice("activity")),
    "a handler of what nobody declares": (
        "//m:objective[not(m:on)]",
        _holds("on", "handles the event nowhere, which is not declared", True, event="nowhere", goto="fail"),
    ),
    "a use of what nobody declares": (
        "//m:use",
        _sets("protocol", "nowhere", "uses the protocol nowhere, which is not declared"),
    ),
    "software that nobody makes": ("//m:hardware", _orphan),
    "an activity needs itself": ("//m:activity[@produces]", _needs_itself),
    "an activity with one alternative returns to a better one": (
        "//m:activity[count(m:alternative) <= 1]",
        _sets("switch_back", "true", "it cannot switch back"),
    ),
}
"""By what is wrong: which elements can be broken so, and how."""
