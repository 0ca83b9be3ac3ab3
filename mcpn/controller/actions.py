"""What the controller orders on an event: stop, release, select, start, in an order that is safe; and timers.

Consumers are stopped before what they consume, and started after it. Hardware is released after the last stop
and before anything new is asked for. An alternative is selected before its activity starts. The timers of
objectives that end are disarmed first, those of objectives that begin armed last.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from mcpn.answers.verdicts.modes import Situation
from mcpn.controller.run import Left
from mcpn.drawing.sections import section_part
from mcpn.mission.flatten import ObjectivesGraph, Section
from mcpn.mission.graph import names_in
from mcpn.mission.static.usage import Usage

Verb = Literal["disarm", "stop", "release", "select", "start", "arm"]
VERBS: tuple[Verb, ...] = ("disarm", "stop", "release", "select", "start", "arm")
"""In the order in which they are given on one event."""


@dataclass(frozen=True, slots=True)
class PlannedAction:
    """One order of the controller to the robot.

    Args:
        verb: ``stop`` or ``start`` an activity, ``select`` one of its alternatives, ``release`` hardware,
            ``arm`` or ``disarm`` the timer of an objective.
        activity: The activity, of the first three.
        alternative: The alternative, for ``select``.
        hardware: The hardware resource, for ``release``.
        objective: The running objective that names the activity, for ``select`` and ``start``; ``None`` for
            an activity that is started by a request for what it produces. Of a timer, the objective.
    """

    verb: Verb
    activity: str | None = None
    alternative: str | None = None
    hardware: str | None = None
    objective: str | None = None


class Ordering:
    """The order of actions, in the net of a mission or of one section of it.

    Args:
        usage: The static analysis of the mission.
        graph: The objectives graph: the mission's, or that of a section alone.
    """

    def __init__(self, usage: Usage, graph: ObjectivesGraph) -> None:
        self.usage = usage
        self._home = {name: section.name for section in graph.sections for name in names_in(section)}
        self._stops = {section.name: _consumers_first(usage, section) for section in graph.sections}
        self._timed = {section.name for section in graph.walk() if section.timeout is not None}
        self._named = {section.name: section.activities for section in graph.walk()}
        # What stands for a fault or a crash is nothing that the robot takes or releases.
        stands = (*usage.mission.faults, *usage.mission.crashes)
        taken = usage.hardware.keys() - {each.name for each in stands}
        self._hardware = {
            (activity.name, alternative.name): [k for k in alternative.consumes if k in taken]
            for activity in usage.activities.values()
            for alternative in activity.alternatives
        }

    def actions(self, before: Situation, after: Situation, passage: Left) -> Iterator[PlannedAction]:
        """The actions of one event.

        Args:
            before: What the robot does before it.
            after: What it does afterwards.
            passage: How the net came from the one to the other.
        """
        changed = {
            a
            for a, alternative in before.mode.items()
            if after.mode.get(a) != alternative or a in passage.left
        }
        stopped = {a for a in before.mode if a not in after.mode or a in passage.idled}
        first = self._order(before, before.mode)
        yield from (PlannedAction("disarm", objective=o) for o in before.objectives if o in passage.ended)
        yield from (PlannedAction("stop", a) for a in first if a in stopped)
        released = [k for a in first if a in changed for k in self._hardware[a, before.mode[a]]]
        yield from (PlannedAction("release", hardware=k) for k in dict.fromkeys(released))
        begun = [
            a for a in self._order(after, after.mode)[::-1] if a not in before.mode or a in changed | stopped
        ]
        objective = {a: name for name in after.objectives for a in self._named[name]}
        for a in begun:
            yield PlannedAction("select", a, after.mode[a], objective=objective.get(a))
        for a in begun:
            if a not in before.mode or a in stopped:
                yield PlannedAction("start", a, objective=objective.get(a))
        for name in after.objectives:
            if name in self._timed and (name not in before.objectives or name in passage.ended):
                yield PlannedAction("arm", objective=name)

    def _order(self, situation: Situation, activities: Mapping[str, str]) -> Sequence[str]:
        """Activities of a situation, consumers before what they consume, in the order of its section."""
        names = (*situation.objectives, *situation.pending, *situation.done)
        home = next((self._home[name] for name in names if name in self._home), None)
        known = self._stops[home] if home is not None else []
        rest = [a for a in activities if a not in known]
        return [a for a in known if a in activities] + rest


def _consumers_first(usage: Usage, section: Section) -> list[str]:
    """The activities of a section, each before those that produce what it consumes.

    The order depends on the shape of the section alone, so that sections of one type have the same.
    """
    found = [activity.name for activity in section_part(usage, section).parts.activities]
    members = set(found)
    waiting = dict.fromkeys(found, 0)
    below = {}
    for name in found:
        alternatives = range(len(usage.activities[name].alternatives))
        below[name] = dict.fromkeys(p for i in alternatives for p in usage.suppliers(name, i) if p in members)
        for supplier in below[name]:
            waiting[supplier] += 1
    ready, order = [name for name in found if not waiting[name]], list[str]()
    for name in ready:  # grows while it is walked
        order.append(name)
        for supplier in below[name]:
            waiting[supplier] -= 1
            if not waiting[supplier]:
                ready.append(supplier)
    return order
