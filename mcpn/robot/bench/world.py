"""A robot and its world as fake drivers: what may happen where the controller is, and how soon.

The model is that of the numbers of risk (:mod:`mcpn.answers.causes.risk`), played instead of solved, and
played on the controller instead of the net: exponential durations, failures and repairs; hardware that
fails as an alternative starts; an objective whose present run cannot succeed any more fails at once. The
world knows of each loss: one that is detected late is drawn as any other, and told to the controller, which
changes no mode; its detection is drawn at its rate; and an objective that uses what is lost ends in
failure. Timers, which numbers of risk do not know, run out in virtual time. Each place of the controller
and what each event does there are asked of the runtime once.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from itertools import accumulate

from mcpn.events import Event, What
from mcpn.robot.bench.chances import Chances
from mcpn.robot.bench.controller_places import ControllerPlace, Demands, Places
from mcpn.robot.runtime.actions import Action
from mcpn.robot.runtime.controller_tables import Inside, Tables, TableSection

UNTIMED = 1.0
"""Mean hours of an objective of which nobody says how long it takes."""


@dataclass(eq=False)
class BenchNode:
    """A place of the controller, with what may happen there.

    Args:
        place: The place.
        seen: What runs.
        degraded: Whether some activity runs in another alternative than its first.
        at_once: Events of which one happens at once, each as likely: objectives that cannot succeed fail.
        events: Others that happen with some rate.
        rates: The sums of their rates per hour, up to each.
        edges: Where events lead, and the actions, as far as they have been asked.
    """

    place: ControllerPlace
    seen: tuple[tuple[str, ...], tuple[tuple[str, str], ...]]
    degraded: bool
    at_once: list[str]
    events: list[str]
    rates: list[float]
    edges: dict[str, tuple[BenchNode, tuple[Action, ...]]] = field(default_factory=dict)


class World:
    """Fake drivers around a controller.

    Args:
        tables: The controller.
        chances: How likely what happens around it is.
        duration: Mean hours of objectives that have none in the file; without it such an objective takes
            one hour, or as long as its timer: a time that says nothing, for runs of which none is asked.
    """

    def __init__(self, tables: Tables, chances: Chances, duration: float | None = None) -> None:
        self.tables = tables
        self.places = Places(tables)
        self.chances = chances
        self.demands = Demands(tables, chances)
        self._duration = duration
        self._first = {
            name: next(iter(activity["alternatives"])) for name, activity in tables.laws.activities.items()
        }
        self._parsed: dict[str, Event] = {}
        self._nodes: dict[ControllerPlace, BenchNode] = {}
        self._hope: dict[tuple[str, str, int, frozenset[str]], bool] = {}
        self.start = self._node(self.places.start)

    def after(self, node: BenchNode, event: str) -> tuple[BenchNode, tuple[Action, ...]] | None:
        """Where an event leads, and the actions; ``None`` where the controller refuses it."""
        if event not in node.edges:
            step = self.places.after(node.place, event)
            if step is None:
                return None
            node.edges[event] = self._node(step[0]), step[1]
        return node.edges[event]

    def _event(self, text: str) -> Event:
        if text not in self._parsed:
            self._parsed[text] = Event.parse(text)
        return self._parsed[text]

    def _node(self, place: ControllerPlace) -> BenchNode:
        if place in self._nodes:
            return self._nodes[place]
        inside = place.inside
        at_once: list[str] = []
        rates: dict[str, float] = {}
        possible = () if place.outcome else place.possible
        for text in possible:
            event = self._event(text)
            if event.what is What.START:
                at_once.append(text)
            elif event.what is What.SUCCESS:
                objective = self.chances.objectives[event.element]
                rate = 1.0 / self._mean(event.element)
                rates[text] = rate * (1.0 - objective.failure)
                for reason, share in objective.reasons.items():
                    rates[str(Event(What.FAILURE, event.element, reason))] = rate * share
            elif event.what is What.FAILURE and not event.reason:
                success = str(Event(What.SUCCESS, event.element))
                if success not in possible and self._seems_well(event.element, inside):
                    rates[text] = 1.0 / self._mean(event.element)
                elif event.element in inside.objectives and not self._can_succeed(event.element, place):
                    at_once.append(text)
            elif text in self.chances.rates:
                rates[text] = self.chances.rates[text]
        some = {text: rate for text, rate in rates.items() if rate > 0 and text in possible}
        node = BenchNode(
            place,
            place.seen,
            any(way != self._first[activity] for activity, way in inside.mode.items()),
            at_once,
            list(some),
            list(accumulate(some.values())),
        )
        self._nodes[place] = node
        return node

    def _mean(self, objective: str) -> float:
        duration = self.chances.objectives[objective].duration
        if duration is not None:
            return duration
        if self._duration is not None:
            return self._duration
        timeout = self.tables.laws.timeouts.get(objective)
        return UNTIMED if timeout is None else timeout / 3600

    def _seems_well(self, objective: str, inside: Inside) -> bool:
        """Whether all activities of an objective run, so that it succeeds, unless it uses what is lost."""
        return objective in inside.objectives and inside.mode.keys() >= {
            *self.tables.laws.objectives[objective]["activities"]
        }

    def _can_succeed(self, objective: str, place: ControllerPlace) -> bool:
        """Whether some run of what may happen, in which it goes on, makes its success possible."""
        assert place.section is not None, "an objective runs in a section"
        key = (objective, *place.section, place.true)
        if key not in self._hope:
            section = self.tables.sections[place.section[0]]
            self._hope[key] = self._search(objective, section, place.section[1], place.true)
        return self._hope[key]

    def _search(self, objective: str, section: TableSection, state: int, true: frozenset[str]) -> bool:
        success = str(Event(What.SUCCESS, objective))
        known = {(state, true)}
        queue = deque(known)
        while queue:
            state, true = queue.popleft()
            possible = section.possible(state, true)
            if success in possible or self._seems_well(objective, section.state(state)):
                return True
            for text in possible:
                if not self._goes_on(objective, text):
                    continue
                step = section.move(state, text, true)
                if step is None or isinstance(step[0], str):
                    continue
                inside = section.state(step[0])
                if objective in inside.objectives:
                    asked = self.demands.started(inside, step[1])
                    first = step[0], (true | step[2]) - step[3]
                    fresh = set(self.demands.ends(section, first, asked)) - known
                    known |= fresh
                    queue.extend(sorted(fresh, key=lambda at: at[0]))
        return False

    def _goes_on(self, objective: str, text: str) -> bool:
        """Whether an event may happen, and does not end the present run of an objective."""
        event = self._event(text)
        if event.what in (What.SUCCESS, What.FAILURE):
            return event.element != objective
        return self.chances.rates.get(text, 0.0) > 0 and (
            text not in self.chances.objectives[objective].stopped_by
        )
