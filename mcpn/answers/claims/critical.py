"""Claims on the events that take the last way to a goal of a mission, without repairs and with them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mcpn.answers.claims.claim import Assumes, Claim
from mcpn.answers.claims.made import some_run
from mcpn.answers.claims.of_check import plain_names
from mcpn.answers.kinds.by_name import KINDS
from mcpn.events import ENDING, Event, What

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes, GoalCauses
    from mcpn.drawing.compose import MissionNet

WORDS = {
    What.OUT_OF_SERVICE: "loss",
    What.DETECTED: "detected loss",
    What.SUCCESS: "success",
    What.FAILURE: "failure",
    What.TIMEOUT: "timeout",
    What.START: "start",
}
"""What an event is to its element; an event that is declared has a name of its own."""
BY_ITSELF = Assumes(repairs="none")


def claims_of_critical(
    causes: Causes, goal: GoalCauses, verb: str, words: str, certain: bool
) -> Iterator[Claim]:
    """The claims on critical events, those of all copies of an objective as one.

    Args:
        causes: Of a mission.
        goal: Its success, or a safe end.
        verb: What losses of it do: ``defeat``, ``endanger``.
        words: The goal in words of formulas.
        certain: Whether these words say it.
    """
    prospects = causes.prospects
    repairs = [f"{name}_EV_RD" for name in prospects.hardware if prospects.carrying(What.REPAIRED, name)]
    hopeful, during = some_run(repairs, words), dict[Event, dict[str, None]]()
    for found in goal.critical:
        event = plain_event(causes.mission_net, found.event)
        running = plain_names(causes.mission_net, found.objectives) or [""]
        # An objective ends while it runs: no more need be said.
        own = event.what in ENDING and event.element in running
        during.setdefault(event, {}).update(dict.fromkeys([] if own else running))
    for event, names in during.items():
        kind, subject = named(event, f"{{}}_may_{verb}")
        template = KINDS[kind].formula
        asked = [_running(name, causes) for name in names] or ["true"]
        formulas = (template.format(hopeful=hopeful, during=each, event=event) for each in asked)
        formula = " & ".join(formulas) if certain else ""
        yield Claim(kind, subject, True, BY_ITSELF, formula, during=tuple(names))
    deciding = (plain_event(causes.mission_net, found.event) for found in goal.critical_with_repairs)
    for event in dict.fromkeys(deciding):
        kind, subject = named(event, "{}_decides" if verb == "defeat" else "{}_endangers")
        formula = KINDS[kind].formula.format(*subject, event=event) if certain else ""
        yield Claim(kind, subject, True, formula=formula)


def plain_event(mission_net: MissionNet, event: Event) -> Event:
    """An event of an objective as that of all its copies."""
    if event.what not in ENDING:
        return event
    return event.of(mission_net.graph.copies.plain(event.element))


def named(event: Event, kind: str) -> tuple[str, tuple[str, ...]]:
    """The kind of claim on an event, and its subject."""
    if event.what is What.DECLARED:
        return kind.format("event"), (event.element,)
    word = WORDS[event.what] + f" for {event.reason}" * bool(event.reason)
    return kind.format("end"), (event.element or "the mission", word)


def _running(name: str, causes: Causes) -> str:
    """That an objective runs; of none, that the mission has not begun."""
    if name:
        return f"objective({name})"
    every = plain_names(causes.mission_net, causes.prospects.sections)
    return f"!({' | '.join(f'objective({each})' for each in every)})"
