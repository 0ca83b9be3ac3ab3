"""Graphs as pictures: boxes in clusters, and curves between them, laid out in layers by Graphviz.

Graphviz gets sizes and numbers only. Texts stay here and are escaped when the picture is written.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Self, TypeAlias

from mcpn.errors import LimitError
from mcpn.report.pictures.drawing import Drawing, rendered
from mcpn.report.pictures.graphviz import Layout, Question, Size, laid_out
from mcpn.report.pictures.layout import shown, text_width

MOST_NODES, MOST_EDGES = 300, 900
"""Boxes and curves of one drawing."""

MOST_AT_ONCE = 400
"""Curves that are laid out together: nobody can follow more, and their layout takes long."""

LINE, MARGIN, MOST_IN_NODE, MOST_IN_LABEL = 17, 8, 60, 44
TEXT, SMALL = 13.0, 11.5
NAME = 18
"""Height of a cluster's name."""


@dataclass(frozen=True)
class Node:
    """A box.

    Args:
        key: Unique among the nodes of its graph.
        lines: What stands in it, its name first.
        kind: Its class in the picture.
        title: The text for a pointer that rests on it, or a screen reader.
        cluster: The key of the cluster that it stands in.
        data: What a script finds it by.
        size: Its width and height, where its lines do not say them.
    """

    key: str
    lines: tuple[str, ...]
    kind: str
    title: str = ""
    cluster: str | None = None
    data: tuple[tuple[str, str], ...] = ()
    size: tuple[float, float] | None = None


@dataclass(frozen=True)
class Arrow:
    """A curve from one box to another.

    Args:
        source: Key of a node.
        target: Key of a node.
        kind: Its class in the picture: ``success``, ``failure``, ``event`` or ``arc``.
        lines: What stands beside it.
        title: The text for a pointer that rests on it.
        both: Whether it has an arrow at its beginning, too.
        arrow: Whether it has an arrow at its end.
    """

    source: str
    target: str
    kind: str
    lines: tuple[str, ...] = ()
    title: str = ""
    both: bool = False
    arrow: bool = True


@dataclass(frozen=True)
class Cluster:
    """A frame around nodes.

    Args:
        key: Unique among the clusters of its graph.
        name: What stands at its top.
        parent: The key of the cluster that it stands in.
        kind: Its class in the picture.
    """

    key: str
    name: str
    parent: str | None = None
    kind: str = "cluster"


@dataclass(frozen=True)
class Graph:
    """What a picture shows, before it is laid out.

    Args:
        name: What it shows, in words.
        nodes: Its boxes.
        edges: Its curves.
        clusters: Frames, outer ones before what they hold.
        sideways: Whether its layers stand beside each other instead of below each other.
        nested: Whether each cluster is laid out by itself; what joins clusters is then drawn straight.
    """

    name: str
    nodes: Sequence[Node]
    edges: Sequence[Arrow] = ()
    clusters: Sequence[Cluster] = ()
    sideways: bool = False
    nested: bool = False


Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class Item:
    """What has a place in the picture."""

    x: float
    y: float

    def moved(self, by: Point) -> Self:
        """A copy, moved by a vector."""
        return replace(self, x=self.x + by[0], y=self.y + by[1])


@dataclass(frozen=True)
class Frame(Item):
    """A rectangle: a node or a cluster."""

    width: float
    height: float
    kind: str
    title: str
    data: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Curve:
    """An edge: a spline from its second point on, and straight ends before and after it, or none."""

    points: tuple[Point, ...]
    kind: str
    title: str
    both: bool
    arrow: bool
    start: Point | None = None
    end: Point | None = None

    @property
    def path(self) -> str:
        """As SVG writes it."""
        points = [_coordinates(point) for point in self.points]
        before = f"M{_coordinates(self.start)}L{points[0]}" if self.start else f"M{points[0]}"
        spline = f"C{' '.join(points[1:])}" if len(points) > 1 else ""
        return before + spline + (f"L{_coordinates(self.end)}" if self.end else "")

    def moved(self, by: Point) -> Curve:
        """A copy, moved by a vector."""
        points = tuple(_sum(point, by) for point in self.points)
        start, end = (point and _sum(point, by) for point in (self.start, self.end))
        return replace(self, points=points, start=start, end=end)


def _coordinates(point: Point) -> str:
    return f"{point[0]:.1f},{point[1]:.1f}"


def _sum(one: Point, other: Point) -> Point:
    return one[0] + other[0], one[1] + other[1]


@dataclass(frozen=True)
class Text(Item):
    """A line of text around the middle ``x``."""

    text: str
    kind: str


