"""What is suspicious in a valid mission, though it can be verified as it stands."""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.errors import Problem
from mcpn.mission.facts.usage import Usage
from mcpn.mission.flatten import ElementarySection, flatten
from mcpn.mission.model import Mission, Use, walk


def find_warnings(mission: Mission) -> list[Problem]:
    """What is suspicious in a valid mission, though it can be verified as it stands.

    Args:
        mission: A valid mission.

    Returns:
        Activities that nothing starts, resources and protocols that nothing uses, events that interrupt
        nothing, objectives that no route reaches, alternatives that are never tried, each with its line.
    """
    return sorted(
        _warnings(mission),
        key=lambda p: (p.source.file, p.source.line or 0) if p.source else ("", 0),
    )


def never_entered(section: ElementarySection) -> Problem:
    """The warning of an objective that no route reaches, in the words of every stage that finds it."""
    return Problem(section.source, f"objective {section.name} can never be entered: no route reaches it")


def _warnings(mission: Mission) -> Iterator[Problem]:
    graph = flatten(mission)
    usage = Usage(mission, graph)
    started = frozenset(usage.started)
    ways = [way for name in started for way in usage.activities[name].alternatives]
    consumed = {resource for way in ways for resource in way.consumes}
    for activity in mission.activities:
        if activity.name not in started:
            yield Problem(activity.source, f"activity {activity.name} is never started")
        for number, alternative in enumerate(activity.alternatives[:-1]):
            if not alternative.consumes:
                for late in activity.alternatives[number + 1 :]:
                    message = f"alternative {late.name} is never tried: {alternative.name} is always possible"
                    yield Problem(late.source, message)
                break
    for resource in (*mission.hardware, *mission.software):
        if resource.name not in consumed:
            yield Problem(resource.source, f"resource {resource.name} is never consumed")
    handled = {i.event for section in graph.all_sections() for i in section.interruptions}
    for event in mission.events:
        if event.name not in handled:
            yield Problem(event.source, f"event {event.name} interrupts nothing")
    texts = (mission.blocks, *(protocol.blocks for protocol in mission.protocols))
    used = {block.protocol for blocks in texts for block in walk(blocks) if isinstance(block, Use)}
    for protocol in mission.protocols:
        if protocol.name not in used:
            yield Problem(protocol.source, f"protocol {protocol.name} is never used")
    yield from map(never_entered, graph.never_entered())
