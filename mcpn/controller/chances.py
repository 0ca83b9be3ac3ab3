"""How likely what a mission's file speaks of is, as the fake drivers of a bench read it.

Of what stops an objective the order of sections says more than the controller's document: which handlers,
timers and changes of facts are those of a block around it.
"""

from __future__ import annotations

from collections.abc import Iterable

from mcpn.drawing.compose import MissionNet
from mcpn.events import Event, What
from mcpn.mission.core.objectives_graph import ElementarySection, ParallelSection, Section
from mcpn.mission.core.routes import Interrupted
from mcpn.mission.model import Mission
from mcpn.robot.bench.chances import AskingOrder, Chances, ObjectiveChances


def chances_of(mission_net: MissionNet) -> Chances:
    """Reads rates, durations and probabilities.

    Args:
        mission_net: The mission, whose file gives them.
    """
    stopped = _stopped_by(mission_net)
    mission = mission_net.core
    on_demand = {h.name: h.demand_probability for h in mission.hardware if h.demand_probability}
    return Chances(
        _rates(mission),
        {
            objective.name: ObjectiveChances(
                objective.duration,
                objective.failure_probability,
                {
                    reason: share
                    for (reason, _), share in zip(objective.failures, objective.shares, strict=True)
                },
                frozenset(map(str, stopped[objective.name])),
            )
            for objective in mission_net.graph.walk()
        },
        on_demand,
        _orders(mission_net) if on_demand else {},
    )


def _rates(mission: Mission) -> dict[str, float]:
    rates: dict[Event, float] = {}
    for hardware in mission.hardware:
        rates[Event(What.OUT_OF_SERVICE, hardware.name)] = hardware.failure_rate or 0.0
        rates[Event(What.REPAIRED, hardware.name)] = hardware.repair_rate or 0.0
    for activity in mission.activities:
        for name in activity.detects:
            rates[Event(What.DETECTED, name)] = activity.detection_rate or 0.0
    for declared in mission.events:
        rates[Event(What.DECLARED, declared.name)] = declared.rate or 0.0
    return {str(event): rate for event, rate in rates.items()}


def _orders(mission_net: MissionNet) -> dict[str, AskingOrder]:
    """By objective, the order in which the activities of its section come upon resources."""
    parts, found = mission_net.section_parts, dict[str, AskingOrder]()
    for section in mission_net.graph.sections:
        used = parts.alone(section).used
        order = AskingOrder(used.number, used.task)
        found.update(dict.fromkeys((objective.name for objective in section.walk()), order))
    return found


def _stopped_by(mission_net: MissionNet) -> dict[str, set[Event]]:
    """By objective, the events of what is around it that end its run."""
    found: dict[str, set[Event]] = {objective.name: set() for objective in mission_net.graph.walk()}
    changing = mission_net.usage.world.changing
    for section in mission_net.graph.all_sections():
        asked = {said for each in section.becomes for said in each.when}
        by_facts = {
            Event(What.DECLARED, name)
            for name, changes in changing.items()
            if any((fact, value) in asked for fact, to in changes.items() for value in to.values())
        }
        for outer, stopped in _inside(section):
            events = {Event(What.DECLARED, handler.event) for handler in outer.interruptions}
            if outer is section:  # the time of a block that pauses does not go on
                events |= {Event(What.TIMEOUT, section.name), *by_facts}
            for inner in stopped:
                found[inner.name] |= events
    return found


def _inside(section: Section) -> list[tuple[Interrupted, Iterable[ElementarySection]]]:
    """A section and its pauses, which handlers interrupt, each with the objectives that end by that."""
    if not isinstance(section, ParallelSection):
        return [(section, section.walk())]
    branches: list[tuple[Interrupted, Iterable[ElementarySection]]] = [
        (section, branch.graph.walk()) for branch in section.branches
    ]
    return branches + [(pausing, pausing.graph.walk()) for pausing in section.pause_graphs]
