"""What is suspicious about the facts of a mission, though it can be verified as it stands.

It speaks of the words of an author: a guard, which a core mission no longer has, a route once for all copies
of its block, and what protocols say that nothing uses. Which values facts may have, the core mission says.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from mcpn.errors import Problem
from mcpn.mission.core.objectives_graph import ObjectivesGraph
from mcpn.mission.fact_conditions import conditions, required, word
from mcpn.mission.fact_usage import FactUsage
from mcpn.mission.model import Mission, Objective, walk
from mcpn.mission.robot import Fact


def fact_warnings(mission: Mission, world: FactUsage, graph: ObjectivesGraph) -> Iterator[Problem]:
    """Facts that nobody changes or reads, changes that change nothing, conditions that are never so.

    Args:
        mission: A valid mission, as its author wrote it.
        world: Its facts.
        graph: Its objectives graph.
    """
    values = _values(world, graph)
    read = {word(text).fact for text in conditions(mission)} | _asked(mission)
    for fact in mission.facts:
        if len(values[fact.name]) == 1:
            said = "is never set to another value" if _is_set(world, graph, fact) else "is never set"
            yield Problem(fact.source, f"fact {fact.name} {said}: it stays {fact.start}")
        if fact.name not in read:
            yield Problem(fact.source, f"fact {fact.name} is never read")
    for blocks in (mission.blocks, *(protocol.blocks for protocol in mission.protocols)):
        for block in walk(blocks):
            for change in block.sets if isinstance(block, Objective) else ():
                if values[change.fact] == {change.to}:
                    said = f"objective {block.name} sets {change.fact} to {change.to}, which it always is"
                    yield Problem(change.source, said)
            for handler in block.handlers:
                never = _never(world, values, handler.when)
                if never:
                    yield Problem(handler.source, f"<on when> of {block.name} never leads away: {never}")
            for guard in block.guards:
                never = _never(world, values, guard.when)
                if never:
                    yield Problem(guard.source, f"{block.name} is never entered: {never}")
            for route in block.routes:
                never = _never(world, values, route.when)
                if never:
                    yield Problem(route.source, f"a route of {block.name} is never taken: {never}")
    for activity in mission.activities:
        for way in activity.alternatives:
            never = _never(world, values, (*activity.requires, *way.requires))
            if never:
                yield Problem(way.source, f"alternative {way.name} is never possible: {never}")


def _values(world: FactUsage, graph: ObjectivesGraph) -> dict[str, set[str]]:
    """The values that facts may have: at the start, and by objectives and events."""
    values = {name: {fact.start} for name, fact in world.facts.items()}
    for objective in graph.walk():
        for setting in objective.sets:
            values[setting.fact].add(setting.value)
    for changes in world.changing.values():
        for name, to in changes.items():
            values[name].update(to.values())
    return values


def _is_set(world: FactUsage, graph: ObjectivesGraph, fact: Fact) -> bool:
    by_objective = any(s.fact == fact.name for objective in graph.walk() for s in objective.sets)
    return by_objective or any(fact.name in changes for changes in world.changing.values())


def _asked(mission: Mission) -> set[str]:
    """Facts that requirements name."""
    return {name for text in required(mission) for name in re.findall(r"fact\(\s*\"?(\w+)", text)}


def _never(world: FactUsage, values: dict[str, set[str]], texts: tuple[str, ...]) -> str:
    """Says which word of a condition never holds; empty where each may hold."""
    for text in texts:
        said = word(text)
        fact = world.facts[said.fact]
        value = said.value or fact.values[not said.negated]
        if value not in values[said.fact]:
            return f"{said.fact} is never {value}"
    return ""
