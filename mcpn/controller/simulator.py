"""A mission played event by event on its net, without any machine: a second opinion on the controller.

Every stable marking, possible event and action is computed by running the net to completion; ways to a goal
and cut sets are searched on the net too.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import combinations

from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.controller.machine import Ordering, PlannedAction
from mcpn.controller.run_to_completion import Runner
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError
from mcpn.events import Event, What
from mcpn.mission.robot import Crash

MAX_VISITED = 200_000
"""Stable markings that one search may look at."""

MOST_CUT = 3
"""Members of the cut sets that are searched for."""

FAILURES = frozenset({What.OUT_OF_SERVICE})
HARDWARE = FAILURES | {What.REPAIRED}


@dataclass(frozen=True)
class Change:
    """What one event did.

    Args:
        event: The event.
        before: What the robot did before it.
        after: What it does now.
        actions: What the controller orders.
    """

    event: Event
    before: Situation
    after: Situation
    actions: tuple[PlannedAction, ...]


class Simulation:
    """A mission that is played; each stable marking is computed once.

    Args:
        mission_net: The mission's net.
        max_states: How many stable markings one search may look at.
    """

    def __init__(self, mission_net: MissionNet, max_states: int = MAX_VISITED) -> None:
        self.mission_net = mission_net
        self.max_states = max_states
        self._runner = Runner(mission_net)
        self._ordering = Ordering(mission_net.usage, mission_net.graph)
        self._possible: dict[int, dict[Event, int]] = {}
        self._situations: dict[int, Situation] = {}
        self._after: dict[tuple[int, int], int] = {}
        self._changes: dict[tuple[int, int], Change] = {}
        self.marking = self._runner.stable()
        self._past: list[tuple[int, Event]] = []

    @property
    def run(self) -> list[Event]:
        """The events taken, those undone left out."""
        return [event for _, event in self._past]

    @property
    def situation(self) -> Situation:
        """What the robot does now."""
        return self._situation(self.marking)

    @property
    def possible(self) -> list[Event]:
        """The events that can happen now, in the net's order."""
        return list(self._events(self.marking))

    def take(self, event: Event) -> Change | None:
        """Takes an event; ``None``, and nothing changes, where it is not possible."""
        transition = self._events(self.marking).get(event)
        if transition is None:
            return None
        key = self.marking, transition
        if key not in self._changes:
            passage = self._runner.fire(*key)
            self._after[key] = passage.marking
            before, after = self._situation(key[0]), self._situation(passage.marking)
            actions = tuple(self._ordering.actions(before, after, passage))
            self._changes[key] = Change(event, before, after, actions)
        self._past.append((self.marking, event))
        self.marking = self._after[key]
        return self._changes[key]

    def undo(self) -> Event | None:
        """Takes back the last event, and says which; ``None`` at the beginning."""
        if not self._past:
            return None
        self.marking, event = self._past.pop()
        return event

    def restart(self) -> None:
        """Goes back to the beginning."""
        while self.undo() is not None:
            pass

    def way_to(self, outcome: str, never: frozenset[What] | None = None) -> list[Event] | None:
        """A shortest run from here to an end of the mission.

        Args:
            outcome: ``success``, ``failure`` or ``abort``.
            never: What does not happen on the way; by default hardware neither fails nor is repaired, unless
                there is no other way.

        Raises:
            LimitError: More stable markings than allowed would have to be looked at.
        """

        def ended(at: int) -> bool:
            return self._situation(at).outcome == outcome

        if never is not None:
            return self._search(self.marking, ended, never)
        found = self._search(self.marking, ended, HARDWARE)
        return found if found is not None else self._search(self.marking, ended, frozenset())

    def cut_set(self) -> tuple[str, ...] | None:
        """Fewest hardware resources that, failing now and never repaired, rule out success.

        Returns:
            The first such set in the mission's order, with what may crash before all else; empty where
            success is ruled out already; ``None`` where no set of :data:`MOST_CUT` resources does it.

        Raises:
            LimitError: More stable markings than allowed would have to be looked at.
        """
        crashes = {crash.name for crash in self.mission_net.core.crashes}
        working = [e.element for e in self.possible if e.what is What.OUT_OF_SERVICE]
        # What a failure stops cannot crash any more.
        working.sort(key=lambda name: name not in crashes)
        for size in range(min(MOST_CUT, len(working)) + 1):
            for chosen in combinations(working, size):
                after = self._without(chosen)
                if after is not None and not self._can_succeed(after):
                    return chosen
        return None

    def _without(self, hardware: tuple[str, ...]) -> int | None:
        """The marking after some failures; ``None`` where one crash keeps another away."""
        at = self.marking
        for name in hardware:
            transition = self._events(at).get(Event(What.OUT_OF_SERVICE, name))
            if transition is None:
                return None
            at = self._next(at, transition)
        return at

    def _can_succeed(self, start: int) -> bool:
        # Other hardware stays as it is: that it fails too could only make success harder to reach.
        return self._search(start, lambda at: self._situation(at).outcome == "success", HARDWARE) is not None

    def _search(self, start: int, goal: Callable[[int], bool], never: frozenset[What]) -> list[Event] | None:
        """A shortest run to a goal without some kinds of events."""
        origin: dict[int, tuple[int, Event] | None] = {start: None}
        queue = deque([start])
        while queue:
            at = queue.popleft()
            if goal(at):
                return self._run_to(at, origin)
            for event, transition in self._events(at).items():
                if event.what not in never:
                    to = self._next(at, transition)
                    if to not in origin:
                        origin[to] = at, event
                        queue.append(to)
            if len(origin) > self.max_states:
                raise LimitError(f"more than {self.max_states} stable markings searched: the limit was hit")
        return None

    def _run_to(self, at: int, origin: dict[int, tuple[int, Event] | None]) -> list[Event]:
        run = []
        while (before := origin[at]) is not None:
            at, event = before
            run.append(event)
        return run[::-1]

    def _events(self, at: int) -> dict[Event, int]:
        if at not in self._possible:
            transitions = self.mission_net.net.transitions
            found = ((transitions[t].event, t) for t in self._runner.possible(at))
            self._possible[at] = {event: t for event, t in found if event is not None}
        return self._possible[at]

    def _next(self, at: int, transition: int) -> int:
        key = at, transition
        if key not in self._after:
            self._after[key] = self._runner.fire(at, transition).marking
        return self._after[key]

    def _situation(self, at: int) -> Situation:
        if at not in self._situations:
            marking = tuple(at >> place & 1 for place in range(len(self.mission_net.net.places)))
            self._situations[at] = situation(self.mission_net, marking)
        return self._situations[at]


