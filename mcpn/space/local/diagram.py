"""Local spaces as decision diagrams: the stable states of one section, where they are too many to list."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

from mcpn._kernel import Zdd
from mcpn.errors import ConfluenceError
from mcpn.net.compose import MissionNet
from mcpn.net.events import START, Event, What
from mcpn.net.sections import LocalPart
from mcpn.space.confluence import open_conflicts
from mcpn.space.encoding import distinct
from mcpn.space.local.interface import Frame, HardwareSpace, HardwareStates
from mcpn.space.local.protocol import Known, Outcome, PremiseError, TornHere, once
from mcpn.space.symbolic import SymbolicSpace, chained, elements


class Undecided(ConfluenceError):
    """What diagrams do not decide: whether a conflict of internal transitions, or a long run, matters."""

    kind = "undecided"


@dataclass(frozen=True, eq=False)
class LocalDiagram:
    """The stable states of one type of sections as a diagram; transient markings beside them.

    Args:
        part: The section that stands for its type.
        net: Its local net.
        space: The net's reachable markings.
    """

    part: LocalPart
    net: MissionNet
    space: SymbolicSpace
    _known: Known = field(default_factory=dict)

    @property
    def faulty(self) -> tuple[str, ...]:
        """Hardware that can fail, by its bit in masks."""
        return self.part.faulty

    @property
    def size(self) -> int:
        """How many stable states there are."""
        return self.stable.count()

    @property
    def stable(self) -> Zdd:
        """Stable markings."""
        assert self.space.stable is not None, "nets of missions have priorities"
        return self.space.stable

    @cached_property
    def before(self) -> Zdd:
        """States before the entry."""
        return self._marking(self.net.beginning)

    @cached_property
    def ended(self) -> Mapping[Outcome, Zdd]:
        """States after the section, by its outcome."""
        return {
            "success": self._marking(self.net.success),
            "failure": self._marking(self.net.failure),
        }

    def _marking(self, place: int) -> Zdd:
        return self.space.encoding.marking_all([place], self.stable)

    @cached_property
    def inside(self) -> Zdd:
        """States of the section itself."""
        return self.stable - self.before - self.ended["success"] - self.ended["failure"]

    @cached_property
    def dead(self) -> Zdd:
        """States without an event."""
        return self.space.dead & self.stable

    # --- hardware ---

    @cached_property
    def _bits(self) -> list[tuple[int, bool]]:
        """By bit, the level that tells whether a resource is out of service, and if it tells the reverse."""
        encoding, found = self.space.encoding, []
        for name in self.faulty:
            (place,) = self.net.by_role["oos", name]
            partner = encoding.partner.get(place)
            found.append((encoding.level[place if partner is None else partner], partner is not None))
        return found

    @once
    def hardware(self, states: Zdd, frame: Frame) -> HardwareStates:
        """Which hardware is out of service in some states, by the names of a section of the type."""
        store = self.space.encoding.store
        takes = [store.event([level], []) for level, _ in self._bits]

        def split(part: Zdd, bit: int) -> tuple[Zdd, Zdd]:
            level, reverse = self._bits[bit]
            unmarked, marked = part.subset(unmarked=[level]), part.images([takes[bit]])
            return (marked, unmarked) if reverse else (unmarked, marked)

        return frame.from_diagram(states.onto(sorted(level for level, _ in self._bits)), split)

    @once
    def with_hardware(self, states: Zdd, hardware: HardwareStates) -> Zdd:
        """Those of some states whose hardware is in one of some states."""
        store, told = self.space.encoding.store, {level for level, _ in self._bits}
        puts = [store.event([], [level]) for level in range(store.levels)]

        def join(up: Zdd, down: Zdd, bit: int) -> Zdd:
            level, reverse = self._bits[bit]
            return up.images([puts[level]]) | down if reverse else up | down.images([puts[level]])

        alike = hardware.built(store.singleton([]), store.empty(), join)
        # Whatever else is marked.
        return states & alike.saturate([put for level, put in enumerate(puts) if level not in told])

    # --- events ---

    @cached_property
    def _by_element(self) -> list[list[int]]:
        """Event transitions but for the start, by the element that they are of."""
        return [of for of in elements(self.space.encoding) if self.net.start not in of]

    @cached_property
    def _every(self) -> list[int]:
        """The same in one list."""
        return [t for of in self._by_element for t in of]

    def _fired(self, before: Zdd, transitions: Iterable[int]) -> Zdd:
        """Markings after one of some events, before any internal firing."""
        events = self.space.encoding.events
        return before.images(distinct(events[t] for t in transitions))

    def _settled(self, after: Zdd) -> Zdd:
        """The stable markings in which internal evolution ends."""
        return after.saturate(self.space.encoding.internal) & self.stable

    def _ending(self, goal: Zdd) -> Zdd:
        """Markings from which internal evolution ends in a goal."""
        return goal.saturate(self.space.encoding.internal_back, within=self.space.reachable)

    def _leading(self, goal: Zdd, transitions: Iterable[int], among: Zdd) -> Zdd:
        """States with an event that ends in a goal."""
        undoing = self.space.encoding.undoing
        return self._ending(goal).images(distinct(undoing[t] for t in transitions), within=among)

    @once
    def begin(self, before: Zdd) -> Zdd:
        """First states inside after the start from states before."""
        return self._settled(self._fired(before, [self.net.start]))

    @once
    def beginnings(self, inside: Zdd) -> Zdd:
        """States before whose start leads into some states inside."""
        return self._leading(inside, [self.net.start], self.before)

    @once
    def reached(self, inside: Zdd) -> Zdd:
        """States inside to which runs inside lead from some, those included."""
        return chained(inside, [partial(self._ahead, transitions=of) for of in self._by_element])

    def _ahead(self, states: Zdd, transitions: Iterable[int]) -> Zdd:
        return self._settled(self._fired(states, transitions)) & self.inside

    @once
    def reaching(self, goal: Zdd) -> Zdd:
        """States inside from which some run through the inside leads to a goal, inside or after."""
        steps = [partial(self._leading, transitions=of, among=self.inside) for of in self._by_element]
        return chained(goal, steps) & self.inside

    @once
    def after(self, inside: Zdd) -> Zdd:
        """States, inside or after the section, one event after states inside."""
        return self._settled(self._fired(inside, self._every))

    def step_into(self, goal: Zdd, among: Zdd) -> tuple[int, Zdd, Zdd] | None:
        """One step from one of some states inside to a goal: a transition, and one state at each end."""
        for transition, before in self.crossing(goal, among):
            source = self.pick(before)
            return transition, source, self.pick(self._settled(self._fired(source, [transition])) & goal)
        return None

    def pick(self, states: Zdd) -> Zdd:
        """A set of one of the states, the same each time."""
        marked = states.pick()
        return states if marked is None else self.space.encoding.store.singleton(marked)

    def crossing(self, goal: Zdd, among: Zdd) -> Iterator[tuple[int, Zdd]]:
        """Event transitions that lead from some states inside to a goal, each with its states before."""
        ending, undoing = self._ending(goal), self.space.encoding.undoing
        ways = ((t, ending.images([undoing[t]], within=among)) for t in self._every)
        return ((transition, before) for transition, before in ways if before)

    # --- what is in them ---

    def grouped(self, states: Zdd, places: Sequence[int]) -> list[tuple[list[int], int]]:
        """How many of some states there are for each way to mark some places, given as those marked."""
        encoding = self.space.encoding
        kept = encoding.telling(places)
        found = []
        for marked in states.onto(kept):
            alike = states.subset(marked=marked, unmarked=[level for level in kept if level not in marked])
            tokens = encoding.marking(marked)
            found.append(([p for p in places if tokens[p]], alike.count()))
        return found

    def edges(self, inside: Zdd) -> int:
        """Number of events, state by state."""
        return sum(self._firings(inside).values())

    def fired(self, inside: Zdd) -> frozenset[int]:
        """Transitions that carry an event in some of the states."""
        return frozenset(t for t, count in self._firings(inside).items() if count)

    def _firings(self, states: Zdd) -> dict[int, int]:
        enabling = self.space.encoding.enabling
        conditions = [(t, c) for t in self._every if (c := enabling[t]) is not None]
        counts = states.counts([c for _, c in conditions])
        return dict(zip([t for t, _ in conditions], counts, strict=True))

    def marks(self, place: int, states: Zdd) -> bool:
        """Whether some of the states mark a place."""
        return bool(self.space.encoding.marking_all([place], states))

    # --- what composition rests on ---

    @cached_property
    def _open(self) -> list[tuple[int, int]]:
        """Internal transitions in conflict that some reachable marking enables both."""
        return list(open_conflicts(self.space))

    def among(self, states: Zdd, marking: Sequence[int]) -> Zdd:
        """A marking, given as tokens by place, as a set of one if it is among some states, else empty."""
        return self.space.encoding.set_of(marking) & states

    def torn(self, inside: Zdd, before: Zdd) -> Iterator[TornHere]:
        """Where diagrams leave confluence or termination open after events in states inside and before."""
        endless = self.space.endless
        if not self._open and not endless:
            return
        begun = self._fired(before, [self.net.start]) | self._fired(inside, self._every)
        transient = begun.saturate(self.space.encoding.internal)
        if transient & endless:
            yield TornHere(inside, None, Undecided("internal runs that need not end"))
        names = self.net.net.transitions
        for first, second in open_conflicts(self.space, transient, self._open):
            found = f"a conflict of {names[first].name} and {names[second].name}"
            yield TornHere(inside, None, Undecided(found))

    def check_premise(self, section: str) -> None:
        """Compares the states after the section with those before it.

        Raises:
            PremiseError: Some place differs.
        """
        encoding = self.space.encoding
        aside = (self.net.beginning, self.net.success, self.net.failure)
        kept = [level for level, place in enumerate(encoding.places) if place not in aside]
        idle = self.before.onto(kept)
        for after in self.ended.values():
            # There is one state before for each state of the hardware: what is none of those differs.
            different = after.onto(kept) - idle
            if different:
                raise PremiseError(section, self._changed(different, idle), [self._run_to(after, different)])

    @cached_property
    def _frame(self) -> Frame:
        """The hardware in the names of the section that stands for its type."""
        return HardwareSpace(self.faulty).frame(self.faulty)

    def _changed(self, different: Zdd, idle: Zdd) -> str:
        """The first place in which one of some markings differs from the idle one of the same hardware."""
        encoding = self.space.encoding
        state = self.pick(different)
        alike = self.with_hardware(idle, self.hardware(state, self._frame))
        marked, idling = set(state.pick() or []), set(alike.pick() or [])
        return self.net.net.places[min(encoding.places[level] for level in marked ^ idling)].name

    def _run_to(self, after: Zdd, different: Zdd) -> list[str]:
        """Events of a shortest run from the start, with some hardware out of service, to such an end."""
        kept = sorted({level for marking in [different.pick()] for level in marking or []})
        layers, goal = [self.begin(self.before)], after.subset(marked=kept)
        seen = layers[0]
        while not (ahead := self.after(layers[-1])) & goal:
            layers.append((ahead & self.inside) - seen)
            seen |= layers[-1]
        run, goal = list[str](), ahead & goal
        for layer in reversed(layers):
            step = self.step_into(goal, layer)
            assert step is not None, "each state of a layer has one before it in the layer before"
            run.append(str(self.net.net.transitions[step[0]].event))
            goal = step[1]
        failed = self.hardware(self.beginnings(goal), self._frame).pick()
        out = [
            str(Event(What.OUT_OF_SERVICE, name)) for bit, name in enumerate(self.faulty) if failed >> bit & 1
        ]
        return [*out, str(START), *reversed(run)]
