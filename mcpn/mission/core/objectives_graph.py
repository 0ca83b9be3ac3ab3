"""The objectives graph: sections with their routes (paper, 5.1 and Fig. 5)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import field, replace
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, TypeAlias

from mcpn.errors import Source
from mcpn.mission.core.copies import Copies
from mcpn.mission.core.routes import GO_ON, Becoming, Interrupted, Interruption, Routes, Setting
from mcpn.mission.fact_cases import FactCase
from mcpn.mission.model import ABORT, FAIL, SUCCEED, TIMED_OUT, Mission
from mcpn.mission.requirement import Requirement
from mcpn.mission.robot import Parameter
from mcpn.notebook import Drawn
from mcpn.records import record

if TYPE_CHECKING:
    import networkx as nx


NO_COPIES = Copies()
"""Of a graph that is a part of a mission's: one object for all of them."""
NO_REQUIREMENTS: Mapping[str, tuple[str, Requirement]] = {}
"""The same of requirements."""


def failed_for(reason: str) -> str:
    """The outcome of an objective that fails for a reason."""
    return f"failure {reason}"


@record(frozen=True, slots=True)
class ElementarySection(Routes):
    """An elementary objective with its place in the graph.

    Args:
        name: Qualified by the uses that it stands in.
        activities: What it runs.
        success: The next section, or one of the graph's own exits, ``succeed``, ``fail`` and ``abort``.
        failure: The same for failure.
        source: Its line.
        parameters: For the control laws, one of each name: its own, else what the innermost block around it
            says, uses and rounds among them, else what the innermost protocol around it declares.
        description: For reports.
        duration: Its mean duration in hours, where known.
        failure_probability: How probable it is that it fails though it could succeed.
        interruptions: Of each event the innermost first: those that happen once, and at most one more, which
            may happen again.
        timeout: After how many seconds it ends by itself; ``None`` where it never does.
        timed_out: Where that leads; ``None`` where it never does.
        sets: Facts that it changes.
        cases: With its outcome, where that leads instead if facts are so; the first that fits counts.
        reasons: The reasons for which it may fail, each with where that leads.
        shares: The parts of ``failure_probability``: failures for no reason, then those for each reason.
        becomes: By what facts become it is left; of several at once the first counts.
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
    interruptions: tuple[Interruption, ...] = ()
    timeout: float | None = None
    timed_out: str | None = None
    sets: tuple[Setting, ...] = ()
    cases: tuple[tuple[str, FactCase], ...] = ()
    reasons: tuple[tuple[str, str], ...] = ()
    shares: tuple[float, ...] = (0.0,)
    becomes: tuple[Becoming, ...] = ()

    @property
    def outcomes(self) -> tuple[tuple[str, str], ...]:
        """How it may end by itself, each with where that leads; timed out only where it has a timeout."""
        ended = (("success", self.success), ("failure", self.failure))
        if not self.reasons and self.timed_out is None and not self.becomes:  # as most objectives are
            return ended
        named = ((failed_for(reason), target) for reason, target in self.reasons)
        late = () if self.timed_out is None else ((TIMED_OUT, self.timed_out),)
        return *ended, *named, *late, *((outcome, each.target) for outcome, each in self.becoming)

    @property
    def failures(self) -> Iterator[tuple[str, str]]:
        """The reasons for which it may fail, none first (an empty text), each with the outcome that it is."""
        yield "", "failure"
        yield from ((reason, failed_for(reason)) for reason, _ in self.reasons)

    def setting(self, on: str) -> dict[str, str]:
        """The facts that it changes on an occasion, with their new values; a timeout is a failure."""
        occasion = on if on in ("success", "start") else "failure"
        return {setting.fact: setting.value for setting in self.sets if setting.on == occasion}

    def walk(self) -> Iterator[ElementarySection]:
        """Itself."""
        yield self


@record(frozen=True, slots=True)
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


@record(frozen=True, slots=True)
class PauseGraph(Interrupted):
    """What runs while a parallel block pauses: a copy of a sibling of a block that the block is or stands in.

    Args:
        graph: Its exits are :data:`GO_ON`, after which the block goes on where it was, and those exits of the
            block that lead away from here.
        interruptions: Of each event the innermost first, in effect where nothing in the graph handles it.
    """

    graph: ObjectivesGraph
    interruptions: tuple[Interruption, ...] = ()


@record(frozen=True, slots=True)
class ParallelSection(Routes):
    """A parallel block with its place in the graph.

    Args:
        name: Qualified by the uses that it stands in.
        branches: Its children, in document order.
        success: The next section, or one of the graph's own exits.
        failure: The same for failure.
        source: Its line.
        description: For reports.
        interruptions: Of each event the innermost first, as of an objective; in effect where no branch
            handles the event itself.
        abort: Where it leads that a branch aborts; ``None`` where none can.
        needed: How many branches must succeed, mandatory or not, and no more are awaited; ``None`` where all
            are awaited, and every mandatory one must.
        hasty: Whether it fails as soon as a mandatory branch has failed.
        failing: How many failed branches, mandatory or not, fail it at once; ``None`` where none need to.
        cases: With its outcome, where that leads instead if facts are so; the first that fits counts.
        pause_graphs: What runs while it pauses.
        pause_exits: Outcomes of these by which it does not go on, each with where that leads.
        timeout: After how many seconds it is left by itself; ``None`` where it never is. A block that has one
            and is not parallel is a section with one branch.
        timed_out: Where that leads; ``None`` where it never does.
        becomes: By what facts become it is left; of several at once the first counts. A block that is left
            so is a section, too.
    """

    name: str
    branches: tuple[Branch, ...]
    success: str
    failure: str
    source: Source | None = field(default=None, compare=False)
    description: str | None = None
    interruptions: tuple[Interruption, ...] = ()
    abort: str | None = None
    needed: int | None = None
    hasty: bool = False
    cases: tuple[tuple[str, FactCase], ...] = ()
    pause_graphs: tuple[PauseGraph, ...] = ()
    pause_exits: tuple[tuple[str, str], ...] = ()
    failing: int | None = None
    timeout: float | None = None
    timed_out: str | None = None
    becomes: tuple[Becoming, ...] = ()

    @property
    def graphs(self) -> Iterator[ObjectivesGraph]:
        """The graphs of its branches, then of what runs while it pauses."""
        yield from (branch.graph for branch in self.branches)
        yield from (pause_graph.graph for pause_graph in self.pause_graphs)

    @property
    def every_interruption(self) -> tuple[Interruption, ...]:
        """Its interruptions, and those of what runs while it pauses."""
        return *self.interruptions, *(
            i for pause_graph in self.pause_graphs for i in pause_graph.interruptions
        )

    @property
    def deciding(self) -> Iterator[tuple[str, Branch]]:
        """Outcomes that may be decided while branches still run, each with the branches that may do so.

        Where a number of successes or failures decides, the branch that completes it may be any from that
        number on, in document order.
        """
        yield from (("abort", branch) for branch in self.branches if branch.graph.aborts)
        if self.needed is not None and self.needed < len(self.branches):
            yield from (("success", branch) for branch in self.branches[self.needed - 1 :])
        for number, branch in enumerate(self.branches, 1):
            enough = self.failing is not None and self.failing <= number and self.failing < len(self.branches)
            if enough or (self.hasty and branch.mandatory and len(self.branches) > 1):
                yield "failure", branch

    @property
    def early(self) -> bool:
        """Whether its end may stop branches that still run."""
        return any(True for _ in self.deciding)

    @property
    def stopped(self) -> bool:
        """Whether its time, or what facts become, may stop branches that run."""
        return self.timed_out is not None or bool(self.becomes)

    def succeeds(self, well: Iterable[Branch]) -> bool:
        """Whether it succeeds when all have ended, some of them well."""
        names = {branch.name for branch in well}
        if self.needed is not None:
            return len(names) >= self.needed
        return all(branch.name in names for branch in self.branches if branch.mandatory)

    @property
    def outcomes(self) -> tuple[tuple[str, str], ...]:
        """How the block may end by itself, each with where that leads; abort only where it can abort."""
        ended = [("success", self.success), ("failure", self.failure)]
        ended += [] if self.abort is None else [("abort", self.abort)]
        ended += [] if self.timed_out is None else [(TIMED_OUT, self.timed_out)]
        ended += [(outcome, each.target) for outcome, each in self.becoming]
        return (*ended, *self.pause_exits)

    def walk(self) -> Iterator[ElementarySection]:
        """Every elementary objective in it, at any depth, in document order."""
        for graph in self.graphs:
            yield from graph.walk()

    @property
    def held(self) -> tuple[str, ...]:
        """The objectives in its branches: it runs while one of them runs or is about to begin."""
        return tuple(inner.name for branch in self.branches for inner in branch.graph.walk())


Section: TypeAlias = ElementarySection | ParallelSection


def rerouted(section: Section, to: Callable[[str], str]) -> Section:
    """A section with other targets."""
    led = replace(
        section,
        success=to(section.success),
        failure=to(section.failure),
        timed_out=section.timed_out and to(section.timed_out),
        cases=tuple((outcome, case._replace(target=to(case.target))) for outcome, case in section.cases),
        interruptions=tuple(i.led(to) for i in section.interruptions),
        becomes=tuple(replace(each, target=to(each.target)) for each in section.becomes),
    )
    if isinstance(led, ElementarySection):
        return replace(led, reasons=tuple((reason, to(target)) for reason, target in led.reasons))
    pause_exits = tuple((outcome, to(target)) for outcome, target in led.pause_exits)
    return replace(led, abort=led.abort and to(led.abort), pause_exits=pause_exits)


def names_in(section: Section) -> Iterator[str]:
    """Objectives, blocks and branches of a section, at any depth, its own name first."""
    yield section.name
    if isinstance(section, ParallelSection):
        for branch in section.branches:
            yield branch.name
            for inner in branch.graph.sections:
                yield from names_in(inner)
        for pause_graph in section.pause_graphs:
            for inner in pause_graph.graph.sections:
                yield from names_in(inner)


@record(frozen=True)
class ObjectivesGraph(Drawn):
    """The objectives graph of a mission, or of a branch of a parallel block.

    Args:
        sections: Those that some route reaches, in document order.
        entry: The first one's name.
        unreached: Those that no route reaches, in document order; they are part of nothing that follows.
        core: Of a whole mission: the core mission that it was read from.
        copies: Of a whole mission: what its objectives and blocks are copies of.
        requirements: Of a whole mission: its requirements by name, those of a protocol for each of its uses,
            qualified, each with what stands before the names of the text that holds it.
    """

    sections: tuple[Section, ...]
    entry: str
    unreached: tuple[Section, ...] = ()
    core: Mission | None = field(default=None, compare=False)
    copies: Copies = field(default=NO_COPIES, compare=False)
    requirements: Mapping[str, tuple[str, Requirement]] = field(
        default_factory=lambda: NO_REQUIREMENTS, compare=False
    )

    def __repr__(self) -> str:
        return f"<objectives graph of {len(self.sections)} sections, from {self.entry}>"

    @cached_property
    def _by_name(self) -> dict[str, Section]:
        return {section.name: section for section in self.sections}

    def section(self, name: str) -> Section:
        """The section of this name, at this level."""
        return self._by_name[name]

    def targets(self, section: Section) -> list[Section]:
        """Sections that a section's outcomes but abort lead to; the graph's exits give none."""
        ends = (outcome for outcome, _ in section.outcomes if outcome != "abort")
        return self._led(route for outcome in ends for route in section.led(outcome))

    def aborted(self, section: Section) -> list[Section]:
        """The sections that an abort of a section leads to; an exit of the graph gives none."""
        return self._led(section.led("abort"))

    @cached_property
    def aborts(self) -> bool:
        """Whether some route leads to the graph's exit ``abort``."""
        return any(ABORT in section.routes for section in self.sections)

    def interrupted(self, section: Section, event: str | None = None) -> list[Section]:
        """Sections that interruptions of a section lead to, those by one event or by any; exits give none."""
        met = (i for i in section.interruptions if event is None or i.event == event)
        routes = (route for i in met for route in i.routes)
        return self._led(dict.fromkeys(routes))

    def _led(self, routes: Iterable[str]) -> list[Section]:
        return [self._by_name[route] for route in routes if route in self._by_name]

    def walk(self) -> Iterator[ElementarySection]:
        """Every elementary objective at any depth, in document order."""
        return iter(self._walked)

    @cached_property
    def _walked(self) -> tuple[ElementarySection, ...]:
        """The elementary objectives: a graph is walked dozens of times."""
        sections = self.sections
        if len(sections) == 1 and isinstance(sections[0], ElementarySection):  # as most branches
            return (sections[0],)
        return tuple(chain.from_iterable(section.walk() for section in sections))

    @property
    def timed(self) -> Iterator[Section]:
        """Objectives and blocks at any depth that have a timeout, in document order, blocks last."""
        yield from (section for section in self.walk() if section.timeout is not None)
        yield from self.timed_blocks()

    def timed_blocks(self) -> Iterator[ParallelSection]:
        """Blocks at any depth whose time may be over, in document order."""
        for section in self.all_sections():
            if isinstance(section, ParallelSection) and section.timeout is not None:
                yield section

    def never_entered(self) -> Iterator[ElementarySection]:
        """Every elementary objective, at any depth, that stands in a section that no route reaches."""
        for section in self.sections:
            for graph in section.graphs if isinstance(section, ParallelSection) else ():
                yield from graph.never_entered()
        for section in self.unreached:
            if isinstance(section, ElementarySection):
                yield section
            else:
                for graph in section.graphs:
                    yield from graph.walk()
                    yield from graph.never_entered()

    def all_sections(self) -> Iterator[Section]:
        """Every section at any depth, parallel blocks before what they hold, in document order."""
        for section in self.sections:
            yield section
            if isinstance(section, ParallelSection):
                for graph in section.graphs:
                    yield from graph.all_sections()

    def reachable(self) -> ObjectivesGraph:
        """The graph of the sections that routes from the entry reach; the others are kept apart."""
        if len(self.sections) == 1:  # as in most branches
            return self
        seen, stack = {self.entry}, [self.entry]
        while stack:
            section = self.section(stack.pop())
            for target in (*self.targets(section), *self.aborted(section), *self.interrupted(section)):
                if target.name not in seen:
                    seen.add(target.name)
                    stack.append(target.name)
        if len(seen) == len(self.sections):
            return self
        reached = tuple(s for s in self.sections if s.name in seen)
        return ObjectivesGraph(reached, self.entry, tuple(s for s in self.sections if s.name not in seen))

    @property
    def exits(self) -> tuple[str, ...]:
        """The graph's own exits: ``succeed``, ``fail``, and ``abort`` where some route leads there."""
        return (SUCCEED, FAIL, ABORT) if self.aborts else (SUCCEED, FAIL)

    def once(self) -> list[str]:
        """Handlers of its sections at any depth that happen once, in the order in which they are met."""
        met = (i.once for section in self.all_sections() for i in section.every_interruption)
        return [handler for handler in dict.fromkeys(met) if handler is not None]

    def to_networkx(self) -> nx.MultiDiGraph[str]:
        """The graph in networkx, branches of parallel blocks at nodes of their own.

        Returns:
            Nodes with ``kind`` (``objective``, ``parallel``, ``exit``), objectives with ``activities``;
            edges with ``outcome`` (``success``, ``failure``, ``failure REASON``, ``abort``, ``timed out``,
            ``event NAME``, ``on FACTS`` as facts become so), or
            ``branch`` from a block to its children.
        """
        import networkx

        graph: nx.MultiDiGraph[str] = networkx.MultiDiGraph()
        self._add_to(graph, {route: route for route in self.exits})
        return graph

    def _add_to(self, graph: nx.MultiDiGraph[str], exits: dict[str, str]) -> None:
        graph.add_nodes_from((node for node in exits.values() if node not in graph), kind="exit")
        for section in self.sections:
            if isinstance(section, ElementarySection):
                graph.add_node(section.name, kind="objective", activities=section.activities)
            else:
                graph.add_node(section.name, kind="parallel")
            pause_graphs, pause_exits = tuple[PauseGraph, ...](), dict[str, str]()
            if isinstance(section, ParallelSection):
                pause_graphs, pause_exits = section.pause_graphs, dict(section.pause_exits)
            becoming = {outcome: f"on {each.words}" for outcome, each in section.becoming}
            for outcome, route in section.outcomes:
                if outcome in pause_exits:
                    continue  # what runs meanwhile leads there
                outcome = becoming.get(outcome, outcome)
                for target in (route, *(case.target for case in section.cases_of(outcome))):
                    graph.add_edge(section.name, exits.get(target, target), outcome=outcome)
            for interruption in section.interruptions:
                paused = (
                    [] if interruption.pauses is None else [pause_graphs[interruption.pauses].graph.entry]
                )
                for target in (*interruption.routes, *paused):
                    route = exits.get(target, target)
                    graph.add_edge(section.name, route, outcome=f"event {interruption.event}")
            for branch in section.branches if isinstance(section, ParallelSection) else ():
                words = {SUCCEED: "ok", FAIL: "fail", ABORT: "abort"}
                inner = {route: f"{branch.name}:{words[route]}" for route in branch.graph.exits}
                branch.graph._add_to(graph, inner)
                graph.add_edge(section.name, branch.graph.entry, outcome="branch", mandatory=branch.mandatory)
            for pause_graph in pause_graphs:
                leading = {exit_: exits.get(target, target) for exit_, target in pause_exits.items()}
                pause_graph.graph._add_to(graph, {GO_ON: section.name, **leading})
