"""Local spaces as decision diagrams: the stable states of one section, where they are too many to list."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial, wraps
from typing import Any, TypeVar, cast

from mcpn_kernel import Zdd

from mcpn.errors import ConfluenceError
from mcpn.net.compose import MissionNet
from mcpn.net.sections import LocalPart
from mcpn.space.confluence import open_conflicts
from mcpn.space.local.interface import Frame, HardwareSpace, HardwareStates
from mcpn.space.local.protocol import Outcome, PremiseError, TornHere
from mcpn.space.symbolic import SymbolicSpace, chained, distinct, elements

Method = TypeVar("Method", bound=Callable[..., Any])


def once(method: Method) -> Method:
    """A method that remembers its results: sections of one type ask their local space the same again."""

    @wraps(method)
    def remembering(self: LocalDiagram, *arguments: Hashable) -> Any:
        key = method.__name__, arguments
        if key not in self._known:
            self._known[key] = method(self, *arguments)
        return self._known[key]

    return cast(Method, remembering)


class Undecided(ConfluenceError):
    """What diagrams do not decide: whether a conflict of internal transitions, or a long run, matters."""


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
    _known: dict[tuple[str, tuple[Hashable, ...]], Any] = field(default_factory=dict)

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

    def marking(self, place: int, among: Zdd) -> Zdd:
        """Those of some markings that mark a place."""
        encoding = self.space.encoding
        return among.subset(encoding.levels([place]), encoding.partners([place]))

    @cached_property
    def before(self) -> Zdd:
        """States before the entry."""
        return self.marking(self.net.beginning, self.stable)

    @cached_property
    def ended(self) -> Mapping[Outcome, Zdd]:
        """States after the section, by its outcome."""
        return {
            "success": self.marking(self.net.success, self.stable),
            "failure": self.marking(self.net.failure, self.stable),
        }

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
    def _internal(self) -> list[int]:
        encoding = self.space.encoding
        return distinct(e for t, e in encoding.events.items() if self._is_internal(t))

    @cached_property
    def _internal_back(self) -> list[int]:
        return distinct(e for t, e in self.space.encoding.undoing.items() if self._is_internal(t))

    def _is_internal(self, transition: int) -> bool:
        return self.net.net.transitions[transition].internal

    @cached_property
    def start(self) -> int:
        """The transition of the section's entry."""
        transitions = self.net.net.transitions
        (start,) = [t for t, of in enumerate(transitions) if of.event == "MISSION_EV_START"]
        return start

    @cached_property
    def _by_element(self) -> list[list[int]]:
        """Event transitions but for the start, by the element that they are of."""
        return [of for of in elements(self.space.encoding) if self.start not in of]

    def _settled(self, after: Zdd) -> Zdd:
        """The stable markings in which internal evolution ends."""
        return after.saturate(self._internal) & self.stable

    def _leading(self, goal: Zdd, transitions: Iterable[int], among: Zdd) -> Zdd:
        """States with an event that ends in a goal."""
        undoing = self.space.encoding.undoing
        ending = goal.saturate(self._internal_back, within=self.space.reachable)
        return ending.images(distinct(undoing[t] for t in transitions), within=among)

    @once
    def begin(self, before: Zdd) -> Zdd:
        """First states inside after the start from states before."""
        return self._settled(before.images([self.space.encoding.events[self.start]]))

    @once
    def beginnings(self, inside: Zdd) -> Zdd:
        """States before whose start leads into some states inside."""
        return self._leading(inside, [self.start], self.before)

    @once
    def reached(self, inside: Zdd) -> Zdd:
        """States inside to which runs inside lead from some, those included."""
        return chained(inside, [partial(self._ahead, transitions=of) for of in self._by_element])

    def _ahead(self, states: Zdd, transitions: Iterable[int]) -> Zdd:
        events = self.space.encoding.events
        return self._settled(states.images(distinct(events[t] for t in transitions))) & self.inside

    @once
    def reaching(self, goal: Zdd) -> Zdd:
        """States inside from which some run through the inside leads to a goal, inside or after."""
        steps = [partial(self._leading, transitions=of, among=self.inside) for of in self._by_element]
        return chained(goal, steps) & self.inside

    @once
    def after(self, inside: Zdd) -> Zdd:
        """States, inside or after the section, one event after states inside."""
        events = self.space.encoding.events
        return self._settled(inside.images(distinct(events[t] for of in self._by_element for t in of)))

    def step_into(self, goal: Zdd, among: Zdd) -> tuple[int, Zdd, Zdd] | None:
        """One step from one of some states inside to a goal: a transition, and one state at each end."""
        encoding = self.space.encoding
        ending = goal.saturate(self._internal_back, within=self.space.reachable)
        for transition in (t for of in self._by_element for t in of):
            before = ending.images([encoding.undoing[transition]], within=among)
            if before:
                source = self.pick(before)
                after = self._settled(source.images([encoding.events[transition]]))
                return transition, source, self.pick(after & goal)
        return None

    def pick(self, states: Zdd) -> Zdd:
        """A set of one of the states, the same each time."""
        marked = states.pick()
        return states if marked is None else self.space.encoding.store.singleton(marked)

    def crossing(self, goal: Zdd, among: Zdd) -> list[tuple[int, Zdd]]:
        """Event transitions that lead from some states inside to a goal, each with its states before."""
        ending = goal.saturate(self._internal_back, within=self.space.reachable)
        undoing = self.space.encoding.undoing
        ways = ((t, ending.images([undoing[t]], within=among)) for of in self._by_element for t in of)
        return [(transition, before) for transition, before in ways if before]

    # --- what is in them ---

    def grouped(self, states: Zdd, places: Sequence[int]) -> list[tuple[list[int], int]]:
        """How many of some states there are for each way to mark some places, given as those marked."""
        encoding = self.space.encoding
        kept = sorted({*encoding.levels(places), *encoding.partners(places)})
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
        conditions = [(t, c) for of in self._by_element for t in of if (c := enabling[t]) is not None]
        counts = states.counts([c for _, c in conditions])
        return dict(zip([t for t, _ in conditions], counts, strict=True))

    def marks(self, place: int, states: Zdd) -> bool:
        """Whether some of the states mark a place."""
        return bool(self.marking(place, states))

    # --- what composition rests on ---

    @cached_property
    def _open(self) -> list[tuple[int, int]]:
        """Internal transitions in conflict that some reachable marking enables both."""
        return list(open_conflicts(self.space))

    def among(self, states: Zdd, marking: Sequence[int]) -> Zdd:
        """A marking, given as tokens by place, as a set of one if it is among some states, else empty."""
        return self.space.encoding.set_of(marking) & states

    @cached_property
    def _endless(self) -> Zdd:
        """Markings from which no internal run comes to a stable one."""
        reachable = self.space.reachable
        return reachable - self.stable.saturate(self._internal_back, within=reachable)

    def torn(self, inside: Zdd, before: Zdd) -> Iterator[TornHere]:
        """Where diagrams leave confluence or termination open after events in states inside and before."""
        if not self._open and not self._endless:
            return
        events = self.space.encoding.events
        ways = distinct(events[t] for of in self._by_element for t in of)
        begun = before.images([events[self.start]]) | inside.images(ways)
        transient = begun.saturate(self._internal)
        if transient & self._endless:
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

    def _changed(self, different: Zdd, idle: Zdd) -> str:
        """The first place in which one of some markings differs from the idle one of the same hardware."""
        encoding = self.space.encoding
        frame = HardwareSpace(self.faulty).frame(self.faulty)
        state = self.pick(different)
        alike = self.with_hardware(idle, self.hardware(state, frame))
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
            run.append(self.net.net.transitions[step[0]].event or "")
            goal = step[1]
        failed = self.hardware(self.beginnings(goal), HardwareSpace(self.faulty).frame(self.faulty)).pick()
        out = [f"{name}_EV_OOS" for bit, name in enumerate(self.faulty) if failed >> bit & 1]
        return [*out, "MISSION_EV_START", *reversed(run)]
