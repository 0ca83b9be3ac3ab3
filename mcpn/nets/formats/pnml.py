"""Reads PNML, the ISO/IEC 15909-2 exchange format, for place/transition nets, with the remarks of mcpn in it.

Names are the ``id`` attributes, which property files refer to; what ``<name>`` says is kept as the label.
:data:`KNOWN` declares the elements and attributes that are read, those that are without meaning, and those
that may only say what changes nothing: what it does not have is refused. Standard PNML has neither read arcs,
events nor priorities: they are written as ``toolspecific`` elements of ``mcpn``, which other tools skip; a
read arc is a consuming and a producing arc to them. A name that is no id in XML is kept in such an element
too. Units of NUPN (``toolspecific tool="nupn"``) are read as hints. Read arcs and inhibitor arcs of other
tools are read where their kind is declared (:data:`KINDS`).

Reference: the 2009 grammar, http://www.pnml.org/version-2009/grammar/ptnet.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple, NoReturn

from lxml import etree

from mcpn.declared import Declared, ElementRule, ElementTable, name_of, refuse
from mcpn.errors import InputError, Source
from mcpn.events import Event
from mcpn.nets.formats.counts import MAX_DIGITS, rank_without_use, read_count
from mcpn.nets.inhibitors import Inhibitor, without_inhibitors
from mcpn.nets.petri import EVENTS, NetBuilder, PetriNet
from mcpn.sentences import quoted
from mcpn.steps import Doing, step
from mcpn.xmlio import line_of, stream_xml

NAMESPACE = "http://www.pnml.org/version-2009/grammar/pnml"
NET_TYPE = "http://www.pnml.org/version-2009/grammar/ptnet"
MAX_FILE_BYTES = 256 << 20

NET_TYPES = (
    NET_TYPE,
    "http://www.pnml.org/version-2009/grammar/pnmlcoremodel",  # pm4py, ProM
    "http://www.informatik.hu-berlin.de/top/pntd/ptNetb",  # WoPeD, after a draft of the standard
    "http://www.informatik.hu-berlin.de/top/pnml/ptNetb",
    "http://www.informatik.hu-berlin.de/top/pntd/ptNet",
    "http://www.yasper.org/specs/epnml-1.1",  # Yasper, ProM 5
    "PTNet",  # Petri Net Kernel, LoLA
    "P/T net",  # PIPE, TAPAAL
)
"""Types of nets whose places hold tokens that are all alike."""

_DRAWN = "-graphics -toolspecific"
_DRAWN_BY_TAPAAL = (
    "-displayName -nameOffsetX -nameOffsetY -positionX -positionY -markingOffsetX -markingOffsetY"
)
_NODES = "page place transition arc referencePlace referenceTransition"
_LABEL = Declared("", f"text value {_DRAWN}")

KNOWN = {
    "pnml": Declared("type -id", "net -toolspecific -finalmarkings -k-bound -query -queries feature"),
    "feature": Declared("-isTimed isGame=false isColored=false isStochastic=false"),
    "net": Declared("id type name active=true", f"name {_NODES} {_DRAWN} token -labels -finalmarkings"),
    "token": Declared("id=Default -enabled -red -green -blue"),
    "page": Declared("id name", f"name {_NODES} {_DRAWN}"),
    "place": Declared(
        f"id name initialMarking capacity=0|inf invariant=<_inf|<inf {_DRAWN_BY_TAPAAL}",
        f"name initialMarking capacity=0 {_DRAWN}",
    ),
    "transition": Declared(
        f"id name priority=0 urgent=false player=0 -infiniteServer -angle -invisible {_DRAWN_BY_TAPAAL}",
        f"name timed=false priority=0|1 -infiniteServer -rate -orientation {_DRAWN}",
    ),
    "arc": Declared(
        f"id source target type weight inscription=1|[0,inf) {_DRAWN_BY_TAPAAL}",
        f"name inscription type arctype tagged=false -arcpath {_DRAWN}",
    ),
    "referencePlace": Declared("id ref", f"name {_DRAWN}"),
    "referenceTransition": Declared("id ref", f"name {_DRAWN}"),
    "name": _LABEL,
    "initialMarking": _LABEL,
    "inscription": _LABEL,
    "capacity": _LABEL,
    "timed": _LABEL,
    "priority": _LABEL,
    "tagged": _LABEL,
    "type": Declared("value", f"text value {_DRAWN}"),
    "arctype": _LABEL,
    "text": Declared(text=True),
    "value": Declared(text=True),
}
"""What the reader knows, as :mod:`mcpn.declared` says it.

