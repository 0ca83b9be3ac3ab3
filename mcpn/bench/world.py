"""The places of a controller, each asked of the runtime once: runs through them look up what is known.

Hardware that fails on demand is played here too: what starts on an event is asked, one by one. The order is
that of the numbers of risk (:mod:`mcpn.answers.causes.demands`): resources as the activities of the section
come upon them, then activities, then alternatives. What starts is read from the controller's actions.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import NamedTuple, TypeAlias

from mcpn.drawing.compose import MissionNet
from mcpn.drawing.sections import SectionParts, Used
from mcpn.mission.expansion.routes import Interrupted
from mcpn.mission.flatten import ElementarySection, ParallelSection
from mcpn.nets.events import Event, What
from mcpn.runtime.controller import Controller
from mcpn.runtime.restoring import Saved
from mcpn.runtime.tables import Action, Inside, Tables, TableSection


class StartDemand(NamedTuple):
    """Hardware that an alternative consumes which has just started; in the order in which they are asked."""

    rank: tuple[int, int, int]
    activity: str
    alternative: str
    hardware: str

    @property
    def event(self) -> str:
        """The event that it fails."""
        return str(Event(What.OUT_OF_SERVICE, self.hardware))


Move: TypeAlias = tuple[int, frozenset[str]]
"""A state of a section, and what has happened then."""


class Demands:
    """What may fail on demand as alternatives start.

    Args:
        mission_net: The mission, whose file says how probable that is.
    """

    def __init__(self, mission_net: MissionNet) -> None:
        mission = mission_net.mission
        self.probability = {h.name: h.demand_probability for h in mission.hardware if h.demand_probability}
        self._ways = {
            (activity.name, way.name): (number, [k for k in way.consumes if k in self.probability])
            for activity in mission.activities
            for number, way in enumerate(activity.alternatives)
        }
        parts = SectionParts(mission_net.usage)
        self._used: dict[str, Used] = {}
        for section in mission_net.graph.sections if self.probability else ():
            self._used.update(dict.fromkeys((o.name for o in section.walk()), parts.alone(section).used))

    def started(self, inside: Inside, actions: Iterable[Action]) -> tuple[StartDemand, ...]:
        """What is asked after an event, in order.

        Args:
            inside: What runs then.
            actions: What the controller has ordered.
        """
        if not self.probability or not inside.objectives:
            return ()
        used, found = self._used[inside.objectives[0]], list[StartDemand]()
        for action in actions:
            activity, alternative = action.activity, action.alternative
            if activity is not None and alternative is not None:
                number, consumed = self._ways[activity, alternative]
                found += (
                    StartDemand((used.number[k], used.task[activity], number), activity, alternative, k)
                    for k in consumed
                )
        return tuple(sorted(found))

    def following(
        self, failed: StartDemand, rest: Sequence[StartDemand], inside: Inside, actions: Iterable[Action]
    ) -> tuple[StartDemand, ...]:
        """What is still asked, and what is asked besides, after something has failed on demand.

        Args:
            failed: What has failed.
            rest: What was to be asked after it.
            inside: What runs then.
            actions: What the controller has ordered.
        """
        still = {
            demand
            for demand in rest
            if demand.hardware != failed.hardware and inside.mode.get(demand.activity) == demand.alternative
        }
        return tuple(sorted(still.union(self.started(inside, actions))))

    def ends(self, section: TableSection, at: Move, asked: Sequence[StartDemand]) -> Iterator[Move]:
        """The states of a section that are possible when some hardware has been asked.

        Args:
            section: The section.
            at: Where it is before.
            asked: What is asked, in order.
        """
        if not asked:
            yield at
            return
        first, rest = asked[0], asked[1:]
        if self.probability[first.hardware] < 1:
            yield from self.ends(section, at, rest)
        step = section.move(at[0], first.event, at[1])
        if step is None:  # it is lost already, and that not known yet
            yield from self.ends(section, at, rest) if self.probability[first.hardware] == 1 else ()
            return
        assert not isinstance(step[0], str), "hardware that fails ends no section"
        lost = step[0], (at[1] | step[2]) - step[3]
        yield from self.ends(section, lost, self.following(first, rest, section.state(step[0]), step[1]))


@dataclass(eq=False)
class ControllerPlace:
    """Where a controller is, its timers aside.

    Args:
        saved: What the runtime goes back to.
        section: The section that runs, and the number of its state.
        inside: What runs.
        gone: Hardware out of service.
        true: Handlers that happen once and have, and what is true of facts.
        outcome: How the mission has ended.
        possible: The events that can be taken.
        edges: Where events lead, and the actions, as far as they have been asked.
    """

    saved: Saved
    section: tuple[str, int] | None
    inside: Inside
    gone: frozenset[str]
    true: frozenset[str]
    outcome: str | None
    possible: tuple[str, ...]
    edges: dict[str, tuple[ControllerPlace, tuple[Action, ...]]] = field(default_factory=dict)

    @property
    def seen(self) -> tuple[tuple[str, ...], tuple[tuple[str, str], ...]]:
        """Objectives that run, and the functioning mode."""
        return self.inside.objectives, tuple(sorted(self.inside.mode.items()))


class Places:
    """The places of one controller, as far as they have been reached.

    Args:
        tables: The controller's.
    """

    def __init__(self, tables: Tables) -> None:
        self.tables = tables
        self._controller = Controller(tables, log=1, clock=lambda: 0.0)
        self._known: dict[Hashable, ControllerPlace] = {}
        self.start = self._here()

    def __iter__(self) -> Iterator[ControllerPlace]:
        return iter(list(self._known.values()))

    def after(self, place: ControllerPlace, event: str) -> tuple[ControllerPlace, tuple[Action, ...]] | None:
        """Where an event leads, and the actions; ``None`` where the controller refuses it."""
        if event not in place.edges:
            if event not in place.possible:
                return None
            self._controller.resume(place.saved)
            actions, _ = self._controller.react(event)
            place.edges[event] = self._here(), actions
        return place.edges[event]

    def _here(self) -> ControllerPlace:
        controller = self._controller
        controller.count = 0  # the same place is the same one, however a run reached it
        saved = controller.saved()
        name = None if saved.section is None else saved.section.name
        gone, true = frozenset(saved.out_of_service), frozenset(saved.true)
        key = saved.phase, name, saved.state, gone, true, tuple(sorted(saved.timers.items()))
        if key not in self._known:
            where = controller.where
            section = None if where.section is None else (where.section, where.state)
            self._known[key] = ControllerPlace(
                saved,
                section,
                where.inside,
                gone,
                true,
                controller.outcome,
                controller.possible,
            )
        return self._known[key]


# --- A robot and its world as fake drivers: what may happen where the controller is, and how soon ---------
#
# The model is that of the numbers of risk (:mod:`mcpn.answers.causes.risk`), played instead of solved, and
# played on the controller instead of the net: exponential durations, failures and repairs; hardware that
# fails as an alternative starts; an objective whose present run cannot succeed any more fails at once. The
# world knows of each loss: one that is detected late is drawn as any other, and told to the controller, which
# changes no mode; its detection is drawn at its rate; and an objective that uses what is lost ends in
# failure. Timers, which numbers of risk do not know, run out in virtual time. Each place of the controller
# and what each event does there are asked of the runtime once.

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
