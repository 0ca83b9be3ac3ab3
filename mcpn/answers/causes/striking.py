"""Runs whose losses come where they strike: after the start, while the hardware is in use.

A shortest run may lose hardware anywhere before it is missed, mostly before the mission starts. Of each
marking on the way only what changes is kept: a run passes as many sections as the mission has.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import TypeAlias

from mcpn.answers.verdicts.modes import Situation, said_by
from mcpn.drawing.compose import MissionNet
from mcpn.events import Event, What
from mcpn.spaces.run import Completion, Evolution, Run

Changes: TypeAlias = Mapping[int, int]
"""By place, the tokens that an event and what follows it bring, or take; places without any are left out."""

_PASSED = (What.START, What.SUCCESS)
"""Events past which a loss may be put off: of others it may be the reason, or they are losses themselves."""


class Striking:
    """Puts losses off on runs of a mission, which end in the same marking then.

    Args:
        mission_net: The mission's net.
    """

    def __init__(self, mission_net: MissionNet) -> None:
        self.mission_net = mission_net
        self._completion = Completion(mission_net.net)

    def on(self, run: Run) -> Run:
        """The same events in another order, if there is one in which a loss comes where it strikes.

        Each loss is put off past the start and past successes of objectives, as long as it changes nothing
        that the robot does and the same marking follows; where it changes nothing before the next other event
        either, to just behind the start.
        """
        events = [t for t in run.transitions if not self.mission_net.net.transitions[t].internal]
        walk = _Replay(self.mission_net, self._completion)
        changes = [walk.fire(t) for t in events]
        for place in range(len(events) - 1, -1, -1):
            walk.undo(changes[place])
            if walk.event(events[place]).what is What.OUT_OF_SERVICE:
                _put_off(walk, events, changes, place)
        return replace(run, transitions=tuple(events))


def _put_off(walk: _Replay, events: list[int], changes: list[Changes], place: int) -> None:
    """Puts one loss off, in place.

    Args:
        walk: Stands before the loss, and does so again afterwards.
        events: The events of the run.
        changes: What each of them changes.
        place: Where the loss stands.
    """
    now, best = place, (events[:], changes[:])
    while now + 1 < len(events) and not walk.strikes(changes[now]):
        other = events[now + 1], events[now]
        passed = walk.event(other[0])
        found = _exchanged(walk, other) if passed.what in _PASSED else None
        if found is None:
            break
        (first, one), (second, two) = found
        if _together(one, two) != _together(changes[now], changes[now + 1]):
            break
        events[now : now + 2], changes[now : now + 2] = (first, second), (one, two)
        walk.redo(one)
        if passed.what is What.START or walk.strikes(two):
            best = events[:], changes[:]
        now += 1
    for done in reversed(changes[place:now]):
        walk.undo(done)
    events[:], changes[:] = best


def _exchanged(walk: _Replay, events: tuple[int, int]) -> list[tuple[int, Changes]] | None:
    """Two events one after the other, the first of which ends no mission; ``None`` where they cannot be."""
    found = list[tuple[int, Changes]]()
    for t in events:
        enabled = None if walk.ended else walk.enabled(walk.event(t))
        if enabled is None:
            break
        found.append((enabled, walk.fire(enabled)))
    for _, done in reversed(found):
        walk.undo(done)
    return found if len(found) == len(events) else None


def _together(one: Changes, other: Changes) -> Changes:
    """What two events change, one after the other."""
    both = Counter(one)
    both.update(other)
    return {place: tokens for place, tokens in both.items() if tokens}


class _Replay:
    """A stable marking of a mission that events change, and that can be changed back.

    Args:
        mission_net: The mission's net.
        completion: Of the net.
    """

    def __init__(self, mission_net: MissionNet, completion: Completion) -> None:
        self.mission_net, self.completion = mission_net, completion
        self.evolution = Evolution(completion, list(mission_net.net.initial))
        for _ in self.evolution.settle():
            pass
        self.telling = {place for place in mission_net.roles if self.evolution.marking[place]}

    def event(self, transition: int) -> Event:
        """What a transition carries."""
        event = self.mission_net.net.transitions[transition].event
        assert event is not None, "internal firings are left out"
        return event

    def enabled(self, event: Event) -> int | None:
        """A transition of an event that is enabled; ``None`` where none is."""
        return self.completion.of_event(self.evolution.marking, event)

    def fire(self, transition: int) -> Changes:
        """Fires an event, and what follows it by itself."""
        changes, transitions = Counter[int](), self.mission_net.net.transitions
        self.evolution.fire(transition)
        for t in (transition, *self.evolution.settle()):
            for place, weight in transitions[t].produce:
                changes[place] += weight
            for place, weight in transitions[t].consume:
                changes[place] -= weight
        found = {place: tokens for place, tokens in changes.items() if tokens}
        self._tell(found)
        return found

    def redo(self, changes: Changes) -> None:
        """Goes on over an event that has been undone."""
        self.evolution.change(changes)
        self._tell(changes)

    def undo(self, changes: Changes) -> None:
        """Goes back over an event."""
        self.redo({place: -tokens for place, tokens in changes.items()})

    def _tell(self, changes: Changes) -> None:
        for place in changes.keys() & self.mission_net.roles.keys():
            (self.telling.add if self.evolution.marking[place] else self.telling.discard)(place)

    @property
    def ended(self) -> bool:
        """Whether the mission has ended."""
        return any(place in self.telling for place in self.mission_net.ends.values())

    def strikes(self, changes: Changes) -> bool:
        """Whether what runs, waits or has no way to run changes with some event."""
        if changes.keys().isdisjoint(self.mission_net.roles):
            return False
        before = self._doing()
        self.redo(changes)
        after = self._doing()
        self.undo(changes)
        return before != after

    def _doing(self) -> Situation:
        return replace(said_by(self.mission_net, sorted(self.telling)), out_of_service=(), unnoticed=())
