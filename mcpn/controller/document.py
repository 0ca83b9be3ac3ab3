"""The controller's document: all that a target or an interpreter needs (:mod:`mcpn.robot.runtime` is one).

One object with these keys, all of them always, whether there is something to say or not:

- ``format``: ``mcpn-controller``; ``version``: 1; ``mission``; ``form``: ``flat``, ``hierarchical`` or
  ``modular``;
  ``unverified``: true, where nobody asked whether the mission keeps what is required;
  ``minimised``: true where states that cannot be told apart have been merged;
- ``hardware``: the hardware that can fail; ``initial``: the section entered at the mission's start;
- ``sections``: each with ``name``, ``type`` (index in ``types``), ``routes`` (outcome, ``success``,
  ``failure``, ``failure R`` for a reason ``R`` for which it may fail, ``abort`` where a branch of it may
  abort, ``timed out`` where its time may be over, ``when 1`` for the first condition on facts by which it is
  left, or ``on E`` for an event ``E`` that interrupts the section,
  ``on E 2`` for its second handler of it, to the section entered next, or ``succeed``, ``fail`` or
  ``abort``), ``events`` (its own text of each event of the type) and ``names`` (by kind, from names in the
  type to its own; a name that is missing stays);
- ``types``: machines, each with ``hardware``, ``once`` (handlers of the type that happen once, by where they
  are written: ``go_home.leak``), ``facts`` (what may be true of its facts), ``entering`` (how many of these,
  the first ones, have bits in the numbers of entries, behind those of the hardware), ``events``, ``states``,
  ``entries`` and ``edges``:

  - a state: ``objectives`` (running), ``pending`` (about to be entered), ``done`` (branches that have ended),
    ``mode`` (activity to alternative), ``waiting`` (activity to the alternative that waits for a resource),
    ``refused`` (activities with no possible alternative), ``out_of_service`` (the section's hardware);
  - an entry: ``to``, ``actions``, ``gained`` and ``lost`` (of ``facts``), one for each number whose bit *i*
    says that ``hardware[i]`` is out of service, or null;
  - an edge: ``from``, ``event`` (an index), ``to`` (a state, or the outcome with which the section is left),
    ``open`` (handlers of ``once`` that must not have happened yet), ``happened`` (those that must have),
    ``gained`` and ``lost``, and ``actions`` in order, each with ``do`` (``disarm``, ``stop``, ``release``,
    ``select``, ``start``, ``arm``) and ``activity``, ``alternative``, ``hardware`` or ``objective`` as it has
    them;
- ``types`` of the modular form: rules, each with ``hardware``, ``once``, ``facts``, ``events`` as above, and
  on a state of ``bits`` bits (a literal 2 *i* asks that bit *i* is not set, 2 *i* + 1 that it is):

  - ``idle``: the bits that are set before the entry; ``status``: for each of ``hardware``, then of ``once``
    and of ``facts``, ``changes``, the bits that change then if it is out of service, has happened or is true,
    and ``when``, the literal that says so inside;
  - ``shown``: what is so (``kind``: a key of a state above; ``name``, in modes ``activity.alternative``)
    where the literal ``when`` is true;
  - ``effects``: ``changes``, ``actions``, ``to``, the outcome with which the section is left, or null, and
    ``then``, the ``parts`` (indices) with which the event goes on, in order;
  - ``entries`` and ``rules``: where the literals ``if`` are true, ``do`` an effect (an index); the latter on
    an ``event`` (an index); those of one event that fit a state do the same;
  - ``parts``: lists of rules. Of each the first that fits is taken, and nothing is done where none fits;
    their effects have no ``then``. Literals of bits from ``bits`` on, *bits* + *i*, ask what bit *i* is after
    the effects so far, all others what it was before the event;
- ``facts``: by name and value what is then true of it that was not at the start, as texts; ``changing``: by
  event what it makes ``true`` and ``false``;
- ``out_of_service``: hardware that is so at the start; ``unrepairable``: hardware that is never repaired;
  ``crashing``: those of ``hardware`` that stand for activities or alternatives that may crash: ``X_EV_OOS``
  of these can be taken only by an edge or a rule;
- ``late``: by hardware that is detected late the text that is true while it is out of service and the robot
  knows it. It is one of the ``facts`` of types, though of no fact;
- ``size``: how large it is, in words; ``all_hardware``: what cannot fail too; ``common_causes``: those that
  stand for a cause by which several resources fail, and are nothing that the robot has; ``started``:
  activities that some objective starts, itself or through resources; ``timers``: how many timers run at a
  time, at most;
- ``objectives`` and ``activities`` carry the parameters for the control laws, untouched; ``timeout`` of an
  objective is when it ends by its time, in seconds, or null;
- ``blocks``, where some have a time of their own: its ``timeout``, and the ``objectives`` in it: it runs
  while one of these is among the ``objectives`` or the ``pending`` of the state;
- ``requirements``: what the mission must satisfy, each with ``name``, ``formula``,
  ``sentence`` and ``description`` (or null), ``expected`` and ``severity``; nothing runs by them;
- ``digest``: SHA-256, in hexadecimal digits, of the object without it as JSON in UTF-8 with sorted keys, no
  spaces, and no escapes but those that JSON demands. A file with another digest has been changed since.

How it is run. Keep the set of hardware out of service, at first that of ``out_of_service``: ``X_EV_OOS`` adds
``X``, ``X_EV_RD``, of what is not ``unrepairable``, takes it away, before the start, in every section and
after the end alike. Of what is detected ``late`` ``X_EV_RD`` can be taken only while its text is true, and
ends that. ``MISSION_EV_START`` enters the initial section. A section is entered by the entry of the hardware
out of service. An edge whose ``to`` is an outcome leaves the section: its actions are given first, then the
next section is entered with the actions of its entry. An event that a state has no edge for, hardware of
other sections aside, cannot be taken there. Keep the set of the handlers that have happened, too: an edge can
be taken where its ``open`` have not happened and its ``happened`` have, and then adds its ``open`` to the
set; at most one edge of a state and an event can. In the modular form a section is entered in the state
``idle``, changed by ``status`` as hardware and handlers are, by an entry that fits; an event takes a rule of
it that fits, and what the state then says of ``once`` has happened. Keep what is true of facts: at first the
texts of what is ``late`` and ``out_of_service``; an entry or edge adds its ``gained`` and takes its ``lost``
away, after a rule the state says it; an event of ``changing`` that the section has not may be taken at any
time where it changes something. An action ``arm`` starts the timer of an objective, ``disarm`` ends it; when
it has run for the objective's ``timeout``, give the event ``OBJ_x_EV_TIMEOUT``. Blocks are named as
objectives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mcpn.answers.verdicts.modes import Situation
from mcpn.controller.hierarchy import SectionMachine
from mcpn.controller.machine import PlannedAction
from mcpn.controller.modular import AnyController, Rules
from mcpn.controller.moves import Move, Moves
from mcpn.drawing.compose import MissionNet
from mcpn.events import Event, What
from mcpn.mission.core.objectives_graph import ElementarySection, ObjectivesGraph
from mcpn.mission.fact_conditions import flags, noticed
from mcpn.mission.fact_usage import FactUsage
from mcpn.mission.robot import Parameter
from mcpn.robot.runtime.documents import FORMAT, VERSION
from mcpn.robot.runtime.file_schema import digest_of
from mcpn.robot.targets.json import canonical
from mcpn.robot.targets.rows import Rows
from mcpn.spaces.memoized import ByKey


def document(controller: AnyController, mission_net: MissionNet, *, verified: bool = True) -> dict[str, Any]:
    """The controller as a JSON object, as :func:`document_in_rows` gives it, but with nothing but lists."""
    found = document_in_rows(controller, mission_net, verified=verified)
    for type_ in found["types"]:
        type_ |= {key: list(value) for key, value in type_.items() if isinstance(value, Rows)}
    return found


def document_in_rows(
    controller: AnyController, mission_net: MissionNet, *, verified: bool = True
) -> dict[str, Any]:
    """The controller as a JSON object, with its edges as rows, which targets read and ``json`` does not.

    Args:
        controller: The controller.
        mission_net: The mission's net.
        verified: Whether all that is required of the mission holds; else the object says that nobody asked.
    """
    found = {
        "format": FORMAT,
        "version": VERSION,
        "mission": controller.mission,
        "form": controller.form,
        "minimised": controller.minimised,
        "hardware": list(controller.hardware),
        "size": controller.size,
        **_hardware(mission_net),
        "started": list(mission_net.usage.started),
        "timers": _timers(mission_net.graph),
        "initial": controller.initial,
        "sections": [
            {
                "name": section.name,
                "type": section.type,
                "routes": dict(section.routes),
                "events": [str(event) for event in section.events],
                "names": {
                    kind: changed
                    for kind, names in section.names.items()
                    if (changed := {old: new for old, new in names.items() if old != new})
                },
            }
            for section in controller.sections
        ],
        "types": [_type(type_) for type_ in controller.types],
        **_laws(mission_net),
        **_world(mission_net.usage.world),
        "requirements": _requirements(mission_net),
    }
    if not verified:
        found["unverified"] = True
    return found | {"digest": digest_of(found, canonical)}


def _hardware(mission_net: MissionNet) -> dict[str, Any]:
    """All hardware, and what of it stands for something else, is out at the start, or is never repaired."""
    hardware = mission_net.core.hardware
    return {
        "all_hardware": [h.name for h in hardware],
        "common_causes": [fault.name for fault in mission_net.core.common_causes],
        "out_of_service": [h.name for h in hardware if h.initial == "oos"],
        "unrepairable": [h.name for h in hardware if not h.repairable],
        "crashing": [crash.name for crash in mission_net.core.crashes],
        "late": {h.name: noticed(h.name) for h in mission_net.core.late},
    }


def _world(world: FactUsage) -> dict[str, Any]:
    """What is true of facts by their values, and what events change beside a section."""
    changing = {
        str(Event(What.DECLARED, event)): {"true": sorted(true), "false": sorted(false)}
        for event, (true, false) in world.turning.items()
    }
    facts = {
        name: {value: sorted(said) for value, said in flags(fact).items()}
        for name, fact in world.facts.items()
    }
    return {"facts": facts, "changing": changing}


def _requirements(mission_net: MissionNet) -> list[dict[str, Any]]:
    if not mission_net.usage.graph.requirements:
        return []
    from mcpn.answers.requirements import asked_of  # which loads temporal logic

    return [asked.said for asked in asked_of(mission_net)]


def _type(type_: SectionMachine | Rules) -> dict[str, Any]:
    return _rules(type_) if isinstance(type_, Rules) else _machine(type_)


def _rules(rules: Rules) -> dict[str, Any]:
    return {
        "hardware": list(rules.hardware),
        "once": list(rules.once),
        "facts": list(rules.facts),
        "events": [str(event) for event in rules.events],
        "bits": rules.bits,
        "idle": list(rules.idle),
        "status": [{"changes": list(s.changes), "when": s.literal} for s in rules.status],
        "shown": [{"kind": s.kind, "name": s.name, "when": s.literal} for s in rules.shown],
        "effects": [
            {
                "changes": list(effect.changes),
                "actions": [_action(a) for a in effect.actions],
                "to": effect.to,
                "then": list(effect.then),
            }
            for effect in rules.effects
        ],
        "entries": [{"if": list(rule.literals), "do": rule.effect} for rule in rules.entries],
        "rules": [
            {"event": rule.event, "if": list(rule.literals), "do": rule.effect} for rule in rules.rules
        ],
        "parts": [[{"if": list(rule.literals), "do": rule.effect} for rule in part] for part in rules.parts],
    }


def _machine(machine: SectionMachine) -> dict[str, Any]:
    return {
        "hardware": list(machine.hardware),
        "once": list(machine.once),
        "facts": list(machine.facts),
        "entering": machine.entering,
        "events": [str(event) for event in machine.events],
        "states": [_state(state) for state in machine.states],
        "entries": [
            entry
            and {
                "to": entry.target,
                "actions": [_action(a) for a in entry.actions],
                "gained": list(entry.gained),
                "lost": list(entry.lost),
            }
            for entry in machine.entries
        ],
        "edges": _edges(machine.moves),
    }


def _edges(moves: Sequence[Move]) -> Rows:
    moves = moves if isinstance(moves, Moves) else Moves.of(moves)
    columns = {"from": moves.sources.tolist(), "event": moves.events.tolist(), "to": moves.targets}
    actions = ByKey[tuple[PlannedAction, ...], list[dict[str, str]]](lambda told: [_action(a) for a in told])
    shared = [
        {
            "actions": actions[ordered],
            "open": list(guard.open),
            "happened": list(guard.happened),
            "gained": list(gained),
            "lost": list(lost),
        }
        for ordered, guard, gained, lost in moves.done
    ]
    keys = ("from", "event", "to", "actions", "open", "happened", "gained", "lost")
    return Rows(keys, columns, moves.kinds.tolist(), shared)


def _state(state: Situation) -> dict[str, Any]:
    return {
        "objectives": list(state.objectives),
        "pending": list(state.pending),
        "done": list(state.done),
        "mode": state.mode,
        "waiting": state.waiting,
        "refused": list(state.refused),
        "out_of_service": list(state.out_of_service),
    }


def _action(action: PlannedAction) -> dict[str, str]:
    parts = (
        ("do", action.verb),
        ("activity", action.activity),
        ("alternative", action.alternative),
        ("hardware", action.hardware),
        ("objective", action.objective),
    )
    return {key: value for key, value in parts if value is not None}


def _laws(mission_net: MissionNet) -> dict[str, Any]:
    """What the control laws need to know of objectives and activities, and timers of blocks."""
    blocks = {
        block.name: {"timeout": block.timeout, "objectives": list(block.held)}
        for block in mission_net.graph.timed_blocks()
    }
    return {
        "objectives": {
            section.name: {
                "activities": list(section.activities),
                "parameters": _parameters(section.parameters),
                "timeout": section.timeout,
            }
            for section in mission_net.graph.walk()
        },
        "activities": {
            activity.name: {
                "produces": list(activity.produces),
                "parameters": _parameters(activity.parameters),
                "alternatives": {
                    alternative.name: {
                        "consumes": list(alternative.consumes),
                        "parameters": _parameters(alternative.parameters),
                    }
                    for alternative in activity.alternatives
                },
            }
            for activity in mission_net.core.activities
        },
        **({"blocks": blocks} if blocks else {}),
    }


def _parameters(parameters: tuple[Parameter, ...]) -> dict[str, Any]:
    return {p.name: {"value": p.value, "unit": p.unit} for p in parameters}


def _timers(graph: ObjectivesGraph) -> int:
    """How many objectives and blocks of a graph that have a timeout run at a time, at most."""
    most = 0
    for section in graph.sections:
        own = int(section.timeout is not None)
        if isinstance(section, ElementarySection):
            most = max(most, own)
        else:
            most = max(most, own + sum(_timers(branch.graph) for branch in section.branches))
            most = max(most, *(_timers(pause_graph.graph) for pause_graph in section.pause_graphs), 0)
    return most