def resources(mission_net: MissionNet, now: Situation) -> Iterator[tuple[str, str]]:
    """Every resource with who has it: hardware, then the software that some activity produces.

    Args:
        mission_net: The mission's net.
        now: What the robot does.

    Yields:
        The name, and ``free``, ``out of service``, ``used by …`` or ``produced by …``; of a fault
        ``fault`` or ``no fault``, of what may crash ``crashed`` or ``not crashed``. What is detected late may
        be ``out of service, unnoticed``, used by somebody or not.
    """
    activities = mission_net.usage.activities
    users: dict[str, list[str]] = {}
    for activity, alternative in now.mode.items():
        (way,) = (w for w in activities[activity].alternatives if w.name == alternative)
        for resource in way.consumes:
            users.setdefault(resource, []).append(activity)
    faults = {fault.name for fault in mission_net.core.common_causes}
    affecting = {
        h.name: {fault.name for fault in mission_net.core.common_causes if h.name in fault.affects}
        for h in mission_net.core.hardware
    }
    for hardware in mission_net.core.hardware:
        name = hardware.name
        if isinstance(hardware, Crash):
            yield name, "crashed" if name in now.out_of_service else "not crashed"
        elif name in faults:
            yield name, "fault" if name in now.out_of_service else "no fault"
        elif name in now.unnoticed:
            use = f", used by {', '.join(users[name])}" if name in users else ""
            yield name, f"out of service, unnoticed{use}"
        elif name in now.out_of_service or not affecting[name].isdisjoint(now.out_of_service):
            yield name, "out of service"
        else:
            yield name, f"used by {', '.join(users[name])}" if name in users else "free"
    for activity in now.mode:
        for name in activities[activity].produces:
            use = f", used by {', '.join(users[name])}" if name in users else ""
            yield name, f"produced by {activity}{use}"
