"""Losing regions and cut sets on decision diagrams, where states are too many to be listed.

The regions of :mod:`mcpn.check.losing` by backward saturation on the markings graph. Cut sets follow from one
more pair of explorations: hardware may *die* while it is out of service before the mission begins, and what
has died is not repaired. Which sets may die without losing the goal is then read off the diagram, the minimal
ones by their size; no set is tried on its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property

from mcpn._kernel import Zdd
from mcpn.check.ctl import SymbolicMarkings
from mcpn.check.cutsets import CutSet
from mcpn.net.compose import MissionNet
from mcpn.net.events import START, Event, What
from mcpn.net.petri import PetriNet, Place, Transition
from mcpn.space.symbolic import SymbolicSpace, reach


class SymbolicOutlook:
    """What the markings of a mission say of its chances.

    Args:
        mission_net: The mission's net.
        space: Its reachable markings.
    """

    def __init__(self, mission_net: MissionNet, space: SymbolicSpace) -> None:
        self.mission_net = mission_net
        self.space = space
        self.graph = SymbolicMarkings(space)
        self.net = space.encoding.net
        self.hardware = tuple(h.name for h in mission_net.mission.hardware if h.faulty)

    def marked(self, *places: int) -> Zdd:
        """Reachable markings that mark some places."""
        return self.space.encoding.marking_all(places, self.space.reachable)

    def of_events(self, events: Iterable[Event]) -> list[int]:
        """Transitions that carry one of these events."""
        wanted = set(events)
        return [t for t, transition in enumerate(self.net.transitions) if transition.event in wanted]

    @cached_property
    def repairs(self) -> frozenset[int]:
        """Transitions that repair hardware."""
        return frozenset(self.of_events(Event(What.REPAIRED, h) for h in self.hardware))

    def reaching(self, along: Zdd, goal: Zdd, without: Iterable[int] = ()) -> Zdd:
        """Markings from which a run reaches a goal.

        Args:
            along: Markings that the run may pass.
            goal: Where it leads.
            without: Transitions that it may not take.
        """
        graph, refused = copy(self.graph), set(without)
        graph.anywhere = [t for t in graph.anywhere if t not in refused]
        graph.stable_only = [t for t in graph.stable_only if t not in refused]
        return graph.until(along, goal)

    def losing(self, repairs: bool) -> Zdd:
        """Markings from which the mission can no longer succeed.

        Args:
            repairs: Whether hardware may be repaired.
        """
        everything, success = self.space.reachable, self.marked(self.mission_net.success)
        return everything - self.reaching(everything, success, () if repairs else self.repairs)

    def losing_objective(self, name: str, repairs: bool) -> Zdd:
        """Markings in which an objective runs and can no longer succeed in its present run.

        Args:
            name: The elementary objective's name.
            repairs: Whether hardware may be repaired.
        """
        (place,) = self.mission_net.by_role["objective", name]
        running = self.marked(place)
        succeeds = self.of_events([Event(What.SUCCESS, name)])
        ends = {*succeeds, *self.of_events([Event(What.FAILURE, name)])}
        won = self.graph.enabling(succeeds)
        return running - self.reaching(running, won, ends if repairs else ends | self.repairs)

    def critical(self, losing: Zdd, running: Zdd, repairs: bool) -> dict[Event, int]:
        """Critical events, and in how many stable markings each leads from a chance to none.

        Args:
            losing: The losing region.
            running: Where the goal is open.
            repairs: Whether hardware may be repaired.
        """
        found: dict[Event, int] = {}
        chance = running - losing
        for t in self.graph.stable_only:
            if repairs or t not in self.repairs:
                number = (self.graph.before(losing, [t]) & chance).count()
                if number:
                    event = self.net.transitions[t].event
                    assert event is not None, "only events wait for stable markings"
                    found[event] = found.get(event, 0) + number
        return found


def symbolic_cut_sets(
    mission_net: MissionNet, objectives: Sequence[str] = ()
) -> tuple[list[CutSet], dict[str, list[CutSet]]]:
    """Minimal cut sets at the start of the mission, on the markings of the mission with mortal hardware.

    Args:
        mission_net: The mission's net.
        objectives: Elementary objectives to look at besides.

    Returns:
        The mission's cut sets, and those of each objective: sets with which it never succeeds.

    Raises:
        LimitError: No diagram stays within memory.
    """
    mortal = _Mortal(mission_net)
    outlook = mortal.outlook
    everything = outlook.space.reachable
    mission = mortal.minimal(outlook.reaching(everything, outlook.marked(mission_net.success)))
    ever = {}
    for name in objectives:
        won = outlook.graph.enabling(outlook.of_events([Event(What.SUCCESS, name)]))
        ever[name] = mortal.minimal(outlook.reaching(everything, won))
    return mission, ever


class _Mortal:
    """A mission whose hardware may die before it begins: a place ``alive`` for each resource is given up.

    Args:
        mission_net: The mission's net.
    """

    def __init__(self, mission_net: MissionNet) -> None:
        net, hardware = mission_net.net, [h.name for h in mission_net.mission.hardware if h.faulty]
        first = len(net.places)
        self.alive = {name: first + i for i, name in enumerate(hardware)}
        self.oos = {name: mission_net.by_role["oos", name][0] for name in hardware}
        begins = [t for t in net.transitions if t.event == START]
        begin = [p for t in begins for p, _ in t.consume]
        places = [*net.places, *(Place(f"{name}_alive", 1) for name in hardware)]
        transitions = [self._needs_life(t) for t in net.transitions]
        for name in hardware:
            reads = tuple(sorted((p, 1) for p in (self.oos[name], *begin)))
            death = Event.parse(f"{name}_EV_DEATH")
            transitions.append(Transition(str(death), ((self.alive[name], 1),), (), reads, death))
        augmented = PetriNet(net.name, tuple(places), tuple(transitions), True, net.units)
        self.outlook = SymbolicOutlook(replace(mission_net, net=augmented), reach(augmented))
        self.begin = begin

    def _needs_life(self, transition: Transition) -> Transition:
        """A repair reads that the resource is alive."""
        event = transition.event
        if event is None or event.what is not What.REPAIRED or event.element not in self.alive:
            return transition
        return replace(transition, read=(*transition.read, (self.alive[event.element], 1)))

    def minimal(self, hopeful: Zdd) -> list[CutSet]:
        """Minimal sets that are dead, all else in service, at the begin and outside a set of markings."""
        encoding, stable = self.outlook.space.encoding, self.outlook.space.stable
        assert stable is not None, "nets of missions have priorities"
        lost = (self.outlook.marked(*self.begin) & stable) - hopeful
        spared = [encoding.condition([self.oos[h], self.alive[h]]) for h in self.alive]
        lost = lost.without([c for c in spared if c is not None])
        weights, constant = encoding.weigh(dict.fromkeys(self.alive.values(), 1))
        found: list[CutSet] = []
        for size in range(len(self.alive) + 1):
            living = len(self.alive) - size - constant
            for marking in lost.weighing(weights, living, living):
                marked = {encoding.places[level] for level in marking}
                marked |= {p for p, kept in encoding.partner.items() if kept not in marked}
                found.append(tuple(sorted(h for h, place in self.alive.items() if place not in marked)))
            above = [encoding.condition([], [self.alive[h] for h in names]) for names in found]
            lost = lost.without([c for c in above if c is not None])
        return sorted(found, key=lambda names: (len(names), names))
