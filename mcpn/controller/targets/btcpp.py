"""The controller as one node of a behaviour tree: C++17 for BehaviorTree.CPP 4, around the controller in C99.

Beside the controller's header and source stand a header with the node, and an example of a tree. What holds
of the controller in C holds of the node: the tables are the same, the node only tells it events.
"""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.controller.modular import AnyController
from mcpn.controller.targets.c import written
from mcpn.controller.targets.names import c_string, comment, render
from mcpn.controller.targets.tables import MachineNumbers, RuleNumbers
from mcpn.drawing.compose import MissionNet
from mcpn.mission.model import Mission
from mcpn.nets.events import START, Event, What


def write_btcpp(controller: AnyController, mission_net: MissionNet) -> dict[str, str]:
    """The files by name: the controller's header and source, the node, an example.

    Args:
        controller: The controller.
        mission_net: The mission's net, for facts, hardware and parameters.
    """
    in_c, texts, _ = written(controller, mission_net)
    numbers, prefix = in_c.numbers, in_c.prefix
    told = _told(mission_net)
    number = {text: place for place, text in enumerate(numbers.events)}
    facts = [
        {
            "port": c_string(f"fact_{fact}"),
            "words": c_string(f"Its value: a change is an event; {' or '.join(sorted(values))} can be told"),
            "initial": c_string(mission_net.usage.world.facts[fact].start),
        }
        for fact, values in told.items()
    ]
    changes = [
        {
            "fact": place,
            "value": c_string(value),
            "event": number[str(Event(What.DECLARED, name))],
        }
        for place, values in enumerate(told.values())
        for value, name in values.items()
    ]
    none = len(numbers.events)
    services = [
        {
            "port": c_string(f"service_{name}"),
            "number": place,
            "lost": numbers.failures[place],
            "back": none if (back := numbers.repairs[place]) is None else back,
        }
        for place, name in enumerate(numbers.faulty)
        if place not in numbers.crashing
    ]
    said = {
        "p": prefix,
        "P": prefix.upper(),
        "mission": comment(controller.mission),
        "id": f"{prefix}_mission",
        "start": numbers.start,
        "start_name": str(START),
        "abort": numbers.abort is not None,
        "timers": numbers.timers,
        "services": services,
        "facts": facts,
        "changes": changes,
        "held": [(comment(name), list(held)) for name, held in _held(numbers, mission_net)],
    }
    return texts | {
        f"{prefix}_node.hpp": render("node.hpp.jinja", **said),
        f"{prefix}_tree.cpp": render("tree.cpp.jinja", **said),
    }


def _told(mission_net: MissionNet) -> dict[str, dict[str, str]]:
    """By fact that a port may tell, by value, the declared event that says nothing but that it has the value.

    Where several say so, the first in the order of the mission does.
    """
    changing = mission_net.usage.world.changing
    found: dict[str, dict[str, str]] = {}
    for event in mission_net.mission.events:
        if len(changes := changing.get(event.name, {})) == 1:
            ((fact, to),) = changes.items()
            if len(values := {*to.values()}) == 1:
                found.setdefault(fact, {}).setdefault(values.pop(), event.name)
    return found


def held(mission: Mission) -> dict[tuple[str, str], list[str]]:
    """By activity and alternative the hardware that the robot takes for it, and releases.

    Args:
        mission: The mission.
    """
    stands = {each.name for each in (*mission.faults, *mission.crashes)}
    hardware = {each.name for each in mission.hardware} - stands
    return {
        (activity.name, way.name): [name for name in way.consumes if name in hardware]
        for activity in mission.activities
        for way in activity.alternatives
    }


def _held(numbers: RuleNumbers | MachineNumbers, mission_net: MissionNet) -> Iterator[tuple[str, list[int]]]:
    """By alternative, in the order of their numbers, the numbers of the hardware that it takes."""
    place = {name: number for number, name in enumerate(numbers.hardware)}
    takes = {".".join(way): [place[k] for k in names] for way, names in held(mission_net.mission).items()}
    for name in numbers.alternatives:
        yield name, takes[name]
