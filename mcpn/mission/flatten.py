"""From blocks to the objectives graph: recursion replaced by its contents (paper, 5.1 and Fig. 5).

Parallel blocks are kept as sections, each branch with a graph of its own; uses of protocols are expanded,
their names qualified by the use (``transect_north.diving``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from mcpn.errors import LimitError, Source
from mcpn.mission.model import (
    FAIL,
    SUCCEED,
    Block,
    Mission,
    Objective,
    Parallel,
    Parameter,
    Protocol,
    Recursive,
    Use,
)

if TYPE_CHECKING:
    import networkx as nx

MAX_OBJECTIVES = 100_000


@dataclass(frozen=True, slots=True)
class ElementarySection:
    """An elementary objective with its place in the graph.

    Args:
        name: Qualified by the uses that it stands in.
        activities: What it runs.
        success: The next section, or one of the graph's own exits, ``succeed`` and ``fail``.
        failure: The same for failure.
        source: Its line.
        parameters: For the control laws, after inheritance and overrides.
        description: For reports.
    """

    name: str
    activities: tuple[str, ...]
    success: str
    failure: str
    source: Source | None = field(default=None, compare=False)
    parameters: tuple[Parameter, ...] = ()
    description: str | None = None


@dataclass(frozen=True, slots=True)
class Branch:
    """A child of a parallel block.

    Args:
        name: The child's qualified name.
        mandatory: Whether its failure fails the block.
        graph: What it runs; an elementary child is a graph of one section of the same name.
        source: Its line.
    """

    name: str
    mandatory: bool
    graph: ObjectivesGraph
    source: Source | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class ParallelSection:
    """A parallel block with its place in the graph.

    Args:
        name: Qualified by the uses that it stands in.
        branches: Its children, in document order.
        success: The next section, or one of the graph's own exits.
        failure: The same for failure.
        source: Its line.
        description: For reports.
    """

    name: str
    branches: tuple[Branch, ...]
    success: str
    failure: str
    source: Source | None = field(default=None, compare=False)
    description: str | None = None


Section: TypeAlias = ElementarySection | ParallelSection


@dataclass(frozen=True)
class ObjectivesGraph:
    """The objectives graph of a mission, or of a branch of a parallel block.

    Args:
        sections: Those that some route reaches, in document order.
        entry: The first one's name.
    """

    sections: tuple[Section, ...]
    entry: str

    @cached_property
    def _by_name(self) -> dict[str, Section]:
        return {section.name: section for section in self.sections}

    def section(self, name: str) -> Section:
        """The section of this name, at this level."""
        return self._by_name[name]

    def targets(self, section: Section) -> list[Section]:
        """Sections that a section's success and failure lead to; the graph's exits give none."""
        routes = (section.success, section.failure)
        return [self._by_name[route] for route in routes if route in self._by_name]

    def walk(self) -> Iterator[ElementarySection]:
        """Every elementary objective at any depth, in document order."""
        for section in self.sections:
            if isinstance(section, ElementarySection):
                yield section
            else:
                for branch in section.branches:
                    yield from branch.graph.walk()

    def to_networkx(self) -> nx.MultiDiGraph[str]:
        """The same as a networkx graph, branches of parallel blocks at nodes of their own.

        Returns:
            Nodes with ``kind`` (``objective``, ``parallel``, ``exit``), objectives with ``activities``;
            edges with ``outcome`` (``success``, ``failure``), or ``branch`` from a block to its children.
        """
        import networkx

        graph: nx.MultiDiGraph[str] = networkx.MultiDiGraph()
        self._add_to(graph, {SUCCEED: SUCCEED, FAIL: FAIL})
        return graph

    def _add_to(self, graph: nx.MultiDiGraph[str], exits: dict[str, str]) -> None:
        for exit_node in exits.values():
            graph.add_node(exit_node, kind="exit")
        for section in self.sections:
            if isinstance(section, ElementarySection):
                graph.add_node(section.name, kind="objective", activities=section.activities)
            else:
                graph.add_node(section.name, kind="parallel")
            for outcome, route in (("success", section.success), ("failure", section.failure)):
                graph.add_edge(section.name, exits.get(route, route), outcome=outcome)
            for branch in section.branches if isinstance(section, ParallelSection) else ():
                inner = {SUCCEED: f"{branch.name}:ok", FAIL: f"{branch.name}:fail"}
                branch.graph._add_to(graph, inner)
                graph.add_edge(section.name, branch.graph.entry, outcome="branch", mandatory=branch.mandatory)


def flatten(mission: Mission) -> ObjectivesGraph:
    """The objectives graph of a mission.

    Args:
        mission: A valid mission.

    Returns:
        Its graph; sections that no route reaches are left out.

    Raises:
        LimitError: Uses of protocols expand to more than :data:`MAX_OBJECTIVES` objectives.
    """
    return _Flattening(mission).graph(mission.blocks, "", {})


class _Flattening:
    def __init__(self, mission: Mission) -> None:
        self.protocols: dict[str, Protocol] = {p.name: p for p in mission.protocols}
        self.objectives = 0

    def graph(
        self, blocks: tuple[Block, ...], prefix: str, inherited: dict[str, Parameter]
    ) -> ObjectivesGraph:
        sections: list[Section] = []
        entry = self.series(blocks, prefix, {SUCCEED: SUCCEED, FAIL: FAIL}, inherited, sections)
        return _reachable(ObjectivesGraph(tuple(sections), entry))

    def series(
        self,
        blocks: tuple[Block, ...],
        prefix: str,
        exits: dict[str, str],
        inherited: dict[str, Parameter],
        sections: list[Section],
    ) -> str:
        """Adds the sections of sibling blocks and returns the entry of the first."""
        entries = {block.name: self.entry(block, prefix) for block in blocks}
        for block, following in zip(blocks, (*blocks[1:], None), strict=True):
            success = block.success or (following.name if following else SUCCEED)
            routes = entries | exits
            self.block(block, prefix, routes[success], routes[block.failure or FAIL], inherited, sections)
        return entries[blocks[0].name]

    def contents(self, block: Recursive | Use, prefix: str) -> tuple[tuple[Block, ...], str]:
        if isinstance(block, Use):
            return self.protocols[block.protocol].blocks, f"{prefix}{block.name}."
        return block.blocks, prefix

    def entry(self, block: Block, prefix: str) -> str:
        """The name of the section that is entered when the block is."""
        while isinstance(block, Recursive | Use):
            inner, prefix = self.contents(block, prefix)
            block = inner[0]
        return prefix + block.name

    def block(
        self,
        block: Block,
        prefix: str,
        success: str,
        failure: str,
        inherited: dict[str, Parameter],
        sections: list[Section],
    ) -> None:
        name = prefix + block.name
        if isinstance(block, Objective):
            self.objectives += 1
            if self.objectives > MAX_OBJECTIVES:
                raise LimitError(f"more than {MAX_OBJECTIVES} objectives after expansion: the limit was hit")
            parameters = tuple(self.inherit(block.parameters, inherited).values())
            sections.append(
                ElementarySection(
                    name, block.activities, success, failure, block.source, parameters, block.description
                )
            )
        elif isinstance(block, Parallel):
            branches = tuple(self.branch(child, prefix, inherited) for child in block.blocks)
            sections.append(
                ParallelSection(name, branches, success, failure, block.source, block.description)
            )
        else:
            inner, inner_prefix = self.contents(block, prefix)
            scope = self.inherit(block.parameters, inherited)
            if isinstance(block, Use):
                scope = self.inherit(self.protocols[block.protocol].parameters, {}) | scope
            self.series(inner, inner_prefix, {SUCCEED: success, FAIL: failure}, scope, sections)

    def branch(self, child: Block, prefix: str, inherited: dict[str, Parameter]) -> Branch:
        alone = replace(child, success=None, failure=None)
        graph = self.graph((alone,), prefix, inherited)
        return Branch(prefix + child.name, child.mandatory, graph, child.source)

    @staticmethod
    def inherit(own: tuple[Parameter, ...], inherited: dict[str, Parameter]) -> dict[str, Parameter]:
        """Own parameters, overridden by those of an enclosing use."""
        return {p.name: p for p in own} | inherited


def _reachable(graph: ObjectivesGraph) -> ObjectivesGraph:
    seen, stack = {graph.entry}, [graph.entry]
    while stack:
        for target in graph.targets(graph.section(stack.pop())):
            if target.name not in seen:
                seen.add(target.name)
                stack.append(target.name)
    return ObjectivesGraph(tuple(s for s in graph.sections if s.name in seen), graph.entry)
