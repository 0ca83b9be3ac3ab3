"""A mission while it is played, as plain lines in a pipe of 80 columns, and each change as JSON."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import Any

from mcpn.answers.verdicts.modes import Situation
from mcpn.controller.machine import VERBS, PlannedAction
from mcpn.controller.simulator import Change, Simulation, resources
from mcpn.drawing.compose import MissionNet
from mcpn.events import Event
from mcpn.report.terminal import Terminal
from mcpn.report.words import event_in_words, what_happens

WIDTH = 80
"""Characters in a line, where neither terminal nor command line says another width."""
INDENT = 12


def _width() -> int:
    return Terminal().width or WIDTH


def state_lines(simulation: Simulation) -> Iterator[str]:
    """Objectives, mode, resources and the possible events by number."""
    now = simulation.situation
    if now.outcome:
        yield f"the mission has ended in {now.outcome}"
    elif not now.objectives:
        yield "the mission has not begun"
    for head, items in _facts(simulation, now):
        if items:
            yield from _wrapped(head, ("; " if head == "resources" else ", ").join(items))
    if not simulation.possible:
        yield "no event is possible"
    mission = simulation.mission_net.mission.name
    for number, event in enumerate(simulation.possible, 1):
        yield from _event_line(number, event, mission)


def _event_line(number: int, event: Event, mission: str) -> list[str]:
    """What may happen, in words, its identifier beside it: below it where they have no room in one line."""
    words = f"{number:4}  {what_happens(event, mission)}  [{event}]"
    return textwrap.wrap(
        words, _width(), subsequent_indent=" " * 6, break_long_words=False, break_on_hyphens=False
    )


def _facts(simulation: Simulation, now: Situation) -> Iterator[tuple[str, list[str]]]:
    yield "objectives", list(now.objectives)
    yield "pending", list(now.pending)
    yield "done", list(now.done)
    yield "mode", [a if a == way else f"{a} as {way}" for a, way in now.mode.items()]
    yield "waiting", [a if a == way else f"{a} for {way}" for a, way in now.waiting.items()]
    yield "no way for", list(now.refused)
    yield "resources", [f"{name} {how}" for name, how in resources(simulation.mission_net, now)]


def change_lines(change: Change, mission_net: MissionNet) -> Iterator[str]:
    """What an event changed, in words, and what the controller orders."""
    words = event_in_words(mission_net.mission.name, change.event, change.before, change.after)
    refused = {*change.after.refused} - {*change.before.refused}
    failing = [
        section.name
        for section in mission_net.graph.walk()
        if section.name in change.after.objectives and not refused.isdisjoint(section.activities)
    ]
    if failing:
        words = f"{words}; {', '.join(failing)} cannot succeed now"
    yield from textwrap.wrap(words, _width(), subsequent_indent="  ", break_on_hyphens=False)
    for verb in VERBS:
        items = [_item(action) for action in change.actions if action.verb == verb]
        if items:
            yield from _wrapped(f"  {verb}", ", ".join(items))


def _item(action: PlannedAction) -> str:
    subject = action.activity or action.hardware or action.objective or ""
    return subject if action.alternative in (None, subject) else f"{subject} as {action.alternative}"


def _wrapped(head: str, text: str) -> list[str]:
    return textwrap.wrap(
        f"{head:{INDENT}}{text}",
        _width(),
        subsequent_indent=" " * INDENT,
        break_long_words=False,
        break_on_hyphens=False,
    )


def change_object(change: Change, mission: str) -> dict[str, Any]:
    """What an event changed, as a JSON object."""
    after = change.after
    return {
        "event": str(change.event),
        "words": event_in_words(mission, change.event, change.before, after),
        "actions": [
            {
                key: value
                for key, value in (
                    ("do", a.verb),
                    ("activity", a.activity),
                    ("alternative", a.alternative),
                    ("hardware", a.hardware),
                    ("objective", a.objective),
                )
                if value is not None
            }
            for a in change.actions
        ],
        "objectives": list(after.objectives),
        "mode": after.mode,
        "out_of_service": list(after.out_of_service),
        "outcome": after.outcome,
    }
