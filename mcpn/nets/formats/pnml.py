"""PNML, the ISO/IEC 15909-2 exchange format, for place/transition nets: the one reader and the one writer.

Names are the ``id`` attributes, which property files refer to. Standard PNML has neither read arcs, events
nor priorities: they are written as ``toolspecific`` elements of ``mcpn``, which other tools skip; a read arc
is a consuming and a producing arc to them. A name that is no id in XML is kept in such an element too. Units
of NUPN (``toolspecific tool="nupn"``) are read as hints. What else could change the meaning of the net is
refused, never skipped.

Reference: the 2009 grammar, http://www.pnml.org/version-2009/grammar/ptnet.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import NoReturn

from lxml import etree

from mcpn.errors import InputError, Source
from mcpn.nets.events import Event
from mcpn.nets.formats.counts import MAX_DIGITS, check_counts, read_count
from mcpn.nets.petri import EVENTS, NetBuilder, PetriNet
from mcpn.xmlio import parse_xml

NAMESPACE = "http://www.pnml.org/version-2009/grammar/pnml"
NET_TYPE = "http://www.pnml.org/version-2009/grammar/ptnet"
MAX_FILE_BYTES = 256 << 20

_NODES = {"place", "transition", "referencePlace", "referenceTransition", "arc"}
_SKIPPED = {"name", "graphics", "toolspecific"}
_LABELS = {"place": {"initialMarking"}, "arc": {"inscription", "type"}}


class _PnmlReader:
    """Collects a net's elements by id, then joins them."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.places: dict[str, etree._Element] = {}
        self.transitions: dict[str, etree._Element] = {}
        self.references: dict[str, etree._Element] = {}
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
        ends = {key: key for key in (*self.places, *self.transitions)}
        self.follow_references(ends)
        builder = NetBuilder(self.name(net), priorities=self.priorities)
        names = {}
        for key, element in self.places.items():
            name = names[key] = self.name(element)
            if builder.has_place(name):
                self.fail(element, f"two places are named {name}")
            builder.place(name, initial=self.number(element, "initialMarking", 0))
        sides = self.sides(ends, names)
        named: set[str] = set()
        for key, element in self.transitions.items():
            name, event = self.name(element), self.ours(element, "event")
            if name in named:
                self.fail(element, f"two transitions are named {name}")
            named.add(name)
            consume, produce, read = sides[key]
            typed = None if event is None else Event.parse(event)
            rank = read_count(self.ours(element, "rank") or "0")
            if rank is None or rank >= EVENTS:
                self.fail(element, f"expected a rank from 0 to {EVENTS - 1}")
            builder.transition(name, consume=consume, produce=produce, read=read, event=typed, rank=rank)
        for unit in self.units:
            builder.unit(names[key] for key in unit if key in names)
        return builder.build()

    def page(self, element: etree._Element) -> None:
        """Everything below a net or a page, pages in pages included; their depth is bounded by the parser."""
        for child in element:
            tag = _tag(child)
            if tag == "page":
                self.page(child)
            elif tag in _NODES:
                self.node(child, tag)
            elif tag not in _SKIPPED:
                self.fail(child, f"found <{tag}>, which place/transition nets do not have")
            elif child.get("tool") == "nupn":
                texts = (unit.text or "" for unit in child.iter() if _tag(unit) == "places")
                self.units.extend(text.split() for text in texts if text.strip())
        self.priorities |= self.ours(element, "priorities") is not None

    def node(self, element: etree._Element, tag: str) -> None:
        key = element.get("id")
        if not key:
            self.fail(element, f"<{tag}> without an id")
        if key in self.ids:
            self.fail(element, f"the id {key} is given twice")
        self.ids.add(key)
        for label in element:
            if _tag(label) not in _SKIPPED and _tag(label) not in _LABELS.get(tag, ()):
                label_error = f"found <{_tag(label)}> in {tag} {key}"
                self.fail(label, f"{label_error}, which place/transition nets do not have")
        if tag == "arc":
            self.arcs.append(element)
        elif tag == "place":
            self.places[key] = element
        elif tag == "transition":
            self.transitions[key] = element
        else:
            self.references[key] = element

    def number(self, element: etree._Element, tag: str, missing: int) -> int:
        """The number that a label of an element says."""
        labels = [child for child in element if _tag(child) == tag]
        if not labels:
            return missing
        if len(labels) > 1:
            self.fail(labels[1], f"{tag} is given twice")
        texts = [child for child in labels[0] if _tag(child) == "text"]
        text = (texts[0].text or "").strip() if len(texts) == 1 and not len(texts[0]) else ""
        number = read_count(text)
        if number is None:
            shown = text if len(text) < 40 else f"{text[:40]}…"
            self.fail(labels[0], f"{tag} is {shown!r}, expected a number of at most {MAX_DIGITS} digits")
        return number

    def follow_references(self, ends: dict[str, str]) -> None:
        """Adds to the ends of arcs, by id, what each reference leads to in the end."""
        for key, element in self.references.items():
            path = [key]
            while path[-1] not in ends:
                following = self.references[path[-1]].get("ref", "")
                if following not in ends and (following not in self.references or following in path[-1:]):
                    self.fail(element, f"reference {key} leads to {following!r}, no place or transition")
                if len(path) > len(self.references):
                    self.fail(element, f"reference {key} leads in a circle, to no place or transition")
                path.append(following)
            ends.update(dict.fromkeys(path, ends[path[-1]]))
            kind = self.places if _tag(element) == "referencePlace" else self.transitions
            if ends[key] not in kind:
                self.fail(element, f"<{_tag(element)}> {key} leads to {ends[key]}, which is of another kind")

    def sides(
        self, ends: dict[str, str], names: dict[str, str]
    ) -> dict[str, tuple[dict[str, int], dict[str, int], dict[str, int]]]:
        """What each transition consumes, produces and reads, by its id and the places' names."""
        arcs: dict[str, tuple[dict[str, int], dict[str, int], dict[str, int]]] = {
            t: ({}, {}, {}) for t in self.transitions
        }
        halves: dict[tuple[str, str], int] = {}
        marked: dict[tuple[str, str], etree._Element] = {}
        for arc in self.arcs:
            source, target = self.end(arc, "source", ends), self.end(arc, "target", ends)
            weight = self.number(arc, "inscription", 1)
            if weight == 0:
                self.fail(arc, f"arc {arc.get('id')} has weight 0")
            for kind in (child.get("value", "") for child in arc if _tag(child) == "type"):
                if kind != "normal":
                    self.fail(arc, f"arc {arc.get('id')} is of type {kind}, which is not supported")
            into = source in self.places
            if into == (target in self.places):
                self.fail(arc, f"arc {arc.get('id')} does not join a place and a transition")
            place, transition = (source, target) if into else (target, source)
            side = arcs[transition][0 if into else 1]
            if self.ours(arc, "read") is not None:
                pair = (place, transition)
                halves[pair] = halves.get(pair, 0) + (weight if into else -weight)
                marked[pair] = arc
                if not into:
                    continue
                side = arcs[transition][2]
            name = names[place]
            side[name] = side.get(name, 0) + weight
        for pair, difference in halves.items():
            if difference:
                self.fail(marked[pair], f"read arc {marked[pair].get('id')} has no arc back of its weight")
        return arcs

    def end(self, arc: etree._Element, attribute: str, ends: dict[str, str]) -> str:
        key = arc.get(attribute, "")
        if key not in ends:
            self.fail(arc, f"{attribute} of arc {arc.get('id')} is {key!r}, which is no place or transition")
        return ends[key]

    def name(self, element: etree._Element) -> str:
        """The name of a net, a place or a transition: its id, unless that could not say it."""
        ours = self.ours(element, "name")
        return element.get("id", "") if ours is None else ours

    def ours(self, element: etree._Element, tag: str) -> str | None:
        """The value of a remark of ``mcpn`` on an element, or ``None`` where it has none."""
        for child in element:
            if _tag(child) == "toolspecific" and child.get("tool") == "mcpn":
                if child.get("version") != "1":
                    self.fail(child, f"toolspecific of mcpn of version {child.get('version')}, expected 1")
                for remark in child:
                    if _tag(remark) == tag:
                        return remark.get("value", "")
        return None


