"""The composite: a mission's alternatives graph as the states of its sections, never put together.

A state of the whole is a section, a state of its local net, and the state of the hardware beside it; before
and after the mission there is the state of the hardware alone. A set of states is a diagram for each section.
Sections are glued at their interface: what the first hands on is its exit and the state of all hardware.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from heapq import heappop, heappush
from typing import Any

from mcpn_kernel import Zdd

from mcpn.mission.model import FAIL, SUCCEED
from mcpn.net.compose import MissionNet
from mcpn.net.events import What
from mcpn.net.petri import Marking
from mcpn.space.algebra import Edge
from mcpn.space.images import Bit, ImageStore
from mcpn.space.local.layout import Layout
from mcpn.space.local.section_type import ALL, Allowed, Exit, beside
from mcpn.space.local.sections import BEGIN, ENDS, PlacedSection

Member = tuple[str, tuple[int, ...]]
"""A state: its section, and its marked levels with the section's own slots unmarked."""

FARTHEST = 2**62


class CompositeSet:
    """A set of states of a composite.

    Args:
        space: The composite.
        parts: By section, a diagram that is not empty; the section's own slots are open in it.
    """

    __slots__ = ("parts", "space")

    def __init__(self, space: CompositeSpace, parts: dict[str, Zdd]) -> None:
        self.space = space
        self.parts = parts

    def __and__(self, other: CompositeSet) -> CompositeSet:
        few, many = sorted((self.parts, other.parts), key=len)
        found = ((name, part & many[name]) for name, part in few.items() if name in many)
        return CompositeSet(self.space, {name: part for name, part in found if part})

    def __or__(self, other: CompositeSet) -> CompositeSet:
        few, many = sorted((self.parts, other.parts), key=len)
        found = dict(many)
        for name, part in few.items():
            found[name] = found[name] | part if name in found else part
        return CompositeSet(self.space, found)

    def __sub__(self, other: CompositeSet) -> CompositeSet:
        theirs = other.parts
        found = ((name, part - theirs[name] if name in theirs else part) for name, part in self.parts.items())
        return CompositeSet(self.space, {name: part for name, part in found if part})

    def __bool__(self) -> bool:
        return bool(self.parts)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, CompositeSet) and self.parts == other.parts

    def __hash__(self) -> int:
        return hash(frozenset(self.parts.items()))

    def count(self) -> int:
        """How many states the set has."""
        return sum(self.space.closed(name, part).count() for name, part in self.parts.items())

    def pick(self) -> Member | None:
        """A state of the first section in the mission's order, with little hardware out of service."""
        for name in self.space.in_order(self.parts):
            levels = self.space.closed(name, self.parts[name]).pick()
            assert levels is not None, "no part is empty"
            return name, tuple(levels)
        return None


class _Waiting:
    """Parts of a growing set that are to be worked on, again each time that one has grown.

    Args:
        found: The parts by name; they are changed in place.
        rank: The order in which they are worked on.
    """

    def __init__(self, found: dict[str, Zdd], rank: Callable[[str], int]) -> None:
        self.found = found
        self.rank = rank
        self._heap = sorted((rank(name), name) for name in found)
        self._queued = set(found)

    def __iter__(self) -> Iterator[str]:
        while self._heap:
            _, name = heappop(self._heap)
            self._queued.discard(name)
            yield name

    def widen(self, name: str, part: Zdd) -> None:
        """Adds states to a part; if it grows it is to be worked on."""
        known = self.found.get(name)
        wider = part if known is None else known | part
        if wider and wider != known:
            self.found[name] = wider
            if name not in self._queued:
                self._queued.add(name)
                heappush(self._heap, (self.rank(name), name))


