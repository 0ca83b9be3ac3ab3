"""Nets as Graphviz text: one writer.

Places are circles, marked ones show their tokens; internal transitions are filled bars, events boxes with the
event's name; read arcs are dashed. Nets of missions are clustered by the element that made each part.
"""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.nets.petri import PetriNet, Place, Transition


def write_dot(net: PetriNet) -> str:
    """A net as a ``digraph``.

    Args:
        net: The net.

    Returns:
        The text; the same net gives the same text.

    Examples:
        >>> from mcpn.testing.nets import token_ring
        >>> print(write_dot(token_ring(1)).splitlines()[0])
        digraph "token-ring-1" {
    """
    return "\n".join(_lines(net)) + "\n"


def _lines(net: PetriNet) -> Iterator[str]:
    yield f"digraph {dot_string(net.name)} {{"
    yield "  rankdir=LR;"
    yield '  node [fontname="Helvetica", fontsize=10];'
    clusters: dict[str, list[str]] = {}
    for number, place in enumerate(net.places):
        clusters.setdefault(_cluster(place), []).append(_place(number, place))
    for number, transition in enumerate(net.transitions):
        clusters.setdefault(_cluster(transition), []).append(_transition(number, transition))
    for number, (name, nodes) in enumerate(clusters.items()):
        if name:
            yield f"  subgraph cluster_{number} {{"
            yield f"    label={dot_string(name)}; color=gray70; fontsize=11;"
            yield from (f"    {node}" for node in nodes)
            yield "  }"
        else:
            yield from (f"  {node}" for node in nodes)
    for number, t in enumerate(net.transitions):
        for p, weight in t.consume:
            yield f"  p{p} -> t{number}{_weight(weight)};"
        for p, weight in t.produce:
            yield f"  t{number} -> p{p}{_weight(weight)};"
        for p, weight in t.read:
            yield f"  p{p} -> t{number}{_weight(weight, 'style=dashed', 'arrowhead=odot')};"
    yield "}"


def _cluster(node: Place | Transition) -> str:
    return str(node.provenance) if node.provenance else ""


def _place(number: int, place: Place) -> str:
    tokens = {0: "", 1: "&#9679;"}.get(place.initial, str(place.initial))
    label = f'label="{tokens}", xlabel={dot_string(place.name)}'
    size = "width=0.3, fixedsize=true" if place.initial < 100 else "width=0.3"  # a long number widens it
    return f"p{number} [shape=circle, {size}, {label}];"


def _transition(number: int, transition: Transition) -> str:
    if transition.internal:
        bar = 'shape=box, height=0.1, width=0.35, style=filled, fillcolor=gray30, label=""'
        look = f"{bar}, xlabel={dot_string(transition.name)}"
    else:
        look = f"shape=box, color=firebrick, label={dot_string(str(transition.event))}"
    return f"t{number} [{look}];"


def _weight(weight: int, *attributes: str) -> str:
    shown = [*attributes, *([f'label="{weight}"'] if weight > 1 else [])]
    return f" [{', '.join(shown)}]" if shown else ""


def dot_string(text: str) -> str:
    """A text as a string of DOT that Graphviz shows as it is.

    Graphviz reads backslashes and the character references of HTML in any label; other escapes, such as those
    of JSON, it shows.
    """
    return '"' + text.replace("&", "&amp;").replace("\\", "\\\\").replace('"', '\\"') + '"'
