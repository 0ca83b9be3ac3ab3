"""The composite: a mission's alternatives graph as the states of its sections, never put together.

A set of states is a diagram for each section; places and transitions are those of the net of the whole.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from functools import cached_property

from mcpn._kernel import Zdd
from mcpn.net.petri import Marking, Transition
from mcpn.space.algebra import Piece
from mcpn.space.images import Bit, ImageStore
from mcpn.space.local.runs import Runs
from mcpn.space.local.sections import BEGIN, ENDS, KINDS, NOWHERE, Kind, Stage
from mcpn.space.local.sets import CompositeSet, Member

FARTHEST = 2**62


class CompositeSpace(Runs):
    """The alternatives graph of a mission by composition: see :class:`mcpn.space.algebra.Space`."""

    def marking(self, state: Member) -> Marking:
        """The marking of a member in the whole net, as tokens by place."""
        stage, marked = self.stages[state[0]], set(state[1])
        tokens, local = list(self.net.initial), stage.type.encoding.marking(state[1])
        tokens[self.mission_net.beginning] = 0
        marked |= {slot for slot, place in stage.own_bits.items() if local[place]}
        for hardware, slots in self.layout.slots.items():
            bits = tuple(b for b, slot in enumerate(slots) if slot in marked)
            for place, value in self._beside[hardware].get(bits, {}).items():
                tokens[place] = value
        for where, value in zip(stage.places.whole, local, strict=True):
            if where != NOWHERE:
                tokens[where] = value
        return tuple(tokens)

    @cached_property
    def _beside(self) -> dict[str, dict[tuple[int, ...], dict[int, int]]]:
        """By hardware and its state, the tokens of its places while nobody uses it, where they differ."""
        return {name: self._idle_tokens(name) for name in self.layout.hardware}

    def _idle_tokens(self, name: str) -> dict[tuple[int, ...], dict[int, int]]:
        net = self.net
        own = self.elements.of["transitions"]["hardware", name]
        tokens = {p: net.initial[p] for p in self.elements.of["places"]["hardware", name]}
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
        for place in places:
            shared = self.net.initial[place] and place not in self._outside
            having = parts if shared or place in self._slot_of_place else self._having("places", place)
            marking = {name: self._those(name, parts.get(name), [place], ()) for name in having}
            for name, part in marking.items():
                if part:
                    found[name] = found[name] | part if name in found else part
        return CompositeSet(self, found)

    @cached_property
    def _outside(self) -> frozenset[int]:
        """The places that say that the mission has not begun, or how it has ended."""
        return frozenset().union(*(self.stages[name].places.own for name in (BEGIN, *ENDS)))

    @cached_property
    def _holders(self) -> Mapping[Kind, tuple[dict[int, str], dict[int, list[list[str]]]]]:
        """By place, and by transition: the stage that it is of; or the groups of those that share it."""
        alike: dict[Hashable, list[str]] = {}
        for name, stage in self.stages.items():
            alike.setdefault(stage.alike, []).append(name)
        found: dict[Kind, tuple[dict[int, str], dict[int, list[list[str]]]]] = {}
        for kind in KINDS:
            owner = {i: n for n, s in self.stages.items() for i in getattr(s, kind).own}
            users: dict[int, list[list[str]]] = {}
            for names in alike.values():
                for index in getattr(self.stages[names[0]], kind).locals:
                    users.setdefault(index, []).append(names)
            found[kind] = owner, users
        return found

    def _having(self, kind: Kind, index: int) -> list[str]:
        """The stages whose local nets have a place, or a transition, of the whole net."""
        owner, users = self._holders[kind]
        return [owner[index]] if index in owner else [n for names in users.get(index, ()) for n in names]

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
        yes, no = set[int](), set[int]()
        for wanted, places in ((True, marked), (False, unmarked)):
            for place in places:
                bit = self._bit(name, place)
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
        shared = {NOWHERE, *self._slot_of_place}
        return {name: frozenset(placed.places.whole) - shared for name, placed in self.sections.items()}

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
        constant = 0
        for place, weight in weights.items():
            where = self._bit(name, place)
            if isinstance(where, bool):
                constant += weight * where
            else:
                level, reverse = where
                levels[level] = levels.get(level, 0) + (-weight if reverse else weight)
                constant += weight if reverse else 0
        return levels, constant

    def _bit(self, name: str, place: int) -> Bit:
        """Where a part of a set says whether a place of the whole net is marked."""
        stage = self.stages[name]
        if (local := stage.places.local(place)) is not None:
            return stage.type.encoding.bit(local)
        if place in self._slot_of_place:
            slot, reverse = self._slot_of_place[place]
            if slot not in stage.own_bits:
                return slot, reverse
            # An interface of the section's own hardware that the section does not use follows its state.
            level, opposite = stage.type.encoding.bit(stage.own_bits[slot])
            return level, reverse != opposite
        return bool(self.net.initial[place]) and place not in self._outside

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
        names = (
            self.everything.parts
            if beside_all
            else {n for t in wanted for n in self._having("transitions", t)}
        )
        for name in names:
            part, stage = self.everything.parts.get(name), self.stages[name]
            if part is not None:
                allowed = allowed_in(name)
                found[name] = stage.able(part, allowed) | (part & stage.type.enabling(allowed))
        return self.of(found)

    def crossing(self, among: CompositeSet, into: CompositeSet) -> Iterator[tuple[int, CompositeSet]]:
        """Transitions with edges from some states into others, each with the states before it."""
        found: dict[int, dict[str, Zdd]] = {}
        for name, part in (self.before(into) & among).parts.items():
            stage, inside = self.stages[name], into.parts.get(name, self.layout.store.empty())
            goal = inside
            for exit_, route in stage.routes.items():
                if route in into.parts:
                    goal |= stage.ending(exit_, self.stages[route].entries(into.parts[route]))
            for t, before in stage.type.crossing(part, goal):
                found.setdefault(stage.transitions.whole[t], {})[name] = before
            for hardware, kind, before in stage.toggling(part, inside):
                found.setdefault(self.toggles[hardware][kind], {})[name] = before
        return ((t, CompositeSet(self, found[t])) for t in sorted(found))

    def pieces(self, states: CompositeSet) -> Iterator[Piece[CompositeSet]]:
        """The states, section by section."""
        for name, part in states.parts.items():
            stage = self.stages[name]
            yield Piece(CompositeSet(self, {name: part}), (stage.alike, part), stage.objectives)

    def firings(self, states: CompositeSet) -> Mapping[int, int]:
        """In how many of some states each transition has an edge."""
        counts: dict[int, int] = {}

        def add(transition: int, number: int) -> None:
            counts[transition] = counts.get(transition, 0) + number

        alike: dict[tuple[Hashable, Zdd], list[Stage]] = {}
        for name, part in states.parts.items():
            stage = self.stages[name]
            alike.setdefault((stage.alike, part), []).append(stage)
        for (_, part), stages in alike.items():
            once, one = self.closed(stages[0].name, part), stages[0]
            inside = one.type.firings(once)
            for local, number in inside.items():
                if one.transitions.shared[local] != NOWHERE:
                    add(one.transitions.shared[local], number * len(stages))
            for stage in stages:
                for t, local in stage.transitions.own.items():
                    add(t, inside.get(local, 0))
            beside_it = [
                (t, c) for h in self.layout.hardware if h not in one.faulty for t, c in self._needing[h]
            ]
            numbers = once.counts([condition for _, condition in beside_it])
            for (t, _), number in zip(beside_it, numbers, strict=True):
                add(t, number * len(stages))
        return {t: number for t, number in counts.items() if number}

    @cached_property
    def _needing(self) -> dict[str, list[tuple[int, int]]]:
        """By hardware, its transitions while nobody uses it, each with the condition on slots for it."""
        return {
            name: [
                (self.toggles[name][kind], self.layout.store.condition(toggle.marked, toggle.unmarked))
                for kind, toggle in toggles.items()
            ]
            for name, toggles in self.layout.toggles.items()
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
                known[name] = tuple(self._bit(name, place) for place in places)
            bits = known[name]
            if (part, bits) not in images.known:
                told = {bit[0] for bit in bits if not isinstance(bit, bool)}
                projected = part.onto(sorted(told))
                if (projected, bits) not in images.known:
                    images.known[projected, bits] = images.of_diagram(projected, self.layout.store, bits)
                images.known[part, bits] = images.known[projected, bits]
            found |= images.known[part, bits]
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
