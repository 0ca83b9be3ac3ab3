"""From blocks to the objectives graph: recursion replaced by its contents (paper, 5.1 and Fig. 5).

Parallel blocks are kept as sections, each branch with a graph of its own; uses of protocols are expanded,
their names qualified by the use (``transect_north.diving``). Rounds of ``each`` and ``repeat`` and tries of
``retries`` are written out one after the other, named by their value, round or try (``visit_12``,
``visit_3``, ``visit_try2``), which qualifies what they hold (``visit_12.travel``).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from mcpn.errors import LimitError, Source
from mcpn.mission.model import (
    FAIL,
    ROUND,
    SUCCEED,
    Block,
    Each,
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
        suffix: Ends the names of blocks of which there are several copies, one for each round or try.
        depth: How many blocks stand around.
        defaults: Parameters that an objective has unless it says otherwise.
        overrides: What the use of this text says instead of the parameters written in it. It does not
            reach into protocols used there: their interface is what the uses in this text say.
        rounds: The values of the rounds in this text that stand around; uses hand them to their protocols.
    """

    prefix: str = ""
    suffix: str = ""
    depth: int = 0
    defaults: Mapping[str, Parameter] = field(default_factory=dict)
    overrides: Mapping[str, Parameter] = field(default_factory=dict)
    rounds: Mapping[str, Parameter] = field(default_factory=dict)

    def name(self, block: Block) -> str:
        """The qualified name of a block that stands here."""
        return f"{self.prefix}{block.name}{self.suffix}"

    def written(self, parameters: tuple[Parameter, ...]) -> dict[str, Parameter]:
        """Parameters written in this text, as the use of the text overrides them."""
        return {p.name: self.overrides.get(p.name, p) for p in parameters}

    def with_defaults(self, parameters: tuple[Parameter, ...]) -> dict[str, Parameter]:
        """The parameters in force where these are written."""
        return {**self.defaults, **self.written(parameters)}

    def into(self, block: Block, parameters: tuple[Parameter, ...] = ()) -> _Scope:
        """The scope of what a block holds in the same text; a copy of a block qualifies it."""
        prefix = f"{self.name(block)}." if self.suffix else self.prefix
        defaults = self.with_defaults(parameters)
        return replace(self, prefix=prefix, suffix="", depth=self.deeper(block), defaults=defaults)

    def into_protocol(self, use: Use, protocol: Protocol) -> _Scope:
        """The scope of a protocol's text as one use of it sees it."""
        overrides = {**self.rounds, **self.written(use.parameters)}
        text = _Scope(f"{self.name(use)}.", "", self.deeper(use), self.defaults, overrides)
        return replace(text, defaults=text.with_defaults(protocol.parameters))

    def copy(self, block: Block, suffix: str, value: Parameter | None = None) -> _Scope:
        """The scope of one copy of a block, or of what stands in one round of it."""
        values = {value.name: value} if value else {}
        return replace(
            self,
            suffix=f"{self.suffix}_{suffix}",
            depth=self.deeper(block),
            defaults={**self.defaults, **values},
            rounds={**self.rounds, **values},
        )

    def deeper(self, block: Block) -> int:
        """The depth inside a block."""
        if self.depth >= MAX_NESTING:
            message = f"blocks nested more than {MAX_NESTING} deep after expansion: the limit was hit"
            raise LimitError(f"{block.source}: {message}" if block.source else message)
        return self.depth + 1


