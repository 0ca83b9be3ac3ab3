"""What every composed mission owes, whatever its engine: looked for in its whole markings graph."""

from __future__ import annotations

import numpy as np

from mcpn.check.verdicts.modes import Situation, situation
from mcpn.net.compose import MissionNet
from mcpn.net.templates.names import names_of
from mcpn.runtime.tables import Inside
from mcpn.space.markings.graph import Ints, StateGraph


def check_promises(found: MissionNet, graph: StateGraph) -> None:
    """Checks unit invariants in every marking, hardware and activities in stable ones, idleness at the ends.

    Args:
        found: The mission's net.
        graph: Its markings graph.
    """
    unit_invariants(found, graph)
    internal = np.array([t.internal for t in graph.net.transitions], np.bool_)
    stable = np.ones(graph.states, np.bool_)
    stable[graph.sources[internal[graph.labels]]] = False
    for hardware in found.mission.hardware:
        known = tokens(found, graph, hardware.name, "free", "busy", "OOS")
        assert (known[stable] == 1).all(), f"{hardware.name} is neither free nor busy nor out of service"
    for state in np.flatnonzero(stable).tolist():
        check_each_is_one_thing(found, situation(found, graph.marking(state)))
    ends = stable & (graph.marked(found.success) | graph.marked(found.failure))
    for state in np.flatnonzero(ends).tolist():
        assert found.not_idle(graph.marking(state)) == []


def check_each_is_one_thing(found: MissionNet, now: Situation | Inside) -> None:
    """Checks that each activity of an objective that runs does so, waits, or is refused: one of three."""
    activities = {section.name: section.activities for section in found.graph.walk()}
    for objective in now.objectives:
        for activity in activities[objective]:
            said = [activity in those for those in (now.mode, now.waiting, now.refused)]
            assert said.count(True) == 1, f"{activity} of {objective}: {now}"


def unit_invariants(found: MissionNet, graph: StateGraph) -> None:
    """Each unit holds one token: the interfaces of each resource, and what the resource itself is in."""
    states = ("available", "take", "answer", "release", "error")
    sharing = found.usage.sharing
    for hardware in found.mission.hardware:
        name = hardware.name
        assert (tokens(found, graph, name, "free", "busy", "OOS", "failing") == 1).all()
        out = tokens(found, graph, name, "OOS")
        for owner in sharing.owners(name):
            assert (tokens(found, graph, name, *states, owner=owner) + out == 1).all()
    for software in found.mission.software:
        name = software.name
        if found.usage.producer[name] not in found.usage.started:
            continue
        for owner in sharing.owners(name):
            assert (tokens(found, graph, name, *states, "waiting", "free", owner=owner) == 1).all()
            if sharing.serves(found.usage.producer[name]):
                assert (tokens(found, graph, name, "unused", "waiting", "busy", owner=owner) == 1).all()
            else:
                own = tokens(found, graph, name, "notAvailable", "waiting", "free", "busy")
                assert (own + tokens(found, graph, name, "error") <= 1).all()


def tokens(found: MissionNet, graph: StateGraph, name: str, *parts: str, owner: str | None = None) -> Ints:
    """By state, the tokens in some places of a resource, or of one owner's interface, those that it has."""
    index, names = found.net.place_index, names_of(found.usage)
    kind = "hardware" if name in found.usage.hardware else "software"
    called = [names.of(kind, name, part, *([owner] if owner else [])) for part in parts]
    places = [index[place] for place in called if place in index]
    return np.asarray(np.sum([graph.marked(p) for p in places], axis=0, dtype=np.int64), np.int64)
