"""The composite: a mission's alternatives graph as the states of its sections, never put together.

A set of states is a diagram for each section; places and transitions are those of the net of the whole.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cached_property

from mcpn._kernel import Zdd
from mcpn.mission.model import SUCCEED
from mcpn.net.petri import Marking, Provenance, Transition
from mcpn.space.images import Bit, ImageStore
from mcpn.space.local.runs import Runs
from mcpn.space.local.sections import BEGIN, ENDS, PlacedSection
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
            placed, allowed = self.sections.get(name), self.allowed_in(name, transitions)
            states = part & self._able(name, part, allowed)
            if placed is not None:
                states |= part & placed.type.enabling(allowed)
            elif name == BEGIN and self.mission_net.start in transitions:
                states = part
            found[name] = states
        return self.of(found)

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
                        t = self.toggles[hardware][kind]
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


def _is_of(provenance: Provenance | None, name: str) -> bool:
    return provenance is not None and provenance.kind == "hardware" and provenance.name == name


def _can_fire(transition: Transition, tokens: Mapping[int, int]) -> bool:
    return all(tokens.get(p, 0) for p, _ in (*transition.consume, *transition.read))


def _fired(transition: Transition, tokens: Mapping[int, int]) -> dict[int, int]:
    after = dict(tokens)
    for p, _ in transition.consume:
        after[p] -= 1
    for p, _ in transition.produce:
        after[p] += 1
    return after
