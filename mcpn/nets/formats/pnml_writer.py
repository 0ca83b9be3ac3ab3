"""Writes PNML: ids that every edition of XML takes, what is not standard in elements for this tool."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import count

from lxml import etree

from mcpn.errors import InputError
from mcpn.nets.formats.counts import check_counts
from mcpn.nets.formats.pnml import NAMESPACE, NET_TYPE
from mcpn.nets.petri import PetriNet

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
        drawn = _node(page, "place", new_id, place.name, label=place.label)
        places.append(drawn.get("id", ""))
        if place.initial:
            _add(_add(drawn, "initialMarking"), "text", str(place.initial))
    for t in net.transitions:
        remark = ("event", str(t.event)) if t.event is not None else ("rank", str(t.rank or "") or None)
        key = _node(page, "transition", new_id, t.name, *remark, label=t.label).get("id", "")
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
    label: str | None = None,
) -> etree._Element:
    """An element with an id and a label; its name, and what else standard PNML cannot say, as remarks."""
    element = _add(parent, tag, id=new_id(name))
    _add(_add(element, "name"), "text", name if label is None else label)
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
