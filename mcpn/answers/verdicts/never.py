"""What never happens: objectives that never run, alternatives never selected."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import NamedTuple

from mcpn.answers.verdicts.routing import Routing
from mcpn.drawing.compose import MissionNet
from mcpn.errors import Problem
from mcpn.mission.static.usage import Usage
from mcpn.mission.static.warnings import (
    in_order,
    never_entered,
    never_used,
    of_objectives,
)
from mcpn.nets.events import Event, What
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
    usage, mission = mission_net.usage, mission_net.mission
    transitions = mission_net.net.transitions
    events = (transitions[t].event for t, count in firings.items() if count)
    happens = {event for event in events if event is not None}
    selected, entered = selected_and_entered(mission_net, space)
    sections = list(usage.graph.walk())
    begun = {activity for section in sections if section.name in entered for activity in section.activities}
    running = frozenset[str]().union(*map(usage.closure, begun))
    problems, used = list[Problem](), set[str]()
    for activity in mission.activities:
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
    routing = Routing(usage.graph, entered, happens, mission)
    problems.extend(routing.never_entered())
    for what, verb in ((What.SUCCESS, "succeed"), (What.FAILURE, "fail")):
        never = (s for s in sections if s.name in entered and Event(what, s.name) not in happens)
        problems.extend(of_objectives(usage, never, f"can never {verb}"))
    problems.extend(never_entered(usage))
    problems.extend(never_used(mission, used))
    return Never(tuple(in_order(problems)), tuple(in_order(routing.futile())))


def _held(usage: Usage, activity: str, consumed: Sequence[str]) -> str:
    """Why it is never selected, where its activity serves another that holds what it consumes."""
    for contention in usage.contentions:
        above = [name for name in contention.rivals if name != activity]
        if contention.wanted in consumed and len(above) == 1 and activity in usage.closure(above[0]):
            return f": {above[0]}, which it serves, has {contention.wanted} already"
    return ""
