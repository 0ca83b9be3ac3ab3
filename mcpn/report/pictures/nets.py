"""Nets as pictures: the units of a mission's net and what joins them, or one section place by place.

The paper's colours: what is internal to a unit is red, a place that no stable marking marks is orange
(temporary), the interface between units is green. Borders differ as well, for those who see no colours.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator

from mcpn.answers.spaces import MissionSpaces
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError, SemanticsError
from mcpn.nets.petri import PetriNet, Provenance
from mcpn.report.pictures.drawing import Drawing
from mcpn.report.pictures.graph import Arrow, Cluster, Graph, Node, drawing

MOST_LISTED = 20_000
"""Most stable markings that are listed to find which places are temporary."""


def net_drawing(net: PetriNet) -> Drawing:
    """The picture of a net, place by place."""
    return drawing(net_picture(net, f"Net {net.name}"))


def section_net_drawing(spaces: MissionSpaces, section: str) -> Drawing:
    """The picture of the local net of a section, place by place.

    Args:
        spaces: The mission's spaces.
        section: The section's name.

    Raises:
        InputError: There is no such section.
    """
    local = spaces.section(section).mission
    try:
        _, graph = spaces.local(section, MOST_LISTED)
    except (LimitError, SemanticsError):
        return drawing(net_picture(local.net, f"Net of the section {section}"))
    marked = {
        place for state in range(graph.states) for place, tokens in enumerate(graph.marking(state)) if tokens
    }
    stable = {local.net.place_index[graph.net.places[place].name] for place in marked}
    stable |= {*local.saying("open"), *local.saying("happened")}
    return drawing(net_picture(local.net, f"Net of the section {section}", stable))


def units_drawing(mission_net: MissionNet) -> Drawing:
    """The picture of the units of a mission's net; curves are interface places between two of them."""
    return drawing(units_picture(mission_net.net, f"Net of the mission {mission_net.mission.name}"))


# --- units ---------------------------------------------------------------------------------------------

_Unit = tuple[str, str]


def _unit(provenance: Provenance | None) -> _Unit | None:
    """The unit that something belongs to: alternatives are drawn with their activity."""
    if provenance is None:
        return None
    if provenance.kind == "alternative":
        return "activity", provenance.name.split(".")[0]
    return provenance.kind, provenance.name


def _arcs(net: PetriNet) -> Iterator[tuple[int, int, str, int]]:
    """Each arc: place, transition, ``consume``, ``produce`` or ``read``, weight."""
    for number, t in enumerate(net.transitions):
        for way in ("consume", "produce", "read"):
            for place, weight in getattr(t, way):
                yield place, number, way, weight


def _owners(net: PetriNet) -> tuple[list[_Unit | None], list[_Unit | None]]:
    """The unit of each place and of each transition.

    In a mission's net their provenance says it. In a net from elsewhere a transition belongs to the declared
    unit that holds all of its places; units of one place are ignored, since they group nothing.
    """
    places = [_unit(place.provenance) for place in net.places]
    transitions = [_unit(transition.provenance) for transition in net.transitions]
    if any(places) or any(transitions):
        return places, transitions
    for number, unit in enumerate(net.units, 1):
        for place in unit if len(unit) > 1 else ():
            places[place] = places[place] or ("unit", str(number))
    touched: dict[int, set[_Unit | None]] = {}
    for place, transition, _, _ in _arcs(net):
        touched.setdefault(transition, set()).add(places[place])
    for transition, units in touched.items():
        if len(units) == 1:
            transitions[transition] = units.pop()
    return places, transitions


def interface(net: PetriNet) -> set[int]:
    """Places that join units: a transition of another unit has an arc with it."""
    places, transitions = _owners(net)
    return {place for place, transition, _, _ in _arcs(net) if places[place] != transitions[transition]}


def units_picture(net: PetriNet, name: str) -> Graph:
    """Units as boxes, and curves that say how many interface places lead from one to another."""
    places = Counter(_unit(place.provenance) for place in net.places)
    transitions = Counter(_unit(transition.provenance) for transition in net.transitions)
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
    for place, transition, way, _ in _arcs(net):
        ends = keys[_unit(net.places[place].provenance)], keys[_unit(net.transitions[transition].provenance)]
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


# --- place by place ------------------------------------------------------------------------------------


def net_picture(net: PetriNet, name: str, stable: Collection[int] | None = None) -> Graph:
    """Places and transitions, each unit in a frame.

    Args:
        net: The net.
        name: What the picture shows.
        stable: Places that some stable marking marks, where they are known.
    """
    joining = interface(net)
    of_places, of_transitions = _owners(net)
    clusters: dict[_Unit, Cluster] = {}

    def cluster_of(unit: _Unit | None) -> str | None:
        if unit is None:
            return None
        known = clusters.setdefault(unit, Cluster(f"c{len(clusters)}", " ".join(unit)))
        return known.key

    nodes = []
    for number, place in enumerate(net.places):
        kind = "internal"
        if number in joining:
            kind = "interface"
        elif stable is not None and number not in stable:
            kind = "temporary"
        marked = " marked" if place.initial else ""
        tokens = {0: "", 1: "● "}.get(place.initial, f"{place.initial} ")
        title = f"place {place.name} ({kind})" + (f", {place.initial} tokens at first" if marked else "")
        text = tokens + _short(place.name, place.provenance)
        nodes.append(
            Node(f"p{number}", (text,), f"place {kind}{marked}", title, cluster_of(of_places[number]))
        )
    for number, transition in enumerate(net.transitions):
        if transition.event is None:
            line, kind = "", "transition"
        else:
            line, kind = str(transition.event), "transition happens"
        title = f"transition {transition.name}"
        nodes.append(Node(f"t{number}", (line,), kind, title, cluster_of(of_transitions[number])))
    edges = []
    for p, t, way, weight in _arcs(net):
        ends = (f"p{p}", f"t{t}") if way != "produce" else (f"t{t}", f"p{p}")
        told = (str(weight),) if weight > 1 else ()
        kind = "read" if way == "read" else "arc"
        edges.append(Arrow(*ends, kind, told, arrow=way != "read"))
    # Units of a mission are laid out one by one; those from elsewhere may be small and many.
    nested = any(place.provenance for place in net.places)
    return Graph(name, nodes, edges, list(clusters.values()), nested=nested)


def _short(name: str, provenance: Provenance | None) -> str:
    """A name without that of its unit, whose frame says it."""
    if provenance is None:
        return name
    unit = (_unit(provenance) or ("", ""))[1]
    for stem in (unit, f"OBJ_{unit}", f"PAR_{unit}"):
        if name.startswith(f"{stem}_"):
            return name[len(stem) + 1 :]
    return name
