"""From blocks to the objectives graph: recursion replaced by its contents (paper, 5.1 and Fig. 5).

Parallel blocks are kept as sections, each branch with a graph of its own; uses of protocols are expanded,
their names qualified by the use (``transect_north.diving``).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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
MAX_PARAMETERS = 1_000_000
MAX_NESTING = 128


@dataclass(frozen=True, slots=True)
class ElementarySection:
    """An elementary objective with its place in the graph.

    Args:
        name: Qualified by the uses that it stands in.
        activities: What it runs.
        success: The next section, or one of the graph's own exits, ``succeed`` and ``fail``.
        failure: The same for failure.
        source: Its line.
        parameters: For the control laws: those of enclosing recursive objectives and protocols, then its own;
            the innermost of a name counts, and a use's overrides replace what its protocol says.
        description: For reports.
        duration: Its mean duration in hours, where known.
        failure_probability: How probable it is that it fails though it could succeed.
    """

    name: str
    activities: tuple[str, ...]
    success: str
    failure: str
    source: Source | None = field(default=None, compare=False)
    parameters: tuple[Parameter, ...] = ()
    description: str | None = None
    duration: float | None = None
    failure_probability: float = 0.0


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
        unreached: Those that no route reaches, in document order; they are part of nothing that follows.
    """

    sections: tuple[Section, ...]
    entry: str
    unreached: tuple[Section, ...] = ()

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

    def never_entered(self) -> Iterator[ElementarySection]:
        """Every elementary objective, at any depth, that stands in a section that no route reaches."""
        for section in self.sections:
            for branch in section.branches if isinstance(section, ParallelSection) else ():
                yield from branch.graph.never_entered()
        for section in self.unreached:
            if isinstance(section, ElementarySection):
                yield section
            else:
                for branch in section.branches:
                    yield from branch.graph.walk()
                    yield from branch.graph.never_entered()

    def all_sections(self) -> Iterator[Section]:
        """Every section at any depth, parallel blocks before what they hold, in document order."""
        for section in self.sections:
            yield section
            if isinstance(section, ParallelSection):
                for branch in section.branches:
                    yield from branch.graph.all_sections()

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
        Its graph; sections that no route reaches are kept aside in it.

    Raises:
        LimitError: Uses of protocols expand to more than :data:`MAX_OBJECTIVES` objectives, to more than
            :data:`MAX_PARAMETERS` parameters of objectives, or to blocks more than :data:`MAX_NESTING` deep.
    """
    return _Flattening(mission).graph(mission.blocks, _Scope())


@dataclass(frozen=True, slots=True)
class _Scope:
    """What the blocks of one text, the mission's or a protocol's, take from around them.

    Args:
        prefix: Qualifies names.
        depth: How many blocks stand around.
        defaults: Parameters that an objective has unless it says otherwise.
        overrides: What the use of this text says instead of the parameters written in it. It does not
            reach into protocols used there: their interface is what the uses in this text say.
    """

    prefix: str = ""
    depth: int = 0
    defaults: Mapping[str, Parameter] = field(default_factory=dict)
    overrides: Mapping[str, Parameter] = field(default_factory=dict)

    def written(self, parameters: tuple[Parameter, ...]) -> dict[str, Parameter]:
        """Parameters written in this text, as the use of the text overrides them."""
        return {p.name: self.overrides.get(p.name, p) for p in parameters}

    def with_defaults(self, parameters: tuple[Parameter, ...]) -> dict[str, Parameter]:
        """The parameters in force where these are written."""
        return {**self.defaults, **self.written(parameters)}

    def entered(self, depth: int, parameters: tuple[Parameter, ...]) -> _Scope:
        """The scope of what stands deeper in the same text, under these parameters."""
        return _Scope(self.prefix, depth, self.with_defaults(parameters), self.overrides)


class _Flattening:
    def __init__(self, mission: Mission) -> None:
        self.protocols: dict[str, Protocol] = {p.name: p for p in mission.protocols}
        self.objectives = 0
        self.parameters = 0

    def graph(self, blocks: tuple[Block, ...], scope: _Scope) -> ObjectivesGraph:
        sections: list[Section] = []
        entry = self.series(blocks, scope, {SUCCEED: SUCCEED, FAIL: FAIL}, sections)
        return _reachable(ObjectivesGraph(tuple(sections), entry))

    def series(
        self, blocks: tuple[Block, ...], scope: _Scope, exits: dict[str, str], sections: list[Section]
    ) -> str:
        """Adds the sections of sibling blocks and returns the entry of the first."""
        entries = {block.name: self.entry(block, scope) for block in blocks}
        routes = entries | exits
        for block, following in zip(blocks, (*blocks[1:], None), strict=True):
            success = block.success or (following.name if following else SUCCEED)
            self.block(block, scope, routes[success], routes[block.failure or FAIL], sections)
        return entries[blocks[0].name]

    def inside(self, block: Recursive | Parallel | Use, scope: _Scope) -> tuple[tuple[Block, ...], _Scope]:
        """What a block holds, and the scope of that."""
        if scope.depth >= MAX_NESTING:
            message = f"blocks nested more than {MAX_NESTING} deep after expansion: the limit was hit"
            raise LimitError(f"{block.source}: {message}" if block.source else message)
        depth = scope.depth + 1
        if isinstance(block, Use):
            protocol = self.protocols[block.protocol]
            overrides = scope.written(block.parameters)
            text = _Scope(f"{scope.prefix}{block.name}.", depth, scope.defaults, overrides)
            return protocol.blocks, text.entered(depth, protocol.parameters)
        return block.blocks, scope.entered(depth, block.parameters if isinstance(block, Recursive) else ())

    def entry(self, block: Block, scope: _Scope) -> str:
        """The name of the section that is entered when the block is."""
        while isinstance(block, Recursive | Use):
            blocks, scope = self.inside(block, scope)
            block = blocks[0]
        return scope.prefix + block.name

    def block(self, block: Block, scope: _Scope, success: str, failure: str, sections: list[Section]) -> None:
        name = scope.prefix + block.name
        if isinstance(block, Objective):
            parameters = tuple(scope.with_defaults(block.parameters).values())
            self.count(len(parameters))
            sections.append(
                ElementarySection(
                    name,
                    block.activities,
                    success,
                    failure,
                    block.source,
                    parameters,
                    block.description,
                    block.duration,
                    block.failure_probability or 0.0,
                )
            )
        elif isinstance(block, Parallel):
            children, inner = self.inside(block, scope)
            branches = tuple(self.branch(child, inner) for child in children)
            sections.append(
                ParallelSection(name, branches, success, failure, block.source, block.description)
            )
        else:
            blocks, inner = self.inside(block, scope)
            self.series(blocks, inner, {SUCCEED: success, FAIL: failure}, sections)

    def branch(self, child: Block, scope: _Scope) -> Branch:
        alone = replace(child, success=None, failure=None)
        return Branch(scope.prefix + child.name, child.mandatory, self.graph((alone,), scope), child.source)

    def count(self, parameters: int) -> None:
        self.objectives += 1
        self.parameters += parameters
        if self.objectives > MAX_OBJECTIVES:
            raise LimitError(f"more than {MAX_OBJECTIVES} objectives after expansion: the limit was hit")
        if self.parameters > MAX_PARAMETERS:
            message = f"more than {MAX_PARAMETERS} parameters of objectives after expansion"
            raise LimitError(f"{message}: the limit was hit")


def _reachable(graph: ObjectivesGraph) -> ObjectivesGraph:
    seen, stack = {graph.entry}, [graph.entry]
    while stack:
        for target in graph.targets(graph.section(stack.pop())):
            if target.name not in seen:
                seen.add(target.name)
                stack.append(target.name)
    reached = tuple(s for s in graph.sections if s.name in seen)
    return ObjectivesGraph(reached, graph.entry, tuple(s for s in graph.sections if s.name not in seen))
