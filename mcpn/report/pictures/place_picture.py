"""The picture of a net place by place, each unit in a frame."""

from __future__ import annotations

from collections.abc import Collection

from mcpn.nets.petri import PetriNet
from mcpn.nets.provenance import Provenance
from mcpn.report.pictures.graph import Arrow, Cluster, Graph, Node
from mcpn.report.pictures.unit_picture import Unit, arcs_between, interface, owners_of, unit_of


def net_picture(net: PetriNet, name: str, stable: Collection[int] | None = None) -> Graph:
    """Places and transitions, each unit in a frame.

    Args:
        net: The net.
        name: What the picture shows.
        stable: Places that some stable marking marks, where they are known.
    """
    joining = interface(net)
    of_places, of_transitions = owners_of(net)
    clusters: dict[Unit, Cluster] = {}

    def cluster_of(unit: Unit | None) -> str | None:
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
    for p, t, way, weight in arcs_between(net):
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
    unit = (unit_of(provenance) or ("", ""))[1]
    for stem in (unit, f"OBJ_{unit}", f"PAR_{unit}"):
        if name.startswith(f"{stem}_"):
            return name[len(stem) + 1 :]
    return name
