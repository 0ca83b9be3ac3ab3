"""The picture of a mission's net by units: who draws what, and what joins them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from mcpn.nets.petri import PetriNet
from mcpn.nets.provenance import Provenance
from mcpn.report.pictures.graph import Arrow, Graph, Node

Unit = tuple[str, str]


def unit_of(provenance: Provenance | None) -> Unit | None:
    """The unit that something belongs to: alternatives are drawn with their activity."""
    if provenance is None:
        return None
    if provenance.kind == "alternative":
        return "activity", provenance.name.split(".")[0]
    return provenance.kind, provenance.name


def arcs_between(net: PetriNet) -> Iterator[tuple[int, int, str, int]]:
    """Each arc: place, transition, ``consume``, ``produce`` or ``read``, weight."""
    for number, t in enumerate(net.transitions):
        for way in ("consume", "produce", "read"):
            for place, weight in getattr(t, way):
                yield place, number, way, weight


def owners_of(net: PetriNet) -> tuple[list[Unit | None], list[Unit | None]]:
    """The unit of each place and of each transition.

    In a mission's net their provenance says it. In a net from elsewhere a transition belongs to the declared
    unit that holds all of its places; units of one place are ignored, since they group nothing.
    """
    places = [unit_of(place.provenance) for place in net.places]
    transitions = [unit_of(transition.provenance) for transition in net.transitions]
    if any(places) or any(transitions):
        return places, transitions
    for number, unit in enumerate(net.units, 1):
        for place in unit if len(unit) > 1 else ():
            places[place] = places[place] or ("unit", str(number))
    touched: dict[int, set[Unit | None]] = {}
    for place, transition, _, _ in arcs_between(net):
        touched.setdefault(transition, set()).add(places[place])
    for transition, units in touched.items():
        if len(units) == 1:
            transitions[transition] = units.pop()
    return places, transitions


def interface(net: PetriNet) -> set[int]:
    """Places that join units: a transition of another unit has an arc with it."""
    places, transitions = owners_of(net)
    return {
        place for place, transition, _, _ in arcs_between(net) if places[place] != transitions[transition]
    }


def units_picture(net: PetriNet, name: str) -> Graph:
    """Units as boxes, and curves that say how many interface places lead from one to another."""
    places = Counter(unit_of(place.provenance) for place in net.places)
    transitions = Counter(unit_of(transition.provenance) for transition in net.transitions)
    keys = {unit: f"u{number}" for number, unit in enumerate({**places, **transitions})}
    nodes = [
        Node(
            keys[unit],
            (unit[1], unit[0], f"{places[unit]} places, {transitions[unit]} transitions")
            if unit
            else (net.name,),
            "node",
        )
        for unit in keys
    ]
    joined: dict[tuple[str, str], set[int]] = {}
    for place, transition, way, _ in arcs_between(net):
        ends = (
            keys[unit_of(net.places[place].provenance)],
            keys[unit_of(net.transitions[transition].provenance)],
        )
        if ends[0] != ends[1]:
            joined.setdefault(ends if way != "produce" else ends[::-1], set()).add(place)
    edges = []
    for (source, target), shared in joined.items():
        back = (target, source) in joined
        if back and source > target:
            continue
        every = shared | joined.get((target, source), set())
        names = ", ".join(net.places[place].name for place in sorted(every))
        edges.append(Arrow(source, target, "joint", (f"{len(every)}",), f"interface places: {names}", back))
    return Graph(name, nodes, edges, sideways=True)
