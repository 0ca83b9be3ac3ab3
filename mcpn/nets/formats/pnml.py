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
from collections.abc import Callable, Iterable
from itertools import count
from pathlib import Path
from typing import NamedTuple, NoReturn

from lxml import etree

from mcpn.errors import InputError, Source
from mcpn.nets.events import Event
from mcpn.nets.formats.counts import MAX_DIGITS, check_counts, read_count
from mcpn.nets.petri import EVENTS, NetBuilder, PetriNet
from mcpn.steps import Doing, step
from mcpn.xmlio import stream_xml

NAMESPACE = "http://www.pnml.org/version-2009/grammar/pnml"
NET_TYPE = "http://www.pnml.org/version-2009/grammar/ptnet"
MAX_FILE_BYTES = 256 << 20

_NODES = {"place", "transition", "referencePlace", "referenceTransition", "arc"}
_SKIPPED = {"name", "graphics", "toolspecific"}
_LABELS = {"place": {"initialMarking"}, "arc": {"inscription", "type"}}
_Sides = tuple[dict[str, int], dict[str, int], dict[str, int]]


class _Place(NamedTuple):
    name: str
    initial: int
    line: int | None


class _Transition(NamedTuple):
    name: str
    event: str | None
    rank: str | None
    line: int | None


class _Reference(NamedTuple):
    tag: str
    leads_to: str
    line: int | None


class _Arc(NamedTuple):
    key: str
    source: str
    target: str
    weight: int
    read: bool
    line: int | None


