"""What is suspicious in a valid mission, though it can be verified as it stands.

It is asked of the core mission, whose elements have their author's lines, and is said once of all copies of
one. Two kinds of warnings are not: what runs for another block and then does not go on there
(:func:`_leading_out`), and what is said of facts (:mod:`mcpn.mission.fact_warnings`), speak of ``recover``,
``pause`` and ``<enter>``, which no core mission has.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from functools import cache

from mcpn.errors import Problem
from mcpn.mission.core.copies import grouped
from mcpn.mission.core.flattening import flatten
from mcpn.mission.core.objectives_graph import ElementarySection, ObjectivesGraph
from mcpn.mission.fact_warnings import fact_warnings
from mcpn.mission.model import ABORT, FAIL, SUCCEED, Block, Holder, Mission, Use, walk
from mcpn.mission.static.contention import contention_warnings
from mcpn.mission.static.resource_use import Usage


def find_warnings(subject: Mission | Usage) -> list[Problem]:
    """What is suspicious in a valid mission, though it can be verified as it stands.

    Args:
        subject: A valid mission, or its static analysis where it is there.

    Returns:
        Activities that nothing starts, resources and protocols that nothing uses, events that interrupt
        nothing, routes of aborts where nothing aborts, objectives that no route reaches, alternatives
        that are never tried, facts that nobody changes or reads, each with its line.
    """
    return in_order(_warnings(subject if isinstance(subject, Usage) else Usage(subject, flatten(subject))))


def static_warnings(usage: Usage) -> list[Problem]:
    """All warnings that need no state space: those of :func:`find_warnings`, and contentions."""
    problems = (*find_warnings(usage), *contention_warnings(usage.contentions, usage.graph))
    return list({str(problem): problem for problem in problems}.values())


def in_order(problems: Iterable[Problem]) -> list[Problem]:
    """Problems in the order of files and lines."""
    return sorted(problems, key=lambda p: (p.source.file, p.source.line or 0) if p.source else ("", 0))


def of_objectives(
    usage: Usage, sections: Iterable[ElementarySection], one: str, several: str = ""
) -> Iterator[Problem]:
    """One problem for each objective that is written, however many rounds, tries and uses it has.

    Args:
        usage: The mission's static analysis.
        sections: Objectives of which the same is to be said, in their order.
        one: What is said of one of them, without its name.
        several: The same of several; that of one by default.
    """
    copies = usage.graph.copies
    for same in grouped(sections, lambda section: copies.written(section.name)).values():
        subject, more = copies.subject("objective", [s.name for s in same], names_of_objectives(usage.graph))
        yield Problem(same[0].source, f"{subject} {(several or one) if more else one}")


def names_of_objectives(graph: ObjectivesGraph) -> list[str]:
    """The names of all objectives, those that no route reaches among them."""
    return [objective.name for objective in (*graph.walk(), *graph.never_entered())]


def never_entered(usage: Usage) -> Iterator[Problem]:
    """The warnings of objectives that no route reaches, in the words of every stage that finds them."""
    said = "can never be entered: no route reaches"
    return of_objectives(usage, usage.graph.never_entered(), f"{said} it", f"{said} them")


def never_used(core: Mission, used: Collection[str]) -> Iterator[Problem]:
    """The warnings of resources that nobody uses, in the words of every stage that finds them."""
    faults = {cause.name for cause in core.common_causes}
    crashes = {crash.name for crash in core.crashes}  # reported as activities and alternatives
    for resource in (*core.hardware, *core.software):
        if resource.name in crashes:
            continue
        if resource.name in faults and resource.name not in used:
            yield Problem(resource.source, f"fault {resource.name} affects nothing that is used")
        elif resource.name not in used:
            yield Problem(resource.source, f"resource {resource.name} is never used")


def _warnings(usage: Usage) -> Iterator[Problem]:
    core, graph = usage.core, usage.graph
    started = frozenset(usage.started)
    ways = [way for name in started for way in usage.activities[name].alternatives]
    consumed = {resource for way in ways for resource in way.consumes}
    for activity in core.activities:
        if activity.name not in started:
            yield Problem(activity.source, f"activity {activity.name} is never started")
        for number, alternative in enumerate(activity.alternatives[:-1]):
            if not (alternative.consumes or alternative.requires or activity.requires):
                for late in activity.alternatives[number + 1 :]:
                    message = f"alternative {late.name} is never tried: {alternative.name} is always possible"
                    yield Problem(late.source, message)
                break
    yield from never_used(core, consumed)
    handled = {i.event for section in graph.all_sections() for i in section.interruptions}
    for event in core.events:
        if event.name not in handled and not event.changes_facts:
            yield Problem(event.source, f"event {event.name} interrupts nothing")
    left = [block for protocol in core.protocols for block in walk(protocol.blocks)]  # by the pass of uses
    used = {block.protocol for block in left if isinstance(block, Use)}
    for protocol in core.protocols:
        if protocol.name not in used:
            yield Problem(protocol.source, f"protocol {protocol.name} is never used")
    yield from fact_warnings(usage.mission, usage.world, graph)
    yield from _vain(core)
    yield from _leading_out(usage.mission)
    yield from never_entered(usage)


def _leading_out(mission: Mission) -> Iterator[Problem]:
    """Siblings that run while blocks pause, or to recover them, and then leave the block around both.

    Some do so when their time is over, some succeed by an event that they handle themselves.
    """
    for blocks in (mission.blocks, *(protocol.blocks for protocol in mission.protocols)):
        named = {block.name: block for block in walk(blocks)}
        for block in named.values():
            by = [(handler.pause, "pauses") for handler in block.handlers] + [(block.recover, "recovers")]
            for name, why in by:
                sibling = named.get(name or "")
                late = sibling and sibling.timeout_goto
                if sibling is not None and late not in (None, FAIL):
                    message = (
                        f"{sibling.name} runs while {block.name} {why}, and leads to {late} when its time is "
                        f"over: {block.name} does not go on then"
                    )
                    yield Problem(sibling.source, message)
                ended = () if sibling is None else sibling.handlers
                for handler in (h for h in ended if h.goto == SUCCEED and h.event is not None):
                    message = (
                        f"{name} runs while {block.name} {why}, and by its event {handler.event} succeeds, "
                        f"which ends the block around both: {block.name} does not go on then; let the event "
                        f"lead out of an objective inside {name}"
                    )
                    yield Problem(handler.source, message)


def _vain(core: Mission) -> Iterator[Problem]:
    """Blocks that route an abort though nothing in them aborts, each once, whatever copies it has."""
    protocols = {protocol.name: protocol.blocks for protocol in core.protocols}  # that nothing uses
    found = dict[str, Problem]()

    @cache
    def leaves(protocol: str) -> bool:
        return any(map(leads_out, protocols[protocol]))

    def aborts(block: Block) -> bool:
        """Whether something in a block aborts, and nothing in it routes that."""
        if isinstance(block, Use):
            return leaves(block.protocol)
        return isinstance(block, Holder) and any(map(leads_out, block.blocks))

    def leads_out(block: Block) -> bool:
        """Whether a block aborts what it stands in."""
        ends = (block.success, block.failure, block.timeout_goto)
        routes = [*ends, *(target for handler in block.handlers for target in handler.targets)]
        routes += [*(route.goto for route in block.routes), *(guard.otherwise for guard in block.guards)]
        return ABORT in routes or (block.abort in (None, ABORT) and aborts(block))

    for blocks in (core.blocks, *protocols.values()):
        for block in walk(blocks):
            if block.abort is not None and not aborts(block):
                message = f"abort of {block.written} has no effect: nothing in it aborts"
                problem = Problem(block.source, message)
                found.setdefault(str(problem), problem)
    yield from found.values()