@dataclass
class Placed:
    """A graph that has been laid out, its nodes by their keys."""

    width: float = 0
    height: float = 0
    clusters: list[Frame] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    texts: list[Text] = field(default_factory=list)
    nodes: dict[str, Frame] = field(default_factory=dict)

    def put(self, other: Placed, by: Point) -> None:
        """Adds what another has, moved."""
        self.clusters += [frame.moved(by) for frame in other.clusters]
        self.curves += [curve.moved(by) for curve in other.curves]
        self.texts += [text.moved(by) for text in other.texts]
        self.nodes |= {key: frame.moved(by) for key, frame in other.nodes.items()}


def drawing(graph: Graph) -> Drawing:
    """The picture of a graph; it is laid out when it is needed."""
    return Drawing(graph.name, lambda: rendered("graph.svg", picture=lay_out(graph), name=graph.name))


def lay_out(graph: Graph) -> Placed:
    """Places a graph in layers.

    Raises:
        LimitError: It has too many boxes or curves to be read, or the extra ``pictures`` is missing.
    """
    return lay_out_all([graph])[0]


def lay_out_all(graphs: Sequence[Graph]) -> list[Placed]:
    """Places several graphs, faster than one after the other.

    Raises:
        LimitError: As of :func:`lay_out`.
    """
    for graph in graphs:
        for count, most, what in (
            (len(graph.nodes), MOST_NODES, "boxes"),
            (len(graph.edges), MOST_EDGES if graph.nested else MOST_AT_ONCE, "curves"),
        ):
            if count > most:
                told = f"{graph.name}: {count:,} {what}"
                raise LimitError(f"{told}, the limit of what one drawing shows is {most}")
    inner = [part for graph in graphs for part in (_parts(graph) if graph.nested else [graph])]
    placed = iter(_layered(inner))
    found = []
    for graph in graphs:
        if graph.nested:
            found.append(_nested(graph, {cluster.key: next(placed) for cluster in graph.clusters}))
        else:
            found.append(next(placed))
    return found


def _layered(graphs: Sequence[Graph]) -> list[Placed]:
    layouts = laid_out([_question(graph) for graph in graphs], ", ".join(graph.name for graph in graphs))
    return [_placed(graph, layout) for graph, layout in zip(graphs, layouts, strict=True)]


def _placed(graph: Graph, layout: Layout) -> Placed:
    left, bottom, right, top = map(float, layout["bb"].split(","))
    placed = Placed(right - left + 2 * MARGIN, top - bottom + 2 * MARGIN)

    def at(point: str) -> Point:
        x, y = map(float, point.split(","))
        return x - left + MARGIN, top - y + MARGIN

    nodes = {f"n{number}": node for number, node in enumerate(graph.nodes)}
    clusters = {f"cluster_{number}": cluster for number, cluster in enumerate(graph.clusters)}
    for item in layout.get("objects", ()):
        if item["name"] in clusters and "bb" in item:
            corners = item["bb"].split(",")
            (x, low), (end, high) = at(",".join(corners[:2])), at(",".join(corners[2:]))
            _frame(placed, clusters[item["name"]], Frame(x, high, end - x, low - high, "", ""))
        elif item["name"] in nodes:
            _place(placed, nodes[item["name"]], at(item["pos"]))
    for item in layout.get("edges", ()):
        edge = graph.edges[int(item["class"][1:])]
        curve = _curve(edge, item["pos"], at)
        placed.curves.append(curve)
        x, y = at(item["lp"]) if "lp" in item else curve.points[0]
        y -= 13 * (len(edge.lines) - 1) / 2 - 4
        for number, line in enumerate(edge.lines):
            placed.texts.append(Text(x, y + 13 * number, shown(line, MOST_IN_LABEL), f"label {edge.kind}"))
    return placed


def _parts(graph: Graph) -> list[Graph]:
    """The inside of each cluster."""
    cluster_of = {node.key: node.cluster for node in graph.nodes}
    parts = []
    for cluster in graph.clusters:
        members = [replace(node, cluster=None) for node in graph.nodes if node.cluster == cluster.key]
        edges = [e for e in graph.edges if cluster_of[e.source] == cluster_of[e.target] == cluster.key]
        parts.append(Graph(cluster.name, members, edges))
    return parts


