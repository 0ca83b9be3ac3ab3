"""Data for the script of a page: the controller, words and weights of its events, boxes, cut sets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from mcpn.answers.causes.minimal_cut_sets import CutSet
from mcpn.controller.likelihood import likelihood
from mcpn.events import Event
from mcpn.report.pages.token_game import position, stored
from mcpn.report.words import folded, what_happens
from mcpn.robot.runtime.actions import START

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes
    from mcpn.findings import Findings


MOST_EVENTS = 5_000
"""Events at most of the run without failures, which may be endless."""

MOST_CHIPS = 14
"""Steps of a strip that are shown; of longer ones the middle is folded."""


def live_data(findings: Findings, keys: Mapping[str, int], *, asks: bool = False) -> dict[str, Any]:
    """What the script needs.

    Args:
        findings: What was found of the mission.
        keys: By objective the key of its box.
        asks: Whether the page has a server that it asks, and needs no graph of the net.
    """
    net = findings.check.mission_net.net
    game = {"first": position(net, net.initial)} if asks else stored(net)
    found: dict[str, Any] = {"net": game} if game else {}
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