def read_pnml(path: Path) -> PetriNet:
    """Reads a place/transition net.

    Args:
        path: The file.

    Returns:
        The net, with the units of NUPN where the file has them: the places of each unit that has any. Takes
        time linear in the size of the file.

    Raises:
        InputError: With file and line.
    """
    return _PnmlReader(path).read(parse_xml(path, MAX_FILE_BYTES))


def _tag(element: etree._Element) -> str:
    return str(element.tag).rpartition("}")[2]


# --- writing -------------------------------------------------------------------------------------------

# What every edition of XML takes as an id; the editions differ on letters beyond ASCII.
_ID = re.compile(r"[A-Za-z_][-.\w]*\Z", re.ASCII)


def write_pnml(net: PetriNet) -> bytes:
    """A net as PNML that reads back as the same net (its units and provenance are not written).

    Args:
        net: The net. Its priorities are a ``toolspecific`` element: standard PNML has none.

    Returns:
        UTF-8 XML.

    Raises:
        InputError: A name holds a character that XML cannot say, or a number is beyond what files may say.
    """
    check_counts(net)
    new_id = _ids(net)
    root = etree.fromstring(f'<pnml xmlns="{NAMESPACE}"/>')
    drawn = _node(root, "net", new_id, net.name, "priorities" if net.priorities else None, "internal > event")
    drawn.set("type", NET_TYPE)
    page = _add(drawn, "page", id=new_id())
    places: list[str] = []
    for place in net.places:
        drawn = _node(page, "place", new_id, place.name)
        places.append(drawn.get("id", ""))
        if place.initial:
            _add(_add(drawn, "initialMarking"), "text", str(place.initial))
    for t in net.transitions:
        remark = ("event", str(t.event)) if t.event is not None else ("rank", str(t.rank or "") or None)
        key = _node(page, "transition", new_id, t.name, *remark).get("id", "")
        arcs = [(places[p], key, w, False) for p, w in t.consume]
        arcs += [(key, places[p], w, False) for p, w in t.produce]
        for p, w in t.read:
            arcs += [(places[p], key, w, True), (key, places[p], w, True)]
        for source, target, weight, read in arcs:
            arc = _add(page, "arc", id=new_id(), source=source, target=target)
            if weight > 1:
                _add(_add(arc, "inscription"), "text", str(weight))
            if read:
                _remark(arc, "read", "")
    return etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8")


