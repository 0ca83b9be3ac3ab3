"""What a mission may still reach: goals, losing regions, and the events that lead into them.

Source: the paper, 7.2 ("studying the resource events that force the mission into a branch leading to
failure"). A state *loses* a goal where no run reaches it any more; without repairs, where no run without an
event ``EV_RD`` does. The goal of the mission is its success; the goal of an objective is that its present run
ends in success, so that a later retry is another run, and one after an interruption too.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, Literal, TypeAlias

from mcpn.check.modes import Mode, said_by
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
        name: Of the mission, or of the objective.
        running: States in which it is not decided yet; runs to it pass no others.
        won: States in which it is reached, or in which the event that reaches it may happen.
        ends: Transitions that end the present run, which no run to it takes.
    """

    name: str
    running: S
    won: S
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


Counted: TypeAlias = Mapping[tuple[tuple[str, ...], tuple[tuple[str, str], ...]], int]
"""By objectives that run and functioning mode, in how many states."""


class Prospects(Generic[S]):
    """What a mission may still reach in a space of its stable states.

    Args:
        mission_net: The mission's net, that of the space.
        space: Its alternatives graph.

    Attributes:
        hardware: The hardware that can fail, in the mission's order.
        sections: The elementary objectives by name, in the mission's order.
        failing: Transitions by which hardware goes out of service.
        dying: Those by which it is lost for good, in a space whose hardware may die.
        everything: All that carry an event, but for those.
        unrepaired: Those of them that repair nothing.
    """

    def __init__(self, mission_net: MissionNet, space: Space[S]) -> None:
        self.mission_net = mission_net
        self.space = space
        self.hardware = tuple(
            h.name for h in mission_net.mission.hardware if ("oos", h.name) in mission_net.by_role
        )
        self.sections = {section.name: section for section in mission_net.graph.walk()}
        self._by_event: dict[Event, set[int]] = {}
        by_what: dict[What, set[int]] = {what: set() for what in What}
        for t, transition in enumerate(mission_net.net.transitions):
            if transition.event is not None:
                self._by_event.setdefault(transition.event, set()).add(t)
                by_what[transition.event.what].add(t)
        self.failing = frozenset(by_what[What.OUT_OF_SERVICE])
        self.dying = frozenset(by_what[What.LOST])
        self.everything = frozenset[int]().union(*by_what.values()) - self.dying
        self.unrepaired = self.everything - by_what[What.REPAIRED]
        self._declared = by_what[What.DECLARED]
        self._images = ImageStore(len(mission_net.roles))
        self._alike: Alike[Counted] = Alike()
        self._entered: dict[str, S] = {}
        self._hopeful: dict[tuple[Goal[S], bool], S] = {}

    def carrying(self, what: What, element: str = "") -> frozenset[int]:
        """Transitions that carry an event."""
        return frozenset(self._by_event.get(Event(what, element), ()))

    def places(self, kind: Kind, names: Iterable[str]) -> list[int]:
        """Places that say something of some elements."""
        return [p for name in names for p in self.mission_net.by_role.get((kind, name), ())]

    # --- goals -------------------------------------------------------------------------------------------

    @cached_property
    def mission(self) -> Goal[S]:
        """Success of the mission."""
        won = self.space.marked([self.mission_net.success])
        return Goal(self.mission_net.mission.name, self.space.everything - won, won, frozenset())

    @cached_property
    def objectives(self) -> Mapping[str, Goal[S]]:
        """Success of each elementary objective in its present run, by its name, in the mission's order."""
        return {name: self._objective(name) for name in self.sections}

    def _objective(self, name: str) -> Goal[S]:
        running = self.space.marked(self.places("objective", [name]))
        succeeds = self.carrying(What.SUCCESS, name)
        won = self.space.enabling(succeeds) & running if running else running
        ends = succeeds | self.carrying(What.FAILURE, name) | self._interrupting[name]
        return Goal(name, running, won, ends)

    @cached_property
    def _interrupting(self) -> Mapping[str, set[int]]:
        """By objective, declared events that stop it: they take its place, or that of a block around it."""
        net, taking = self.mission_net.net, dict[tuple[str, str], set[int]]()
        for t in self._declared:
            for place, _ in net.transitions[t].consume:
                if (origin := net.places[place].provenance) is not None:
                    taking.setdefault((origin.kind, origin.name), set()).add(t)
        found: dict[str, set[int]] = {name: set() for name in self.sections}
        for section in self.mission_net.graph.all_sections() if taking else ():
            kind = "objective" if isinstance(section, ElementarySection) else "parallel"
            for inner in section.walk():
                found[inner.name] |= taking.get((kind, section.name), set())
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
        before = space.before(inside, self.everything)
        if isinstance(section, ElementarySection):
            # A retry ends one run and begins the next with one event.
            again = space.after(before & inside, self.objectives[section.name].ends)
            entry = space.after(before - inside, self.everything) | again
        else:
            names = [*(b.name for b in section.branches), *(inner.name for inner in section.walk())]
            kinds: tuple[Kind, ...] = ("objective", "pending", "done")
            running = space.marked([p for kind in kinds for p in self.places(kind, names)])
            entry = space.after(before - inside - running, self.everything)
        return space.reached(entry & inside, transitions=self.failing | self.dying)

    # --- losing regions ------------------------------------------------------------------------------------

    def allowed(self, goal: Goal[S], *, repairs: bool) -> frozenset[int]:
        """What the edges of a run to a goal may carry."""
        return (self.everything if repairs else self.unrepaired) - goal.ends

    def hopeful(self, goal: Goal[S], *, repairs: bool = True) -> S:
        """States from which a goal can be reached; where repairs are allowed, of hardware that is alive."""
        if (goal, repairs) not in self._hopeful:
            transitions = self.allowed(goal, repairs=repairs)
            self._hopeful[goal, repairs] = self.space.reaching(goal.won, goal.running, transitions)
        return self._hopeful[goal, repairs]

    def losing(self, goal: Goal[S], *, repairs: bool) -> S:
        """States in which a goal is still open and can no longer be reached."""
        return goal.running - self.hopeful(goal, repairs=repairs)

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
        found: Counter[tuple[Event, tuple[str, ...], tuple[tuple[str, str], ...]]] = Counter()
        for t, states in self.space.crossing(goal.running - losing, losing):
            event = self.mission_net.net.transitions[t].event
            if event is None or t not in allowed:
                continue
            for piece in self.space.pieces(states):
                for (objectives, mode), count in self._counted(event, piece).items():
                    found[event, objectives, mode] += count
        return [CriticalEvent(event, names, dict(mode), n) for (event, names, mode), n in found.items()]

    def _counted(self, event: Event, piece: Piece[S]) -> Counted:
        """States before an event by the objectives that run and the mode; found once for alike pieces."""

        def compute() -> Counted:
            concerned, counts = {"", *self._concerned(event)}, dict[tuple[Any, Any], int]()
            telling = sorted(p for p in self.space.varying(piece.states) if self._says.get(p) in concerned)
            for marked, part in partition(self.space, piece.states, telling, self._images):
                said = said_by(self.mission_net, sorted(marked))
                counts[said.objectives, tuple(said.mode.items())] = part.count()
            return counts

        if piece.kind is None:
            return compute()
        ends = event.what in (What.SUCCESS, What.FAILURE)
        of = piece.names.index(event.element) if ends else event.element
        found, names = self._alike.known((event.what, of, piece.kind), piece.names, compute)
        return {(tuple(names[n] for n in running), mode): count for (running, mode), count in found.items()}

    @cached_property
    def _says(self) -> Mapping[int, str]:
        """By place of an alternative its activity, by place of an objective nothing."""
        roles = self.mission_net.roles.items()
        says = {p: name.split(".", 1)[0] for p, (kind, name) in roles if kind == "active"}
        return says | {p: "" for p, (kind, _) in roles if kind == "objective"}

    def _concerned(self, event: Event) -> Iterable[str]:
        """Activities whose choice of alternative matters to an event.

        Those of the objective that ends; or those with an alternative that stands on the hardware, directly
        or through others, and another that does not.
        """
        if event.what in (What.SUCCESS, What.FAILURE):
            return self.sections[event.element].activities if event.element in self.sections else ()
        # A declared event may bear the name of hardware.
        return () if event.what is What.DECLARED else self._choosing.get(event.element, ())

    @cached_property
    def _choosing(self) -> Mapping[str, set[str]]:
        """By hardware, the activities of which some but not all alternatives may stand on it."""
        usage = self.mission_net.usage
        found: dict[str, set[str]] = {}
        for name in usage.started:
            alternatives = usage.activities[name].alternatives
            ways = [frozenset().union(*map(usage.hardware_under, a.consumes)) for a in alternatives]
            for hardware in frozenset().union(*ways) - ways[0].intersection(*ways):
                found.setdefault(hardware, set()).add(name)
        return found
