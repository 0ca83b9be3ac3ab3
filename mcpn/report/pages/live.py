"""Data for the script of a page: the controller, words and weights of its events, boxes, cut sets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from mcpn.answers.causes.cutsets import CutSet
from mcpn.controller.simulator import likelihood
from mcpn.events import Event
from mcpn.nets.petri import Arcs, PetriNet
from mcpn.report.words import folded, what_happens
from mcpn.robot.runtime.tables import START

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes
    from mcpn.findings import Findings


MOST_EVENTS = 5_000
"""Events at most of the run without failures, which may be endless."""

MOST_TRANSITIONS = 400
"""Transitions of a net up to which a page has its token game."""

MOST_CHIPS = 14
"""Steps of a strip that are shown; of longer ones the middle is folded."""


def live_data(findings: Findings, keys: Mapping[str, int]) -> dict[str, Any]:
    """What the script needs.

    Args:
        findings: What was found of the mission.
        keys: By objective the key of its box.
    """
    found: dict[str, Any] = {"net": net} if (net := _net(findings.check.mission_net.net)) else {}
    if findings.causes is not None:
        found["losses"] = _losses(findings.causes)
    if findings.controller is None:
        return found
    document = dict(findings.controller)
    mission, weight = document["mission"], likelihood(findings.check.mission_net)
    events = {START, *document.get("changing", ()), *(e for s in document["sections"] for e in s["events"])}
    for hardware in document["hardware"]:
        events |= {f"{hardware}_EV_OOS", f"{hardware}_EV_RD"}
    typed = {text: Event.parse(text) for text in sorted(events)}
    document.pop("objectives")
    document.pop("activities")
    words = {
        text: [event.what.value, what_happens(event, mission), float(f"{weight(event):.4g}")]
        for text, event in typed.items()
    }
    return found | {"controller": document, "events": words, "boxes": dict(keys)}


def _net(net: PetriNet) -> dict[str, Any] | None:
    """The net as numbers, for the token game; ``None`` of a net that is too large to be played by hand."""
    if len(net.transitions) > MOST_TRANSITIONS:
        return None
    arcs = [
        [t.name, "" if t.event is None else str(t.event), rank, *map(_flat, (t.consume, t.produce, t.read))]
        for t, rank in zip(net.transitions, net.ranks, strict=True)
    ]
    return {
        "places": [place.name for place in net.places],
        "initial": list(net.initial),
        "transitions": arcs,
        "priorities": net.priorities,
    }


def _flat(arcs: Arcs) -> list[int]:
    return [number for arc in arcs for number in arc]


def _losses(causes: Causes) -> dict[str, Any]:
    """Minimal cut sets, from which the script computes what the loss of any set of hardware defeats."""
    mission_net = causes.mission_net
    shared: dict[tuple[CutSet, ...], list[str]] = {}
    for name, goal in causes.objectives.items():
        shared.setdefault(tuple(goal.cut_sets), []).append(name)
    return {
        "mission": causes.mission.cut_sets,
        "safety": None if causes.safety is None else causes.safety.cut_sets,
        "objectives": [
            [", ".join(folded(mission_net, names)), cut_sets]
            for cut_sets, names in shared.items()
            if cut_sets
        ],
    }
