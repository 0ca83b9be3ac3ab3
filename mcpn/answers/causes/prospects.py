"""What a mission that has begun may still reach: goals, losing regions, what leads there, runs that show it.

Source: the paper, 7.2 ("studying the resource events that force the mission into a branch leading to
failure"). A state *loses* a goal where no run reaches it any more; without repairs, where no run without an
event ``EV_RD`` does. The goal of the mission is its success; the goal of an objective is that its present run
ends in success, so that a later retry is another run, and one after an interruption too.

A shortest run may lose hardware anywhere before it is missed, mostly before the mission starts. A run that is
shown has its losses where they strike: after the start, while the hardware is in use.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Hashable, Iterable, Iterator, Mapping, Set
from copy import copy
from dataclasses import field, replace
from functools import cached_property, reduce
from itertools import chain, product
from operator import or_
from typing import Any, Generic, Literal, Self, TypeAlias

from mcpn.answers.reentry import Reentry
from mcpn.answers.verdicts.modes import Mode, Situation, said_by, situation
from mcpn.answers.verdicts.unsafe_abort import Aborts, aborts
from mcpn.drawing.compose import MissionNet
from mcpn.events import ENDING, HELPING, Event, What
from mcpn.mission.core.objectives_graph import ElementarySection, ObjectivesGraph, Section
from mcpn.mission.static.handover import entries
from mcpn.nets.petri import Marking
from mcpn.records import record
from mcpn.spaces.algebra import Alike, Edge, Piece, S, Space, Without, partition
from mcpn.spaces.memoized import memoized
from mcpn.spaces.projections import ImageStore
from mcpn.spaces.run import Completion, Evolution, Run, transitions_of

_PASSED = (What.START, What.SUCCESS)
"""Events past which a loss may be put off: of others it may be the reason, or they are losses themselves."""

Step: TypeAlias = tuple[int, ...]
"""An event of a run, and the internal transitions that fire after it."""


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
        net = self.mission_net.net
        evolution, steps = Evolution(self._completion, list(net.initial)), list[Step]()
        for _ in evolution.settle():
            pass
        for t in (t for t in run.transitions if net.event(t) is not None):
            evolution.fire(t)
            steps.append((t, *evolution.settle()))
        before = evolution.marking
        for place in reversed(range(len(steps))):
            for t in reversed(steps[place]):
                net.undo_in_place(before, t)
            if self._event(steps[place][0]).what is What.OUT_OF_SERVICE:
                self._put_off(steps, tuple(before), place)
        return replace(run, transitions=tuple(t for t, *_ in steps))

    def _put_off(self, steps: list[Step], before: Marking, place: int) -> None:
        """Puts one loss off, in place.

        Args:
            steps: Those of the run.
            before: The stable marking before the loss.
            place: Where the loss stands.
        """
        now, after, swapped = place, self._played(before, steps[place]), list[tuple[Step, Step]]()
        while now + 1 < len(steps) and not self._strikes(before, after):
            (lost, *_), (next_, *_) = earlier, later = steps[now], steps[now + 1]
            passed = self._event(next_)
            first = self._fired(before, next_) if passed.what in _PASSED else None
            if first is None or self._ended(first[1]):
                break
            second = self._fired(first[1], lost)
            if second is None or second[1] != self._played(after, later):
                break
            swapped.append((earlier, later))
            (steps[now], before), (steps[now + 1], after) = first, second
            if passed.what is What.START or self._strikes(before, after):
                swapped.clear()  # here it may stay
            now += 1
        for number, pair in enumerate(reversed(swapped), 1):
            steps[now - number : now - number + 2] = pair

    def _played(self, marking: Marking, step: Step) -> Marking:
        """The marking after a step from one in which it can be taken."""
        changing = list(marking)
        for t in step:
            self.mission_net.net.fire_in_place(changing, t)
        return tuple(changing)

    def _event(self, transition: int) -> Event:
        event = self.mission_net.net.event(transition)
        assert event is not None, "internal firings are left out"
        return event

    def _strikes(self, before: Marking, after: Marking) -> bool:
        """Whether what runs, waits or has no way to run changes."""
        return self._doing(before) != self._doing(after)

    def _doing(self, marking: Marking) -> Situation:
        return replace(situation(self.mission_net, marking), out_of_service=(), unnoticed=())

    def _fired(self, marking: Marking, transition: int) -> tuple[Step, Marking] | None:
        """The event of a transition by one that is enabled, and what follows; ``None`` where none is."""
        t = self._completion.of_event(marking, self._event(transition))
        if t is None:
            return None
        internal, after = self._completion.after(marking, t)
        return (t, *internal), after

    def _ended(self, marking: Marking) -> bool:
        return any(marking[place] for place in self.mission_net.ends.values())


Kind: TypeAlias = Literal["objective", "pending", "done", "oos", "alive", "dead"]


@record(frozen=True, eq=False)
class Goal(Generic[S]):
    """Something that a mission may still reach.

    Args:
        name: Of the mission, or of the objective.
        running: States in which it is not decided yet; runs to it pass no others.
        won: States in which it is reached, or in which the event that reaches it may happen.
        ends: Transitions that end the present run, which no run to it takes.
        ends_from: By transition that ends it from some states alone, these states.
        lost_by: By transition that loses it at once from some states, these states.
    """

    name: str
    running: S
    won: S
    ends: frozenset[int] = frozenset()
    ends_from: Mapping[int, S] = field(default_factory=dict)
    lost_by: Mapping[int, S] = field(default_factory=dict)


@record(frozen=True)
class CriticalEvent:
    """How many edges of one event lead into a losing region from one functioning mode.

    Args:
        event: The event.
        objectives: Objectives that run before it, in the mission's order.
        mode: The alternatives, before it, of the activities that the event concerns.
        edges: How many edges of the alternatives graph.
    """

    event: Event
    objectives: tuple[str, ...]
    mode: Mode
    edges: int

    def named(self, names: Mapping[str, str]) -> CriticalEvent:
        """A copy with other names of objectives."""
        event = self.event
        if event.what in ENDING:
            event = event.of(names.get(event.element, event.element))
        return CriticalEvent(event, tuple(names[n] for n in self.objectives), self.mode, self.edges)


Counted: TypeAlias = Mapping[tuple[tuple[str, ...], tuple[tuple[str, str], ...]], int]
"""The number of states, by the objectives that run and the functioning mode."""


class Prospects(Generic[S]):
    """What a mission may still reach in a space of its stable states.

    Args:
        mission_net: The mission's net, that of the space.
        space: Its alternatives graph.
        max_states: The user's limit on states of its chains; ``None`` for that of each question. An
            attribute, too.

    Attributes:
        hardware: The hardware that can fail, in the mission's order.
        sections: The elementary objectives by name, in the mission's order.
        failing: Transitions by which hardware goes out of service.
        dying: Those by which it is lost for good, in a space whose hardware may die.
        everything: All transitions that carry an event, but for ``dying``.
        unrepaired: Those of ``everything`` that repair nothing.
    """

    def __init__(self, mission_net: MissionNet, space: Space[S], max_states: int | None = None) -> None:
        self.mission_net = mission_net
        self.space = space
        self.max_states = max_states
        self.hardware = tuple(
            h.name for h in mission_net.core.hardware if ("oos", h.name) in mission_net.by_role
        )
        self.sections = {section.name: section for section in mission_net.graph.walk()}
        self.events = mission_net.net.events
        self.failing = frozenset(self.events.carrying(What.OUT_OF_SERVICE))
        self.dying = frozenset(self.events.carrying(What.LOST))
        self.everything = frozenset(t for t, _ in self.events.pairs) - self.dying
        self.unrepaired = self.everything.difference(self.events.carrying(What.REPAIRED))
        self._striking = Striking(mission_net)
        self._alike: Alike[Counted] = Alike()
        self._critical: Alike[list[CriticalEvent]] = Alike()

    @cached_property
    def _images(self) -> ImageStore:
        """For images of states on places that say something; checks need none."""
        return ImageStore(len(self.mission_net.roles))

    def within(self, max_states: int | None) -> Self:
        """The same, with another limit on states of its chains."""
        other = copy(self)
        other.max_states = max_states
        return other

    def carrying(self, what: What, element: str = "", reason: str | None = None) -> frozenset[int]:
        """Transitions that carry an event; a failure for any reason or none, unless one is said."""
        events = self.events
        own = events.of_element(what, element) if reason is None else events.of(Event(what, element, reason))
        return frozenset(own)

    def places(self, kind: Kind, names: Iterable[str]) -> list[int]:
        """Places that say something of some elements."""
        return [p for name in names for p in self.mission_net.by_role.get((kind, name), ())]

    @cached_property
    def mission(self) -> Goal[S]:
        """Success of the mission."""
        won = self.space.marked([self.mission_net.success])
        return Goal(self.mission_net.core.name, self.space.everything - won, won)

    @cached_property
    def safety(self) -> Goal[S] | None:
        """A safe end of the mission, success or abort; ``None`` of a mission that cannot abort.

        An abort by the failure of a safing objective is none. So the goal is reached in states
        in which another event may lead to abort.
        """
        space, found, name = self.space, self.aborts, self.mission_net.core.name
        if found is None or self.mission_net.abort is None:
            return None
        success = space.marked([self.mission_net.success])
        ended = success | space.marked([self.mission_net.abort])
        running = space.everything - ended
        if not found.unsafe:
            return Goal(name, running, ended)
        won = reduce(or_, found.well.values(), success)
        return Goal(name, running, won, ends_from=found.well, lost_by=found.badly)

    @cached_property
    def aborts(self) -> Aborts[S] | None:
        """How the mission reaches its abort; ``None`` of a mission that cannot abort."""
        return None if self.mission_net.abort is None else aborts(self.mission_net, self.space)

    @cached_property
    def objectives(self) -> Mapping[str, Goal[S]]:
        """Success of each elementary objective in its present run, by its name, in the mission's order."""
        # A declared event, or the end of a block's time, stops an objective if it takes its place, or that of
        # a block around it.
        net, taking = self.mission_net.net, defaultdict[str, set[int]](set)
        for t in self.events.carrying(*HELPING):
            origins = (net.origin(place) for place, _ in net.arcs(t)[0])
            for origin in origins:
                if origin is not None and origin.kind in ("objective", "parallel"):
                    taking[origin.name].add(t)
        stopping = {name: set[int]() for name in self.sections}
        for section in self.mission_net.graph.all_sections() if taking else ():
            for inner in section.walk():
                stopping[inner.name] |= taking[section.name]
        return {name: self._objective(name, interrupting) for name, interrupting in stopping.items()}

    def _objective(self, name: str, interrupting: set[int]) -> Goal[S]:
        running = self.space.marked(self.places("objective", [name]))
        won = self.space.enabling(self.carrying(What.SUCCESS, name)) & running if running else running
        ends = frozenset().union(*(self.carrying(what, name) for what in ENDING))
        return Goal(name, running, won, ends | interrupting, self.reentry.ending(name, running))

    @cached_property
    def reentry(self) -> Reentry[S]:
        """Edges with which a block that runs is entered again."""
        return Reentry(self.mission_net, self.space)

    @cached_property
    def sound(self) -> S:
        """States in which no hardware is out of service."""
        return self.space.restricted(self.space.everything, (), self.places("oos", self.hardware))

    @cached_property
    def begun(self) -> S:
        """States in which the mission has begun."""
        return self.space.everything - self.space.marked([self.mission_net.beginning])

    @memoized
    def entered(self, section: Section) -> S:
        """States just after the entry of a section, closed under hardware failures that come at once."""
        space, first = self.space, [inner.name for inner in entries(section)]
        running = inside = space.marked([*self.places("objective", first), *self.places("pending", first)])
        before, again = space.before(inside, self.everything), space.nothing
        if isinstance(section, ElementarySection):
            # A retry ends one run and begins the next with one event.
            again = space.after(before & inside, self.objectives[section.name].ends)
            again = again | self.reentry.entered(section, inside)
        else:
            names = [*(b.name for b in section.branches), *(inner.name for inner in section.walk())]
            kinds: tuple[Kind, ...] = ("objective", "pending", "done")
            running = running | space.marked([p for kind in kinds for p in self.places(kind, names)])
            again = self.reentry.entered(section, running)
        entry = (space.after(before - running, self.everything) | again) & inside
        return space.reached(entry, transitions=self.failing | self.dying)

    def allowed(self, goal: Goal[S], *, repairs: bool) -> Set[int]:
        """What the edges of a run to a goal may carry."""
        return Without(self.everything if repairs else self.unrepaired, goal.ends)

    @memoized
    def hopeful(self, goal: Goal[S], *, repairs: bool) -> S:
        """States from which a goal can be reached; where repairs are allowed, of hardware that is alive."""
        allowed, ends = self.allowed(goal, repairs=repairs), goal.ends_from.items()
        guards = {t: self.space.everything - states for t, states in ends}
        return self.space.reaching(goal.won, goal.running, allowed, guards or None)

    def losing(self, goal: Goal[S], *, repairs: bool) -> S:
        """States in which a goal is still open and can no longer be reached."""
        return goal.running - self.hopeful(goal, repairs=repairs)

    @cached_property
    def forced(self) -> Mapping[int, S]:
        """By transition with which an objective fails or times out, states in which it can only fail.

        As guards they leave runs in which objectives fail only where the lost hardware makes them fail. The
        time of a block is over only where something that runs in it can only fail.
        """
        found = {
            t: self.losing(goal, repairs=False)
            for name, goal in self.objectives.items()
            for what in (What.FAILURE, What.TIMEOUT)
            for t in self.carrying(what, name)
        }
        for block in self.mission_net.graph.timed_blocks():
            losing = (self.losing(self.objectives[name], repairs=False) for name in block.held)
            late = self.carrying(What.TIMEOUT, block.name)
            found |= dict.fromkeys(late, reduce(or_, losing, self.space.nothing))
        return found

    def alike(self, goal: Goal[S], *states: S) -> tuple[Hashable, tuple[str, ...]] | None:
        """A key of a goal and of some states in which it is open, which does not depend on names.

        Returns:
            The key, equal for goals whose runs pass alike pieces of the space, and the objectives of these
            pieces with their timed blocks; ``None`` where nothing is known to be alike.
        """
        pieces = [list(self.space.pieces(some)) for some in (goal.running, *states)]
        if len(pieces[0]) != 1 or goal.name not in pieces[0][0].names or pieces[0][0].kind is None:
            return None
        names = self.ending_in(pieces[0][0])
        return (names.index(goal.name), *(tuple(piece.kind for piece in some) for some in pieces)), names

    def critical(self, goal: Goal[S], *, repairs: bool) -> list[CriticalEvent]:
        """Edges from a chance to reach a goal to none, in the order of the net's transitions."""
        known = self.alike(goal)
        if known is None:
            return self._critical_of(goal, repairs)
        kind, own = known
        found, names = self._critical.known((kind, repairs), own, lambda: self._critical_of(goal, repairs))
        return [critical.named(names) for critical in found]

    def _critical_of(self, goal: Goal[S], repairs: bool) -> list[CriticalEvent]:
        losing, allowed = self.losing(goal, repairs=repairs), self.allowed(goal, repairs=repairs)
        found: Counter[tuple[Event, tuple[str, ...], tuple[tuple[str, str], ...]]] = Counter()
        hopeful = goal.running - losing
        crossing = self.space.crossing(hopeful, losing) if losing else ()
        at_once = ((t, states & hopeful) for t, states in goal.lost_by.items())
        for t, states in chain(crossing, at_once):
            event = self.mission_net.net.event(t)
            if event is None or t not in allowed:
                continue
            if t in goal.ends_from and not (states := states - goal.ends_from[t]):
                continue
            for piece in self.space.pieces(states):
                for (objectives, mode), count in self._counted(event, piece).items():
                    found[event, objectives, mode] += count
        return [CriticalEvent(event, names, dict(mode), n) for (event, names, mode), n in found.items()]

    def _counted(self, event: Event, piece: Piece[S]) -> Counted:
        """States before an event by the objectives that run and the mode; found once for alike pieces."""

        def compute() -> Counted:
            concerned, counts = self._concerned(event), dict[tuple[Any, Any], int]()
            roles = {p: self.mission_net.roles.get(p, ("", "")) for p in self.space.varying(piece.states)}
            telling = sorted(
                place
                for place, (kind, name) in roles.items()
                if kind == "objective" or (kind == "active" and name.split(".", 1)[0] in concerned)
            )
            for marked, part in partition(self.space, piece.states, telling, self._images):
                said = said_by(self.mission_net, sorted(marked))
                counts[said.objectives, tuple(said.mode.items())] = part.count()
            return counts

        if piece.kind is None:
            return compute()
        own = self.ending_in(piece)
        element = own.index(event.element) if event.what in ENDING else event.element
        found, names = self._alike.known((event.what, event.reason, element, piece.kind), own, compute)
        return {(tuple(names[n] for n in running), mode): count for (running, mode), count in found.items()}

    def ending_in(self, piece: Piece[S]) -> tuple[str, ...]:
        """What may end in a piece: its objectives, then blocks whose time may be over."""
        return (*piece.names, *(block for name in piece.names[:1] for block in self._timed_beside[name]))

    @cached_property
    def _timed_beside(self) -> Mapping[str, tuple[str, ...]]:
        """By objective the blocks of its section whose time may be over."""
        found = dict[str, tuple[str, ...]]()
        for section in self.mission_net.graph.sections:
            blocks = tuple(block.name for block in ObjectivesGraph((section,), section.name).timed_blocks())
            found |= dict.fromkeys((objective.name for objective in section.walk()), blocks)
        return found

    @memoized
    def _concerned(self, event: Event) -> set[str]:
        """Activities whose present alternative may influence what an event does.

        If an objective ends: the activities of that objective. If hardware fails or is repaired: activities
        of which one alternative needs the hardware, itself or through its suppliers, and another does not.
        """
        usage, choosing = self.mission_net.usage, set[str]()
        if event.what in ENDING and event.element in self.sections:
            choosing.update(self.sections[event.element].activities)
        if event.what in (What.OUT_OF_SERVICE, What.REPAIRED):
            for name in usage.started:
                ways = [way.consumes for way in usage.activities[name].alternatives]
                standing = {any(event.element in usage.hardware_under(k) for k in way) for way in ways}
                if standing == {False, True}:
                    choosing.add(name)
        return choosing

    # On these runs nothing is repaired, and objectives fail only where they cannot succeed any more.

    def to_failure(self, goal: Goal[S], cut_set: Iterable[str]) -> Run | None:
        """A short run in which a goal fails because of a cut set, and no other hardware fails.

        It leads to the failure of the mission or the objective, with all of the cut set out of service; where
        the mission need not end, to where it can no longer succeed. The cut set is lost before the mission
        ends, each of it where it strikes (:class:`mcpn.answers.causes.prospects.Striking`). Where that
        suffices, no declared event happens and no time is over, since these might defeat the goal by
        themselves. ``None`` where no run leads there.
        """
        space, names = self.space, list(cut_set)
        losses = (self.carrying(What.OUT_OF_SERVICE, name) for name in names)
        transitions = (self.unrepaired - self.failing).union(*losses)
        ended = space.marked(self.mission_net.ends.values())
        ends = [self.losing(goal, repairs=False)]
        whole = goal is self.mission or goal is self.safety
        if whole:
            ends = [ended - goal.won, ends[0] & self.begun]
        oos = self.places("oos", names)
        ends = [space.restricted(end, oos, ()) for end in ends]
        forced, free = (self._onward(goal, guards) for guards in (self.forced, None))
        quiet = transitions.difference(self.events.carrying(*HELPING))
        tries = [(quiet, end, forced) for end in ends]
        tries += [(transitions, end, guards) for end, guards in product(ends, (forced, free))]
        for steps, end, guards in tries:
            run = space.run(space.initial.pick(), end, space.everything - ended, steps, guards)
            if run is not None:
                if not whole:
                    fails = self.carrying(What.FAILURE, goal.name, "")
                    run.append(next(e for e in space.edges(run[-1].target) if e.transition in fails))
                return self._striking.on(self._run(run))
        return None

    def most_failures(self, goal: Goal[S], section: Section | None = None) -> Run | None:
        """A shortest run to an end of the mission among those in which the most resources fail.

        Args:
            goal: Of the mission: its success, or its safe ends.
            section: Counts failures from the entry of this section on, with all hardware in service there; by
                default from the start of the mission.

        Returns:
            The run; ``None`` where none ends so.
        """
        space, oos = self.space, self.places("oos", self.hardware)
        begin, prefix = space.initial.pick(), list[Edge]()
        if section is not None:
            found = space.run(begin, space.restricted(self.entered(section), (), oos))
            if found is None:
                return None
            begin, prefix = found[-1].target if found else begin, found
        here, transitions = space.single(begin), self.unrepaired
        guards = self._onward(goal, self.forced)
        if here & goal.won:
            return self._striking.on(self._run([*prefix, *self._reached(goal, begin)]))
        # Failures after success are no evidence of robustness: only failures before it are counted.
        before = space.reached(here, goal.running, transitions, guards)
        ends = space.after(before, transitions, guards) & goal.won
        if not ends:
            return None
        images = ImageStore(len(oos))
        most = images.sized(space.image(ends, oos, images))
        widest = ends & space.at_most(dict.fromkeys(oos, -1), -most)
        onward = space.run(begin, widest, goal.running, transitions, guards)
        if onward is None:
            return None
        return self._striking.on(self._run([*prefix, *onward, *self._reached(goal, onward[-1].target)]))

    def _onward(self, goal: Goal[S], guards: Mapping[int, S] | None = None) -> Mapping[int, S] | None:
        """Guards of runs on which an abort is none that makes the robot safe, where one may not."""
        if not goal.lost_by:
            return guards
        known = guards or {}
        unsafe = {t: self.space.everything - states for t, states in goal.ends_from.items()}
        return {**known, **{t: known[t] & s if t in known else s for t, s in unsafe.items()}}

    def _reached(self, goal: Goal[S], state: Any) -> Iterator[Edge]:
        """The event that reaches a goal from a state in which it may happen; none where it is reached."""
        here = self.space.single(state)
        if here & goal.running:
            edges = self.space.edges(state)
            yield next(e for e in edges if here & goal.ends_from.get(e.transition, self.space.nothing))

    def _run(self, edges: Iterable[Edge]) -> Run:
        return Run(self.space.net, transitions_of(edges), settles=True)
