"""Lists the words that formulas about a mission may name; what they mean is said in mission_names.py."""

from __future__ import annotations

from collections.abc import Mapping

from mcpn.answers.mission_names import MissionNames
from mcpn.drawing.compose import MissionNet
from mcpn.events import What
from mcpn.records import record


@record(frozen=True)
class NamedWord:
    """A name that formulas may say.

    Args:
        name: The name; of copies the one that means all of them.
        copies: Each of them by itself; none where there is only one.
        description: What the mission says of it.
    """

    name: str
    copies: tuple[str, ...] = ()
    description: str | None = None


@record(frozen=True)
class NamedActivity(NamedWord):
    """An activity, and what alternatives it has."""

    alternatives: tuple[str, ...] = ()


@record(frozen=True)
class NamedFact(NamedWord):
    """A fact, and what values it has."""

    values: tuple[str, ...] = ()


@record(frozen=True)
class Vocabulary:
    """What formulas about a mission may name, by kind, in the order of the mission.

    Args:
        mission: The mission's name.
        objectives: For ``objective(x)`` and ``pending(x)``.
        blocks: For ``block(x)``: those that hold objectives.
        activities: For ``activity(x)``, ``alternative(x)=y``, ``waiting(x)`` and ``refused(x)``.
        hardware: For ``oos(x)`` and ``available(x)``.
        software: For ``available(x)``.
        facts: For ``fact(x)=v``, with their values.
        events: For ``happens(x)`` and ``event(x)``.
        ends: How the mission may end, words by themselves.
    """

    mission: str
    objectives: tuple[NamedWord, ...]
    blocks: tuple[NamedWord, ...]
    activities: tuple[NamedActivity, ...]
    hardware: tuple[NamedWord, ...]
    software: tuple[NamedWord, ...]
    facts: tuple[NamedFact, ...]
    events: tuple[NamedWord, ...]
    ends: tuple[str, ...]


def vocabulary(mission_net: MissionNet) -> Vocabulary:
    """The words of a mission; nothing is explored to know them."""
    mission, names = mission_net.core, MissionNames(mission_net)
    copies = mission_net.graph.copies
    described = {section.name: section.description for section in mission_net.graph.walk()}
    happening: dict[str, str | None] = {
        e.element if e.what is What.DECLARED else str(e): None for e in mission_net.net.events
    }
    happening |= {event.name: event.description for event in mission.events if event.name in happening}

    def folded(known: Mapping[str, str | None]) -> tuple[NamedWord, ...]:
        return tuple(
            NamedWord(name, tuple(copies) if copies != [name] else (), known[copies[0]])
            for name, copies in names.folded(known).items()
        )

    return Vocabulary(
        mission=mission.name,
        objectives=folded(described),
        blocks=folded(
            {n: None for n, held in copies.held.items() if held != (n,) and n not in copies.wholes}
        ),
        activities=tuple(
            NamedActivity(a.name, (), a.description, tuple(way.name for way in a.alternatives))
            for a in mission_net.usage.activities.values()
        ),
        hardware=tuple(NamedWord(h.name, (), h.description) for h in mission.hardware),
        software=tuple(NamedWord(s.name, (), s.description) for s in mission.software),
        facts=tuple(NamedFact(f.name, (), f.description, f.values) for f in mission.facts),
        events=folded(happening),
        ends=tuple(mission_net.ends),
    )
