"""Losses on a run come where they strike: after the mission has started, while the hardware is in use.

A shortest run may lose hardware anywhere before it is missed, mostly before the mission starts. A reader sees
what a loss does where it changes what the robot does.
"""

from __future__ import annotations

from dataclasses import replace

from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.drawing.compose import MissionNet
from mcpn.nets.events import Event, What
from mcpn.nets.petri import Marking
from mcpn.spaces.run import Completion, Run

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
        marking = list(self.mission_net.net.initial)
        for _ in self._completion.settle(marking):
            pass
        markings = [tuple(marking)]
        for t in events:
            markings.append(self._completion.after(markings[-1], t)[1])
        for place in range(len(events) - 1, -1, -1):
            if self._event(events[place]).what is What.OUT_OF_SERVICE:
                self._put_off(events, markings, place)
        return replace(run, transitions=tuple(events))

    def _put_off(self, events: list[int], markings: list[Marking], place: int) -> None:
        """Puts one loss off, in place.

        Args:
            events: The events of the run.
            markings: The stable markings before the first of them and after each.
            place: Where the loss stands.
        """
        now, best = place, (events[:], markings[:])
        while now + 1 < len(events) and not self._strikes(markings[now], markings[now + 1]):
            passed = self._event(events[now + 1])
            first = self._fired(markings[now], events[now + 1]) if passed.what in _PASSED else None
            if first is None or self._ended(first[1]):
                break
            second = self._fired(first[1], events[now])
            if second is None or second[1] != markings[now + 2]:
                break
            (events[now], markings[now + 1]), (events[now + 1], markings[now + 2]) = first, second
            if passed.what is What.START or self._strikes(first[1], second[1]):
                best = events[:], markings[:]
            now += 1
        events[:], markings[:] = best

    def _event(self, transition: int) -> Event:
        event = self.mission_net.net.transitions[transition].event
        assert event is not None, "internal firings are left out"
        return event

    def _strikes(self, before: Marking, after: Marking) -> bool:
        """Whether what runs, waits or has no way to run changes."""
        return self._doing(before) != self._doing(after)

    def _doing(self, marking: Marking) -> Situation:
        return replace(situation(self.mission_net, marking), out_of_service=(), unnoticed=())

    def _fired(self, marking: Marking, transition: int) -> tuple[int, Marking] | None:
        """The event of a transition by one that is enabled, and what follows; ``None`` where none is."""
        t = self._completion.of_event(marking, self._event(transition))
        return None if t is None else (t, self._completion.after(marking, t)[1])

    def _ended(self, marking: Marking) -> bool:
        return any(marking[place] for place in self.mission_net.ends.values())
