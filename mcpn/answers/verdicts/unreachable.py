"""What never happens: objectives that never run, alternatives never selected, events that change nothing.

An event that no block around what runs handles changes nothing, and in formulas it does not happen there. So
"after a leak the robot comes up" is met by a mission that handles no leak. It is **answered** already while
what a handler of it leads to runs, in whichever copy and however that was entered: a robot that is on its way
home is not called home. In all other states in which nothing handles it, it is **ignored**.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterator, Mapping, Sequence
from functools import cache
from typing import NamedTuple

from mcpn.answers.verdicts.as_written import led_to_by_events
from mcpn.answers.verdicts.routing import Routing
from mcpn.drawing.compose import MissionNet
from mcpn.errors import Problem
from mcpn.events import Event, What
from mcpn.mission.core.copies import Copies, Written
from mcpn.mission.static.resource_use import Usage
from mcpn.mission.static.warnings import (
    in_order,
    never_entered,
    never_used,
    of_objectives,
)
from mcpn.spaces.algebra import Piece, S, Space


def objectives_run(mission_net: MissionNet, space: Space[S], states: S) -> set[str]:
    """Objectives that run in some of these states.

    Args:
        mission_net: The mission's net.
        space: Its stable states, or its markings.
        states: Those that are asked.
    """
    return _names(mission_net, space, _alike(mission_net, space, states))


def selected_and_entered(mission_net: MissionNet, space: Space[S]) -> tuple[set[str], set[str]]:
    """Alternatives and objectives that run in some stable state."""
    active, selected = mission_net.saying("active"), set[str]()
    pieces = list(_alike(mission_net, space, space.stable))
    for piece, _, first in pieces:
        if first:
            left = ((place, name) for place, name in active.items() if name not in selected)
            selected |= {name for place, name in left if space.restricted(piece.states, [place], ())}
    return selected, _names(mission_net, space, iter(pieces))


def _alike(
    mission_net: MissionNet, space: Space[S], states: S
) -> Iterator[tuple[Piece[S], tuple[str, ...], bool]]:
    """Parts of some states, each with its objectives, and whether it is the first of those that are alike."""
    everywhere, known = tuple(mission_net.saying("objective").values()), set[Hashable]()
    for piece in space.pieces(states):
        yield piece, everywhere if piece.kind is None else piece.names, piece.kind not in known
        known.add(piece.kind)


def _names(
    mission_net: MissionNet, space: Space[S], pieces: Iterator[tuple[Piece[S], tuple[str, ...], bool]]
) -> set[str]:
    """Objectives that run in some pieces; pieces of one kind are asked once."""
    by_role, entered, known = mission_net.by_role, set[str](), dict[Hashable, list[int]]()
    for piece, names, first in pieces:
        if first:
            places = (by_role["objective", name] for name in names)
            known[piece.kind] = [
                number
                for number, own in enumerate(places)
                if any(space.restricted(piece.states, [place], ()) for place in own)
            ]
        entered.update(names[number] for number in known[piece.kind])
    return entered


# Elements of a mission that are never selected, entered, left or used in any of its reachable states.


class Never(NamedTuple):
    """What is suspicious in the states of a mission, each with its line.

    Args:
        unselectable: Alternatives never selected, objectives never entered or never left, resources never
            used.
        futile: Objectives and blocks whose success leads only to failure.
    """

    unselectable: tuple[Problem, ...] = ()
    futile: tuple[Problem, ...] = ()


def never_happens(mission_net: MissionNet, space: Space[S], firings: Mapping[int, int]) -> Never:
    """What of a mission never happens.

    Args:
        mission_net: The mission's net.
        space: Its stable states, or its markings.
        firings: By transition how often it fires between them.
    """
    usage, mission = mission_net.usage, mission_net.core
    events = mission_net.net.events
    happens = {event for event in events if any(map(firings.get, events.of(event)))}
    selected, entered = selected_and_entered(mission_net, space)
    sections = list(usage.graph.walk())
    begun = {activity for section in sections if section.name in entered for activity in section.activities}
    running = frozenset[str]().union(*map(usage.closure, begun))
    problems, used = list[Problem](), set[str]()
    for activity in usage.core.activities:
        if activity.name not in usage.started:
            continue
        for alternative in activity.alternatives:
            name = f"{activity.name}.{alternative.name}"
            # Where no objective with the activity is entered, these are reported, not its alternatives.
            if name in selected or activity.name not in running:
                used.update(alternative.consumes)
            else:
                why = _held(usage, activity.name, alternative.consumes)
                problems.append(Problem(alternative.source, f"alternative {name} can never be selected{why}"))
    routing = Routing(usage.graph, entered, happens, mission, _succeeding(mission_net, space))
    problems.extend(routing.never_entered())
    for what, verb in ((What.SUCCESS, "succeed"), (What.FAILURE, "fail")):
        ended = {event.element for event in happens if event.what is what and not event.reason}
        never = (s for s in sections if s.name in entered and s.name not in ended)
        problems.extend(of_objectives(usage, never, f"can never {verb}"))
    problems.extend(never_entered(usage))
    problems.extend(never_used(usage.core, used))
    return Never(tuple(in_order(problems)), tuple(in_order(routing.futile())))


def _succeeding(mission_net: MissionNet, space: Space[S]) -> Callable[[Collection[str]], bool]:
    """Whether the success of a mission is reached from a state that runs one of some objectives."""

    @cache
    def hopeful() -> S:
        return space.reaching(space.marked([mission_net.success]))

    def succeeds(objectives: Collection[str]) -> bool:
        places = [p for name in objectives for p in mission_net.by_role.get(("objective", name), ())]
        return bool(space.marked(places) & hopeful())

    return succeeds


def _held(usage: Usage, activity: str, consumed: Sequence[str]) -> str:
    """Why it is never selected, where its activity serves another that holds what it consumes."""
    for contention in usage.contentions:
        above = [name for name in contention.rivals if name != activity]
        if contention.wanted in consumed and len(above) == 1 and activity in usage.closure(above[0]):
            return f": {above[0]}, which it serves, has {contention.wanted} already"
    return ""


class Ignored(NamedTuple):
    """A declared event that changes nothing in some state in which an objective runs.

    Args:
        event: Its name.
        objectives: Those that run in some state in which it is ignored, in document order.
        required: Whether its declaration says that it must always be handled.
        answering: The objectives in what its handlers lead to that run in some state in which it is answered
            already and no longer handled, in document order.
    """

    event: str
    objectives: tuple[str, ...]
    required: bool
    answering: tuple[str, ...] = ()


def changing_nothing(mission_net: MissionNet, space: Space[S]) -> Iterator[Ignored]:
    """The declared events that are ignored or answered already in some state, in document order.

    Args:
        mission_net: The mission's net.
        space: Its stable states, or its markings.
    """
    graph, events = mission_net.graph, mission_net.net.events
    answers = led_to_by_events(mission_net.mission)
    for declared in mission_net.core.events:
        if declared.changes_facts:
            continue  # it changes facts, and interrupts nothing
        own = events.of(Event(What.DECLARED, declared.name))
        unhandled = space.stable - space.enabling(own) if own else space.stable
        led = _inside(graph.copies, answers.get(declared.name, frozenset()))
        places = [p for name in led for p in mission_net.by_role.get(("objective", name), ())]
        answered = unhandled & space.marked(places) if places else unhandled - unhandled
        running = objectives_run(mission_net, space, unhandled - answered)
        meanwhile = objectives_run(mission_net, space, answered) & led
        ignored, answering = (
            tuple(section.name for section in graph.walk() if section.name in names)
            for names in (running, meanwhile)
        )
        if ignored or answering:
            yield Ignored(declared.name, ignored, declared.required, answering)


def _inside(copies: Copies, blocks: frozenset[Written]) -> set[str]:
    """The objectives in some blocks, in all copies of them."""
    return {name for name in copies.objectives if blocks and not blocks.isdisjoint(copies.around(name))}
