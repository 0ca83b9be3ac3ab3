"""From blocks to the objectives graph: recursion replaced by its contents (paper, 5.1 and Fig. 5).

Parallel blocks are kept as sections, each branch with a graph of its own; uses of protocols are expanded,
their names qualified by the use (``transect_north.diving``). Rounds of ``each`` and ``repeat`` and tries of
``retries`` are written out one after the other, named by their value, round or try (``visit_12``,
``visit_3``, ``visit_try2``; runs of a block that recovers ``visit_run2``), which qualifies what they hold
(``visit_12.travel``).

Routes that facts choose (``<route when="door=open">``) become the cases of sections in
:meth:`_Flattening.deciding`, by :func:`mcpn.mission.expansion.destinations.by_facts`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from mcpn.errors import InputError, Source
from mcpn.mission.conditions import facts_of, resolved
from mcpn.mission.expansion.copies import Copies
from mcpn.mission.expansion.destinations import (
    Destination,
    Destinations,
    Named,
    by_facts,
    failing_for,
    reasons_led,
)
from mcpn.mission.expansion.guards import guarded
from mcpn.mission.expansion.left_by_facts import left_by_facts, refuse_paused
from mcpn.mission.expansion.pauses import PAUSE, suffix_at, with_pause_graph
from mcpn.mission.expansion.recovery import entered, following, helping
from mcpn.mission.expansion.routes import GO_ON, Becoming, Condition, Interruption, Setting
from mcpn.mission.expansion.scope import (
    MAX_NESTING,
    MAX_OBJECTIVES,
    Scope,
    copies,
    limit_hit,
    several,
    unrouted,
)
from mcpn.mission.graph import (
    IN_TIME,
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
    Protocol,
    Recursive,
    Use,
)
from mcpn.mission.reasons import probabilities, reasons_of
from mcpn.mission.requirement import Requirement
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

MAX_PARAMETERS = 1_000_000


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
    graph = flattening.graph(mission.blocks, Scope(), mission.handlers)
    return replace(graph, copies=flattening.positions)


def requirements_of(mission: Mission) -> dict[str, tuple[str, Requirement]]:
    """The requirements of a mission, those of a protocol for each of its uses.

    Args:
        mission: A mission; as of :func:`flatten`.

    Returns:
        By qualified name what stands before the names of the text that holds it, and the requirement.

    Raises:
        InputError: As :func:`flatten`.
        LimitError: As :func:`flatten`.
    """
    found = {each.name: ("", each) for each in mission.requirements}
    if any(protocol.requirements for protocol in mission.protocols):
        flattening = _Flattening(valid(mission))
        flattening.graph(mission.blocks, Scope(), mission.handlers)
        found |= flattening.requirements
    return found


class _Flattening:
    def __init__(self, mission: Mission) -> None:
        self.requirements: dict[str, tuple[str, Requirement]] = {}
        self.positions = Copies()
        self.protocols: dict[str, Protocol] = {p.name: p for p in mission.protocols}
        self.activities = {activity.name: activity for activity in mission.activities}
        self.facts = facts_of(mission)
        self.pauses: dict[str, str] = {}
        """By placeholder for the target of a pause, the name of the sibling that is run meanwhile."""
        self.copied: set[str] = set()
        """Names of copies of siblings that are run while blocks pause."""
        self.objectives = 0
        self.parameters = 0

    def graph(
        self,
        blocks: tuple[Block, ...],
        scope: Scope,
        handlers: tuple[Handler, ...] = (),
    ) -> ObjectivesGraph:
        sections: list[Section] = []
        exits = {exit_: Destination(exit_) for exit_ in (SUCCEED, FAIL, ABORT)}
        self.series(blocks, scope, exits, sections, handlers)
        return ObjectivesGraph(tuple(sections), self.entry(blocks[0], scope)).reachable()

    def series(
        self,
        blocks: tuple[Block, ...],
        scope: Scope,
        exits: dict[str, Destination],
        sections: list[Section],
        around: tuple[Handler, ...] = (),
        copied: Mapping[str, Named] | None = None,
    ) -> None:
        """Adds the sections of sibling blocks, under handlers that lead to them as well.

        One copy of a block is a series, too, where named failures lead as ``copied`` says.
        """
        routes = guarded(blocks, partial(self.entry, scope=scope), exits, self.facts)
        scope = self.handling(scope, around, routes, "")
        after, named = following(blocks), {block.name: block for block in blocks}
        aside = helping(blocks)
        aside -= entered(blocks, around) if aside else aside
        for block in blocks:
            if block.name in aside:
                continue
            success = block.success or after[block.name]
            inner = self.handling(scope, block.handlers, routes, block.name)
            failure = block.failure or FAIL
            late = block.timeout_goto or failure
            leads = Destinations(routes[success], routes[failure], routes[block.abort or ABORT], routes[late])
            before = len(sections)
            leads = leads._replace(named=copied) if copied else self.deciding(block, routes, leads, exits)
            leads = leads._replace(becoming=self.becoming(block, routes))
            if block.recover is None:
                self.block(block, inner, leads, sections)
            else:
                recovery = named[block.recover], scope, routes
                self.recovered(block, inner, leads, recovery, sections)
            own = inner.handlers[: len(inner.handlers) - len(scope.handlers)]
            if runs := {i.target: named[self.pauses[i.target]] for i in own if i.target in self.pauses}:
                self.paused(before, runs, (scope, routes), leads.failure, sections)

    def deciding(
        self,
        block: Block,
        routes: Mapping[str, Destination],
        leads: Destinations,
        exits: Mapping[str, Destination],
    ) -> Destinations:
        """The leads of a block, its routes with a condition on facts or a reason put before the others."""
        own: dict[str, list[tuple[Condition, str]]] = {"success": [], "failure": []}
        named = {reason: list[tuple[Condition, str]]() for reason in reasons_led(exits)}
        for route in block.routes:
            decided = own[route.on] if route.reason is None else named.setdefault(route.reason, [])
            decided.append((resolved(route.when, self.facts), route.goto))
        if not block.routes and not named:
            return leads

        def led(
            cases: list[tuple[Condition, str]], failing: Destination
        ) -> tuple[tuple[Condition, Destination], ...]:
            return tuple((when, failing if goto == FAIL else routes[goto]) for when, goto in cases)

        success = by_facts(led(own["success"], routes[FAIL]), leads.success)
        failure = by_facts(led(own["failure"], routes[FAIL]), leads.failure)
        found = dict[str, Named]()
        for reason, cases in named.items():
            # What fails so fails the block around for the same reason.
            around = exits.get(failing_for(reason), routes[FAIL])
            default = around if block.failure in (None, FAIL) else leads.failure
            found[reason] = Named(led(cases, around), by_facts(led(own["failure"], around), default))
        return Destinations(
            success, failure, leads.abort, leads.timed_out if block.timeout_goto else failure, found
        )

    def recovered(
        self,
        block: Block,
        scope: Scope,
        leads: Destinations,
        recovery: tuple[Block, Scope, Mapping[str, Destination]],
        sections: list[Section],
    ) -> None:
        """Adds the runs of a block that recovers, and between them copies of the sibling that it names."""
        by, around, routes = recovery
        runs = list(copies(block, scope))
        for number, ((blocks, inside), again) in enumerate(zip(runs, (*runs[1:], None), strict=True), 1):
            if again is None:
                self.series(blocks, inside, leads.exits, sections, copied=leads.named)
                return
            here = around.copy(by, f"{block.name}{number}")
            run = leads.failing(Destination(self.entry(by, here)))
            self.series(blocks, inside, run.exits, sections, copied=run.named)
            back = Destination(self.entry(again[0][0], again[1]))
            self.helper(by, here, routes, (back, leads.failure), sections)

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
                here = scope.copy(by, suffix_at(section.name, scope))
                if here.name(by) in self.copied:
                    message = f"two copies of {by.name} would be called {here.name(by)}"
                    raise InputError.at(by.source, f"{message}: rename one of the blocks that pause")
                self.copied.add(here.name(by))
                own = {mark for mark, runner in runs.items() if runner is by}
                if isinstance(section, ElementarySection):
                    self.helper(by, here, routes, (Destination(section.name), failure), sections)
                    entries |= dict.fromkeys(own, self.entry(by, here))
                    continue
                copy = list[Section]()
                self.helper(by, replace(here, handlers=()), routes, (Destination(GO_ON), failure), copy)
                graph = ObjectivesGraph(tuple(copy), self.entry(by, here)).reachable()
                section = with_pause_graph(section, PauseGraph(graph, here.interruptions), own)
            led = (replace(i, target=entries.get(i.target, i.target)) for i in section.interruptions)
            sections[number] = replace(section, interruptions=tuple(led))

    def helper(
        self,
        by: Block,
        here: Scope,
        routes: Mapping[str, Destination],
        ways: tuple[Destination, Destination],
        sections: list[Section],
    ) -> None:
        """Adds a copy of a sibling that is run for another block; its success and failure lead two ways."""
        success, failure = ways
        late = by.timeout_goto
        leads = Destinations(success, failure, routes[by.abort or ABORT], routes[late] if late else failure)
        leads = leads._replace(becoming=self.becoming(by, routes))
        self.block(by, self.handling(here, by.handlers, routes, by.name), leads, sections)

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
                lead, when = routes[handler.goto or ABORT], resolved(handler.when, self.facts)
                found.append((Becoming(when, lead.target, handler.source), lead))
        return tuple(found)

    def leading(self, handler: Handler, routes: Mapping[str, Destination]) -> Destination:
        """Where a handler leads; for a pause a placeholder, which :meth:`paused` replaces by a copy."""
        if handler.pause is None:
            return routes[handler.goto or ABORT]  # a valid one has one of the two
        self.pauses[mark := f"{PAUSE}{len(self.pauses)}"] = handler.pause
        return Destination(mark)

    def inside(self, block: Recursive | Parallel | Use, scope: Scope) -> tuple[tuple[Block, ...], Scope]:
        """What a block holds, and the scope of that."""
        if isinstance(block, Use):
            protocol = self.protocols[block.protocol]
            return protocol.blocks, scope.into_protocol(block, protocol)
        return block.blocks, scope.into(block, block.parameters if isinstance(block, Recursive) else ())

    def entry(self, block: Block, scope: Scope) -> str:
        """The name of the section that is entered when the block is."""
        while True:
            if left_by_facts(block):
                return scope.name(block)
            if several(block):
                blocks, scope = next(copies(block, scope))
            elif isinstance(block, Recursive | Use) and block.timeout is None:
                blocks, scope = self.inside(block, scope)
            else:
                return scope.name(block)
            block = blocks[0]

    def block(self, block: Block, scope: Scope, leads: Destinations, sections: list[Section]) -> None:
        if leads.becoming and (several(block) or not isinstance(block, Objective | Parallel)):
            sections.append(self.whole(block, scope, leads))
        elif several(block):
            self.copies(block, scope, leads, sections)
        elif isinstance(block, Objective):
            parameters = scope.in_force(block.parameters)
            self.count(len(parameters), block.source)
            reasons = reasons_of(block, self.activities)
            leads = leads.of_reasons(each.name for each in reasons)
            whole, parts = probabilities(block, reasons)
            self.positions.objectives[scope.name(block)] = scope.position(block)
            sections.append(
                ElementarySection(
                    scope.name(block),
                    block.activities,
                    leads.success.target,
                    leads.failure.target,
                    block.source,
                    parameters,
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
            )
        elif isinstance(block, Parallel):
            children, inner = self.inside(block, scope)
            branches = tuple(self.branch(child, inner) for child in children)
            name, (needed, hasty, failing) = scope.name(block), block.decided
            sections.append(
                ParallelSection(
                    name,
                    branches,
                    leads.success.target,
                    leads.failure.target,
                    block.source,
                    block.description,
                    scope.interruptions,
                    leads.abort.target if any(branch.graph.aborts for branch in branches) else None,
                    needed,
                    hasty,
                    leads.cases,
                    failing=failing,
                    timeout=block.timeout,
                    timed_out=None if block.timeout is None else leads.timed_out.target,
                    becomes=leads.becomes,
                )
            )
        elif block.timeout is not None:
            sections.append(self.whole(block, scope, leads))
        elif isinstance(block, Recursive | Use):
            blocks, inner = self.inside(block, scope)
            for each in self.protocols[block.protocol].requirements if isinstance(block, Use) else ():
                self.requirements[f"{inner.prefix}{each.name}"] = inner.prefix, each
            self.series(blocks, inner, leads.exits, sections)

    def whole(self, block: Block, scope: Scope, leads: Destinations) -> ParallelSection:
        """A block that is stopped as a whole and is not parallel: a section with one branch, which it is.

        Its time may be over, or it is left as facts become so; the copies of a block have times of their own.
        """
        timeout = None if several(block) else block.timeout
        inside = unrouted(block)
        inside = inside if timeout is None else replace(inside, timeout=None, timeout_goto=None)
        graph = self.graph((inside,), replace(scope, handlers=()))
        name = scope.name(block)
        return ParallelSection(
            name,
            (Branch(f"{name}{IN_TIME}", True, graph, block.source),),
            leads.success.target,
            leads.failure.target,
            block.source,
            block.description,
            scope.interruptions,
            leads.abort.target if graph.aborts else None,
            cases=leads.cases,
            timeout=timeout,
            timed_out=None if timeout is None else leads.timed_out.target,
            becomes=leads.becomes,
        )

    def settings(self, block: Objective) -> tuple[Setting, ...]:
        """The facts that an objective changes; that it has succeeded is one where something reads that."""
        said = tuple(Setting(change.fact, change.to, change.occasion) for change in block.sets)
        done = f"done({block.name})"
        return (*said, Setting(done, BOOLEAN_VALUES[True], "success")) if done in self.facts else said

    def copies(self, block: Block, scope: Scope, leads: Destinations, sections: list[Section]) -> None:
        """Adds the rounds of a block, or its tries, one after the other."""
        tries = block.repeat is None and block.retries > 0
        here: tuple[tuple[Block, ...], Scope] | None = next(each := copies(block, scope))
        while here is not None:
            (blocks, inner), here = here, next(each, None)
            following = self.entry(here[0][0], here[1]) if here else None
            if following is None:
                each_leads = leads
            elif tries:
                each_leads = leads.failing(Destination(following))
            else:
                each_leads = leads._replace(success=Destination(following))
            copied = each_leads.named if tries or block.repeat is not None else None
            self.series(blocks, inner, each_leads.exits, sections, copied=copied)

    def branch(self, child: Block, scope: Scope) -> Branch:
        alone = replace(child, success=None, failure=None, routes=())
        name = scope.name(child)
        graph = self.graph((alone,), replace(scope, handlers=()))
        return Branch(name, child.mandatory, graph, child.source)

    def count(self, parameters: int, source: Source | None) -> None:
        self.objectives += 1
        self.parameters += parameters
        if self.objectives > MAX_OBJECTIVES:
            raise limit_hit(f"more than {MAX_OBJECTIVES} objectives after expansion", source)
        if self.parameters > MAX_PARAMETERS:
            raise limit_hit(f"more than {MAX_PARAMETERS} parameters of objectives after expansion", source)