class _Flattening:
    def __init__(self, mission: Mission) -> None:
        self.protocols: dict[str, Protocol] = {p.name: p for p in mission.protocols}
        self.objectives = 0
        self.parameters = 0

    def graph(self, blocks: tuple[Block, ...], scope: _Scope) -> ObjectivesGraph:
        sections: list[Section] = []
        self.series(blocks, scope, {SUCCEED: SUCCEED, FAIL: FAIL}, sections)
        return _reachable(ObjectivesGraph(tuple(sections), self.entry(blocks[0], scope)))

    def series(
        self, blocks: tuple[Block, ...], scope: _Scope, exits: dict[str, str], sections: list[Section]
    ) -> None:
        """Adds the sections of sibling blocks."""
        routes = {block.name: self.entry(block, scope) for block in blocks} | exits
        for block, following in zip(blocks, (*blocks[1:], None), strict=True):
            success = block.success or (following.name if following else SUCCEED)
            self.block(block, scope, routes[success], routes[block.failure or FAIL], sections)

    def inside(self, block: Recursive | Parallel | Use, scope: _Scope) -> tuple[tuple[Block, ...], _Scope]:
        """What a block holds, and the scope of that."""
        if isinstance(block, Use):
            protocol = self.protocols[block.protocol]
            return protocol.blocks, scope.into_protocol(block, protocol)
        return block.blocks, scope.into(block, block.parameters if isinstance(block, Recursive) else ())

    def entry(self, block: Block, scope: _Scope) -> str:
        """The name of the section that is entered when the block is."""
        while True:
            if _several(block):
                blocks, scope = next(_copies(block, scope))
            elif isinstance(block, Recursive | Use):
                blocks, scope = self.inside(block, scope)
            else:
                return scope.name(block)
            block = blocks[0]

    def block(self, block: Block, scope: _Scope, success: str, failure: str, sections: list[Section]) -> None:
        if _several(block):
            self.copies(block, scope, success, failure, sections)
        elif isinstance(block, Objective):
            parameters = tuple(scope.with_defaults(block.parameters).values())
            self.count(len(parameters))
            sections.append(
                ElementarySection(
                    scope.name(block),
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
            name = scope.name(block)
            sections.append(
                ParallelSection(name, branches, success, failure, block.source, block.description)
            )
        elif isinstance(block, Recursive | Use):
            blocks, inner = self.inside(block, scope)
            self.series(blocks, inner, {SUCCEED: success, FAIL: failure}, sections)

    def copies(
        self, block: Block, scope: _Scope, success: str, failure: str, sections: list[Section]
    ) -> None:
        """Adds the rounds of a block, or its tries, one after the other."""
        tries = block.repeat is None and block.retries > 0
        here: tuple[tuple[Block, ...], _Scope] | None = next(copies := _copies(block, scope))
        while here is not None:
            (blocks, inner), here = here, next(copies, None)
            following = self.entry(here[0][0], here[1]) if here else None
            exits = (success, following or failure) if tries else (following or success, failure)
            self.series(blocks, inner, dict(zip((SUCCEED, FAIL), exits, strict=True)), sections)

    def branch(self, child: Block, scope: _Scope) -> Branch:
        alone = replace(child, success=None, failure=None)
        return Branch(scope.name(child), child.mandatory, self.graph((alone,), scope), child.source)

    def count(self, parameters: int) -> None:
        self.objectives += 1
        self.parameters += parameters
        if self.objectives > MAX_OBJECTIVES:
            raise LimitError(f"more than {MAX_OBJECTIVES} objectives after expansion: the limit was hit")
        if self.parameters > MAX_PARAMETERS:
            message = f"more than {MAX_PARAMETERS} parameters of objectives after expansion"
            raise LimitError(f"{message}: the limit was hit")


def _several(block: Block) -> bool:
    """Whether a block stands for several copies, one after the other."""
    return block.repeat is not None or block.retries > 0 or isinstance(block, Each)


def _copies(block: Block, scope: _Scope) -> Iterator[tuple[tuple[Block, ...], _Scope]]:
    """The rounds of a block, else its tries, else its values: what is done each time, and its scope."""
    alone = replace(block, success=None, failure=None)
    if block.repeat is not None:
        for number in range(1, block.repeat + 1):
            value = Parameter(name=ROUND, value=str(number), source=block.source)
            yield (replace(alone, repeat=None),), scope.copy(block, str(number), value)
    elif block.retries:
        for number in range(1, block.retries + 2):
            yield (replace(alone, retries=0),), scope.copy(block, f"try{number}")
    elif isinstance(block, Each):
        inside = scope.into(block)
        for text in block.values:
            value = Parameter(name=block.bound, value=text, source=block.source)
            yield block.blocks, inside.copy(block, text, value)


def _reachable(graph: ObjectivesGraph) -> ObjectivesGraph:
    seen, stack = {graph.entry}, [graph.entry]
    while stack:
        for target in graph.targets(graph.section(stack.pop())):
            if target.name not in seen:
                seen.add(target.name)
                stack.append(target.name)
    reached = tuple(s for s in graph.sections if s.name in seen)
    return ObjectivesGraph(reached, graph.entry, tuple(s for s in graph.sections if s.name not in seen))