def _nested(graph: Graph, inside: Mapping[str, Placed]) -> Placed:
    """Lays out clusters, each placed already, as boxes; then draws the edges between them."""
    cluster_of = {node.key: node.cluster for node in graph.nodes}
    boxes = [
        Node(key, ("",), "", size=(placed.width, placed.height + NAME)) for key, placed in inside.items()
    ]
    crossing = [
        e for e in graph.edges if cluster_of[e.source] != cluster_of[e.target] or cluster_of[e.source] is None
    ]
    pairs = dict.fromkeys(
        (cluster_of[e.source] or e.source, cluster_of[e.target] or e.target) for e in crossing
    )
    free = [node for node in graph.nodes if node.cluster is None]
    joints = [Arrow(*pair, "arc") for pair in pairs if pair[::-1] not in pairs or pair < pair[::-1]]
    (outer,) = _layered([Graph(graph.name, [*boxes, *free], joints, sideways=graph.sideways)])
    placed = Placed(outer.width, outer.height)
    for cluster in graph.clusters:
        box = outer.nodes[cluster.key]
        _frame(placed, cluster, box)
        placed.put(inside[cluster.key], (box.x, box.y + NAME))
    for node in free:
        box = outer.nodes[node.key]
        _place(placed, node, (box.x + box.width / 2, box.y + box.height / 2))
    for edge in crossing:
        source, target = placed.nodes[edge.source], placed.nodes[edge.target]
        start, end = _towards(source, target), _towards(target, source)
        kind = f"{edge.kind} joins"
        placed.curves.append(Curve((start, start, end, end), kind, edge.title, edge.both, edge.arrow))
    return placed


def _towards(frame: Frame, other: Frame) -> Point:
    """Where the straight line from one box to the middle of another leaves it."""
    x, y = frame.x + frame.width / 2, frame.y + frame.height / 2
    dx, dy = other.x + other.width / 2 - x, other.y + other.height / 2 - y
    sides = (frame.width / 2, dx), (frame.height / 2, dy)
    share = min([1.0, *(half / abs(d) for half, d in sides if d)])
    return x + dx * share, y + dy * share


def _frame(placed: Placed, cluster: Cluster, box: Frame) -> None:
    placed.clusters.append(replace(box, kind=cluster.kind, title=shown(cluster.name, 1000)))
    placed.texts.append(Text(box.x + box.width / 2, box.y + 15, shown(cluster.name), "cluster-name"))


def _place(placed: Placed, node: Node, middle: Point) -> None:
    width, height = _size(node)
    x, y = middle
    title = shown(node.title or node.lines[0], 1000)
    frame = Frame(x - width / 2, y - height / 2, width, height, node.kind, title, node.data)
    placed.nodes[node.key] = frame
    first = y - LINE * (len(node.lines) - 1) / 2 + 4.5
    for number, line in enumerate(node.lines):
        kind = "small" if _small(node) else "note" if number else "name"
        placed.texts.append(Text(x, first + LINE * number, shown(line, MOST_IN_NODE), kind))


def _small(node: Node) -> bool:
    return node.kind.startswith(("place", "transition"))


def _size(node: Node) -> tuple[float, float]:
    """Width and height of a box."""
    if node.size is not None:
        return node.size
    texts = [shown(line, MOST_IN_NODE) for line in node.lines]
    if not any(texts):
        return 34.0, 9.0
    sizes = [SMALL if _small(node) else TEXT + 2.5 if number == 0 else SMALL for number in range(len(texts))]
    width = max(text_width(text, size) for text, size in zip(texts, sizes, strict=True))
    return width + 16, LINE * len(texts) + (4 if _small(node) else 10)


def _question(graph: Graph) -> Question:
    """What Graphviz is asked of a graph."""
    number = {node.key: n for n, node in enumerate(graph.nodes)}
    cluster_number = {cluster.key: n for n, cluster in enumerate(graph.clusters)}
    clusters = [
        {
            "parent": None if cluster.parent is None else cluster_number[cluster.parent],
            "members": [number[node.key] for node in graph.nodes if node.cluster == cluster.key],
            "label": (text_width(shown(cluster.name), SMALL) + 8, 16),
        }
        for cluster in graph.clusters
    ]
    edges = [
        {
            "ends": (number[edge.source], number[edge.target]),
            "label": _label(edge),
            "both": edge.both,
            "arrow": edge.arrow,
            "weight": 6 if edge.kind == "success" else 1,
        }
        for edge in graph.edges
    ]
    nodes = [_size(node) for node in graph.nodes]
    return {"sideways": graph.sideways, "nodes": nodes, "clusters": clusters, "edges": edges}


def _label(edge: Arrow) -> Size | None:
    """The size of what stands beside an edge."""
    if not edge.lines:
        return None
    wide = max(text_width(shown(line, MOST_IN_LABEL), SMALL) for line in edge.lines)
    return wide + 6, 13 * len(edge.lines) + 4


def _curve(edge: Arrow, position: str, at: Callable[[str], Point]) -> Curve:
    """An edge with its spline as Graphviz writes it."""
    start = end = None
    points = []
    for word in position.split():
        if word.startswith("s,"):
            start = at(word[2:])
        elif word.startswith("e,"):
            end = at(word[2:])
        else:
            points.append(at(word))
    title = shown(edge.title, 1000)
    return Curve(tuple(points), edge.kind, title, edge.both, edge.arrow, start, end)