class CompositeSpace:
    """The alternatives graph of a mission by composition.

    Args:
        mission_net: The net of the whole mission; it is not explored.
        layout: The diagram store.
        sections: Every section with its type, in document order.
    """

    def __init__(
        self, mission_net: MissionNet, layout: Layout, sections: Sequence[PlacedSection]
    ) -> None:
        self.mission_net = mission_net
        self.net = mission_net.net
        self.layout = layout
        self.sections = {placed.name: placed for placed in sections}
        self.nothing = CompositeSet(self, {})
        self._order = {name: i for i, name in enumerate((BEGIN, *self.sections, *ENDS))}
        self._into: dict[str, list[tuple[str, Exit]]] = {}
        for placed in sections:
            for exit_, route in placed.routes.items():
                self._into.setdefault(route, []).append((placed.name, exit_))
        entry = mission_net.graph.entry
        self._into.setdefault(entry, []).append((BEGIN, "success"))

    # --- sets -----------------------------------------------------------------------------------------

    def in_order(self, names: Iterable[str]) -> list[str]:
        """Names of sections, and of what is before and after them, in the mission's order."""
        return sorted(names, key=self._order.__getitem__)

    def closed(self, name: str, part: Zdd) -> Zdd:
        """A part of a set with the section's own slots unmarked, so that each state is there once."""
        placed = self.sections.get(name)
        return part if placed is None else part.subset(unmarked=placed.slots)

    def of(self, parts: Mapping[str, Zdd]) -> CompositeSet:
        """The set of some parts, of which some may be empty."""
        return CompositeSet(self, {name: part for name, part in parts.items() if part})

    @cached_property
    def initial(self) -> CompositeSet:
        """The state before the mission with all hardware in service."""
        return CompositeSet(self, {BEGIN: self.layout.store.singleton([])})

    @cached_property
    def everything(self) -> CompositeSet:
        """All reachable states."""
        return self._reached(self.initial, None, None)

    @cached_property
    def stable(self) -> CompositeSet:
        """All states: each is stable."""
        return self.everything

    @cached_property
    def dead(self) -> CompositeSet:
        """States in which neither the section nor hardware beside it can do anything."""
        found = {}
        for name, part in self.everything.parts.items():
            placed = self.sections.get(name)
            if name != BEGIN:
                resting = part if placed is None else part & placed.type.dead
                found[name] = resting - self._able(name, resting, ALL) if resting else resting
        return self.of(found)

    @cached_property
    def regions(self) -> Sequence[CompositeSet]:
        """Sections that lead to each other, and each other section alone: no cycle leaves a region."""
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import connected_components

        names = list(self.everything.parts)
        number = {name: i for i, name in enumerate(names)}
        pairs = [
            (number[before], number[name])
            for name in names
            for before, _ in self._into.get(name, ())
            if before in number
        ]
        rows, columns = zip(*pairs, strict=True) if pairs else ((), ())
        matrix = coo_matrix(([1] * len(pairs), (rows, columns)), (len(names), len(names)))
        _, component = connected_components(matrix.tocsr(), directed=True, connection="strong")
        found: dict[int, dict[str, Zdd]] = {}
        for name, part in self.everything.parts.items():
            found.setdefault(int(component[number[name]]), {})[name] = part
        return [CompositeSet(self, parts) for parts in found.values()]

    # --- what states say ------------------------------------------------------------------------------

    def single(self, state: Member) -> CompositeSet:
        """The set that holds one member."""
        name, levels = state
        part, placed = self.layout.store.singleton(list(levels)), self.sections.get(name)
        return CompositeSet(
            self, {name: part if placed is None else self.layout.opened(part, placed.slots)}
        )

    def marking(self, state: Member) -> Marking:
        """The marking of a member in the whole net, as tokens by place."""
        name, levels = state
        tokens, marked = list(self.net.initial), set(levels)
        tokens[self.mission_net.beginning] = int(name == BEGIN)
        placed = self.sections.get(name)
        for hardware in self.layout.hardware:
            bits = tuple(b for b, slot in enumerate(self.layout.slots[hardware]) if slot in marked)
            for place, value in self._beside[hardware].get(bits, {}).items():
                tokens[place] = value
        if placed is not None:
            places = placed.places
            for local, value in enumerate(placed.type.encoding.marking(levels)):
                tokens[places[local]] = value
            tokens[self.mission_net.beginning] = 0
        elif name in ENDS:
            tokens[self._end_place(name)] = 1
        return tuple(tokens)

    def _end_place(self, name: str) -> int:
        return self.mission_net.success if name == SUCCEED else self.mission_net.failure

    @cached_property
    def _beside(self) -> dict[str, dict[tuple[int, ...], dict[int, int]]]:
        """By hardware and its state, the tokens of its places while nobody uses it, where they differ."""
        return {name: self._idle_tokens(name) for name in self.layout.hardware}

    def _idle_tokens(self, name: str) -> dict[tuple[int, ...], dict[int, int]]:
        net = self.net
        own = [t for t, transition in enumerate(net.transitions) if _is_of(transition.provenance, name)]
        places = [p for p, place in enumerate(net.places) if _is_of(place.provenance, name)]
        tokens = {p: net.initial[p] for p in places}
        found: dict[tuple[int, ...], dict[int, int]] = {}
        wanted = self.layout.statuses()
        kinds = self._toggles[name]
        for bits, kind in zip(wanted, ("fails", "dies"), strict=False):
            run = [kinds[kind]]
            while run:
                tokens = _fired(net.transitions[run.pop()], tokens)
                run = [t for t in own if net.transitions[t].internal and _can_fire(net.transitions[t], tokens)][:1]
            found[bits] = {p: value for p, value in tokens.items() if value != net.initial[p]}
        return found

    @cached_property
    def _toggles(self) -> dict[str, dict[str, int]]:
        """By hardware, the transitions of the whole net with which it fails and so on while idle."""
        kinds = {What.OUT_OF_SERVICE: "fails", What.REPAIRED: "repaired", What.LOST: "dies"}
        found: dict[str, dict[str, int]] = {name: {} for name in self.layout.hardware}
        initial = self.net.initial
        for t, transition in enumerate(self.net.transitions):
            event = transition.event
            if event is None or event.what not in kinds or event.element not in found:
                continue
            if event.what is What.OUT_OF_SERVICE and not all(initial[p] for p, _ in transition.consume):
                continue  # the failure of a resource in use
            found[event.element][kinds[event.what]] = t
        return found

    def marked(self, places: Collection[int]) -> CompositeSet:
        """States that mark at least one of some places."""
        found = self.nothing
        for place in places:
            found |= self.everything - self.at_most({place: 1}, 0)
        return found

    def at_most(self, weights: Mapping[int, int], bound: int) -> CompositeSet:
        """States whose weighted sum of tokens is at most a bound."""
        found = {}
        for name, part in self.everything.parts.items():
            levels, constant = self._weigh(name, weights)
            if any(levels.values()):
                every = [levels.get(level, 0) for level in range(self.layout.store.levels)]
                found[name] = part.weighing(every, -FARTHEST, max(-FARTHEST, min(bound - constant, FARTHEST)))
            elif constant <= bound:
                found[name] = part
        return self.of(found)

    def _weigh(self, name: str, weights: Mapping[int, int]) -> tuple[dict[int, int], int]:
        """A weighted sum of tokens in a section, as weights of marked levels and a constant."""
        levels: dict[int, int] = {}
        constant, placed = 0, self.sections.get(name)
        for place, weight in weights.items():
            where = self._bit(name, placed, place)
            if isinstance(where, bool):
                constant += weight * where
            else:
                level, reverse = where
                levels[level] = levels.get(level, 0) + (-weight if reverse else weight)
                constant += weight if reverse else 0
        return levels, constant

    def _bit(self, name: str, placed: PlacedSection | None, place: int) -> Bit:
        """Where a part of a set says whether a place of the whole net is marked."""
        if placed is not None and (local := placed.local_place(place)) is not None:
            return placed.type.encoding.bit(local)
        if place in self._slot_of_place:
            return self._slot_of_place[place]
        if place == self.mission_net.beginning:
            return name == BEGIN
        if place in (self.mission_net.success, self.mission_net.failure):
            return name in ENDS and place == self._end_place(name)
        return bool(self.net.initial[place])

    @cached_property
    def _slot_of_place(self) -> dict[int, tuple[int, bool]]:
        """Places of idle hardware by the slot that says the same, or the reverse."""
        found: dict[int, tuple[int, bool]] = {}
        for name, states in self._beside.items():
            slots, initial = self.layout.slots[name], self.net.initial
            for place in {p for tokens in states.values() for p in tokens}:
                values = [states[bits].get(place, initial[place]) for bits in self.layout.statuses()]
                # A place that changes only where the resource dies follows the last slot.
                slot = slots[0] if values[0] != initial[place] else slots[-1]
                found[place] = slot, bool(initial[place])
        return found

    def enabling(self, transitions: Collection[int]) -> CompositeSet:
        """States with an edge of some of these transitions."""
        found = {}
        for name, part in self.everything.parts.items():
            placed, allowed = self.sections.get(name), self._allowed(name, transitions)
            states = part & self._able(name, part, allowed)
            if placed is not None:
                states |= part & placed.type.enabling(allowed)
            elif name == BEGIN and self.mission_net.start in transitions:
                states = part
            found[name] = states
        return self.of(found)

    def _able(self, name: str, part: Zdd, allowed: Allowed) -> Zdd:
        """Those of some states in which hardware beside the section can do something that is allowed."""
        placed = self.sections.get(name)
        own = set() if placed is None else set(placed.faulty)
        found = self.layout.store.empty()
        for hardware in self.layout.hardware:
            if hardware in own:
                continue
            for kind, (marked, unmarked) in self.layout.needs(hardware).items():
                if allowed.beside is None or (hardware, kind) in allowed.beside:
                    found |= part.subset(marked, unmarked)
        return found

    def firings(self, states: CompositeSet) -> Mapping[int, int]:
        """In how many of some states each transition has an edge."""
        counts: dict[int, int] = {}
        for name, part in states.parts.items():
            placed, states_once = self.sections.get(name), self.closed(name, part)
            if placed is not None:
                for local, number in placed.type.firings(states_once).items():
                    t = placed.transitions[local]
                    counts[t] = counts.get(t, 0) + number
            elif name == BEGIN:
                counts[self.mission_net.start] = states_once.count()
            own = set() if placed is None else set(placed.faulty)
            for hardware in self.layout.hardware:
                if hardware not in own:
                    for kind, (marked, unmarked) in self.layout.needs(hardware).items():
                        t = self._toggles[hardware][kind]
                        counts[t] = counts.get(t, 0) + states_once.subset(marked, unmarked).count()
        return {t: number for t, number in counts.items() if number}

    def image(self, states: CompositeSet, places: Sequence[int], images: ImageStore) -> Zdd:
        """How some states mark some places; see :meth:`mcpn.space.algebra.Space.image`."""
        found = images.nothing
        known: set[tuple[Zdd, tuple[Bit, ...]]] = set()
        for name, part in states.parts.items():
            placed = self.sections.get(name)
            bits = tuple(self._bit(name, placed, place) for place in places)
            told = {bit[0] for bit in bits if not isinstance(bit, bool)}
            projected = self.closed(name, part).onto(sorted(told))
            if (projected, bits) not in known:
                known.add((projected, bits))
                found |= images.of_diagram(projected, self.layout.store, bits)
        return found

    # --- steps and closures ---------------------------------------------------------------------------

    def _allowed(self, name: str, transitions: Collection[int] | None) -> Allowed:
        """What edges may carry, as a section sees it."""
        if transitions is None:
            return ALL
        wanted = transitions if isinstance(transitions, set | frozenset) else frozenset(transitions)
        pairs = frozenset(
            (hardware, kind)
            for hardware, kinds in self._toggles.items()
            for kind, t in kinds.items()
            if t in wanted
        )
        placed = self.sections.get(name)
        if placed is None:
            return Allowed(frozenset({0}) if self.mission_net.start in wanted else frozenset(), pairs)
        return Allowed(frozenset(local for local, t in enumerate(placed.transitions) if t in wanted), pairs)

    def _filter(self, transitions: Collection[int] | None) -> Callable[[str], Allowed]:
        """The same, worked out once for each section that it is asked of."""
        wanted = None if transitions is None else frozenset(transitions)
        known: dict[str, Allowed] = {}

        def of(name: str) -> Allowed:
            if name not in known:
                known[name] = self._allowed(name, wanted)
            return known[name]

        return of

    def _entries(self, name: str, inside: Zdd) -> Zdd:
        """The states of all hardware with which a section, or an end, is entered in some of its states."""
        placed = self.sections.get(name)
        return inside if placed is None else placed.type.entries(inside, placed.faulty)

    def _enter(self, name: str, hardware: Zdd) -> Zdd:
        placed = self.sections.get(name)
        return hardware if placed is None else placed.type.entered(hardware, placed.faulty)

    def _leaving(self, before: str, exit_: Exit, hardware: Zdd, allowed: Allowed) -> Zdd:
        """States with an event that ends a section by an exit with all hardware in some states."""
        if before == BEGIN:
            start = allowed.local is None or bool(allowed.local)
            return hardware if start else self.layout.store.empty()
        placed = self.sections[before]
        ended = placed.type.from_slots(hardware, placed.faulty, exit_) & placed.type.ended[exit_]
        return placed.type.before_step(ended, allowed)

    def before(self, states: CompositeSet, transitions: Collection[int] | None = None) -> CompositeSet:
        """States with an edge into some states."""
        allowed, found = self._filter(transitions), dict[str, Zdd]()

        def add(name: str, part: Zdd) -> None:
            part = part & self.everything.parts.get(name, self.layout.store.empty())
            if part:
                found[name] = found[name] | part if name in found else part

        for name, part in states.parts.items():
            placed = self.sections.get(name)
            if placed is not None:
                add(name, placed.type.before_step(part, allowed(name)))
            add(name, part.images(self._beside_it(name, allowed(name), undone=True)))
            for before, exit_ in self._into.get(name, ()):
                add(before, self._leaving(before, exit_, self._entries(name, part), allowed(before)))
        return CompositeSet(self, found)

    def after(self, states: CompositeSet, transitions: Collection[int] | None = None) -> CompositeSet:
        """States that an edge leads to from some states."""
        allowed, found = self._filter(transitions), dict[str, Zdd]()

        def add(name: str, part: Zdd) -> None:
            if part:
                found[name] = found[name] | part if name in found else part

        for name, part in states.parts.items():
            inside, leaving = self._step(name, part, allowed(name))
            add(name, inside)
            add(name, part.images(self._beside_it(name, allowed(name), undone=False)))
            for route, hardware in leaving:
                add(route, self._enter(route, hardware))
        return CompositeSet(self, found)

    def _step(self, name: str, part: Zdd, allowed: Allowed) -> tuple[Zdd, list[tuple[str, Zdd]]]:
        """States of the section one of its own events later, and how all hardware is where it ends."""
        if name in ENDS:
            return self.layout.store.empty(), []
        if name == BEGIN:
            start = allowed.local is None or bool(allowed.local)
            return self.layout.store.empty(), [(self.mission_net.graph.entry, part)] if start else []
        placed = self.sections[name]
        after = placed.type.after(part, allowed)
        leaving = [
            (route, placed.type.to_slots(ended, placed.faulty, exit_))
            for exit_, route in placed.routes.items()
            if (ended := after & placed.type.ended[exit_])
        ]
        return after & placed.type.inside, leaving

    def reaching(
        self,
        goal: CompositeSet,
        along: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
    ) -> CompositeSet:
        """States from which some run through ``along`` leads into a goal, the goal's own included."""
        within = (self.everything if along is None else along).parts
        allowed = self._filter(transitions)
        found = dict(goal.parts)
        waiting = _Waiting(found, lambda name: -self._order[name])
        for name in waiting:
            found[name] = self._reaching_inside(name, found[name], within.get(name), allowed(name))
            entries = self._entries(name, found[name])
            for before, exit_ in self._into.get(name, ()):
                if before in within:
                    waiting.widen(before, self._leaving(before, exit_, entries, allowed(before)) & within[before])
        return self.of(found)

    def _reaching_inside(self, name: str, goal: Zdd, along: Zdd | None, allowed: Allowed) -> Zdd:
        """The closure within one section, or within what is before or after them."""
        if along is None:
            return goal
        placed = self.sections.get(name)
        if placed is not None:
            return placed.type.reaching(goal, along, allowed)
        return goal.saturate(beside(self.layout, allowed, undone=True), within=along | goal)

    def reached(
        self,
        begin: CompositeSet,
        along: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
    ) -> CompositeSet:
        """States of ``along`` to which some run through it leads, those it begins from included."""
        return self._reached(begin, self.everything if along is None else along, transitions)

    def _reached(
        self, begin: CompositeSet, along: CompositeSet | None, transitions: Collection[int] | None
    ) -> CompositeSet:
        """The same; without ``along`` through all that local nets allow."""
        allowed = self._filter(transitions)

        def within(name: str) -> Zdd | None:
            if along is not None:
                return along.parts.get(name)
            placed = self.sections.get(name)
            return self.layout.universe if placed is None else placed.type.inside

        found = {name: part & room for name, part in begin.parts.items() if (room := within(name)) is not None}
        found = {name: part for name, part in found.items() if part}
        waiting = _Waiting(found, self._order.__getitem__)
        for name in waiting:
            room, placed = within(name), self.sections.get(name)
            assert room is not None, "only parts of what runs may pass are found"
            if placed is not None:
                found[name] = placed.type.reached(found[name], room, allowed(name))
            else:
                toggles = beside(self.layout, allowed(name), undone=False)
                found[name] = found[name].saturate(toggles, within=room)
            for route, hardware in self._step(name, found[name], allowed(name))[1]:
                onward = within(route)
                if onward is not None:
                    waiting.widen(route, self._enter(route, hardware) & onward)
        return self.of(found)

    def staying(self, along: CompositeSet) -> CompositeSet:
        """States from which some maximal run, endless or ending in a dead state, stays in a set."""
        found = dict((along & self.everything).parts)
        ends = self.dead.parts
        empty = self.layout.store.empty()
        waiting = set(found)
        while waiting:
            name = max(waiting, key=self._order.__getitem__)
            waiting.discard(name)
            part, placed = found.get(name, empty), self.sections.get(name)
            onward = empty
            for route, exit_ in self._exits(name):
                if route in found:
                    onward |= self._leaving(name, exit_, self._entries(route, found[route]), ALL)
            dead, before = ends.get(name, empty), None
            while before != part:
                before = part
                ways = part.images(self._beside_it(name, ALL, undone=True))
                if placed is not None:
                    ways |= placed.type.before_step(part)
                part = part & (ways | onward | dead)
            if part != found.get(name, empty):
                found[name] = part
                waiting |= {before for before, _ in self._into.get(name, ()) if before in found}
        return self.of(found)

    def _beside_it(self, name: str, allowed: Allowed, *, undone: bool) -> list[int]:
        """Events of the store for what hardware beside a section does, or what undoes it.

        Closures may take those of all hardware (:func:`mcpn.space.local.section_type.beside`), since a
        section's own slots are open: they change nothing there, but they would look like steps.
        """
        placed = self.sections.get(name)
        return beside(self.layout, allowed, undone=undone, but=() if placed is None else placed.faulty)

    def _exits(self, name: str) -> list[tuple[str, Exit]]:
        if name == BEGIN:
            return [(self.mission_net.graph.entry, "success")]
        placed = self.sections.get(name)
        return [] if placed is None else [(route, exit_) for exit_, route in placed.routes.items()]

    # --- runs -----------------------------------------------------------------------------------------

    def edges(self, state: Member) -> Iterator[Edge]:
        """The edges of one member, in the order of the whole net's transitions."""
        found = list(self._toggled(state))
        name, levels = state
        if name == BEGIN:
            found.append(Edge(self.mission_net.start, self._entered(self.mission_net.graph.entry, set(levels))))
        elif name in self.sections:
            found += self._fired(self.sections[name], levels)
        return iter(sorted(found, key=lambda edge: edge.transition))

    def _toggled(self, state: Member) -> Iterator[Edge]:
        name, levels = state
        placed, marked = self.sections.get(name), set(levels)
        own = set() if placed is None else set(placed.faulty)
        for hardware in self.layout.hardware:
            if hardware in own:
                continue
            for kind, (needed, unmarked) in self.layout.needs(hardware).items():
                if marked.issuperset(needed) and marked.isdisjoint(unmarked):
                    after = marked ^ self.layout.changes(kind, hardware)
                    yield Edge(self._toggles[hardware][kind], (name, tuple(sorted(after))))

    def _fired(self, placed: PlacedSection, levels: tuple[int, ...]) -> Iterator[Edge]:
        type_ = placed.type
        net, marking = type_.net.net, type_.encoding.marking(levels)
        beside_it = {level for level in levels if level >= self.layout.first_slot}
        for t in net.enabled(marking):
            after = _run_to_completion(net, net.fire(marking, t))
            exit_ = next((e for e, place in type_.ends.items() if after[place]), None)
            if exit_ is None:
                target = (placed.name, tuple(sorted({*type_.encoding.marked_levels(after), *beside_it})))
            else:
                target = self._entered(placed.routes[exit_], beside_it | self._own_bits(placed, after))
            yield Edge(placed.transitions[t], target)

    def _own_bits(self, placed: PlacedSection, marking: Marking) -> set[int]:
        roles = placed.type.net.by_role
        return {
            slot
            for theirs, mine in zip(placed.type.faulty, placed.faulty, strict=True)
            for slot, role in zip(self.layout.slots[mine], self.layout.bits, strict=True)
            if marking[roles[role, theirs][0]]
        }

    def _entered(self, name: str, slots: set[int]) -> Member:
        """The first state of a section entered with all hardware in one state."""
        entered = self._enter(name, self.layout.store.singleton(sorted(slots)))
        levels = self.closed(name, entered).pick()
        assert levels is not None, "every state of the hardware has an entry"
        return name, tuple(levels)

    def run(
        self,
        begin: Member,
        goal: CompositeSet,
        along: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
    ) -> list[Edge] | None:
        """A run from a member into a goal through as few sections as can be.

        Within each section it is a shortest one; see :meth:`mcpn.space.algebra.Space.run`.
        """
        hops = self._hops(begin, goal, along, transitions)
        if hops is None:
            return None
        allowed, run, state = self._filter(transitions), list[Edge](), begin
        while True:
            hop = next(i for i, found in enumerate(hops) if state[0] in found and self._in(state, found[state[0]][0]))
            target = hops[hop][state[0]][1]
            inside = None if along is None else along.parts.get(state[0])
            legs = self._run_inside(state, target, inside, allowed(state[0]))
            run += legs
            state = legs[-1].target if legs else state
            if hop == 0:
                return run
            run.append(next(e for e in self.edges(state) if self._leads_on(e, state, hops[hop - 1], transitions)))
            state = run[-1].target

    def _in(self, state: Member, part: Zdd) -> bool:
        return bool(self.single(state).parts[state[0]] & part)

    def _leads_on(
        self, edge: Edge, state: Member, hop: dict[str, tuple[Zdd, Zdd]], transitions: Collection[int] | None
    ) -> bool:
        """Whether an edge leaves a section for states from which the goal is one section nearer."""
        after = edge.target
        leaves = edge.transition == self.mission_net.start or self._ends_section(state, edge.transition)
        allowed = transitions is None or edge.transition in transitions
        return leaves and allowed and after[0] in hop and self._in(after, hop[after[0]][0])

    def _ends_section(self, state: Member, transition: int) -> bool:
        placed = self.sections.get(state[0])
        return placed is not None and transition in placed.own_transitions

    def _hops(
        self,
        begin: Member,
        goal: CompositeSet,
        along: CompositeSet | None,
        transitions: Collection[int] | None,
    ) -> list[dict[str, tuple[Zdd, Zdd]]] | None:
        """By number of sections to leave before the goal: from which states, and to where within a section."""
        within = (self.everything if along is None else along).parts
        allowed = self._filter(transitions)
        seen: dict[str, Zdd] = {}
        targets = dict(goal.parts)
        hops: list[dict[str, tuple[Zdd, Zdd]]] = []
        while targets:
            hop: dict[str, tuple[Zdd, Zdd]] = {}
            for name, target in targets.items():
                closed = self._reaching_inside(name, target, within.get(name), allowed(name))
                if name in seen:
                    closed = closed - seen[name]
                if closed:
                    hop[name] = closed, target
                    seen[name] = seen[name] | closed if name in seen else closed
            if not hop:
                return None
            hops.append(hop)
            if begin[0] in hop and self._in(begin, hop[begin[0]][0]):
                return hops
            targets = {}
            for name, (closed, _) in hop.items():
                entries = self._entries(name, closed)
                for before, exit_ in self._into.get(name, ()):
                    if before in within:
                        leaving = self._leaving(before, exit_, entries, allowed(before)) & within[before]
                        if leaving:
                            targets[before] = targets[before] | leaving if before in targets else leaving
        return None

    def _run_inside(
        self, begin: Member, goal: Zdd, along: Zdd | None, allowed: Allowed
    ) -> list[Edge]:
        """A shortest run within one section; there is one."""
        name = begin[0]
        placed = self.sections.get(name)
        within = self.everything.parts[name] if along is None else along
        layers, seen = [goal], goal
        while not self._in(begin, layers[-1]):
            earlier = layers[-1].images(self._beside_it(name, allowed, undone=True))
            if placed is not None:
                earlier |= placed.type.before_step(layers[-1], allowed)
            layers.append((earlier & within) - seen)
            assert layers[-1], "the caller knows that there is a run"
            seen |= layers[-1]
        run, state = list[Edge](), begin
        for layer in reversed(layers[:-1]):
            edge = next(
                e
                for e in self.edges(state)
                if e.target[0] == name and self._carried(e, name, allowed) and self._in(e.target, layer)
            )
            run.append(edge)
            state = edge.target
        return run

    def _carried(self, edge: Edge, name: str, allowed: Allowed) -> bool:
        """Whether an edge within a section is allowed."""
        if allowed is ALL:
            return True
        placed = self.sections.get(name)
        if placed is not None and (local := placed.local_transition(edge.transition)) is not None:
            return allowed.local is None or local in allowed.local
        return allowed.beside is None or any(
            self._toggles[hardware][kind] == edge.transition for hardware, kind in allowed.beside
        )


def _is_of(provenance: Any, name: str) -> bool:
    return provenance is not None and provenance.kind == "hardware" and provenance.name == name


def _can_fire(transition: Any, tokens: Mapping[int, int]) -> bool:
    return all(tokens.get(p, 0) for p, _ in (*transition.consume, *transition.read))


def _fired(transition: Any, tokens: Mapping[int, int]) -> dict[int, int]:
    after = dict(tokens)
    for p, _ in transition.consume:
        after[p] -= 1
    for p, _ in transition.produce:
        after[p] += 1
    return after


def _run_to_completion(net: Any, marking: Marking) -> Marking:
    while (enabled := net.enabled(marking)) and net.transitions[enabled[0]].internal:
        marking = net.fire(marking, enabled[0])
    return marking
