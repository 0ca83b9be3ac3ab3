"""PNML, the ISO/IEC 15909-2 exchange format, for place/transition nets: the one reader and the one writer.

Names are the ``id`` attributes, which property files refer to. Standard PNML has neither read arcs, events
nor priorities: they are written as ``toolspecific`` elements of ``mcpn``, which other tools skip; a read arc
is a consuming and a producing arc to them. Units of NUPN (``toolspecific tool="nupn"``) are read as hints.

Reference: the 2009 grammar, http://www.pnml.org/version-2009/grammar/ptnet.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

from lxml import etree

from mcpn.errors import InputError, Source
from mcpn.net.petri import Arcs, NetBuilder, PetriNet
from mcpn.xmlio import parse_xml

NAMESPACE = "http://www.pnml.org/version-2009/grammar/pnml"
NET_TYPE = "http://www.pnml.org/version-2009/grammar/ptnet"
MAX_FILE_BYTES = 256 << 20
MAX_DIGITS = 18


class _Reader:
    def __init__(self, path: Path) -> None:
        self.path = path
        self.places: dict[str, int] = {}
        self.transitions: dict[str, str | None] = {}
        self.aliases: dict[str, str] = {}
        self.arcs: list[etree._Element] = []
        self.ids: set[str] = set()
        self.units: list[list[str]] = []
        self.priorities = False

    def fail(self, element: etree._Element, message: str) -> NoReturn:
        line = element.sourceline
        raise InputError.at(Source(str(self.path), line if isinstance(line, int) else None), message)

    def read(self, root: etree._Element) -> PetriNet:
        nets = [child for child in root if _tag(child) == "net"]
        if _tag(root) != "pnml" or len(nets) != 1:
            self.fail(root, f"expected <pnml> with one <net>, found <{_tag(root)}> with {len(nets)}")
        net = nets[0]
        kind = net.get("type", "")
        if not kind.endswith(("/ptnet", "#ptnet", "PTNet", "P/T net")):
            self.fail(net, f"expected a place/transition net (type {NET_TYPE}), found type {kind!r}")
        self.page(net)
        builder = NetBuilder(net.get("id", ""), priorities=self.priorities)
        for place, tokens in self.places.items():
            builder.place(place, initial=tokens)
        sides = self.sides()
        for transition, event in self.transitions.items():
            consume, produce, read = sides[transition]
            builder.transition(transition, consume=consume, produce=produce, read=read, event=event)
        for unit in self.units:
            builder.unit(place for place in unit if place in self.places)
        return builder.build()

    def page(self, element: etree._Element) -> None:
        """Everything below a net or a page, pages in pages included; their depth is bounded by the parser."""
        for child in element:
            tag = _tag(child)
            if tag == "page":
                self.page(child)
            elif tag == "place":
                self.places[self.identify(child)] = self.number(child, "initialMarking", 0)
            elif tag == "transition":
                self.transitions[self.identify(child)] = _event(child)
            elif tag in ("referencePlace", "referenceTransition"):
                self.aliases[self.identify(child)] = child.get("ref", "")
            elif tag == "arc":
                self.identify(child)
                self.arcs.append(child)
            elif tag == "toolspecific":
                self.tool(child)

    def identify(self, element: etree._Element) -> str:
        name = element.get("id")
        if not name:
            self.fail(element, f"<{_tag(element)}> without an id")
        if name in self.ids:
            self.fail(element, f"the id {name} is given twice")
        self.ids.add(name)
        return name

    def number(self, element: etree._Element, tag: str, missing: int) -> int:
        """The number that a label of an element says."""
        for child in element:
            if _tag(child) == tag:
                texts = [inner.text or "" for inner in child if _tag(inner) == "text"]
                text = texts[0].strip() if texts else ""
                if not (text.isascii() and text.isdigit() and len(text) <= MAX_DIGITS):
                    shown = text if len(text) < 40 else f"{text[:40]}…"
                    self.fail(child, f"{tag} is {shown!r}, expected a number of at most {MAX_DIGITS} digits")
                return int(text)
        return missing

    def resolve(self, arc: etree._Element, attribute: str) -> str:
        name, steps = arc.get(attribute, ""), 0
        while name in self.aliases and steps <= len(self.aliases):
            name, steps = self.aliases[name], steps + 1
        if name not in self.places and name not in self.transitions:
            self.fail(arc, f"{attribute} of arc {arc.get('id')} is {name!r}, which is no place or transition")
        return name

    def sides(self) -> dict[str, tuple[dict[str, int], dict[str, int], dict[str, int]]]:
        """What each transition consumes, produces and reads."""
        found: dict[str, tuple[dict[str, int], dict[str, int], dict[str, int]]] = {
            t: ({}, {}, {}) for t in self.transitions
        }
        for arc in self.arcs:
            source, target = self.resolve(arc, "source"), self.resolve(arc, "target")
            weight = self.number(arc, "inscription", 1)
            if weight == 0:
                self.fail(arc, f"arc {arc.get('id')} has weight 0")
            kinds = [child.get("value") for child in arc if _tag(child) == "type"]
            if any(kind not in (None, "normal") for kind in kinds):
                self.fail(arc, f"arc {arc.get('id')} is of type {kinds[0]}, which is not supported")
            role = _ours(arc, "read")
            if source in self.places and target in self.transitions:
                place, side = source, found[target][2 if role is not None else 0]
            elif source in self.transitions and target in self.places:
                if role is not None:
                    continue  # the other half of a read arc
                place, side = target, found[source][1]
            else:
                self.fail(arc, f"arc {arc.get('id')} does not join a place and a transition")
            side[place] = side.get(place, 0) + weight
        return found

    def tool(self, element: etree._Element) -> None:
        if element.get("tool") == "nupn":
            for unit in element.iter():
                if _tag(unit) == "places" and (unit.text or "").strip():
                    self.units.append((unit.text or "").split())
        elif element.get("tool") == "mcpn":
            self.priorities |= any(_tag(child) == "priorities" for child in element)


def read_pnml(path: Path) -> PetriNet:
    """Reads a place/transition net.

    Args:
        path: The file.

    Returns:
        The net, with the units of NUPN where the file has them.

    Raises:
        InputError: With file and line.
    """
    return _Reader(path).read(parse_xml(path, MAX_FILE_BYTES))


def _tag(element: etree._Element) -> str:
    return etree.QName(element).localname


def _ours(element: etree._Element, tag: str) -> etree._Element | None:
    for child in element:
        if _tag(child) == "toolspecific" and child.get("tool") == "mcpn":
            return next((inner for inner in child if _tag(inner) == tag), None)
    return None


def _event(transition: etree._Element) -> str | None:
    event = _ours(transition, "event")
    return None if event is None else event.get("name")


# --- writing -------------------------------------------------------------------------------------------


def write_pnml(net: PetriNet) -> bytes:
    """A net as PNML that reads back as the same net.

    Args:
        net: The net. Its priorities are a ``toolspecific`` element: standard PNML has none.

    Returns:
        UTF-8 XML.

    Raises:
        InputError: A name cannot be an id in XML, or names a place and a transition.
    """
    root = etree.fromstring(f'<pnml xmlns="{NAMESPACE}"/>')
    element = _add(root, "net", id=net.name or "net", type=NET_TYPE)
    page = _add(element, "page", id="page")
    if net.priorities:
        _add(_add(page, "toolspecific", tool="mcpn", version="1"), "priorities", levels="internal > event")
    shared = net.place_index.keys() & net.transition_index.keys()
    if shared:
        raise InputError.at(None, f"{min(shared)} names a place and a transition, PNML needs different ids")
    for place in net.places:
        drawn = _named(page, "place", place.name)
        if place.initial:
            _add(_add(drawn, "initialMarking"), "text").text = str(place.initial)
    for transition in net.transitions:
        drawn = _named(page, "transition", transition.name)
        if transition.event is not None:
            _add(_add(drawn, "toolspecific", tool="mcpn", version="1"), "event", name=transition.event)
    taken = net.place_index.keys() | net.transition_index.keys()
    numbers = (f"arc{n}" for n in range(1 << 62))
    ids = (name for name in numbers if name not in taken)
    for transition in net.transitions:
        for arcs, into, out, read in (
            (transition.consume, True, False, False),
            (transition.produce, False, True, False),
            (transition.read, True, True, True),
        ):
            for source, target, weight in _ends(net, transition.name, arcs, into, out):
                arc = _add(page, "arc", id=next(ids), source=source, target=target)
                if weight > 1:
                    _add(_add(arc, "inscription"), "text").text = str(weight)
                if read:
                    _add(_add(arc, "toolspecific", tool="mcpn", version="1"), "read")
    return etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8")


def _ends(
    net: PetriNet, transition: str, arcs: Arcs, into: bool, out: bool
) -> Iterator[tuple[str, str, int]]:
    for place, weight in arcs:
        name = net.places[place].name
        if into:
            yield name, transition, weight
        if out:
            yield transition, name, weight


def _named(parent: etree._Element, tag: str, name: str) -> etree._Element:
    element = _add(parent, tag, id=name)
    _add(_add(element, "name"), "text").text = name
    return element


def _add(parent: etree._Element, tag: str, **attributes: str) -> etree._Element:
    element = etree.SubElement(parent, f"{{{NAMESPACE}}}{tag}")
    for key, value in attributes.items():
        try:
            element.set(key, value)
        except ValueError as error:
            raise InputError.at(None, f"the name {value!r} cannot stand in XML: {error}") from error
    return element
