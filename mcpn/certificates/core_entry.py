"""The entry ``core.json`` of a certificate: a mission's objectives graph and robot, without its net."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from mcpn.certificates.certcheck import VERSION
from mcpn.drawing.compose import MissionNet
from mcpn.mission.core.objectives_graph import ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.core.routes import Interruption
from mcpn.mission.fact_cases import FactCase
from mcpn.mission.fact_conditions import Condition
from mcpn.mission.model import TIMED_OUT
from mcpn.mission.robot import Activity, Crash, Hardware
from mcpn.mission.static.resource_use import Usage

Entry = dict[str, Any]


def core_entry(mission_net: MissionNet) -> Entry:
    """The core mission of a net as the certificate holds it.

    Args:
        mission_net: The net of a whole mission.
    """
    graph, robot = _graph(mission_net.graph), _robot(mission_net.usage)
    return {"format": "mcpn-certificate", "version": VERSION, "graph": graph, "robot": robot}


def _graph(graph: ObjectivesGraph) -> Entry:
    return {"entry": graph.entry, "sections": [_section(section) for section in graph.sections]}


def _section(section: Section) -> Entry:
    left = {outcome for outcome, _ in section.becoming}
    routes = {
        "timeout" if outcome == TIMED_OUT else outcome: _cases(section.cases_of(outcome), target)
        for outcome, target in section.outcomes
        if outcome not in left
    }
    entry = {
        "name": section.name,
        "routes": routes,
        "handlers": [_handler(each) for each in section.interruptions],
        "left": [
            {"when": _pairs(each.when), "to": _cases(section.cases_of(outcome), each.target)}
            for outcome, each in section.becoming
        ],
    }
    return entry | (_objective(section) if isinstance(section, ElementarySection) else _block(section))


def _pairs(when: Condition) -> list[list[str]]:
    return [[fact, value] for fact, value in when]


def _cases(cases: Iterable[FactCase], otherwise: str) -> list[Entry]:
    """Where something leads by facts: the first case counts whose facts are so."""
    return [{"when": _pairs(case.when), "to": case.target} for case in (*cases, FactCase((), otherwise))]


def _handler(handler: Interruption) -> Entry:
    pauses = 0 if handler.pauses is None else handler.pauses + 1
    to = [] if pauses else _cases(handler.cases, handler.target)
    return {"event": handler.event, "once": handler.once or "", "to": to, "pauses": pauses}


def _objective(section: ElementarySection) -> Entry:
    sets = [[setting.fact, setting.value, setting.on] for setting in section.sets]
    return {"activities": list(section.activities), "sets": sets}


def _block(section: ParallelSection) -> Entry:
    needed = len(section.branches) + 1 if section.needed is None else section.needed
    failing = len(section.branches) + 1 if section.failing is None else section.failing
    return {
        "needed": needed,
        "failing": failing,
        "hasty": section.hasty,
        "branches": [
            {"name": branch.name, "mandatory": branch.mandatory, "graph": _graph(branch.graph)}
            for branch in section.branches
        ],
        "pauses": [
            {"graph": _graph(pause.graph), "handlers": [_handler(each) for each in pause.interruptions]}
            for pause in section.pause_graphs
        ],
    }


def _robot(usage: Usage) -> Entry:
    mission, started = usage.core, [usage.activities[name] for name in usage.started]
    return {
        "hardware": [_hardware(each) for each in mission.hardware],
        "software": [{"name": each.name, "exclusive": each.exclusive} for each in mission.software],
        "facts": [{"name": name, "initial": fact.start} for name, fact in usage.world.facts.items()],
        "events": [_event(name, changes) for name, changes in usage.world.changing.items()],
        "activities": [_activity(each, usage) for each in started],
    }


def _event(name: str, changes: Mapping[str, Mapping[str, str]]) -> Entry:
    """By value of each fact that an event changes the one that it has then."""
    each = [[fact, was, to] for fact, after in changes.items() for was, to in after.items() if was != to]
    return {"name": name, "changes": each}


def _hardware(hardware: Hardware) -> Entry:
    return {
        "name": hardware.name,
        "faulty": hardware.faulty,
        "shared": hardware.shared,
        "repairable": hardware.repairable,
        "out": hardware.initial == "oos",
        "late": hardware.detected == "late",
        "crash": isinstance(hardware, Crash),
    }


def _activity(activity: Activity, usage: Usage) -> Entry:
    return {
        "name": activity.name,
        "produces": list(activity.produces),
        "switch_back": activity.switch_back,
        "detects": list(activity.detects),
        "alternatives": [
            {
                "name": way.name,
                "consumes": list(way.consumes),
                "requires": _pairs(usage.world.requires(activity.name, number)),
            }
            for number, way in enumerate(activity.alternatives)
        ],
    }
