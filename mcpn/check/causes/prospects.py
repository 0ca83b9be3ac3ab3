"""What a mission may still reach: goals, losing regions, and the events that lead into them.

Source: the paper, 7.2 ("studying the resource events that force the mission into a branch leading to
failure"). A state *loses* a goal where no run reaches it any more; without repairs, where no run without an
event ``EV_RD`` does. The goal of the mission is its success; the goal of an objective is that its present run
ends in success, so that a later retry is another run, and one after an interruption too.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, Literal, TypeAlias

from mcpn.check.modes import Mode
from mcpn.mission.facts.handover import entries
from mcpn.mission.flatten import ElementarySection, Section
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event, What
from mcpn.space.algebra import Alike, Piece, S, Space, partition
from mcpn.space.images import ImageStore

Kind: TypeAlias = Literal["objective", "pending", "done", "oos", "alive", "dead"]


@dataclass(frozen=True, eq=False)
class Goal(Generic[S]):
    """Something that a mission may still reach.

    Args:
        kind: What is to succeed.
        name: Its name.
        running: States in which it is not decided yet.
        won: States in which it is reached, or in which the event that reaches it may happen.
        along: States that a run to it may pass.
        ends: Transitions that end the present run, which no run to it takes.
    """

    kind: Literal["mission", "objective"]
    name: str
    running: S
    won: S
    along: S
    ends: frozenset[int]


@dataclass(frozen=True)
class CriticalEvent:
    """Edges of one event that lead into a losing region, from one functioning mode.

    Args:
        event: The event.
        objectives: Objectives that run before it, in the mission's order.
        mode: The alternatives, before it, of the activities that the event concerns: those that may use the
            hardware, directly or through others, or those of the objective that ends.
        edges: How many edges of the alternatives graph.
    """

    event: Event
    objectives: tuple[str, ...]
    mode: Mode
    edges: int

    def renamed(self, names: Mapping[str, str]) -> CriticalEvent:
        """The same with other names of objectives."""
        event, ends = self.event, self.event.what in (What.SUCCESS, What.FAILURE)
        event = Event(event.what, names[event.element]) if ends else event
        return CriticalEvent(event, tuple(names[name] for name in self.objectives), self.mode, self.edges)


Counted: TypeAlias = tuple[tuple[str, ...], tuple[str, ...], int]
"""Objectives that run, the mode, and in how many states."""


class Prospects(Generic[S]):
    """What a mission may still reach in a space of its stable states.

    Args:
        mission_net: The mission's net, that of the space.
        space: Its alternatives graph.
    """

    def __init__(self, mission_net: MissionNet, space: Space[S]) -> None:
        self.mission_net = mission_net
        self.space = space
        roles = mission_net.by_role
        self.images = ImageStore(len(roles))
        self._alike: Alike[list[Counted]] = Alike()
        self._entered: dict[str, S] = {}
        self._losing: dict[tuple[str, str, bool], S] = {}
        self.hardware = tuple(h.name for h in mission_net.mission.hardware if ("oos", h.name) in roles)

    # --- transitions by what they say --------------------------------------------------------------------

    @cached_property
    def _by_event(self) -> Mapping[Event, frozenset[int]]:
        found: dict[Event, set[int]] = {}
        for t, transition in enumerate(self.mission_net.net.transitions):
            if transition.event is not None:
                found.setdefault(transition.event, set()).add(t)
        return {event: frozenset(transitions) for event, transitions in found.items()}

    def carrying(self, what: What, element: str = "") -> frozenset[int]:
        """Transitions that carry an event."""
        return self._by_event.get(Event(what, element), frozenset())

    @cached_property
    def _by_what(self) -> Mapping[What, frozenset[int]]:
        found: dict[What, set[int]] = {what: set() for what in What}
        for event, transitions in self._by_event.items():
            found[event.what] |= transitions
        return {what: frozenset(transitions) for what, transitions in found.items()}

    @cached_property
    def everything(self) -> frozenset[int]:
        """Transitions that carry an event, but for hardware that dies."""
        return frozenset(t for of in self._by_event.values() for t in of) - self._by_what[What.LOST]

    @cached_property
    def unrepaired(self) -> frozenset[int]:
        """Those of them that repair nothing."""
        return self.everything - self._by_what[What.REPAIRED]

    @cached_property
    def failing(self) -> frozenset[int]:
        """Those of them by which hardware goes out of service."""
        return self._by_what[What.OUT_OF_SERVICE]

    @cached_property
    def dying(self) -> frozenset[int]:
        """Those by which hardware is lost for good, in a space whose hardware may die."""
        return self._by_what[What.LOST]

    # --- goals -------------------------------------------------------------------------------------------

    def places(self, kind: Kind, names: Iterable[str]) -> list[int]:
        """Places that say something of some elements."""
        return [p for name in names for p in self.mission_net.by_role.get((kind, name), ())]

    @cached_property
    def mission(self) -> Goal[S]:
        """Success of the mission."""
        space, name = self.space, self.mission_net.mission.name
        won = space.marked([self.mission_net.success])
        return Goal("mission", name, space.everything - won, won, space.everything, frozenset())

    @cached_property
    def objectives(self) -> Mapping[str, Goal[S]]:
        """Success of each elementary objective in its present run, by its name, in the mission's order."""
        return {section.name: self._objective(section.name) for section in self.mission_net.graph.walk()}

    def _objective(self, name: str) -> Goal[S]:
        running = self.space.marked(self.places("objective", [name]))
        succeeds = self.carrying(What.SUCCESS, name)
        won = self.space.enabling(succeeds) & running if running else running
        ends = succeeds | self.carrying(What.FAILURE, name) | self._interrupting(name)
        return Goal("objective", name, running, won, running, ends)

    def _interrupting(self, name: str) -> frozenset[int]:
        """Declared events that stop an objective: they take its place, or that of a block around it."""
        if not self._taking:
            return frozenset()
        return frozenset[int]().union(*(self._taking.get(key, ()) for key in self._around[name]))

    @cached_property
    def _taking(self) -> Mapping[tuple[str, str], set[int]]:
        """By objective or parallel block, the transitions of declared events that take a place of it."""
        found: dict[tuple[str, str], set[int]] = {}
        net = self.mission_net.net
        for t in self._by_what[What.DECLARED]:
            for place, _ in net.transitions[t].consume:
                origin = net.places[place].provenance
                if origin is not None:
                    found.setdefault((origin.kind, origin.name), set()).add(t)
        return found

    @cached_property
    def _around(self) -> Mapping[str, tuple[tuple[str, str], ...]]:
        """By objective, itself and the parallel blocks around it."""
        found: dict[str, tuple[tuple[str, str], ...]] = {}
        stack: list[tuple[Section, tuple[tuple[str, str], ...]]]
        stack = [(section, ()) for section in self.mission_net.graph.sections]
        while stack:
            section, blocks = stack.pop()
            if isinstance(section, ElementarySection):
                found[section.name] = (("objective", section.name), *blocks)
                continue
            blocks = (("parallel", section.name), *blocks)
            stack.extend((inner, blocks) for branch in section.branches for inner in branch.graph.sections)
        return found

    @cached_property
    def begun(self) -> S:
        """States in which the mission has begun."""
        return self.space.everything - self.space.marked([self.mission_net.beginning])

    def entered(self, section: Section) -> S:
        """States at the entry of a section: just entered, or so but for failures that came at once."""
        if section.name not in self._entered:
            self._entered[section.name] = self._entering(section)
        return self._entered[section.name]

    def _entering(self, section: Section) -> S:
        space = self.space
        first = [inner.name for inner in entries(section)]
        inside = space.marked([*self.places("objective", first), *self.places("pending", first)])
        running, again = inside, frozenset[int]()
        if isinstance(section, ElementarySection):
            # A retry ends one run and begins the next with one event.
            again = self.objectives[section.name].ends
        else:
            names = [n for b in section.branches for n in (b.name, *(s.name for s in b.graph.walk()))]
            kinds: tuple[Kind, ...] = ("objective", "pending", "done")
            places = [p for kind in kinds for p in self.places(kind, names)]
            running = running | space.marked(places)
        before = space.before(inside, self.everything)
        entry = space.after(before - running, self.everything) & inside
        if again:
            entry = entry | (space.after(before & running, again) & inside)
        return space.reached(entry, transitions=self.failing | self.dying)

    # --- losing regions ------------------------------------------------------------------------------------

    def allowed(self, goal: Goal[S], *, repairs: bool) -> frozenset[int]:
        """What the edges of a run to a goal may carry."""
        return (self.everything if repairs else self.unrepaired) - goal.ends

    def hopeful(self, goal: Goal[S], *, repairs: bool = True) -> S:
        """States from which a goal can be reached; where repairs are allowed, of hardware that is alive."""
        transitions = self.allowed(goal, repairs=repairs)
        return self.space.reaching(goal.won, goal.along, transitions)

    def losing(self, goal: Goal[S], *, repairs: bool) -> S:
        """States in which a goal is still open and can no longer be reached."""
        known = self._losing.get((goal.name, goal.kind, repairs))
        if known is None:
            known = goal.running - self.hopeful(goal, repairs=repairs)
            self._losing[goal.name, goal.kind, repairs] = known
        return known

    @cached_property
    def forced(self) -> Mapping[int, S]:
        """By transition with which an objective fails, the states in which it cannot succeed any more.

        As guards they leave runs in which objectives fail only where they must; what happens in them is what
        the lost hardware makes happen.
        """
        return {
            t: self.losing(goal, repairs=False)
            for name, goal in self.objectives.items()
            for t in self.carrying(What.FAILURE, name)
        }

    # --- critical events -----------------------------------------------------------------------------------

    def critical(self, goal: Goal[S], *, repairs: bool) -> list[CriticalEvent]:
        """Edges from a chance to reach a goal to none, by event, running objectives and functioning mode.

        Args:
            goal: What is lost.
            repairs: Whether hardware may be repaired.

        Returns:
            In the order of the net's transitions.
        """
        losing, allowed = self.losing(goal, repairs=repairs), self.allowed(goal, repairs=repairs)
        if not losing:
            return []
        found: dict[tuple[Event, tuple[str, ...], tuple[str, ...]], int] = {}
        for t, states in self.space.crossing(goal.running - losing, losing):
            event = self.mission_net.net.transitions[t].event
            if t not in allowed or event is None:
                continue
            for piece in self.space.pieces(states):
                for objectives, active, count in self._counted(event, piece):
                    key = event, objectives, active
                    found[key] = found.get(key, 0) + count
        return [
            CriticalEvent(event, names, dict(n.split(".", 1) for n in mode), count)
            for (event, names, mode), count in found.items()
        ]

    def _counted(self, event: Event, piece: Piece[S]) -> Iterable[Counted]:
        """Some states before an event by the objectives that run and the mode: each with their number."""

        def compute() -> list[Counted]:
            counts, telling = list[Counted](), self._telling(event, piece.states)
            for marked, part in partition(self.space, piece.states, telling, self.images):
                said = self.said(marked)
                counts.append((said["objective"], said["active"], part.count()))
            return counts

        if piece.kind is None:
            return compute()
        ends = event.what in (What.SUCCESS, What.FAILURE)
        of = piece.names.index(event.element) if ends else event.element
        found, names = self._alike.known((event.what, of, piece.kind), piece.names, compute)
        return ((tuple(names[name] for name in running), mode, count) for running, mode, count in found)

    def said(self, marked: Iterable[int]) -> dict[str, tuple[str, ...]]:
        """What some marked places say: by kind, the elements, in the net's order."""
        found: dict[str, list[str]] = {"objective": [], "active": [], "wait": [], "refused": []}
        for place in sorted(marked):
            kind, name = self.mission_net.roles[place]
            found[kind].append(name)
        found["objective"].sort(key=self._rank.__getitem__)
        return {kind: tuple(names) for kind, names in found.items()}

    @cached_property
    def _rank(self) -> dict[str, int]:
        """Elementary objectives by their place in the mission's order."""
        return {section.name: i for i, section in enumerate(self.mission_net.graph.walk())}

    def _telling(self, event: Event, states: S) -> list[int]:
        """Places that tell objectives, and the alternatives of the activities that an event concerns."""
        wanted = [self._modes[""], *(self._modes.get(name, set()) for name in self.concerned(event))]
        return sorted(set().union(*wanted).intersection(self.space.varying(states)))

    @cached_property
    def _modes(self) -> Mapping[str, set[int]]:
        """By activity, the places of its alternatives; by the empty name those of objectives."""
        found: dict[str, set[int]] = {"": set()}
        for place, (kind, name) in self.mission_net.roles.items():
            if kind in ("objective", "active"):
                of = name.split(".", 1)[0] if kind == "active" else ""
                found.setdefault(of, set()).add(place)
        return found

    def concerned(self, event: Event) -> frozenset[str]:
        """Activities whose choice of alternative matters to an event.

        Those of the objective that ends; or those with an alternative that stands on the hardware, directly
        or through others, and another that does not.
        """
        if event.what in (What.SUCCESS, What.FAILURE):
            return next(
                (frozenset(s.activities) for s in self.mission_net.graph.walk() if s.name == event.element),
                frozenset(),
            )
        if event.what is What.DECLARED:  # it may bear the name of hardware
            return frozenset()
        return self._choosing.get(event.element, frozenset())

    @cached_property
    def _choosing(self) -> Mapping[str, frozenset[str]]:
        """By hardware, the activities of which some but not all alternatives may stand on it."""
        usage = self.mission_net.usage
        found: dict[str, set[str]] = {}
        for name in usage.started:
            alternatives = usage.activities[name].alternatives
            ways = [frozenset().union(*map(usage.hardware_under, a.consumes)) for a in alternatives]
            for hardware in frozenset().union(*ways) - ways[0].intersection(*ways):
                found.setdefault(hardware, set()).add(name)
        return {hardware: frozenset(names) for hardware, names in found.items()}

    @cached_property
    def serving(self) -> Mapping[str, frozenset[str]]:
        """By objective, its activities and all that serve them through resources."""
        usage = self.mission_net.usage
        return {
            section.name: frozenset[str]().union(*(usage.closure(a) for a in section.activities))
            for section in self.mission_net.graph.walk()
        }