``capacity``, ``invariant``, ``urgent``, ``priority``, ``timed``, ``player`` and ``tagged`` may only say that
there is none. Where a net ends (``finalmarkings``), how it is drawn, and what tools note for themselves
changes nothing of it.
"""

KINDS = {
    "normal": "normal",
    "timed": "normal",  # of TAPAAL; its table has no interval but [0,inf)
    "inhibitor": "inhibitor",
    "tapninhibitor": "inhibitor",
    "read": "read",
    "test": "read",
}
"""By kind of an arc, as its ``type`` or ``arctype`` says it in small letters, how it is read."""

REMARKS = {
    "toolspecific": Declared("tool version=1", "name event rank read priorities"),
    **dict.fromkeys(("name", "event", "rank", "read"), Declared("value")),
    "priorities": Declared("value=internal_>_event"),
}
"""What ``toolspecific`` of ``mcpn`` may hold."""
REMARKED = {
    "net": ("name", "priorities"),
    "place": ("name",),
    "transition": ("name", "event", "rank"),
    "arc": ("read",),
}
"""By element the remarks that may stand in it, each once."""
_REMARKS = ElementTable(REMARKS, "toolspecific")
_TABLE = ElementTable(KNOWN, "pnml")
_Inside = list[tuple[str, etree._Element]]
"""What stands in an element, with its names."""
_Sides = tuple[dict[str, int], dict[str, int], dict[str, int]]


class _Place(NamedTuple):
    name: str
    label: str | None
    initial: int
    line: int | None


class _Transition(NamedTuple):
    name: str
    label: str | None
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
    kind: str
    half: bool
    line: int | None


class _PnmlReader:
    """Collects what a net's elements say, one after the other, then joins them."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.file = str(path)
        self.net: str | None = None
        self.places: dict[str, _Place] = {}
        self.transitions: dict[str, _Transition] = {}
        self.references: dict[str, _Reference] = {}
        self.arcs: list[_Arc] = []
        self.ids: set[str] = set()
        self.units: list[tuple[int | None, list[str]]] = []
        self.remarks: dict[str, str] = {}
        """Those of the net."""

    def fail(self, line: int | None, message: str) -> NoReturn:
        raise InputError.at(Source(self.file, line), message)

    def read(self) -> PetriNet:
        rules: list[ElementRule | None] = []  # of each open element, None where it is without meaning
        holds: list[bool] = []  # whether it is the net or one of its pages
        root: int | None = 1
        for event, element in stream_xml(self.path, MAX_FILE_BYTES, self.far):
            if event == "start":
                if not rules:
                    root = line_of(element)
                inert = bool(rules) and rules[-1] is None
                rule = None if inert else _TABLE.entered(self.file, element, rules[-1] if rules else None)
                holds.append(rule is not None and name_of(element) in ("net", "page"))
                rules.append(rule)
                if rule is not None and len(rules) == 2:
                    self.begin_net(element)
                continue
            if (rule := rules.pop()) is not None:
                _TABLE.left(self.file, element, rule)
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

    def begin_net(self, element: etree._Element) -> None:
        """Takes the net's name, and sees to it that there is one net and that its type is known."""
        if name_of(element) != "net":
            return
        if self.net is not None:
            refuse(self.file, element, "expected <pnml> with one <net>, found a second")
        root = element.getparent()
        of_root = None if root is None else root.get("type")  # where bpmn2pnml-ltl-analyzer says it
        said = [kind.strip() for kind in (of_root, element.get("type")) if kind is not None]
        for kind in said or [""]:
            if _of_scheme(kind) not in NET_TYPES:
                expected = f"expected a place/transition net (type {NET_TYPE}), found type {quoted(kind)}"
                refuse(self.file, element, expected)
        self.net = element.get("id", "")

    def ends(self, element: etree._Element, *, of_net: bool) -> None:
        """Takes what an element of a net or a page says."""
        tag = name_of(element)
        if tag in ("place", "transition", "arc", "referencePlace", "referenceTransition"):
            self.node(element, tag)
        elif tag == "toolspecific" and element.get("tool") == "nupn":
            units = ((unit, (unit.text or "").split()) for unit in element.iter("{*}places"))
            self.units.extend((line_of(unit), places) for unit, places in units if places)
        elif tag == "toolspecific":
            self.remark(element, "net" if of_net else "page", self.remarks)

    def node(self, element: etree._Element, tag: str) -> None:
        key, line = element.get("id"), line_of(element)
        if not key:
            self.fail(line, f"found <{tag}> without an id, expected one")
        if key in self.ids:
            self.fail(line, f"found a second element of the id {key}, expected ids that differ")
        self.ids.add(key)
        inside = [(name_of(child), child) for child in element]
        remarks: dict[str, str] = {}
        for name, child in inside:
            if name == "toolspecific":
                self.remark(child, tag, remarks)
        said = self.said(element, inside, "name")
        name = remarks.get("name", key)
        label = None if said == name else said or None
        if tag == "arc":
            self.arcs.append(self.arc(element, inside, key, said, half="read" in remarks))
        elif tag == "place":
            initial = self.number(element, inside, "initialMarking", 0)
            self.places[key] = _Place(name, label, initial, line)
        elif tag == "transition":
            event, rank = remarks.get("event"), remarks.get("rank")
            self.transitions[key] = _Transition(name, label, event, rank, line)
        else:
            self.references[key] = _Reference(tag, element.get("ref", ""), line)

    def arc(
        self, element: etree._Element, inside: _Inside, key: str, said: str | None, *, half: bool
    ) -> _Arc:
        line = line_of(element)
        weight = attribute = self.number(element, inside, "weight", 1)
        if any(name == "inscription" for name, _ in inside):  # TAPAAL's attribute is an interval of time
            weight = self.number(element, inside, "inscription", 1)
            if "weight" in element.attrib and weight != attribute:
                said_twice = f"found weight {attribute} and inscription {weight} of arc {key}"
                self.fail(line, f"{said_twice}, expected one number")
        if weight == 0:
            self.fail(line, f"found weight 0 of arc {key}, expected 1 or more")
        if said and read_count(said) not in (None, weight):  # tools have written the weight as the name
            self.fail(
                line, f"found the name {said} of arc {key} and its weight {weight}, expected one number"
            )
        return _Arc(
            key,
            element.get("source", ""),
            element.get("target", ""),
            weight,
            self.kind(element, inside, key, half=half),
            half,
            line,
        )

    def kind(self, element: etree._Element, inside: _Inside, key: str, *, half: bool) -> str:
        """How an arc is read, by all places that may say its type."""
        attribute, line = element.get("type"), line_of(element)
        found = [] if attribute is None else [attribute]
        for child in (child for name, child in inside if name in ("type", "arctype")):
            texts = [part.text or "" for part in child if name_of(part) in ("text", "value")]
            value = child.get("value")
            found += [*([] if value is None else [value]), *texts] or [""]
        for one in found:
            if one.strip().lower() not in KINDS:
                self.fail(line, f"found arc {key} of type {quoted(one, 40)}, expected {', '.join(KINDS)}")
        kinds = {KINDS[one.strip().lower()]: quoted(one, 40) for one in found}
        if half:
            kinds.setdefault("normal", "a remark of mcpn")
        if len(kinds) > 1:
            self.fail(line, f"found arc {key} of types {' and '.join(kinds.values())}, expected one")
        return next(iter(kinds), "normal")

    def said(self, element: etree._Element, inside: _Inside, tag: str) -> str | None:
        """What an element says by a label or by an attribute; ``None`` where it says nothing."""
        labels = [child for name, child in inside if name == tag]
        attribute = element.get(tag)
        if len(labels) > 1 or (labels and attribute is not None and tag != "name"):
            refuse(self.file, labels[-1], f"found a second {tag}, expected one")
        if not labels:
            return attribute
        parts = [child for child in labels[0] if name_of(child) in ("text", "value")]
        if len(parts) > 1:
            refuse(self.file, labels[0], f"found {len(parts)} texts of {tag}, expected one")
        return (parts[0].text or "").strip() if parts else ""

    def number(self, element: etree._Element, inside: _Inside, tag: str, missing: int) -> int:
        """The number that an element says by a label or by an attribute."""
        text = self.said(element, inside, tag)
        if text is None:
            return missing
        number = read_count(text.removeprefix("Default,").strip())  # PIPE says the class of tokens, too
        if number is None:
            found = quoted(text, 40) if text else "an empty text"
            label = next((child for name, child in inside if name == tag), element)
            said = f"found {found} as {tag}, expected a number of at most {MAX_DIGITS} digits"
            refuse(self.file, label, said)
        return number

    def remark(self, element: etree._Element, tag: str, said: dict[str, str]) -> None:
        """Adds what a remark of ``mcpn`` says of the element around it, whose name is ``tag``."""
        if element.get("tool") != "mcpn":
            return
        _REMARKS.check(self.file, element)
        for remark in element:
            name = name_of(remark)
            if name not in REMARKED.get(tag, ()):
                refuse(self.file, remark, f"found <{name}> of mcpn in <{tag}>, where it says nothing")
            if name in said:
                refuse(self.file, remark, f"found a second <{name}> of mcpn, expected one")
            said[name] = remark.get("value", "")

    def joined(self, net: str) -> PetriNet:
        ends = {key: key for key in (*self.places, *self.transitions)}
        self.follow_references(ends)
        builder = NetBuilder(self.remarks.get("name", net), priorities="priorities" in self.remarks)
        for place in self.places.values():
            if builder.has_place(place.name):
                self.fail(place.line, f"found a second place named {place.name}, expected names that differ")
            builder.place(place.name, initial=place.initial, label=place.label)
        sides, inhibitors = self.sides(ends)
        named: set[str] = set()
        for key, (name, label, event, said, line) in self.transitions.items():
            if name in named:
                self.fail(line, f"found a second transition named {name}, expected names that differ")
            named.add(name)
            consume, produce, read = sides[key]
            if event == "":
                self.fail(line, f"found an event without a name of transition {name}, expected one")
            typed = None if event is None else Event.parse(event)
            rank = read_count(said or "0")
            if rank is None or rank >= EVENTS:
                self.fail(line, f"found {said!r} as rank of transition {name}, expected 0 to {EVENTS - 1}")
            if rank and (why := rank_without_use(event, priorities=builder.priorities)):
                self.fail(line, f"found {said!r} as rank of transition {name}, {why}")
            builder.transition(name, consume=consume, produce=produce, read=read, event=typed, rank=rank)
            builder.label(name, label)
        for line, unit in self.units:
            for key in unit:
                if key not in self.places:
                    self.fail(line, f"found {quoted(key, 40)} in a unit, expected the id of a place")
            builder.unit(self.places[key].name for key in unit)
        return without_inhibitors(builder.build(), inhibitors)

    def follow_references(self, ends: dict[str, str]) -> None:
        """Adds to the ends of arcs, by id, what each reference leads to in the end."""
        for key, (tag, _, line) in self.references.items():
            path = [key]
            while path[-1] not in ends:
                following = self.references[path[-1]].leads_to
                if following not in ends and (following not in self.references or following in path[-1:]):
                    said = f"reference {key} leads to {following!r}"
                    self.fail(line, f"{said}, expected the id of a place, a transition or a reference")
                if len(path) > len(self.references):
                    self.fail(line, f"reference {key} leads in a circle, expected a place or a transition")
                path.append(following)
            ends.update(dict.fromkeys(path, ends[path[-1]]))
            kind = self.places if tag == "referencePlace" else self.transitions
            if ends[key] not in kind:
                wanted = tag.removeprefix("reference").lower()
                self.fail(line, f"<{tag}> {key} leads to {ends[key]}, of another kind: expected a {wanted}")

    def sides(self, ends: dict[str, str]) -> tuple[dict[str, _Sides], list[Inhibitor]]:
        """What each transition consumes, produces and reads, by its id; and the inhibitor arcs."""
        arcs: dict[str, _Sides] = {t: ({}, {}, {}) for t in self.transitions}
        halves: dict[tuple[str, str], int] = {}
        marked: dict[tuple[str, str], _Arc] = {}
        inhibitors: list[Inhibitor] = []
        for arc in self.arcs:
            source, target = (
                self.end(arc, "source", arc.source, ends),
                self.end(arc, "target", arc.target, ends),
            )
            into = source in self.places
            if into == (target in self.places):
                both = "places" if into else "transitions"
                self.fail(arc.line, f"arc {arc.key} joins two {both}, expected a place and a transition")
            place, transition = (source, target) if into else (target, source)
            name = self.places[place].name
            if arc.kind != "normal" and not into:
                self.fail(arc.line, f"{arc.kind} arc {arc.key} leads to a place, expected a transition")
            if arc.kind == "inhibitor":
                here = Source(self.file, arc.line)
                inhibitors.append(Inhibitor(name, self.transitions[transition].name, arc.weight, here))
                continue
            if arc.kind == "read":
                read = arcs[transition][2]
                read[name] = max(read.get(name, 0), arc.weight)
                continue
            side = arcs[transition][0 if into else 1]
            if arc.half:
                pair = (place, transition)
                halves[pair] = halves.get(pair, 0) + (arc.weight if into else -arc.weight)
                marked[pair] = arc
                if not into:
                    continue
                side = arcs[transition][2]
            side[name] = side.get(name, 0) + arc.weight
        for pair, difference in halves.items():
            if difference:
                arc = marked[pair]
                self.fail(arc.line, f"found read arc {arc.key} alone, expected an arc back of its weight")
        return arcs, inhibitors

    def end(self, arc: _Arc, attribute: str, key: str, ends: dict[str, str]) -> str:
        if key not in ends:
            self.fail(arc.line, f"{attribute} of arc {arc.key} is {key!r}, expected a place or a transition")
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
    # The parser may still be adding to the text behind the element, so that must stay the object that it is.
    element.clear(keep_tail=True)  # type: ignore[call-arg]
    parent = element.getparent()
    while parent is not None and element.getprevious() is not None:
        del parent[0]


def _of_scheme(kind: str) -> str:
    return re.sub(r"^https://(www2?\.)?", "http://www.", kind)
