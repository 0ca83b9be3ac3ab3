"""Guards are written out: what leads to a guarded block chooses by the facts that its guards ask for.

A route or a handler that leads to a block with a guard leads elsewhere where its facts are not so: it becomes
several, each with its facts, of which the first that fits counts. So a block that nothing but its place leads
to, as the first of a series, cannot have a guard.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from mcpn.errors import Problem, Source
from mcpn.mission.fact_cases import Destination, FactCase, by_facts
from mcpn.mission.fact_conditions import in_words, resolved
from mcpn.mission.language.references import cycles
from mcpn.mission.model import FAIL, UNNAMED, Block, FactRoute, Handler, Mission, Parallel, walk
from mcpn.mission.rewriting.blocks import in_series
from mcpn.mission.rewriting.siblings import helping
from mcpn.mission.robot import Fact

_BY_OUTCOME = {"success": "success", "failure": "failure", "abort": "abort", "timeout": "timeout_goto"}
"""The outcomes on which facts may choose, each with the route that counts where none fits."""


def guards(mission: Mission) -> Mission:
    """Guards become facts by which all that leads to their blocks chooses (`<enter>`)."""
    if not any(block.guards for block in walk(mission.blocks)):
        return mission
    facts = {fact.name: fact for fact in mission.every_fact}
    handlers = _Guarded(mission.blocks, facts).handlers(mission.handlers)

    def written_out(siblings: tuple[Block, ...], around: tuple[Handler, ...]) -> tuple[Block, ...]:
        found = _Guarded(siblings, facts)
        found.handlers(around)
        return found.siblings()

    return replace(in_series(mission, written_out), handlers=handlers)


class _Guarded:
    """What leads to the guarded blocks of a series.

    Args:
        blocks: The series.
        facts: The facts of the mission.
    """

    def __init__(self, blocks: tuple[Block, ...], facts: Mapping[str, Fact]) -> None:
        self.blocks = blocks
        self.facts = facts
        self.led = set[str]()
        """What is led to by facts that guards ask for, the guarded blocks among it."""
        self.leads = dict[str, Destination]()
        """By guarded block where a route to it leads."""
        waiting = {block.name: block for block in blocks if block.guards}
        while waiting:  # what they lead to else comes first; in a valid series that ends
            for block in [b for b in waiting.values() if all(g.otherwise not in waiting for g in b.guards)]:
                lead = Destination(block.name)
                for guard in reversed(block.guards):
                    default = UNNAMED if guard.otherwise == FAIL else guard.otherwise
                    default_lead = self.leads.get(default, Destination(default))
                    lead = by_facts([(resolved(guard.when, facts), lead)], default_lead)
                self.leads[block.name] = lead
                del waiting[block.name]

    def siblings(self) -> tuple[Block, ...]:
        """The blocks, choosing by facts; guards of those that nothing leads to stay, and change nothing."""
        if not self.leads:
            return self.blocks
        made = [self.block(block) for block in self.blocks]
        return tuple(replace(block, guards=()) if block.name in self.led else block for block in made)

    def block(self, block: Block) -> Block:
        """A block whose routes choose."""
        changes, routes = dict[str, Any](), list[FactRoute]()
        for route in block.routes:
            routes += self.routes(route)
        for on, name in _BY_OUTCOME.items():
            target = getattr(block, name)
            if target in self.leads:
                lead = self.to(target)
                routes += self.cases(lead.cases, block.source, on=on)
                changes[name] = lead.target
        return replace(block, routes=tuple(routes), handlers=self.handlers(block.handlers), **changes)

    def handlers(self, handlers: Iterable[Handler]) -> tuple[Handler, ...]:
        """Handlers that choose."""
        made = list[Handler]()
        for handler in handlers:
            if handler.goto in self.leads:
                lead = self.to(handler.goto)
                cases = self.cases(lead.cases, handler.source)
                handler = replace(handler, goto=lead.target, routes=(*handler.routes, *cases))
            made.append(handler)
        return tuple(made)

    def routes(self, route: FactRoute) -> Iterator[FactRoute]:
        """A route by facts, or for a reason, as those that stand for it."""
        if route.goto not in self.leads:
            yield route
            return
        lead = by_facts([(resolved(route.when, self.facts), self.to(route.goto))], Destination(route.goto))
        yield from self.cases(lead.cases, route.source, on=route.on, reason=route.reason)
        if not route.when:
            yield replace(route, goto=lead.target)

    def to(self, target: str) -> Destination:
        """Where a route to a guarded block leads."""
        lead = self.leads[target]
        self.led |= {target, lead.target, *(case.target for case in lead.cases)}
        return lead

    def cases(self, cases: Iterable[FactCase], source: Source | None, **also: Any) -> tuple[FactRoute, ...]:
        """Cases as routes."""
        return tuple(
            FactRoute(when=in_words(case.when, self.facts), goto=case.target, source=source, **also)
            for case in cases
        )


def guard_problems(siblings: Sequence[Block]) -> Iterator[Problem]:
    """What is wrong with the guards of a series, routes and conditions apart."""
    helpers, named = helping(siblings), {block.name: block for block in siblings}
    for place, block in enumerate(siblings):
        for guard in block.guards[:1]:
            who = f"{block.name} has a guard (enter), though"
            if place == 0:
                remedy = "put another block before it, or the condition on what leads to the block around"
                yield Problem(guard.source, f"{who} it is the first of its series: {remedy}")
            elif block.name in helpers:
                yield Problem(guard.source, f"{who} it is run for another block, whatever the facts")
    yield from cycles(
        "guards (enter) lead to each other, so that no block might be entered",
        named,
        lambda name: [g.otherwise for g in named[name].guards if g.otherwise in named],
    )


def of_branches(block: Parallel) -> Iterator[Problem]:
    """Guards of children of a parallel block."""
    for child in block.blocks:
        for guard in child.guards[:1]:
            message = f"{child.name} has a guard (enter), though it is a child of a parallel block"
            yield Problem(guard.source, f"{message}: guards stand on {block.name}")
