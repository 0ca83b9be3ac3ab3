"""A controller without machine or tables: the net itself, fired by its plain definition.

It shares no code with :mod:`mcpn.controller` but for the words of actions. Interleavings are drawn at random:
so it also shows that their order, within a rank, makes no difference to what the robot is told.
"""

from __future__ import annotations

import random
import re

from mcpn.drawing.compose import MissionNet

BUSY = re.compile(r"[_:](Start|Stop|StartByRes|(eval|wait|active)\d+|error|refusing|running)$")


class NetRobot:
    """A robot that follows the net.

    Args:
        mission_net: The mission's net.
        rng: Draws the interleavings.
    """

    def __init__(self, mission_net: MissionNet, rng: random.Random) -> None:
        self.mission_net, self.net, self.rng = mission_net, mission_net.net, rng
        self.marking = self.net.initial
        self.running_place = {
            place: name.split(".", 1) for place, name in mission_net.saying("active").items()
        }
        self.timed = {s.name for s in mission_net.graph.walk() if s.timeout is not None}
        self.ended: set[str] = set()
        """Objectives left since the event."""
        self.own: dict[str, list[int]] = {activity.name: [] for activity in mission_net.core.activities}
        for number, place in enumerate(self.net.places):
            of = place.provenance
            if of and of.kind in ("activity", "alternative") and BUSY.search(place.name):
                self.own[of.name.split(".", 1)[0]].append(number)
        self.complete()

    @property
    def mode(self) -> dict[str, str]:
        return {a: way for place, (a, way) in self.running_place.items() if self.marking[place]}

    @property
    def outcome(self) -> str | None:
        for kind in ("success", "failure", "abort"):
            if any(self.marking[place] for place in self.mission_net.saying(kind)):
                return kind
        return None

    @property
    def objectives(self) -> set[str]:
        return {name for place, name in self.mission_net.saying("objective").items() if self.marking[place]}

    @property
    def possible(self) -> dict[str, int]:
        found = {}
        for number in self.net.enabled(self.marking):
            event = self.net.transitions[number].event
            assert event is not None
            assert str(event) not in found
            found[str(event)] = number
        return found

    def handle(self, event: str) -> list[tuple[str, ...]]:
        before, ran = self.mode, self.objectives & self.timed
        self.ended = set()
        left: set[str] = set()
        idle: set[str] = set()
        self.fire(self.possible[event], left, idle)
        self.complete(left, idle)
        after, runs = self.mode, self.objectives & self.timed
        stopped = {a for a in before if a not in after or a in idle}
        changed = {a for a in before if a in stopped or a in left or after.get(a) != before[a]}
        released = {k for a in changed for k in self.hardware(a, before[a])}
        selected = {a for a in after if a not in before or a in changed}
        started = {a for a in after if a not in before or a in stopped}
        return sorted(
            [("stop", a) for a in stopped]
            + [("release", k) for k in released]
            + [("select", a, after[a]) for a in selected]
            + [("start", a) for a in started]
            + [("disarm", name) for name in ran & self.ended]
            + [("arm", name) for name in runs if name not in ran or name in self.ended]
        )

    def hardware(self, activity: str, alternative: str) -> list[str]:
        robots = self.mission_net.mission.robots  # as declared: nobody takes what stands for a fault
        (of,) = [a for robot in robots for a in robot.activities if a.name == activity]
        (way,) = [w for w in of.alternatives if w.name == alternative]
        return [k for k in way.consumes if k in {h.name for robot in robots for h in robot.hardware}]

    def fire(self, transition: int, left: set[str], idle: set[str]) -> None:
        before = self.marking
        self.marking = self.net.fire(before, transition)
        for place, name in self.mission_net.saying("objective").items():
            if place in {p for p, _ in self.net.transitions[transition].consume}:
                self.ended.add(name)
        for place, (activity, _) in self.running_place.items():
            if before[place] > self.marking[place]:
                left.add(activity)
        idle |= {a for a in left if not any(self.marking[place] for place in self.own[a])}

    def complete(self, left: set[str] | None = None, idle: set[str] | None = None) -> None:
        left = set() if left is None else left
        idle = set() if idle is None else idle
        while True:
            enabled = [t for t in self.net.enabled(self.marking) if self.net.transitions[t].internal]
            if not enabled:
                return
            self.fire(self.rng.choice(enabled), left, idle)
