"""The controller as one node of a behaviour tree: C++17 for BehaviorTree.CPP 4, around the controller in C99.

Beside the controller's header and source stand a header with the node, and an example of a tree. What holds
of the controller in C holds of the node: the tables are the same, the node only tells it events.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mcpn.events import START
from mcpn.robot.targets.c import written
from mcpn.robot.targets.identifiers import c_string, comment
from mcpn.robot.targets.render import render
from mcpn.robot.targets.type_numbers import MachineNumbers, RuleNumbers


def write_btcpp(document: Mapping[str, Any]) -> dict[str, str]:
    """The files by name: the controller's header and source, the node, an example.

    Args:
        document: The controller's.
    """
    in_c, texts, _ = written(document)
    numbers, prefix = in_c.numbers, in_c.prefix
    told = _told(document)
    number = {text: place for place, text in enumerate(numbers.events)}
    facts = [
        {
            "port": c_string(f"fact_{fact}"),
            "words": c_string(f"Its value: a change is an event; {' or '.join(sorted(values))} can be told"),
            "initial": c_string(next(value for value, flags in document["facts"][fact].items() if not flags)),
        }
        for fact, values in told.items()
    ]
    changes = [
        {
            "fact": place,
            "value": c_string(value),
            "event": number[text],
        }
        for place, values in enumerate(told.values())
        for value, text in values.items()
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
        "mission": comment(document["mission"]),
        "id": f"{prefix}_mission",
        "start": numbers.start,
        "start_name": str(START),
        "abort": numbers.abort is not None,
        "timers": numbers.timers,
        "services": services,
        "facts": facts,
        "changes": changes,
        "held": [(comment(name), list(held)) for name, held in _held(numbers, document)],
    }
    return texts | {
        f"{prefix}_node.hpp": render("node.hpp.jinja", **said),
        f"{prefix}_tree.cpp": render("tree.cpp.jinja", **said),
    }


def _told(document: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """By fact that a port may tell, by value, the declared event that says nothing but that it has the value.

    Where several say so, the first in the order of the mission does.
    """
    found: dict[str, dict[str, str]] = {}
    for event, changes in document["changing"].items():
        true, false = set(changes["true"]), set(changes["false"])
        for fact, values in document["facts"].items():
            if true | false == {flag for flags in values.values() for flag in flags}:
                for value, flags in values.items():
                    if set(flags) == true:
                        found.setdefault(fact, {}).setdefault(value, event)
    return found


def held(document: Mapping[str, Any]) -> dict[tuple[str, str], list[str]]:
    """By activity and alternative the hardware that the robot takes for it, and releases.

    Args:
        document: The controller's.
    """
    hardware = {*document["all_hardware"]}.difference(document["common_causes"], document["crashing"])
    return {
        (activity, way): [name for name in said["consumes"] if name in hardware]
        for activity, own in document["activities"].items()
        for way, said in own["alternatives"].items()
    }


def _held(
    numbers: RuleNumbers | MachineNumbers, document: Mapping[str, Any]
) -> Iterator[tuple[str, list[int]]]:
    """By alternative, in the order of their numbers, the numbers of the hardware that it takes."""
    place = {name: number for number, name in enumerate(numbers.hardware)}
    takes = {".".join(way): [place[k] for k in names] for way, names in held(document).items()}
    for name in numbers.alternatives:
        yield name, takes[name]
