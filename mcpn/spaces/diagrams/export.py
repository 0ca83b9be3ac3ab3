"""The decision diagram of a set node by node, its levels named by places: for drawings, other libraries."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mcpn._kernel import Zdd
from mcpn.errors import LimitError
from mcpn.nets.formats.dot import dot_string
from mcpn.nets.petri import PetriNet
from mcpn.records import record
from mcpn.spaces.diagrams.encoding import Levels

if TYPE_CHECKING:
    import networkx as nx

MAX_NODES = 5_000
"""Nodes of a diagram that is shown."""


@record(frozen=True)
class DiagramNode:
    """A node of a zero-suppressed diagram.

    Args:
        level: Its level, from 0 on top.
        place: What the level says: a place that is marked, or ``not`` before one that is not, where its
            complement has the level; several, where one level tells of several.
        low: Number of the node for markings whose level is unmarked; -1 for none, -2 for the one that marks
            no further level.
        high: The same for those whose level is marked.
    """

    level: int
    place: str
    low: int
    high: int


@record(frozen=True)
class Diagram:
    """A zero-suppressed diagram: a level that a path skips is unmarked.

    Args:
        nodes: From the root on, by number; children come after who leads to them first.
    """

    nodes: tuple[DiagramNode, ...]

    def __len__(self) -> int:
        return len(self.nodes)

    def to_networkx(self) -> nx.MultiDiGraph[int]:
        """The diagram in networkx: nodes have ``place``, ``level``, edges ``marked``; ends are -1 and -2."""
        import networkx

        graph: nx.MultiDiGraph[int] = networkx.MultiDiGraph()
        for number, node in enumerate(self.nodes):
            graph.add_node(number, place=node.place, level=node.level)
            for marked, target in ((False, node.low), (True, node.high)):
                graph.add_edge(number, target, marked, marked=marked)
        return graph

    def to_dot(self) -> str:
        """The diagram for Graphviz: nodes of a level side by side, dashed edges where it is unmarked.

        Edges to the empty set are left out.
        """
        lines = ["digraph diagram {", '  end [label="1", shape=box];']
        for number, node in enumerate(self.nodes):
            lines.append(f"  n{number} [label={dot_string(node.place)}];")
            for style, target in (("dashed", node.low), ("solid", node.high)):
                if target != EMPTY:
                    name = "end" if target == END else f"n{target}"
                    lines.append(f"  n{number} -> {name} [style={style}];")
        levels: dict[int, list[str]] = {}
        for number, node in enumerate(self.nodes):
            levels.setdefault(node.level, []).append(f"n{number}")
        lines += [f"  {{ rank=same; {' '.join(names)} }}" for _, names in sorted(levels.items())]
        return "\n".join([*lines, "}"]) + "\n"


EMPTY, END = -1, -2


def diagram_of(levels: Levels, net: PetriNet, states: Zdd) -> Diagram:
    """The diagram of a set of markings.

    Args:
        levels: What the levels of its store say.
        net: The net of the places.
        states: The set.

    Raises:
        LimitError: It has more than :data:`MAX_NODES` nodes.
    """
    said: dict[int, list[str]] = {}
    for number, place in enumerate(net.places):
        bit = levels.bit(number)
        if not isinstance(bit, bool):
            said.setdefault(bit[0], []).append(f"not {place.name}" if bit[1] else place.name)
    store = levels.store
    taking = [store.event([level], []) for level in range(store.levels)]
    numbers: dict[Zdd, int] = {}
    nodes: list[tuple[int, Zdd, Zdd]] = []
    tops: dict[Zdd, int] = {states: 0}
    queue = [states] if states else []
    for found in queue:
        level = tops[found]
        while level < store.levels and not found.subset(marked=[level]):
            level += 1
        if level == store.levels:
            numbers[found] = END
            continue
        numbers[found] = len(nodes)
        if len(nodes) == MAX_NODES:
            raise LimitError(f"more than {MAX_NODES} nodes: the limit on a diagram to be shown was hit")
        low = found.subset(unmarked=[level])
        high = found.subset(marked=[level]).images([taking[level]])
        nodes.append((level, low, high))
        for child in (low, high):
            if child and child not in tops:
                tops[child] = level + 1
                queue.append(child)
    return Diagram(
        tuple(
            DiagramNode(
                level,
                ", ".join(said.get(level, [f"level {level}"])),
                *(numbers[child] if child else EMPTY for child in (low, high)),
            )
            for level, low, high in nodes
        )
    )
