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
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import accumulate

from mcpn.bench.controller_places import ControllerPlace, Demands, Places
from mcpn.drawing.compose import MissionNet
from mcpn.events import Event, What
from mcpn.mission.expansion.routes import Interrupted
from mcpn.mission.flatten import ElementarySection, ParallelSection
from mcpn.robot.runtime.tables import Action, Inside, Tables, TableSection

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
        mission_net: The mission, whose file gives rates and durations.
        tables: Its controller.
        duration: Mean hours of objectives that have none in the file; without it such an objective takes
            one hour, or as long as its timer: a time that says nothing, for runs of which none is asked.
    """

    def __init__(self, mission_net: MissionNet, tables: Tables, duration: float | None = None) -> None:
        self.mission_net = mission_net
        self.tables = tables
        self.places = Places(tables)
        self._objectives: dict[str, ElementarySection] = {o.name: o for o in mission_net.graph.walk()}
        self._duration = duration
        self.demands = Demands(mission_net)
        mission = mission_net.mission
        self._rates: dict[Event, float] = {}
        for hardware in mission.hardware:
            self._rates[Event(What.OUT_OF_SERVICE, hardware.name)] = hardware.failure_rate or 0.0
            self._rates[Event(What.REPAIRED, hardware.name)] = hardware.repair_rate or 0.0
        for activity in mission.activities:
            for name in activity.detects:
                self._rates[Event(What.DETECTED, name)] = activity.detection_rate or 0.0
        for declared in mission.events:
            self._rates[Event(What.DECLARED, declared.name)] = declared.rate or 0.0
        self._stopping: dict[str, set[Event]] = {name: set() for name in self._objectives}
        changing = mission_net.usage.world.changing.items()
        for section in mission_net.graph.all_sections():
            asked = {said for each in section.becomes for said in each.when}
            by_facts = {
                Event(What.DECLARED, name)
                for name, changes in changing
                if any((fact, value) in asked for fact, to in changes.items() for value in to.values())
            }
            inside: list[tuple[Interrupted, Iterable[ElementarySection]]] = [(section, section.walk())]
            if isinstance(section, ParallelSection):
                inside = [(section, branch.graph.walk()) for branch in section.branches]
                inside += [(pause_graph, pause_graph.graph.walk()) for pause_graph in section.pause_graphs]
            for outer, stopped in inside:
                events = {Event(What.DECLARED, handler.event) for handler in outer.interruptions}
                if outer is section:  # the time of a block that pauses does not go on
                    events |= {Event(What.TIMEOUT, section.name), *by_facts}
                for inner in stopped:
                    self._stopping[inner.name] |= events
        self._first = {a.name: a.alternatives[0].name for a in mission.activities}
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
                objective = self._objectives[event.element]
                rate = 1.0 / self._mean(objective)
                rates[text] = rate * (1.0 - objective.failure_probability)
                for (reason, _), share in zip(objective.failures, objective.shares, strict=True):
                    rates[str(Event(What.FAILURE, event.element, reason))] = rate * share
            elif event.what is What.FAILURE and not event.reason:
                success = str(Event(What.SUCCESS, event.element))
                if success not in possible and self._seems_well(event.element, inside):
                    rates[text] = 1.0 / self._mean(self._objectives[event.element])
                elif event.element in inside.objectives and not self._can_succeed(event.element, place):
                    at_once.append(text)
            elif event in self._rates:
                rates[text] = self._rates[event]
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

    def _mean(self, objective: ElementarySection) -> float:
        if objective.duration is not None:
            return objective.duration
        if self._duration is not None:
            return self._duration
        return UNTIMED if objective.timeout is None else objective.timeout / 3600

    def _seems_well(self, objective: str, inside: Inside) -> bool:
        """Whether all activities of an objective run, so that it succeeds, unless it uses what is lost."""
        return objective in inside.objectives and inside.mode.keys() >= {
            *self._objectives[objective].activities
        }

    # --- can the present run of an objective still succeed? ---

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
                if not self._goes_on(objective, self._event(text)):
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

    def _goes_on(self, objective: str, event: Event) -> bool:
        """Whether an event may happen, and does not end the present run of an objective."""
        if event.what in (What.SUCCESS, What.FAILURE):
            return event.element != objective
        return self._rates.get(event, 0.0) > 0 and event not in self._stopping[objective]
