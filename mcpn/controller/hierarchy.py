"""The mission controller in two levels: a machine for each type of section, and one that leads between them.

Its size is the sum of the sizes of the types, where the flat machine's is a product with all hardware that a
section does not use. To run it: keep the set of hardware out of service (its failure adds, its repair takes
away). A section is entered by taking, in its type's machine, the edge ``MISSION_EV_START`` from the state
before the start that has the section's own hardware in that set out of service. When the machine comes to a
state with an outcome, the section has ended so, and its route for that outcome says what is entered next.
"""

from __future__ import annotations

from dataclasses import dataclass

from mcpn.controller.machine import Machine, controller
from mcpn.space.local.composite import Composite


@dataclass(frozen=True)
class TopState:
    """A section as a state of the top machine.

    Args:
        name: The section's name.
        type: Number of its type's machine.
        names: What elements of the type's machine are called in this section, by their names there: kind
            (``objectives``, ``activities``, ``alternatives`` as ``activity.alternative``, ``hardware``) to
            the names.
        success: The section entered after success, or ``succeed`` or ``fail``.
        failure: The same after failure.
    """

    name: str
    type: int
    names: dict[str, dict[str, str]]
    success: str
    failure: str


@dataclass(frozen=True)
class Hierarchy:
    """A mission controller in two levels.

    Args:
        mission: The mission's name.
        initial: The section entered at the mission's start.
        sections: In document order.
        types: Their machines.
    """

    mission: str
    initial: str
    sections: tuple[TopState, ...]
    types: tuple[Machine, ...]


def hierarchical_controller(composite: Composite) -> Hierarchy:
    """Generates the controller of a mission in two levels.

    Args:
        composite: The mission's composite, the states of every section listed.

    Returns:
        A machine for each type of section, and the routes between sections.
    """
    numbers: dict[int, int] = {}
    types, sections = list[Machine](), list[TopState]()
    for placed in composite.sections:
        local = placed.listed
        if id(local) not in numbers:
            numbers[id(local)] = len(types)
            types.append(controller(local.net, local.graph))
        section = placed.section
        renaming = placed.renaming
        names = {
            "objectives": renaming.objectives,
            "activities": renaming.activities,
            "alternatives": renaming.alternatives,
            "hardware": renaming.hardware,
        }
        sections.append(TopState(section.name, numbers[id(local)], names, section.success, section.failure))
    return Hierarchy(composite.usage.mission.name, composite.graph.entry, tuple(sections), tuple(types))