def _ids(net: PetriNet) -> Callable[..., str]:
    """Makes ids that are unique in the file: a name itself, once, where it can be an id; else a fresh one."""
    names = {net.name, *net.place_index, *net.transition_index}
    fresh = (key for key in (f"id{number}" for number in count(1)) if key not in names)
    given: set[str] = set()

    def new_id(name: str = "") -> str:
        key = name if name not in given and _ID.match(name) else next(fresh)
        given.add(key)
        return key

    return new_id


def _node(
    parent: etree._Element,
    tag: str,
    new_id: Callable[..., str],
    name: str,
    remark: str | None = None,
    value: str | None = None,
) -> etree._Element:
    """An element with an id and a name; its name, and what else standard PNML cannot say, as remarks."""
    element = _add(parent, tag, id=new_id(name))
    _add(_add(element, "name"), "text", name)
    if element.get("id") != name:
        _remark(element, "name", name)
    if remark is not None and value is not None:
        _remark(element, remark, value)
    return element


def _remark(element: etree._Element, tag: str, value: str) -> None:
    _add(_add(element, "toolspecific", tool="mcpn", version="1"), tag, value=value)


def _add(parent: etree._Element, tag: str, text: str | None = None, **attributes: str) -> etree._Element:
    element = etree.SubElement(parent, f"{{{NAMESPACE}}}{tag}")
    try:
        element.text = text
        for key, value in attributes.items():
            element.set(key, value)
    except ValueError as error:
        said = text if text is not None else " ".join(attributes.values())
        raise InputError.at(None, f"the name {said!r} cannot stand in XML: {error}") from error
    return element
