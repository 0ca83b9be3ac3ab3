"""The controller as JSON, for programs that interpret it.

One object with the keys ``format`` (``mcpn-controller``), ``version`` (1), ``mission``, ``initial`` (number
of a state), ``events`` (sorted names), ``states``, ``edges``, ``objectives`` and ``activities``:

- a state: ``id``, ``objectives`` (running), ``pending`` (about to be entered), ``done`` (branches that have
  ended), ``mode`` (activity to alternative), ``waiting`` (activity to the alternative that waits for a
  resource), ``refused`` (activities with no possible alternative), ``out_of_service`` (hardware), ``outcome``
  (``success``, ``failure`` or null);
- an edge: ``from``, ``event``, ``to``, ``actions`` in order, each with ``do`` (``stop``, ``start``,
  ``select``), ``activity`` and, for ``select``, ``alternative``;
- ``objectives`` and ``activities`` carry the parameters for the control laws, untouched.

An event that a state has no edge for is ignored there.
"""

from __future__ import annotations

import json
from typing import Any

from mcpn.controller.hierarchy import Hierarchy
from mcpn.controller.machine import Action, Machine
from mcpn.mission.model import Parameter
from mcpn.net.compose import MissionNet

FILE_NAME = "controller.json"


def write_json(machine: Machine, mission_net: MissionNet) -> str:
    """The controller as a JSON text, the same for the same mission.

    Args:
        machine: The controller.
        mission_net: The mission's net, for the parameters.

    Returns:
        The text, ending in a newline.
    """
    document = {
        "format": "mcpn-controller",
        "version": 1,
        "mission": machine.mission,
        **_machine(machine),
        **_laws(mission_net),
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def write_hierarchical_json(hierarchy: Hierarchy, mission_net: MissionNet) -> str:
    """The controller in two levels as a JSON text, the same for the same mission.

    One object with the keys ``format`` (``mcpn-hierarchical-controller``), ``version`` (1), ``mission``,
    ``initial`` (the first section), ``sections`` (each with ``name``, ``type``, ``success``, ``failure`` and
    ``names``, from those of its type's machine to its own), ``types`` (machines with ``initial``, ``events``,
    ``states`` and ``edges`` as in the flat form), ``objectives`` and ``activities``. How it is run:
    :mod:`mcpn.controller.hierarchy`.

    Args:
        hierarchy: The controller.
        mission_net: The mission's net, for the parameters.

    Returns:
        The text, ending in a newline.
    """
    document = {
        "format": "mcpn-hierarchical-controller",
        "version": 1,
        "mission": hierarchy.mission,
        "initial": hierarchy.initial,
        "sections": [
            {"name": s.name, "type": s.type, "success": s.success, "failure": s.failure, "names": s.names}
            for s in hierarchy.sections
        ],
        "types": [_machine(machine) for machine in hierarchy.types],
        **_laws(mission_net),
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def _machine(machine: Machine) -> dict[str, Any]:
    return {
        "initial": machine.initial,
        "events": [str(event) for event in machine.events],
        "states": [
            {
                "id": number,
                "objectives": state.objectives,
                "pending": state.pending,
                "done": state.done,
                "mode": state.mode,
                "waiting": state.waiting,
                "refused": state.refused,
                "out_of_service": state.out_of_service,
                "outcome": state.outcome,
            }
            for number, state in enumerate(machine.states)
        ],
        "edges": [
            {
                "from": e.source,
                "event": str(e.event),
                "to": e.target,
                "actions": [_action(a) for a in e.actions],
            }
            for e in machine.edges
        ],
    }


def _laws(mission_net: MissionNet) -> dict[str, Any]:
    """What the control laws need to know of objectives and activities."""
    return {
        "objectives": {
            section.name: {
                "activities": section.activities,
                "parameters": _parameters(section.parameters),
            }
            for section in mission_net.graph.walk()
        },
        "activities": {
            activity.name: {
                "produces": activity.produces,
                "parameters": _parameters(activity.parameters),
                "alternatives": {
                    alternative.name: {
                        "consumes": alternative.consumes,
                        "parameters": _parameters(alternative.parameters),
                    }
                    for alternative in activity.alternatives
                },
            }
            for activity in mission_net.mission.activities
        },
    }


def _action(action: Action) -> dict[str, str]:
    described = {"do": action.verb, "activity": action.activity}
    if action.alternative is not None:
        described["alternative"] = action.alternative
    return described


def _parameters(parameters: tuple[Parameter, ...]) -> dict[str, Any]:
    return {p.name: {"value": p.value, "unit": p.unit} for p in parameters}
