"""Puts runs into mission words, event by event; only reports do so, not the searches that find runs."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from mcpn.answers.verdicts.modes import Mode, Situation, said_by
from mcpn.events import Event, What
from mcpn.sentences import enumeration
from mcpn.spaces.run import Run

if TYPE_CHECKING:
    from mcpn.answers.verdicts.mission import MissionCheck
    from mcpn.drawing.compose import MissionNet
    from mcpn.robot.runtime.controller_tables import Inside


def in_words(mission_net: MissionNet, run: Run) -> Iterator[tuple[Event | str, str]]:
    """Each event of a run with what happens and what changes, up to the next event, for a reader.

    Where a run shows the internal firings after its last event, these follow by the names of the transitions.

    Args:
        mission_net: The mission's net.
        run: A run of this net.
    """
    net, roles = mission_net.net, mission_net.roles
    marked = {place for place in roles if net.initial[place]}
    begun: tuple[Event, Situation] | None = None
    shown = run.tail
    walked = run if run.settles and not shown else replace(run.of_events, settles=not run.detailed)
    for t, marking in walked.steps():
        event, (consume, produce, _) = net.event(t), net.arcs(t)
        if event is not None:
            settled = said_by(mission_net, sorted(marked))
            if begun is not None:
                yield begun[0], event_in_words(mission_net.mission.name, *begun, settled)
            begun = event, settled
        for place, _ in (*consume, *produce):
            if place in roles:
                (marked.add if marking[place] else marked.discard)(place)
    if begun is not None:
        last = begun[1] if run.detailed else said_by(mission_net, sorted(marked))
        yield begun[0], event_in_words(mission_net.mission.name, *begun, last)
    yield from ((name, f"internal: {name}") for name in shown)


def event_in_words(mission: str, event: Event, before: Situation, after: Situation) -> str:
    """An event of a mission, given by name, with what it changes in what the robot does."""
    happens, changed = what_happens(event, mission), changes(before, after)
    return f"{happens}: {', '.join(changed)}" if changed else happens


def what_happens(event: Event, mission: str) -> str:
    """An event of a mission, given by name, for a reader: for example "GPS_sensor fails"."""
    name = event.element
    match event.what:
        case What.START:
            return f"mission {mission} starts"
        case What.EARLIER:
            said = name.replace("=", " is ")
            return f"{said} before" if said != name else f"the handler {name} has happened before"
        case What.SUCCESS:
            return f"objective {name} succeeds"
        case What.FAILURE:
            return f"objective {name} fails{f' for {event.reason}' * bool(event.reason)}"
        case What.TIMEOUT:
            return f"the time of {name} is over"
        case What.OUT_OF_SERVICE:
            return f"{name} fails"
        case What.DETECTED:
            return f"the loss of {name} is noticed"
        case What.LOST:
            return f"{name} is lost for good"
        case What.REPAIRED:
            return f"{name} works again"
        case What.DECLARED:
            return f"event {name} happens"


_WRONG = (What.FAILURE, What.TIMEOUT, What.OUT_OF_SERVICE, What.LOST, What.DECLARED)


def wrong_in_words(mission_net: MissionNet, run: Run) -> str:
    """What fails, is over or interrupts on a run; empty where nothing does."""
    wrong = (event for event in run.events if event.what in _WRONG)
    said = dict.fromkeys(what_happens(event, mission_net.mission.name) for event in wrong)
    return f"on this run {enumeration([*said])}" if said else ""


def changes(before: Situation, after: Situation) -> list[str]:
    """What changes from one stable marking to the next, in mission words."""
    phrases = [f"{name} begins" for name in after.objectives if name not in before.objectives]
    for activity, alternative in after.mode.items():
        was = before.mode.get(activity)
        if was is not None and was != alternative:
            phrases.append(f"{activity} changes from {was} to {alternative}")
        elif was is None and alternative != activity:
            phrases.append(f"{activity} runs as {alternative}")
    phrases += [f"{name} has no way to run" for name in after.refused if name not in before.refused]
    phrases += [f"{name} waits" for name in after.waiting if name not in before.waiting]
    phrases += [
        f"{fact} is {value}" for fact, value in after.facts.items() if before.facts.get(fact, value) != value
    ]
    if after.outcome and not before.outcome:
        phrases.append(f"the mission ends in {after.outcome}")
    return phrases


def situation_in_words(now: Situation | Inside) -> str:
    """What the robot does, for a reader: what runs and how, what waits, what is refused, what is lost."""
    phrases = [f"{name} runs" for name in now.objectives]
    phrases += [f"{name} is about to begin" for name in now.pending]
    phrases += [f"{name} has ended" for name in now.done]
    phrases += [f"{a} runs" + (f" as {way}" if way != a else "") for a, way in now.mode.items()]
    phrases += [f"{name} waits" for name in now.waiting]
    phrases += [f"{name} has no way to run" for name in now.refused]
    if isinstance(now, Situation):
        phrases += [f"{name} is out of service" for name in now.out_of_service]
        phrases += [f"{fact} is {value}" for fact, value in now.facts.items()]
        phrases += [f"the mission has ended in {now.outcome}"] if now.outcome else []
    return ", ".join(phrases) or "nothing runs"


MOST_NAMED = 12
"""Objectives that are named of those with the same modes: a mission of 300 sections has as many in each."""


def modes_together(check: MissionCheck) -> dict[tuple[str, ...], list[str]]:
    """By functioning modes in words the objectives that have these, each group folded."""
    said: dict[int, tuple[str, ...]] = {}  # objectives of sections of one type have one list of modes
    shared: dict[tuple[str, ...], list[str]] = {}
    for objective, modes in check.modes.items():
        if id(modes) not in said:
            said[id(modes)] = modes_in_words(modes)
        shared.setdefault(said[id(modes)], []).append(objective)
    return {ways: folded(check.mission_net, names) for ways, names in shared.items()}


def folded(mission_net: MissionNet, objectives: Collection[str]) -> list[str]:
    """Objectives by name; where all rounds and tries of one are among them they are said together."""
    every = (objective.name for objective in mission_net.graph.walk())
    return mission_net.graph.copies.told(objectives, every)


def of_all_copies(mission_net: MissionNet, text: str) -> str:
    """What is said of an objective, in the words that hold of its other rounds and tries as well.

    Args:
        mission_net: The mission's net.
        text: What is said, which names blocks.
    """
    copies = mission_net.graph.copies

    def plain(found: re.Match[str]) -> str:
        return copies.plain(found[0]) if found[0] in copies.held else found[0]

    return re.sub(r"\w++(?:\.\w++)*+", plain, text)


def modes_in_words(modes: Iterable[Mode]) -> tuple[str, ...]:
    """Functioning modes as a person distinguishes them, in their order.

    Alternatives named like their activity go unsaid; what then reads the same is said once.
    """
    said = (", ".join(f"{a}: {way}" for a, way in mode.items() if a != way) for mode in modes)
    return tuple(dict.fromkeys(said))


def skipped_in_words(names: Sequence[str]) -> str:
    """That some objectives begin on a run and never succeed on it.

    >>> skipped_in_words(["take_picture", "measure"])
    '2 objectives never succeed on this run: take_picture, measure'
    """
    verb = "objectives never succeed" if len(names) > 1 else "objective never succeeds"
    return f"{len(names)} {verb} on this run: {', '.join(names)}"
