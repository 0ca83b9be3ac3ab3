"""The composite: a mission's alternatives graph as the states of its sections, never put together.

A set of states is a diagram for each section; places and transitions are those of the net of the whole.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterator, Mapping, Sequence
from functools import cached_property

from mcpn._kernel import Zdd
from mcpn.net.petri import Marking
from mcpn.space.algebra import Edge, Guards, Piece
from mcpn.space.diagrams.base import FARTHEST
from mcpn.space.images import Bit, ImageStore
from mcpn.space.local.glued import CompositeSet, Glued, Member, Parts
from mcpn.space.local.layout import idle_places, remembered
from mcpn.space.local.section_type import ALL, Allowed
from mcpn.space.local.sections import BEGIN, ENDS, NOWHERE, Kind, Stage


class TwoOutcomes(Exception):
    """An event on the way has several outcomes, of which a run follows one, and not the one that leads on.

    Args:
        run: The edges before that event.
    """

    def __init__(self, run: list[Edge]) -> None:
        super().__init__("an event has several outcomes")
        self.run = run


class CompositeSpace(Glued):
    """The alternatives graph of a mission by composition: see :class:`mcpn.space.algebra.Space`."""

    # --- where a part of a set says whether a place of the whole net is marked ---

    def _bit(self, name: str, place: int) -> Bit:
        stage = self.stages[name]
        if (local := stage.local.get(place)) is not None:
            return stage.type.encoding.bit(local)
        if place in self._hardware:
            hardware, number, reverse = self._hardware[place]
            slot = self.layout.slots[hardware][number]
            if slot not in stage.own_places:
                return slot, reverse
            # An interface of the section's own hardware that the section does not use follows its status.
            level, opposite = stage.type.encoding.bit(stage.own_places[slot])
            return level, reverse != opposite
        return bool(self._idle[place])

    @cached_property
    def _hardware(self) -> dict[int, tuple[str, int, bool]]:
        """Places of hardware by what they say of its status while nobody uses it."""
        return idle_places(self.mission_net)

    @cached_property
    def _idle(self) -> list[int]:
        """The tokens of each place in the sections that have it not, with all hardware in service."""
        tokens = [*self.net.initial]
        for stage in (self.stages[name] for name in (BEGIN, *ENDS)):
            for place in stage.local:
                tokens[place] = 0
        return tokens

    @remembered
    def _holders(self, kind: Kind) -> Mapping[int, list[str]]:
        """By place, or by transition, the stages whose local nets have it."""
        found: dict[int, list[str]] = {}
        for name, stage in self.stages.items():
            for where in getattr(stage, kind):
                found.setdefault(where, []).append(name)
        return found

    # --- what states say ---

    def marking(self, state: Member) -> Marking:
        """The marking of a member in the whole net, as tokens by place."""
        tokens = self._idle.copy()
        for place in (*self._hardware, *self.stages[state[0]].local):
            bit = self._bit(state[0], place)
            tokens[place] = int(bit if isinstance(bit, bool) else (bit[0] in state[1]) != bit[1])
        return tuple(tokens)

    def marked(self, places: Collection[int]) -> CompositeSet:
        """States that mark at least one of some places."""
        found, parts = Parts(), self.everything.parts
        for place in places:
            anywhere = self._idle[place] or place in self._hardware
            for name in parts if anywhere else self._holders("places").get(place, ()):
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
        return set[int]().union(*sections) - {NOWHERE, *self._hardware}

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
        for name, part in states.parts.items():
            bits, levels = self._bits(name, tuple(places))
            key = part.onto(levels), bits
            if key not in images.known:
                images.known[key] = images.of_diagram(key[0], self.layout.store, bits)
            found |= images.known[key]
        return found

    @remembered
    def _bits(self, name: str, places: tuple[int, ...]) -> tuple[tuple[Bit, ...], list[int]]:
        """Where parts of sets say of some places whether they are marked, and the levels that do."""
        bits = tuple(self._bit(name, place) for place in places)
        return bits, [*{bit[0] for bit in bits if not isinstance(bit, bool)}]

    def pieces(self, states: CompositeSet) -> Iterator[Piece[CompositeSet]]:
        """The states, section by section."""
        for name, part in states.parts.items():
            stage = self.stages[name]
            yield Piece(CompositeSet(self, {name: part}), (stage.alike, part), stage.objectives)

    # --- edges of sets ---

    def enabling(self, transitions: Collection[int]) -> CompositeSet:
        """States with an edge of some of these transitions."""
        wanted, found, parts = frozenset(transitions), dict[str, Zdd](), self.everything.parts
        allowed_in = self.filtered(wanted)
        beside = not wanted.isdisjoint(self.layout.toggles)
        for name in parts if beside else {n for t in wanted for n in self._holders("transitions").get(t, ())}:
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

    # --- edges of single states, and runs ---

    def single(self, state: Member) -> CompositeSet:
        """The set that holds one member."""
        part, slots = self.layout.store.singleton(state[1]), self.stages[state[0]].slots
        return CompositeSet(self, {state[0]: self.layout.opened(part, slots)})

    def edges(self, state: Member) -> Iterator[Edge]:
        """The edges of one member, in the order of the whole net's transitions."""
        return self._edges(state, ALL, self.everything.parts)

    def _edges(self, state: Member, allowed: Allowed, goal: Mapping[str, Zdd]) -> Iterator[Edge]:
        """Those of them that are allowed and lead into a set."""
        name, marked = state[0], frozenset(state[1])
        edges = [
            Edge(toggle.transition, (name, tuple(sorted(marked ^ toggle.changed))))
            for toggle in (self.stages[name].beside(allowed) if name in goal else ())
            if toggle.marked <= marked and toggle.unmarked.isdisjoint(marked)
        ]
        edges += self._fired(state, allowed, goal)
        for edge in sorted(edges, key=lambda edge: edge.transition):
            if self._in(edge.target, goal[edge.target[0]]):
                yield edge

    def _fired(self, state: Member, allowed: Allowed, into: Collection[str]) -> Iterator[Edge]:
        """The edges of the section's own events, those into some sections."""
        stage, first, guards = self.stages[state[0]], self.layout.first_slot, dict(allowed.guards)
        local = tuple(level for level in state[1] if level < first)
        beside = state[1][len(local) :]
        for t, after, exit_ in stage.type.fired(local):
            name = stage.name if exit_ is None else stage.routes[exit_]
            barred = allowed.local is not None and t not in allowed.local
            if barred or name not in into or (t in guards and not self._in(state, guards[t])):
                continue
            if exit_ is None:
                target = (*sorted(after), *beside)
            else:
                marks, own = stage.type.encoding.marks, stage.own_places.items()
                slots = (*beside, *(slot for slot, place in own if marks(after, place)))
                entered = self.closed(name, self.stages[name].entered(self.layout.store.singleton(slots)))
                target = tuple(entered.pick() or ())
            yield Edge(stage.transitions[t], (name, target))

    def _in(self, state: Member, part: Zdd) -> bool:
        # A part is open in the section's own slots, so the member stands for all that it is open to.
        return bool(self.layout.store.singleton(state[1]) & part)

    def run(
        self,
        begin: Member,
        goal: CompositeSet,
        along: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> list[Edge] | None:
        """A run from a member into a goal through as few sections as can be.

        Within each section it is a shortest one; see :meth:`mcpn.space.algebra.Space.run`.

        Raises:
            TwoOutcomes: The mission is not confluent, and the run would pass such an event.
        """
        allowed = self.filtered(transitions, guards)
        within = (self.everything if along is None else along).parts
        hops = self._hops(begin, goal, within, allowed)
        if hops is None:
            return None
        run, state = list[Edge](), begin
        while hops:  # each edge out of a section leads one section nearer
            _, targets = hops.pop()
            name, stage = state[0], self.stages[state[0]]
            layers = [targets[name]]  # back to one that holds the state: by the length of shortest runs
            seen = targets[name]
            while not self._in(state, layers[-1]):
                layers.append((stage.back(layers[-1], allowed(name)) & within[name]) - seen)
                assert layers[-1], "there is a run"
                seen |= layers[-1]
            onward: list[Mapping[str, Zdd]] = [{name: layer} for layer in reversed(layers[:-1])]
            for target in [*onward, *(closed for closed, _ in hops[-1:])]:
                edge = next(self._edges(state, allowed(state[0]), target), None)
                if edge is None:
                    raise TwoOutcomes(run)
                run.append(edge)
                state = edge.target
        return run

    def _hops(
        self,
        begin: Member,
        goal: CompositeSet,
        within: Mapping[str, Zdd],
        allowed: Callable[[str], Allowed],
    ) -> list[tuple[Parts, Parts]] | None:
        """By number of sections to leave before the goal: from which states, and to which."""
        hops: list[tuple[Parts, Parts]] = []
        seen, targets = Parts(), Parts(goal.parts)
        while targets:
            closed, onward = Parts(), Parts()
            for name, target in targets.items():
                stage = self.stages[name]
                found = stage.type.reaching(target, within.get(name, self.empty), allowed(name))
                closed.add(name, found - seen.get(name, self.empty))
                if seen.add(name, found):
                    for before, leaving in self.leaving_for(
                        name, stage.entries(closed[name]), within, allowed
                    ):
                        onward.add(before, leaving)
            hops.append((closed, targets))
            if begin[0] in closed and self._in(begin, closed[begin[0]]):
                return hops
            targets = onward
        return None