class _PnmlReader:
    """Collects what a net's elements say, one after the other, then joins them."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.net: str | None = None
        self.places: dict[str, _Place] = {}
        self.transitions: dict[str, _Transition] = {}
        self.references: dict[str, _Reference] = {}
        self.arcs: list[_Arc] = []
        self.ids: set[str] = set()
        self.units: list[list[str]] = []
        self.priorities = False

    def fail(self, line: int | None, message: str) -> NoReturn:
        raise InputError.at(Source(str(self.path), line), message)

    def read(self) -> PetriNet:
        holds: list[bool] = []  # of each open element, whether it is the net or one of its pages
        root: int | None = 1
        for event, element in stream_xml(self.path, MAX_FILE_BYTES, self.far):
            if event == "start":
                if not holds:
                    root = _line(element)
                holds.append(self.begins(element, holds))
                continue
            holds.pop()
            if holds and holds[-1]:
                self.ends(element, of_net=len(holds) == 2)
            if not holds or holds[-1] or len(holds) == 1:
                _let_go(element)
        if self.net is None:
            self.fail(root, "expected <pnml> with one <net>, found none")
        return self.joined(self.net)

    def far(self, read: int, size: int) -> None:
        step(Doing.READING, question=f"{self.path.name} ({read >> 20} of {size >> 20} MiB)")

    def begins(self, element: etree._Element, holds: list[bool]) -> bool:
        """Whether nodes stand in an element that begins; refuses what may not stand where it does."""
        tag = _tag(element)
        if not holds:
            if tag != "pnml":
                self.fail(_line(element), f"expected <pnml> with one <net>, found <{tag}>")
            return False
        if len(holds) == 1:
            if tag != "net":
                return False
            if self.net is not None:
                self.fail(_line(element), "expected <pnml> with one <net>, found a second")
            kind = element.get("type", "")
            if not kind.endswith(("/ptnet", "#ptnet", "PTNet", "P/T net")):
                said = f"expected a place/transition net (type {NET_TYPE}), found type {kind!r}"
                self.fail(_line(element), said)
            self.net = element.get("id", "")
            return True
        if holds[-1] and tag != "page" and tag not in _NODES and tag not in _SKIPPED:
            self.fail(_line(element), f"found <{tag}>, which place/transition nets do not have")
        return holds[-1] and tag == "page"

    def ends(self, element: etree._Element, *, of_net: bool) -> None:
        """Takes what an element of a net or a page says."""
        tag = _tag(element)
        if tag in _NODES:
            self.node(element, tag)
        elif tag == "toolspecific" and element.get("tool") == "nupn":
            texts = (unit.text or "" for unit in element.iter() if _tag(unit) == "places")
            self.units.extend(text.split() for text in texts if text.strip())
        elif tag == "toolspecific":
            remarks = self.remarks([element])
            self.priorities |= "priorities" in remarks
            if of_net:
                self.net = remarks.get("name", self.net)

    def node(self, element: etree._Element, tag: str) -> None:
        key, line = element.get("id"), _line(element)
        if not key:
            self.fail(line, f"<{tag}> without an id")
        if key in self.ids:
            self.fail(line, f"the id {key} is given twice")
        self.ids.add(key)
        for label in element:
            if _tag(label) not in _SKIPPED and _tag(label) not in _LABELS.get(tag, ()):
                label_error = f"found <{_tag(label)}> in {tag} {key}"
                self.fail(_line(label), f"{label_error}, which place/transition nets do not have")
        remarks = self.remarks(element)
        name = remarks.get("name", key)
        if tag == "arc":
            self.arcs.append(self.arc(element, key, "read" in remarks))
        elif tag == "place":
            self.places[key] = _Place(name, self.number(element, "initialMarking", 0), line)
        elif tag == "transition":
            self.transitions[key] = _Transition(name, remarks.get("event"), remarks.get("rank"), line)
        else:
            self.references[key] = _Reference(tag, element.get("ref", ""), line)

    def arc(self, element: etree._Element, key: str, read: bool) -> _Arc:
        weight, line = self.number(element, "inscription", 1), _line(element)
        if weight == 0:
            self.fail(line, f"arc {key} has weight 0")
        for kind in (child.get("value", "") for child in element if _tag(child) == "type"):
            if kind != "normal":
                self.fail(line, f"arc {key} is of type {kind}, which is not supported")
        return _Arc(key, element.get("source", ""), element.get("target", ""), weight, read, line)

    def number(self, element: etree._Element, tag: str, missing: int) -> int:
        """The number that a label of an element says."""
        labels = [child for child in element if _tag(child) == tag]
        if not labels:
            return missing
        if len(labels) > 1:
            self.fail(_line(labels[1]), f"{tag} is given twice")
        texts = [child for child in labels[0] if _tag(child) == "text"]
        text = (texts[0].text or "").strip() if len(texts) == 1 and not len(texts[0]) else ""
        number = read_count(text)
        if number is None:
            shown = text if len(text) < 40 else f"{text[:40]}…"
            said = f"{tag} is {shown!r}, expected a number of at most {MAX_DIGITS} digits"
            self.fail(_line(labels[0]), said)
        return number

    def remarks(self, elements: Iterable[etree._Element]) -> dict[str, str]:
        """The remarks of ``mcpn`` in some elements: the first value of each."""
        said: dict[str, str] = {}
        for child in elements:
            if _tag(child) == "toolspecific" and child.get("tool") == "mcpn":
                if child.get("version") != "1":
                    found = f"toolspecific of mcpn of version {child.get('version')}, expected 1"
                    self.fail(_line(child), found)
                for remark in child:
                    said.setdefault(_tag(remark), remark.get("value", ""))
        return said

    # --- joining ---

    def joined(self, net: str) -> PetriNet:
        ends = {key: key for key in (*self.places, *self.transitions)}
        self.follow_references(ends)
        builder = NetBuilder(net, priorities=self.priorities)
        for place in self.places.values():
            if builder.has_place(place.name):
                self.fail(place.line, f"two places are named {place.name}")
            builder.place(place.name, initial=place.initial)
        sides = self.sides(ends)
        named: set[str] = set()
        for key, (name, event, said, line) in self.transitions.items():
            if name in named:
                self.fail(line, f"two transitions are named {name}")
            named.add(name)
            consume, produce, read = sides[key]
            typed = None if event is None else Event.parse(event)
            rank = read_count(said or "0")
            if rank is None or rank >= EVENTS:
                self.fail(line, f"expected a rank from 0 to {EVENTS - 1}")
            builder.transition(name, consume=consume, produce=produce, read=read, event=typed, rank=rank)
        for unit in self.units:
            builder.unit(self.places[key].name for key in unit if key in self.places)
        return builder.build()

    def follow_references(self, ends: dict[str, str]) -> None:
        """Adds to the ends of arcs, by id, what each reference leads to in the end."""
        for key, (tag, _, line) in self.references.items():
            path = [key]
            while path[-1] not in ends:
                following = self.references[path[-1]].leads_to
                if following not in ends and (following not in self.references or following in path[-1:]):
                    self.fail(line, f"reference {key} leads to {following!r}, no place or transition")
                if len(path) > len(self.references):
                    self.fail(line, f"reference {key} leads in a circle, to no place or transition")
                path.append(following)
            ends.update(dict.fromkeys(path, ends[path[-1]]))
            kind = self.places if tag == "referencePlace" else self.transitions
            if ends[key] not in kind:
                self.fail(line, f"<{tag}> {key} leads to {ends[key]}, which is of another kind")

    def sides(self, ends: dict[str, str]) -> dict[str, _Sides]:
        """What each transition consumes, produces and reads, by its id and the places' names."""
        arcs: dict[str, _Sides] = {t: ({}, {}, {}) for t in self.transitions}
        halves: dict[tuple[str, str], int] = {}
        marked: dict[tuple[str, str], _Arc] = {}
        for arc in self.arcs:
            source, target = (
                self.end(arc, "source", arc.source, ends),
                self.end(arc, "target", arc.target, ends),
            )
            into = source in self.places
            if into == (target in self.places):
                self.fail(arc.line, f"arc {arc.key} does not join a place and a transition")
            place, transition = (source, target) if into else (target, source)
            side = arcs[transition][0 if into else 1]
            if arc.read:
                pair = (place, transition)
                halves[pair] = halves.get(pair, 0) + (arc.weight if into else -arc.weight)
                marked[pair] = arc
                if not into:
                    continue
                side = arcs[transition][2]
            name = self.places[place].name
            side[name] = side.get(name, 0) + arc.weight
        for pair, difference in halves.items():
            if difference:
                arc = marked[pair]
                self.fail(arc.line, f"read arc {arc.key} has no arc back of its weight")
        return arcs

    def end(self, arc: _Arc, attribute: str, key: str, ends: dict[str, str]) -> str:
        if key not in ends:
            self.fail(arc.line, f"{attribute} of arc {arc.key} is {key!r}, which is no place or transition")
        return ends[key]


def read_pnml(path: Path) -> PetriNet:
    """Reads a place/transition net.

    Args:
        path: The file.

    Returns:
        The net, with the units of NUPN where the file has them: the places of each unit that has any. Takes
        time linear in the size of the file; its elements are let go as they are read.

    Raises:
        InputError: With file and line.
    """
    return _PnmlReader(path).read()


def _let_go(element: etree._Element) -> None:
    """Forgets what stands in an element that has ended, and its siblings before it."""
    element.clear()
    parent = element.getparent()
    while parent is not None and element.getprevious() is not None:
        del parent[0]


def _line(element: etree._Element) -> int | None:
    line = element.sourceline
    return line if isinstance(line, int) else None


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
