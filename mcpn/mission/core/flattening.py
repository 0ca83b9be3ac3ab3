"""From the core mission to the objectives graph: recursion replaced by its contents (paper, 5.1 and Fig. 5).

Copies are written out before, by the passes of :mod:`mcpn.mission.passes`. Here routes find the sections that
they lead to: through the exits of blocks, as facts and reasons decide; and handlers come to the
sections that they interrupt.

Parallel blocks are kept as sections, each branch with a graph of its own. Routes that facts choose become
cases of sections (:func:`mcpn.mission.core.destinations.deciding`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from mcpn.mission.core.copies import Copies
from mcpn.mission.core.destinations import Destinations, deciding
from mcpn.mission.core.objectives_graph import (
    Branch,
    ElementarySection,
    ObjectivesGraph,
    ParallelSection,
    PauseGraph,
    Section,
)
from mcpn.mission.core.pause_graphs import PAUSE, end_of_pause, with_pause_graph
from mcpn.mission.core.routes import Becoming, Interruption, Setting
from mcpn.mission.core.surrounding_handlers import Scope
from mcpn.mission.fact_cases import Destination, by_facts
from mcpn.mission.fact_conditions import resolved
from mcpn.mission.model import (
    ABORT,
    FAIL,
    SUCCEED,
    UNNAMED,
    Block,
    Handler,
    Mission,
    Objective,
    Parallel,
    Recursive,
    walk,
)
from mcpn.mission.passes import core
from mcpn.mission.passes.pauses import runs_for
from mcpn.mission.reasons import probabilities, reason
from mcpn.mission.validate import valid


def flatten(mission: Mission) -> ObjectivesGraph:
    """The objectives graph of a mission.

    Args:
        mission: A mission; one that was built in Python is checked here, once.

    Returns:
        Its graph; sections that no route reaches are kept aside in it.

    Raises:
        InputError: The mission is not valid, with every problem.
        LimitError: Its core mission would be too large (:mod:`mcpn.mission.rewriting.limits`).
    """
    flattening = _Flattening(valid(mission))
    graph = flattening.mission()
    return replace(
        graph,
        core=flattening.written_out,
        copies=flattening.positions,
        requirements=flattening.requirements,
    )


class _Flattening:
    def __init__(self, mission: Mission) -> None:
        self.requirements = {each.name: ("", each) for each in mission.requirements}
        self.written_out = core(mission)
        self.positions = Copies()
        self.facts = {fact.name: fact for fact in self.written_out.every_fact}
        copies = (block for block in walk(self.written_out.blocks) if block.resumes is not None)
        self.resuming = {(block.resumes, runs_for(block)): self.entry(block) for block in copies}
        """By what is stopped, and the sibling that is run meanwhile, the section that is entered then."""

    def mission(self) -> ObjectivesGraph:
        """The graph of the mission."""
        return self.graph(self.written_out.blocks, Scope(), self.written_out.handlers)

    def graph(
        self,
        blocks: tuple[Block, ...],
        scope: Scope,
        handlers: tuple[Handler, ...] = (),
    ) -> ObjectivesGraph:
        sections: list[Section] = []
        exits = {exit_: Destination(exit_) for exit_ in (SUCCEED, FAIL, ABORT)} | {UNNAMED: Destination(FAIL)}
        self.series(blocks, scope, exits, sections, handlers)
        return ObjectivesGraph(tuple(sections), self.entry(blocks[0])).reachable()

    def series(
        self,
        blocks: tuple[Block, ...],
        scope: Scope,
        exits: dict[str, Destination],
        sections: list[Section],
        around: tuple[Handler, ...] = (),
        whole: str = "",
    ) -> None:
        """Adds the sections of sibling blocks, under handlers that lead to them as well.

        Those whose stem is ``whole`` are copies of the block around.
        """
        routes = {block.name: Destination(self.entry(block)) for block in blocks} | exits
        scope = self.handling(scope, around, routes, "")
        for block in blocks:
            inner = self.handling(scope, block.handlers, routes, block.written)
            failure = block.failure or FAIL
            late = block.timeout_goto or failure
            leads = Destinations(
                routes[block.success or SUCCEED], routes[failure], routes[block.abort or ABORT], routes[late]
            )
            leads = deciding(block, routes, leads, self.facts, copy=block.stem == whole)
            leads = leads._replace(becoming=self.becoming(block, routes))
            if block.resumes is not None:
                self.meanwhile(block, inner, scope, routes, leads, sections)
            else:
                self.block(block, inner, leads, sections)

    def meanwhile(
        self,
        block: Block,
        inner: Scope,
        around: Scope,
        routes: Mapping[str, Destination],
        leads: Destinations,
        sections: list[Section],
    ) -> None:
        """Adds what runs while something is stopped: beside an objective, or into a parallel block.

        In a parallel block its own handlers are in effect, and where these are not, those around it.
        """
        number = next(n for n, section in enumerate(sections) if section.name == block.resumes)
        stopped, inside = sections[number], list[Section]()
        if isinstance(stopped, ElementarySection):
            self.block(block, inner, leads._replace(success=Destination(stopped.name)), sections)
            return
        own = self.handling(replace(around, handlers=()), block.handlers, routes, block.written)
        end = Destination(end_of_pause(stopped.name))
        self.block(block, own, leads._replace(success=end), inside)
        pause_graph = PauseGraph(
            ObjectivesGraph(tuple(inside), self.entry(block)).reachable(), around.interruptions
        )
        sections[number] = with_pause_graph(stopped, pause_graph, f"{PAUSE}{runs_for(block)}")

    def handling(
        self, scope: Scope, handlers: tuple[Handler, ...], routes: Mapping[str, Destination], block: str
    ) -> Scope:
        """The scope under some handlers more, those of a block or of the mission."""
        found = []
        for handler in handlers:
            if handler.event is None:
                continue  # facts do not concern what stands inside: see becoming
            once = scope.written_at(block, handler.event) if handler.once else None
            lead = self.leading(handler, routes)
            found.append(Interruption(handler.event, lead.target, once, handler.source, lead.cases))
        return replace(scope, handlers=(*found, *scope.handlers)) if found else scope

    def becoming(
        self, block: Block, routes: Mapping[str, Destination]
    ) -> tuple[tuple[Becoming, Destination], ...]:
        """By what facts become a block is left, each with where that leads."""
        found = []
        for handler in block.handlers:
            if handler.when:
                lead, when = self.leading(handler, routes), resolved(handler.when, self.facts)
                found.append((Becoming(when, lead.target, handler.source), lead))
        return tuple(found)

    def leading(self, handler: Handler, routes: Mapping[str, Destination]) -> Destination:
        """Where a handler leads; for a pause a placeholder, until it is known what is stopped."""
        if handler.pause is None:  # a valid one has one of the two
            cases = ((resolved(each.when, self.facts), routes[each.goto]) for each in handler.routes)
            return by_facts(cases, routes[handler.goto or ABORT])
        return Destination(f"{PAUSE}{handler.pause}")

    def resumed(self, interruption: Interruption, stopped: str) -> Interruption:
        """The interruption of an objective; by a pause it leads to the copy that resumes this one."""
        if not interruption.target.startswith(PAUSE):
            return interruption
        by = interruption.target.removeprefix(PAUSE)
        return replace(interruption, target=self.resuming[stopped, by])

    def entry(self, block: Block) -> str:
        """The name of the section that is entered when the block is."""
        while isinstance(block, Recursive):
            block = block.blocks[0]
        return block.name

    def block(self, block: Block, scope: Scope, leads: Destinations, sections: list[Section]) -> None:
        """Adds the sections of a block, which its outcomes lead out of."""
        if isinstance(block, Objective):
            sections.append(self.objective(block, scope, leads))
        elif isinstance(block, Parallel):
            sections.append(self.parallel(block, scope, leads))
        elif isinstance(block, Recursive):
            for each in block.requirements:
                self.requirements[f"{block.own}.{each.name}"] = f"{block.own}.", each
            self.series(block.blocks, scope.into(block), leads.exits, sections, whole=block.stem)

    def objective(self, block: Objective, scope: Scope, leads: Destinations) -> ElementarySection:
        reasons = tuple(map(reason, block.failures))
        leads = leads.of_reasons(each.name for each in reasons)
        whole, parts = probabilities(block, reasons)
        self.positions.objectives[block.name] = scope.position(block)
        return ElementarySection(
            name=block.name,
            activities=block.activities,
            success=leads.success.target,
            failure=leads.failure.target,
            source=block.source,
            parameters=block.parameters,
            description=block.description,
            duration=block.duration,
            failure_probability=whole,
            interruptions=tuple(self.resumed(each, block.name) for each in scope.interruptions),
            timeout=block.timeout,
            timed_out=None if block.timeout is None else leads.timed_out.target,
            sets=self.settings(block),
            cases=leads.cases,
            reasons=tuple((each.name, leads.named[each.name].target) for each in reasons),
            shares=parts,
            becomes=leads.becomes,
        )

    def parallel(self, block: Parallel, scope: Scope, leads: Destinations) -> ParallelSection:
        inner = replace(scope.into(block), handlers=())
        branches = tuple(
            Branch(child.name, child.mandatory, self.graph((child,), inner), child.source)
            for child in block.blocks
        )
        return ParallelSection(
            name=block.name,
            branches=branches,
            success=leads.success.target,
            failure=leads.failure.target,
            source=block.source,
            description=block.description,
            interruptions=scope.interruptions,
            abort=leads.abort.target if any(branch.graph.aborts for branch in branches) else None,
            needed=None if block.success_when == "all" else int(block.success_when),
            hasty=block.failure_when == "any",
            cases=leads.cases,
            failing=block.failing,
            timeout=block.timeout,
            timed_out=None if block.timeout is None else leads.timed_out.target,
            becomes=leads.becomes,
        )

    def settings(self, block: Objective) -> tuple[Setting, ...]:
        """The facts that an objective changes."""
        return tuple([Setting(change.fact, change.to, change.occasion) for change in block.sets])
