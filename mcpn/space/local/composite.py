"""The composite: a mission's alternatives graph as the states of its sections, never put together.

A set of states is a diagram for each section; places and transitions are those of the net of the whole.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property

from mcpn._kernel import Zdd
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.net.petri import Marking, Transition
from mcpn.space.algebra import Piece
from mcpn.space.images import Bit, ImageStore
from mcpn.space.local.runs import Runs
from mcpn.space.local.sections import BEGIN, ENDS, NOWHERE, PlacedSection, Placement
from mcpn.space.local.sets import CompositeSet, Member

FARTHEST = 2**62


class CompositeSpace(Runs):
    """The alternatives graph of a mission by composition: see :class:`mcpn.space.algebra.Space`."""

    def marking(self, state: Member) -> Marking:
        """The marking of a member in the whole net, as tokens by place."""
        name, levels = state
        tokens, marked = list(self.net.initial), set(levels)
        tokens[self.mission_net.beginning] = int(name == BEGIN)
        placed = self.sections.get(name)
        local_marking = () if placed is None else placed.type.encoding.marking(levels)
        if placed is not None:
            marked |= self.own_bits(placed, local_marking)
        for hardware in self.layout.hardware:
            bits = tuple(b for b, slot in enumerate(self.layout.slots[hardware]) if slot in marked)
            for place, value in self._beside[hardware].get(bits, {}).items():
                tokens[place] = value
        if placed is not None:
            places = placed.places
            for local, value in enumerate(local_marking):
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
        own = self.elements.transitions["hardware", name]
        tokens = {p: net.initial[p] for p in self.elements.places["hardware", name]}
        found: dict[tuple[int, ...], dict[int, int]] = {}
        wanted = self.layout.statuses()
        kinds = self.toggles[name]
        for bits, kind in zip(wanted, ("fails", "dies"), strict=False):
            run = [kinds[kind]]
            while run:
                tokens = _fired(net.transitions[run.pop()], tokens)
                run = [
                    t for t in own if net.transitions[t].internal and _can_fire(net.transitions[t], tokens)
                ][:1]
            found[bits] = {p: value for p, value in tokens.items() if value != net.initial[p]}
        return found

    def marked(self, places: Collection[int]) -> CompositeSet:
        """States that mark at least one of some places."""
        found, parts = dict[str, Zdd](), self.everything.parts
        marking: Mapping[str, Zdd | None]
        for place in places:
            if place in self._of_mission:
                name = self._of_mission[place]
                marking = {name: parts.get(name)}
            else:
                shared = place in self._slot_of_place or self.net.initial[place]
                names = parts if shared else self._holding(place)
                marking = {name: self._those(name, parts.get(name), [place], ()) for name in names}
            for name, part in marking.items():
                if part:
                    found[name] = found[name] | part if name in found else part
        return CompositeSet(self, found)

    @cached_property
    def _of_mission(self) -> Mapping[int, str]:
        """The places of the mission itself, each with what stands for a section while it is marked."""
        mission = self.mission_net
        return {mission.beginning: BEGIN, mission.success: SUCCEED, mission.failure: FAIL}

    @cached_property
    def _users(self) -> Mapping[Placement, list[str]]:
        """Sections by placement."""
        found: dict[Placement, list[str]] = {}
        for name, placed in self.sections.items():
            found.setdefault(placed.placement, []).append(name)
        return found

    def _holding(self, place: int) -> Iterator[str]:
        """The sections whose local nets have a place of the whole net, if it is not the mission's."""
        if place in self._place_owners:
            yield self._place_owners[place]
        for placement in self._place_users.get(place, ()):
            yield from self._users[placement]

    @cached_property
    def _place_users(self) -> Mapping[int, list[Placement]]:
        """By place that is of no section, the placements whose local nets have it."""
        return _reversed((placement, placement.places.locals) for placement in self._users)

    @cached_property
    def _place_owners(self) -> Mapping[int, str]:
        """By place that is of a section's objectives and blocks, the section."""
        return {place: name for name, placed in self.sections.items() for place in placed.own_places}

    def restricted(
        self, states: CompositeSet, marked: Collection[int], unmarked: Collection[int]
    ) -> CompositeSet:
        """Those of some states that mark all of some places, and none of others."""
        found = {name: self._those(name, part, marked, unmarked) for name, part in states.parts.items()}
        return CompositeSet(self, {name: part for name, part in found.items() if part})

    def _those(
        self, name: str, part: Zdd | None, marked: Collection[int], unmarked: Collection[int]
    ) -> Zdd | None:
        """The same of one section's states; ``None`` where there are none."""
        placed = self.sections.get(name)
        yes, no = set[int](), set[int]()
        for wanted, places in ((True, marked), (False, unmarked)):
            for place in places:
                bit = self._bit(name, placed, place)
                if not isinstance(bit, bool):
                    (yes if bit[1] != wanted else no).add(bit[0])
                elif bit != wanted:
                    return None
        return None if part is None or yes & no else part.subset(sorted(yes), sorted(no))

    def varying(self, states: CompositeSet) -> Collection[int]:
        """Places of the sections that these states are of, but for those of hardware and of the mission."""
        return frozenset().union(*(self._own_places.get(name, ()) for name in states.parts))

    @cached_property
    def _own_places(self) -> Mapping[str, frozenset[int]]:
        shared = {NOWHERE, *self._slot_of_place, *self._of_mission}
        return {name: frozenset(placed.places) - shared for name, placed in self.sections.items()}

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
        if place in self._of_mission:
            return name == self._of_mission[place]
        if placed is not None and (local := placed.local_place(place)) is not None:
            return placed.type.encoding.bit(local)
        if place in self._slot_of_place:
            slot, reverse = self._slot_of_place[place]
            if placed is None or slot not in placed.slots:
                return slot, reverse
            # An interface of the section's own hardware that the section does not use follows its state.
            level, opposite = placed.bit_of(slot)
            return level, reverse != opposite
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
        wanted, found = frozenset(transitions), dict[str, Zdd]()
        allowed_in = self.filtered(wanted)
        beside_all = any(t in wanted for kinds in self.toggles.values() for t in kinds.values())
        names = self.everything.parts if beside_all else {n for t in wanted for n in self._firing(t)}
        for name in names:
            part, placed = self.everything.parts.get(name), self.sections.get(name)
            if part is None:
                continue
            allowed = allowed_in(name)
            states = part & self._able(name, part, allowed)
            if placed is not None:
                states |= part & placed.type.enabling(allowed)
            elif name == BEGIN and self.mission_net.start in wanted:
                states = part
            found[name] = states
        return self.of(found)

    def _firing(self, transition: int) -> Iterator[str]:
        """The sections whose local nets have a transition of the whole net."""
        if transition == self.mission_net.start:
            yield BEGIN
        if transition in self._transition_owners:
            yield self._transition_owners[transition]
        for placement in self._transition_users.get(transition, ()):
            yield from self._users[placement]

    @cached_property
    def _transition_users(self) -> Mapping[int, list[Placement]]:
        """By transition that is of no section, the placements whose local nets have it."""
        return _reversed((placement, placement.transitions.locals) for placement in self._users)

    @cached_property
    def _transition_owners(self) -> Mapping[int, str]:
        """By transition that is of a section's objectives and blocks, the section."""
        return {t: name for name, placed in self.sections.items() for t in placed.own_transitions}

    def crossing(self, among: CompositeSet, into: CompositeSet) -> Iterator[tuple[int, CompositeSet]]:
        """Transitions with edges from some states into others, each with the states before it."""
        found: dict[int, dict[str, Zdd]] = {}
        for name, part in (self.before(into) & among).parts.items():
            placed, inside = self.sections.get(name), into.parts.get(name, self.layout.store.empty())
            goal = inside
            for route, exit_ in self.exits(name):
                onward = self.entries(route, into.parts[route]) if route in into.parts else None
                if onward and placed is not None:
                    ended = placed.type.from_slots(onward, placed.faulty, exit_)
                    goal |= ended & placed.type.ended[exit_]
                elif onward and onward & part:
                    found.setdefault(self.mission_net.start, {})[name] = onward & part
            if placed is not None:
                for t, before in placed.type.crossing(part, goal):
                    found.setdefault(placed.transitions[t], {})[name] = before
            for hardware, kind, before in self._toggling(placed, part, inside):
                found.setdefault(self.toggles[hardware][kind], {})[name] = before
        return ((t, CompositeSet(self, found[t])) for t in sorted(found))

    def _toggling(self, placed: PlacedSection | None, part: Zdd, goal: Zdd) -> list[tuple[str, str, Zdd]]:
        """Events of hardware beside a section that lead from some states of it into others."""

        def compute() -> list[tuple[str, str, Zdd]]:
            own = () if placed is None else placed.faulty
            return [
                (hardware, kind, before)
                for hardware in self.layout.hardware
                if hardware not in own
                for kind, (_, undo) in self.layout.toggles(hardware).items()
                if (before := goal.images([undo]) & part)
            ]

        if placed is None:
            return compute()
        return placed.type.remembered(("toggling", part, goal, placed.faulty), compute)

    def pieces(self, states: CompositeSet) -> Iterator[Piece[CompositeSet]]:
        """The states, section by section."""
        for name, part in states.parts.items():
            placed = self.sections.get(name)
            piece = CompositeSet(self, {name: part})
            yield Piece(piece) if placed is None else Piece(piece, (*placed.kind, part), placed.objectives)

    def firings(self, states: CompositeSet) -> Mapping[int, int]:
        """In how many of some states each transition has an edge."""
        counts: dict[int, int] = {}

        def add(transition: int, number: int) -> None:
            counts[transition] = counts.get(transition, 0) + number

        alike: dict[tuple[Placement | None, Zdd], list[str]] = {}
        for name, part in states.parts.items():
            placed = self.sections.get(name)
            placement = None if placed is None else placed.placement
            alike.setdefault((placement, part), []).append(name)
        for (placement, part), names in alike.items():
            once, own = self.closed(names[0], part), () if placement is None else placement.part.faulty
            if placement is None:
                add(self.mission_net.start, once.count() * names.count(BEGIN))
            else:
                shared, inside = placement.transitions.shared, placement.type.firings(once)
                for local, number in inside.items():
                    if shared[local] != NOWHERE:
                        add(shared[local], number * len(names))
                for name in names:
                    for t, local in self.sections[name].own_transitions.items():
                        add(t, inside.get(local, 0))
            beside_it = [(t, c) for h in self.layout.hardware if h not in own for t, c in self._needing[h]]
            numbers = once.counts([condition for _, condition in beside_it])
            for (t, _), number in zip(beside_it, numbers, strict=True):
                add(t, number * len(names))
        return {t: number for t, number in counts.items() if number}

    @cached_property
    def _needing(self) -> dict[str, list[tuple[int, int]]]:
        """By hardware, its transitions while nobody uses it, each with the condition on slots for it."""
        return {
            name: [
                (self.toggles[name][kind], self.layout.store.condition(marked, unmarked))
                for kind, (marked, unmarked) in self.layout.needs(name).items()
            ]
            for name in self.layout.hardware
        }

    @cached_property
    def _bits(self) -> dict[tuple[int, ...], dict[str, tuple[Bit, ...]]]:
        """By some places and a section: where its parts of sets say of them whether they are marked."""
        return {}

    def image(self, states: CompositeSet, places: Sequence[int], images: ImageStore) -> Zdd:
        """How some states mark some places; see :meth:`mcpn.space.algebra.Space.image`."""
        found = images.nothing
        known = self._bits.setdefault(tuple(places), {})
        for name, part in states.parts.items():
            if name not in known:
                placed = self.sections.get(name)
                known[name] = tuple(self._bit(name, placed, place) for place in places)
            bits = known[name]
            if (part, bits) not in images.known:
                told = {bit[0] for bit in bits if not isinstance(bit, bool)}
                projected = part.onto(sorted(told))
                if (projected, bits) not in images.known:
                    images.known[projected, bits] = images.of_diagram(projected, self.layout.store, bits)
                images.known[part, bits] = images.known[projected, bits]
            found |= images.known[part, bits]
        return found


def _reversed(having: Iterable[tuple[Placement, Iterable[int]]]) -> dict[int, list[Placement]]:
    found: dict[int, list[Placement]] = {}
    for placement, indices in having:
        for index in indices:
            found.setdefault(index, []).append(placement)
    return found


def _can_fire(transition: Transition, tokens: Mapping[int, int]) -> bool:
    return all(tokens.get(p, 0) for p, _ in (*transition.consume, *transition.read))


def _fired(transition: Transition, tokens: Mapping[int, int]) -> dict[int, int]:
    after = dict(tokens)
    for p, _ in transition.consume:
        after[p] -= 1
    for p, _ in transition.produce:
        after[p] += 1
    return after
