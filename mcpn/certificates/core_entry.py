"""The entry ``core.json`` of a certificate: the objectives graph of a mission, if corecheck can play it."""

from __future__ import annotations

from typing import Any

from mcpn.certificates.certcheck import VERSION
from mcpn.mission.expansion.routes import Interruption
from mcpn.mission.graph import TIMED_OUT, ElementarySection, ObjectivesGraph, ParallelSection, Section

OBJECTIVES = "objectives"
"""The key of what corecheck shows."""
PLAYED = "In the net the objectives run, end and follow each other as the mission says."


class Unplayed(Exception):
    """The mission has an element that corecheck does not play."""


def core_entry(graph: ObjectivesGraph) -> dict[str, Any]:
    """The objectives graph as the certificate holds it.

    Args:
        graph: That of the whole mission.

    Raises:
        Unplayed: It has an element that corecheck does not play.
    """
    return {"format": "mcpn-certificate", "version": VERSION, "graph": _graph(graph)}


def _graph(graph: ObjectivesGraph) -> dict[str, Any]:
    return {"entry": graph.entry, "sections": [_section(section) for section in graph.sections]}


def _section(section: Section) -> dict[str, Any]:
    if section.becomes:
        raise Unplayed(f"{section.name} is left as facts become so")
    entry: dict[str, Any] = {"name": section.name, "routes": {}, "handlers": []}
    for outcome, target in section.outcomes:
        by_facts = [case.target for case in section.cases_of(outcome)]
        entry["routes"]["timeout" if outcome == TIMED_OUT else outcome] = list(
            dict.fromkeys([target, *by_facts])
        )
    entry["handlers"] = [_handler(section, each) for each in section.interruptions]
    return entry if isinstance(section, ElementarySection) else entry | _block(section)


def _handler(section: Section, interruption: Interruption) -> dict[str, Any]:
    if interruption.pauses is not None:
        raise Unplayed(f"{section.name} pauses")
    return {
        "event": interruption.event,
        "once": interruption.once or "",
        "to": list(dict.fromkeys(interruption.routes)),
    }


def _block(section: ParallelSection) -> dict[str, Any]:
    if section.timed_out is not None:
        raise Unplayed(f"the block {section.name} has a timeout")
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
    }
