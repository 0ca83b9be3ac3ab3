"""Guards: blocks that are entered only where facts are so.

What leads to a block with a guard leads elsewhere where its facts are not so. Nothing of a guard is left in
the objectives graph: it becomes the cases of whatever leads to the block. So a block that nothing but its
place leads to, as the first of a series, cannot have one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from mcpn.errors import Problem
from mcpn.mission.conditions import resolved
from mcpn.mission.expansion.destinations import Destination, by_facts
from mcpn.mission.expansion.helpers import helping
from mcpn.mission.language.references import cycles
from mcpn.mission.model import Block, Parallel
from mcpn.mission.robot import Fact


def guarded(
    siblings: Sequence[Block],
    entry: Callable[[Block], str],
    exits: Mapping[str, Destination],
    facts: Mapping[str, Fact],
) -> dict[str, Destination]:
    """Where routes to siblings lead, by name, and the exits around them.

    Args:
        siblings: The blocks of a valid series.
        entry: The section that is entered when a block is.
        exits: By the name of an exit, where it leads.
        facts: The facts of the mission.
    """
    found = {block.name: Destination(entry(block)) for block in siblings if not block.guards} | dict(exits)
    waiting = [block for block in siblings if block.guards]
    while waiting:  # what they lead to else comes first; in a valid series that ends
        ready = [block for block in waiting if all(guard.otherwise in found for guard in block.guards)]
        for block in ready:
            lead = Destination(entry(block))
            for guard in reversed(block.guards):
                lead = by_facts([(resolved(guard.when, facts), lead)], found[guard.otherwise])
            found[block.name] = lead
        waiting = [block for block in waiting if block.name not in found]
    return found


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
