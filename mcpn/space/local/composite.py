"""The composite: a mission's alternatives graph as the states of its sections, never put together.

A set of states is a diagram for each section; places and transitions are those of the net of the whole.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterator, Mapping, Sequence
from functools import cached_property

from mcpn._kernel import Zdd
from mcpn.net.petri import Marking
from mcpn.space.algebra import Piece
from mcpn.space.images import Bit, ImageStore
from mcpn.space.local.runs import Runs
from mcpn.space.local.sections import BEGIN, ENDS, NOWHERE, Stage
from mcpn.space.local.sets import CompositeSet, Member, Parts
from mcpn.space.run import Completion

FARTHEST = 2**62


class CompositeSpace(Runs):
    """The alternatives graph of a mission by composition: see :class:`mcpn.space.algebra.Space`."""

    # --- where a part of a set says whether a place of the whole net is marked ---

    def _bit(self, name: str, place: int) -> Bit:
        stage = self.stages[name]
        if (local := stage.local.get(place)) is not None:
            return stage.type.encoding.bit(local)
        if place in self._slot_of_place:
            slot, reverse = self._slot_of_place[place]
            if slot not in stage.own_places:
                return slot, reverse
            # An interface of the section's own hardware that the section does not use follows its status.
            level, opposite = stage.type.encoding.bit(stage.own_places[slot])
            return level, reverse != opposite
        return bool(self._idle[place])

    @cached_property
    def _slot_of_place(self) -> dict[int, tuple[int, bool]]:
        """Places of idle hardware by the slot that says the same, or the reverse."""
        found: dict[int, tuple[int, bool]] = {}
        initial, roles, completion = self.net.initial, self.mission_net.by_role, Completion(self.net)
        for toggle in self.layout.beside():
            if not toggle.marked:  # it fails
                name = toggle.hardware
                oos, *dead = self.layout.slots[name]
                _, after = completion.after(initial, toggle.transition)
                for place in self.whole.elements[0]["hardware", name]:
                    if after[place] != initial[place]:
                        found[place] = oos, bool(initial[place])
                for slot in dead:
                    found[roles["dead", name][0]], found[roles["alive", name][0]] = (
                        (slot, False),
                        (slot, True),
                    )
        return found

    @cached_property
    def _idle(self) -> list[int]:
        """The tokens of each place in the sections that have it not, with all hardware in service."""
        tokens = [*self.net.initial]
        for stage in (self.stages[name] for name in (BEGIN, *ENDS)):
            for place in stage.local:
                tokens[place] = 0
        return tokens

    def _holders(self, located: Callable[[Stage], Sequence[int]]) -> dict[int, list[str]]:
        found: dict[int, list[str]] = {}
        for name, stage in self.stages.items():
            for where in located(stage):
                found.setdefault(where, []).append(name)
        return found

    @cached_property
    def _with_place(self) -> dict[int, list[str]]:
        """By place, the stages whose local nets have it."""
        return self._holders(lambda stage: stage.places)

    @cached_property
    def _with_transition(self) -> dict[int, list[str]]:
        """By transition, the stages whose local nets have it."""
        return self._holders(lambda stage: stage.transitions)

    # --- what states say ---

    def marking(self, state: Member) -> Marking:
        """The marking of a member in the whole net, as tokens by place."""
        tokens = self._idle.copy()
        for place in (*self._slot_of_place, *self.stages[state[0]].local):
            bit = self._bit(state[0], place)
            tokens[place] = int(bit if isinstance(bit, bool) else (bit[0] in state[1]) != bit[1])
        return tuple(tokens)

    def marked(self, places: Collection[int]) -> CompositeSet:
        """States that mark at least one of some places."""
        found, parts = Parts(), self.everything.parts
        for place in places:
            anywhere = self._idle[place] or place in self._slot_of_place
            for name in parts if anywhere else self._with_place.get(place, ()):
                if name in parts:
                    found.add(name, self._those(name, parts[name], [place], ()))
        return CompositeSet(self, found)

    def restricted(
        self, states: CompositeSet, marked: Collection[int], unmarked: Collection[int]
    ) -> CompositeSet:
        """Those of some states that mark all of some places, and none of others."""
        found = {name: self._those(name, part, marked, unmarked) for name, part in states.parts.items()}
        return CompositeSet(self, found)

    def _those(self, name: str, part: Zdd, marked: Collection[int], unmarked: Collection[int]) -> Zdd:
        """The same of one section's states."""
        yes, no = set[int](), set[int]()
        for wanted, places in ((True, marked), (False, unmarked)):
            for place in places:
                bit = self._bit(name, place)
                if not isinstance(bit, bool):
                    (yes if bit[1] != wanted else no).add(bit[0])
                elif bit != wanted:
                    return self.empty
        return self.empty if yes & no else part.subset([*yes], [*no])

    def varying(self, states: CompositeSet) -> Collection[int]:
        """Places of the sections that these states are of, but for those of hardware and of the mission."""
        sections = (self.sections[name].places for name in states.parts if name in self.sections)
        return set[int]().union(*sections) - {NOWHERE, *self._slot_of_place}

    def at_most(self, weights: Mapping[int, int], bound: int) -> CompositeSet:
        """States whose weighted sum of tokens is at most a bound."""
        found = {}
        for name, part in self.everything.parts.items():
            levels, rest = [0] * self.layout.store.levels, bound
            for place, weight in weights.items():
                bit = self._bit(name, place)
                if isinstance(bit, bool):
                    rest -= weight * bit
                else:
                    levels[bit[0]] += -weight if bit[1] else weight
                    rest -= weight * bit[1]
            found[name] = part.weighing(levels, -FARTHEST, max(-FARTHEST, min(rest, FARTHEST)))
        return CompositeSet(self, found)

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
                projected = part.onto([*told])
                if (projected, bits) not in images.known:
                    images.known[projected, bits] = images.of_diagram(projected, self.layout.store, bits)
                images.known[part, bits] = images.known[projected, bits]
            found |= images.known[part, bits]
        return found

    @cached_property
    def _bits(self) -> dict[tuple[int, ...], dict[str, tuple[Bit, ...]]]:
        """By some places and a section: where its parts of sets say of them whether they are marked."""
        return {}

    def pieces(self, states: CompositeSet) -> Iterator[Piece[CompositeSet]]:
        """The states, section by section."""
        for name, part in states.parts.items():
            stage = self.stages[name]
            yield Piece(CompositeSet(self, {name: part}), (stage.alike, part), stage.objectives)

    # --- edges ---

    def enabling(self, transitions: Collection[int]) -> CompositeSet:
        """States with an edge of some of these transitions."""
        wanted, found, parts = frozenset(transitions), dict[str, Zdd](), self.everything.parts
        allowed_in = self.filtered(wanted)
        beside = not wanted.isdisjoint(self.layout.toggles)
        for name in parts if beside else {n for t in wanted for n in self._with_transition.get(t, ())}:
            if name in parts:
                stage, allowed, part = self.stages[name], allowed_in(name), parts[name]
                own = stage.type.inside & stage.type.graph.enabling(allowed.local or ())
                idle = part.without([toggle.condition for toggle in stage.beside(allowed)])
                found[name] = (part & own) | (part - idle)
        return CompositeSet(self, found)

    def crossing(self, among: CompositeSet, into: CompositeSet) -> Iterator[tuple[int, CompositeSet]]:
        """Transitions with edges from some states into others, each with the states before it."""
        found: dict[int, dict[str, Zdd]] = {}
        for name, part in (self.before(into) & among).parts.items():
            stage, inside = self.stages[name], into.parts.get(name, self.empty)
            goal = inside | self.ends_into(stage, into.parts)
            for t, before in stage.type.crossing(part, goal):
                found.setdefault(stage.transitions[t], {})[name] = before
            for t, before in stage.type.toggling(part, inside, stage.faulty):
                found.setdefault(t, {})[name] = before
        return ((t, CompositeSet(self, found[t])) for t in sorted(found))

    def firings(self, states: CompositeSet) -> Mapping[int, int]:
        """In how many of some states each transition has an edge."""
        counts: dict[int, int] = {}
        alike: dict[tuple[Hashable, Zdd], list[Stage]] = {}
        for name, part in states.parts.items():
            alike.setdefault((self.stages[name].alike, part), []).append(self.stages[name])
        for (_, part), stages in alike.items():
            once, beside = self.closed(stages[0].name, part), stages[0].beside()
            own = stages[0].type.graph.firings(once)
            idle = once.counts([toggle.condition for toggle in beside])
            for stage in stages:
                for t, number in own.items():
                    counts[stage.transitions[t]] = counts.get(stage.transitions[t], 0) + number
            for toggle, number in zip(beside, idle, strict=True):
                counts[toggle.transition] = counts.get(toggle.transition, 0) + number * len(stages)
        return {t: number for t, number in counts.items() if number and t != NOWHERE}
