"""The objectives graph as a picture: sections and their routes; of a long one the blocks they stand in."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from mcpn.drawing.compose import MissionNet
from mcpn.mission.core.objectives_graph import ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.core.routes import GO_ON, Interruption
from mcpn.mission.fact_cases import FactCase
from mcpn.mission.model import ABORT, FAIL, SUCCEED, TIMED_OUT
from mcpn.report.pictures.drawing import Drawing
from mcpn.report.pictures.graph import Arrow, Cluster, Graph, Node, drawing

MOST_SECTIONS = 80
"""Sections that are drawn one by one; of more, those of one block are drawn as one."""

MOST_INTERRUPTED = 4
"""Sections that an event may lead from to one target with a curve for each."""

ENDS = {SUCCEED: "success", FAIL: "failure", ABORT: "abort"}


def objectives_drawing(mission_net: MissionNet, notes: Mapping[str, str] | None = None) -> Drawing:
    """The picture of an objectives graph.

    Args:
        mission_net: The mission's net.
        notes: By section, what stands below its name instead of its activities.
    """
    name = f"Objectives graph of the mission {mission_net.mission.name}"
    return drawing(objectives_picture(mission_net.graph, name, notes))


def objectives_picture(graph: ObjectivesGraph, name: str, notes: Mapping[str, str] | None = None) -> Graph:
    """The picture as a graph of nodes and arrows, without positions."""
    if sum(1 for _ in graph.all_sections()) > MOST_SECTIONS:
        return _by_block(graph, name)
    drawn = _Drawn(notes or {})
    drawn.level(graph, dict.fromkeys(ENDS, ""), None)
    drawn.gather()
    ends = [Node(key, (word,), f"node {word}") for key, word in ENDS.items() if key in drawn.reached]
    begin = Node("", ("start",), "node")
    edges = [Arrow("", drawn.first(graph), "success", title="the mission starts"), *drawn.edges]
    return Graph(name, [begin, *drawn.nodes, *ends], edges, drawn.clusters)


class _Drawn:
    """What has been drawn so far."""

    def __init__(self, notes: Mapping[str, str]) -> None:
        self.notes = notes
        self.nodes: list[Node] = []
        self.edges: list[Arrow] = []
        self.clusters: list[Cluster] = []
        self.reached: set[str] = set()

    def level(self, graph: ObjectivesGraph, exits: Mapping[str, str], cluster: str | None) -> None:
        """Draws the sections of one graph and their routes; exits lead to nodes, or to the ends by name."""
        for section in graph.sections:
            if isinstance(section, ElementarySection):
                told = self.notes.get(section.name)
                lines = section.activities if told is None else (told,)
                self.nodes.append(
                    Node(section.name, (section.name, *lines), "node", _title(section), cluster)
                )
            else:
                self._block(section, cluster)
                self._meanwhile(section, graph, exits)
            for route, lines, kind in _routes(section):
                target = self._target(graph, exits, route)
                if route in exits:
                    self.reached.add(target)
                said = lines if kind == "event" else (kind, *lines)
                to = ENDS.get(route, target if route in exits else route)
                title = f"{section.name}: {', '.join(said)} leads to {to}"
                self.edges.append(Arrow(self.last(section), target, kind, lines, title))

    def gather(self) -> None:
        """Draws an event as one box where it interrupts so many sections that its curves would hide them."""
        events = [edge for edge in self.edges if edge.kind == "event"]
        counts = Counter((edge.lines, edge.target) for edge in events)
        for number, ((lines, target), count) in enumerate(counts.items()):
            if count > MOST_INTERRUPTED:
                gone = [e for e in events if (e.lines, e.target) == (lines, target)]
                title = "; ".join(edge.title for edge in gone)
                key = f"event {number}"
                self.nodes.append(Node(key, (*lines, f"in any of {count} sections"), "node", title))
                self.edges = [edge for edge in self.edges if edge not in gone]
                self.edges.append(Arrow(key, target, "event", title=title))

    def _block(self, section: ParallelSection, cluster: str | None) -> None:
        """A parallel block: a frame with its branches, a box where they begin and one where they end."""
        key = f"block {section.name}"
        name = f"{section.name}, in parallel" + (
            f": {self.notes[section.name]}" if section.name in self.notes else ""
        )
        self.clusters.append(Cluster(key, name, cluster))
        fork, join = f"fork {section.name}", f"join {section.name}"
        self.nodes += [
            Node(fork, ("",), "transition", f"{section.name} begins", key),
            Node(join, ("",), "transition", f"{section.name} ends", key),
        ]
        for branch in section.branches:
            word = () if branch.mandatory else ("optional",)
            self.edges.append(Arrow(fork, self.first(branch.graph), "arc", word, f"{branch.name} begins"))
            self.level(branch.graph, dict.fromkeys(ENDS, join), key)

    def _meanwhile(self, section: ParallelSection, graph: ObjectivesGraph, exits: Mapping[str, str]) -> None:
        """What runs while a parallel block pauses, in its frame; it leads back to where the block begins."""
        inside, last = f"block {section.name}", self.last(section)
        leading = {exit_: self._target(graph, exits, to) for exit_, to in section.pause_exits}
        self.reached.update(leading.values())
        first = [self.first(pause_graph.graph) for pause_graph in section.pause_graphs]
        for interrupted, begin in zip((section, *section.pause_graphs), (last, *first), strict=True):
            for i in interrupted.interruptions:
                word, to = _on(i), None if i.pauses is None else first[i.pauses]
                if to is not None:
                    title = f"{section.name}: {word} runs {to}, then goes on"
                    self.edges.append(Arrow(begin, to, "event", (word,), title))
        for pause_graph, begin in zip(section.pause_graphs, first, strict=True):
            for i in pause_graph.interruptions:
                for route, lines, kind in _by_facts(i.target, i.cases, (_on(i),), "event"):
                    if i.pauses is None:
                        title = f"{begin}: {', '.join(lines)} leads to {leading[route]}"
                        self.edges.append(Arrow(begin, leading[route], kind, lines, title))
            self.level(pause_graph.graph, {GO_ON: f"fork {section.name}", **leading}, inside)

    def _target(self, graph: ObjectivesGraph, exits: Mapping[str, str], route: str) -> str:
        """The node that a route of a graph leads to."""
        return exits[route] or route if route in exits else self.first(graph, route)

    def first(self, graph: ObjectivesGraph, name: str | None = None) -> str:
        """The node at which a section begins."""
        section = graph.section(name or graph.entry)
        return section.name if isinstance(section, ElementarySection) else f"fork {section.name}"

    @staticmethod
    def last(section: Section) -> str:
        """The node at which a section ends."""
        return section.name if isinstance(section, ElementarySection) else f"join {section.name}"


def _routes(section: Section) -> Iterator[tuple[str, tuple[str, ...], str]]:
    """Where a section may lead, with what stands beside the arrow, and of which kind that is."""
    meanwhile = dict(section.pause_exits) if isinstance(section, ParallelSection) else {}
    named = {to: why for why, to in section.failures if why} if isinstance(section, ElementarySection) else {}
    becoming = dict(section.becoming)
    for outcome, route in section.outcomes:
        if outcome in meanwhile:
            continue  # what runs meanwhile leads there by itself
        lines, kind = ((outcome,), "event") if outcome in ("abort", TIMED_OUT) else ((), outcome)
        if outcome in named:
            lines, kind = (f"for {named[outcome]}",), "failure"
        if outcome in becoming:
            lines, kind = (f"on {becoming[outcome].words}",), "event"
        yield from _by_facts(route, section.cases_of(outcome), lines, kind)
    for interruption in section.interruptions:
        if interruption.pauses is None:
            lines = (_on(interruption),)
            yield from _by_facts(interruption.target, interruption.cases, lines, "event")


def _on(interruption: Interruption) -> str:
    return f"on {interruption.event}" + (" once" if interruption.once else "")


def _by_facts(
    route: str, cases: Sequence[FactCase], lines: tuple[str, ...], kind: str
) -> Iterator[tuple[str, tuple[str, ...], str]]:
    """The cases of a route, labelled with their conditions on facts, then its default, labelled else."""
    for case in cases:
        yield case.target, (*lines, f"when {case.words}"), kind
    yield route, (*lines, "else") if cases else lines, kind


def _title(section: ElementarySection) -> str:
    told = f"objective {section.name}: {', '.join(section.activities)}"
    return f"{told}; {section.description}" if section.description else told


def _by_block(graph: ObjectivesGraph, name: str) -> Graph:
    """Sections of one block as one box: the deepest blocks of which there are few enough, or neighbours."""
    group_of = _groups(graph)
    members = Counter(group_of.values())
    nodes = [Node("", ("start",), "node")]
    nodes += [
        Node(group, (group, f"{count} sections" if count > 1 else "1 section"), "node")
        for group, count in members.items()
    ]
    counts: Counter[tuple[str, str, str]] = Counter()
    for section in graph.sections:
        for route, _, kind in _routes(section):
            source, target = group_of[section.name], group_of.get(route, route)
            if source != target:
                counts[source, target, kind] += 1
    ends = {target for _, target, _ in counts} & ENDS.keys()
    nodes += [Node(key, (ENDS[key],), f"node {ENDS[key]}") for key in ENDS if key in ends]
    edges = [Arrow("", group_of[graph.entry], "success", title="the mission starts")]
    edges += [
        Arrow(source, target, kind, (f"{count}",) if count > 1 else (), f"{count} routes on {kind}")
        for (source, target, kind), count in counts.items()
    ]
    return Graph(name, nodes, edges)


def _groups(graph: ObjectivesGraph) -> dict[str, str]:
    names = [section.name for section in graph.sections]
    for depth in range(max(name.count(".") for name in names), 0, -1):
        group_of = {name: ".".join(name.split(".")[:depth]) for name in names}
        if len(set(group_of.values())) <= MOST_SECTIONS:
            return group_of
    size = -(-len(names) // MOST_SECTIONS)
    group_of = {}
    for start in range(0, len(names), size):
        part = names[start : start + size]
        group_of |= dict.fromkeys(part, f"{part[0]} to {part[-1]}" if len(part) > 1 else part[0])
    return group_of
