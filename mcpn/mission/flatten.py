"""From the core mission to the objectives graph: recursion replaced by its contents (paper, 5.1 and Fig. 5).

Copies are written out before, by the passes of :mod:`mcpn.mission.passes`. Here routes find the sections that
they lead to: through the exits of blocks, as facts and reasons decide; handlers come to the
sections that they interrupt; and siblings are copied that run while others pause.

Parallel blocks are kept as sections, each branch with a graph of its own. Routes that facts choose become
cases of sections (:func:`mcpn.mission.expansion.destinations.deciding`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from mcpn.errors import InputError
from mcpn.mission.conditions import facts_of, resolved
from mcpn.mission.expansion.copies import Copies
from mcpn.mission.expansion.destinations import Destination, Destinations, Named, by_facts, deciding
from mcpn.mission.expansion.helpers import entered, following, helping
from mcpn.mission.expansion.left_by_facts import refuse_paused
from mcpn.mission.expansion.pauses import PAUSE, end_of_pause, suffix_at, with_pause_graph
from mcpn.mission.expansion.routes import Becoming, Interruption, Setting
from mcpn.mission.expansion.scope import Scope
from mcpn.mission.graph import (
    UNNAMED,
    Branch,
    ElementarySection,
    ObjectivesGraph,
    ParallelSection,
    PauseGraph,
    Section,
)
from mcpn.mission.model import (
    ABORT,
    FAIL,
    SUCCEED,
    Block,
    Handler,
    Mission,
    Objective,
    Parallel,
    Recursive,
)
from mcpn.mission.passes import core
from mcpn.mission.passes.copying import copied
from mcpn.mission.passes.limits import MAX_NESTING, MAX_OBJECTIVES, MAX_PARAMETERS, Counted
from mcpn.mission.reasons import probabilities, reason
from mcpn.mission.robot import BOOLEAN_VALUES
from mcpn.mission.validate import valid

__all__ = [
    "MAX_NESTING",
    "MAX_OBJECTIVES",
    "MAX_PARAMETERS",
    "Branch",
    "ElementarySection",
    "Interruption",
    "ObjectivesGraph",
    "ParallelSection",
    "Section",
    "flatten",
]


def flatten(mission: Mission) -> ObjectivesGraph:
    """The objectives graph of a mission.

    Args:
        mission: A mission; one that was built in Python is checked here, once.

    Returns:
        Its graph; sections that no route reaches are kept aside in it.

    Raises:
        InputError: The mission is not valid, with every problem.
        LimitError: Uses of protocols expand to more than :data:`MAX_OBJECTIVES` objectives, to more than
            :data:`MAX_PARAMETERS` parameters of objectives, or to blocks more than :data:`MAX_NESTING` deep.
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
        self.facts = facts_of(mission)
        self.pauses: dict[str, str] = {}
        """By placeholder for the target of a pause, the name of the sibling that is run meanwhile."""
        self.copied: set[str] = set()
        """Names of copies of siblings that are run while blocks pause."""
        self.helping: set[str] = set()
        """Names of siblings of which such copies are made."""
        self.counted = Counted()

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
        whole: tuple[str, Mapping[str, Named]] | None = None,
    ) -> None:
        """Adds the sections of sibling blocks, under handlers that lead to them as well.

        Copies of a block, which ``whole`` names by its stem, fail for reasons where it says that they lead.
        """
        routes = {block.name: Destination(self.entry(block)) for block in blocks} | exits
        scope = self.handling(scope, around, routes, "")
        after, siblings = following(blocks), {block.name: block for block in blocks}
        aside = helping(blocks)
        aside -= entered(blocks, around) if aside else aside
        waiting = dict[str, tuple[int, dict[str, Block]]]()  # by last run of a block the pauses of others
        for block in sorted(blocks, key=lambda block: block.name in aside):
            if block.name in aside & self.helping:
                continue  # of one that helps none it is said that it is never entered
            success = block.success or after[block.name]
            inner = self.handling(scope, block.handlers, routes, block.written)
            failure = block.failure or FAIL
            late = block.timeout_goto or failure
            leads = Destinations(routes[success], routes[failure], routes[block.abort or ABORT], routes[late])
            before = len(sections)
            if whole and whole[1] and whole[0] == block.stem:
                leads = leads.of_copy(whole[1], last=failure == FAIL)
            else:
                leads = deciding(block, routes, leads, exits, self.facts)
            leads = leads._replace(becoming=self.becoming(block, routes))
            self.block(block, inner, leads, sections)
            own = inner.handlers[: len(inner.handlers) - len(scope.handlers)]
            found = {i.target: siblings[self.pauses[i.target]] for i in own if i.target in self.pauses}
            if not found:
                continue
            last = next((each.fails_as for each in block.handlers if each.fails_as), block.name)
            begin, others = waiting.pop(last, (before, {}))
            if last == block.name:
                self.paused(begin, others | found, (scope, routes), leads.failure, sections)
            else:
                waiting[last] = begin, others | found

    def paused(
        self,
        before: int,
        runs: Mapping[str, Block],
        around: tuple[Scope, Mapping[str, Destination]],
        failure: Destination,
        sections: list[Section],
    ) -> None:
        """Makes copies of siblings, one for each section (from number ``before`` on) of a block that pauses.

        The copy for an objective is added, and leads back to it; that for a parallel block is put into it
        (:func:`mcpn.mission.expansion.pauses.sheltered`). Handlers whose targets are placeholders (keys of
        ``runs``) are replaced by handlers that lead to the copies.
        """
        scope, routes = around
        for number in range(before, len(sections)):
            section, entries = sections[number], dict[str, str]()
            refuse_paused(section)
            marks = (i.target for i in section.every_interruption if i.target in runs)
            for by in {id(runs[mark]): runs[mark] for mark in marks}.values():
                copy = copied(by, suffix_at(section.name, by.prefix))
                if copy.name in self.copied:
                    message = f"two copies of {by.written} would be called {copy.name}"
                    raise InputError.at(by.source, f"{message}: rename one of the blocks that pause")
                self.copied.add(copy.name)
                self.helping.add(by.name)
                own = {mark for mark, runner in runs.items() if runner is by}
                if isinstance(section, ElementarySection):
                    self.helper(copy, scope, routes, (Destination(section.name), failure), sections)
                    entries |= dict.fromkeys(own, self.entry(copy))
                    continue
                inside, end = list[Section](), Destination(end_of_pause(section.name))
                self.helper(copy, replace(scope, handlers=()), routes, (end, failure), inside)
                graph = ObjectivesGraph(tuple(inside), self.entry(copy)).reachable()
                section = with_pause_graph(section, PauseGraph(graph, scope.interruptions), own)
            led = (replace(i, target=entries.get(i.target, i.target)) for i in section.interruptions)
            sections[number] = replace(section, interruptions=tuple(led))

    def helper(
        self,
        by: Block,
        scope: Scope,
        routes: Mapping[str, Destination],
        ways: tuple[Destination, Destination],
        sections: list[Section],
    ) -> None:
        """Adds a copy of a sibling that is run for another block; its success and failure lead two ways."""
        success, failure = ways
        late = by.timeout_goto
        leads = Destinations(success, failure, routes[by.abort or ABORT], routes[late] if late else failure)
        outwards = replace(by, routes=tuple(each for each in by.routes if each.on in ("abort", "timeout")))
        leads = deciding(outwards, routes, leads, {}, self.facts)
        leads = leads._replace(becoming=self.becoming(by, routes))
        self.block(by, self.handling(scope, by.handlers, routes, by.written), leads, sections)

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
        """Where a handler leads; for a pause a placeholder, which :meth:`paused` replaces by a copy."""
        if handler.pause is None:  # a valid one has one of the two
            cases = ((resolved(each.when, self.facts), routes[each.goto]) for each in handler.routes)
            return by_facts(cases, routes[handler.goto or ABORT])
        self.pauses[mark := f"{PAUSE}{len(self.pauses)}"] = handler.pause
        return Destination(mark)

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
            self.series(
                block.blocks, scope.into(block), leads.exits, sections, whole=(block.stem, leads.named)
            )

    def objective(self, block: Objective, scope: Scope, leads: Destinations) -> ElementarySection:
        self.counted.add(len(block.parameters), block.source)
        reasons = tuple(map(reason, block.failures))
        leads = leads.of_reasons(each.name for each in reasons)
        whole, parts = probabilities(block, reasons)
        self.positions.objectives[block.name] = scope.position(block)
        return ElementarySection(
            block.name,
            block.activities,
            leads.success.target,
            leads.failure.target,
            block.source,
            block.parameters,
            block.description,
            block.duration,
            whole,
            scope.interruptions,
            block.timeout,
            None if block.timeout is None else leads.timed_out.target,
            self.settings(block),
            leads.cases,
            tuple((each.name, leads.named[each.name].lead.target) for each in reasons),
            parts,
            leads.becomes,
        )

    def parallel(self, block: Parallel, scope: Scope, leads: Destinations) -> ParallelSection:
        inner = replace(scope.into(block), handlers=())
        branches = tuple(
            Branch(child.name, child.mandatory, self.graph((child,), inner), child.source)
            for child in block.blocks
        )
        return ParallelSection(
            block.name,
            branches,
            leads.success.target,
            leads.failure.target,
            block.source,
            block.description,
            scope.interruptions,
            leads.abort.target if any(branch.graph.aborts for branch in branches) else None,
            None if block.success_when == "all" else int(block.success_when),
            block.failure_when == "any",
            leads.cases,
            failing=block.failing,
            timeout=block.timeout,
            timed_out=None if block.timeout is None else leads.timed_out.target,
            becomes=leads.becomes,
        )

    def settings(self, block: Objective) -> tuple[Setting, ...]:
        """The facts that an objective changes; that it has succeeded is one where something reads that."""
        said = tuple(Setting(change.fact, change.to, change.occasion) for change in block.sets)
        done = f"done({block.written})"
        return (*said, Setting(done, BOOLEAN_VALUES[True], "success")) if done in self.facts else said
