"""What one event does in all states of a section at once, with what happens to activities on the way.

The state after an event does not say whether an activity that runs before and after it has gone on, or has
been restarted. So the net of the section gets places that remember: one for each activity, that it has come
to rest since the event, and one for each of its alternatives, that it was left. They are set by internal
transitions that come before all others, and nothing but these asks for them; so what the net does is not
changed. The event is then run to completion from whole sets of states (:mod:`mcpn.spaces.stable.big_steps`).
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from operator import or_

from mcpn._kernel import BigSteps as KernelSteps
from mcpn._kernel import MemoryLimit, StateLimit, Zdd, choices
from mcpn.composite.section_type import SectionType
from mcpn.controller.run_to_completion import Runner
from mcpn.controller.sizes import each_step
from mcpn.nets.petri import Arcs, PetriNet, Place, Transition
from mcpn.nets.structure import incidence
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.diagrams.symbolic import DEFAULT_MEMORY
from mcpn.spaces.markings.explicit import KernelNet
from mcpn.spaces.markings.masked import bits_of
from mcpn.spaces.stable.big_steps import FEW_CASES, MOST_KEPT, MOST_SINGLY, is_function


class Remembering:
    """The net of a type of sections with places that remember, on a store of its own.

    Args:
        type_: The type.
        runner: Its net, as events run it to completion.

    Attributes:
        encoding: The net on the levels of the store.
        level: By level of the type's store, that of the same place.
        active: By activity, by alternative, the place that says that it runs.
    """

    def __init__(self, type_: SectionType, runner: Runner) -> None:
        self.type = type_
        self.timed: dict[str, list[int]] = {}
        """By objective or block with a timeout, the places that say that it runs."""
        for place, name in runner.timed.items():
            self.timed.setdefault(name, []).append(place)
        self.active: dict[str, dict[str, int]] = {}
        for place, name in type_.net.saying("active").items():
            activity, alternative = name.split(".", 1)
            self.active.setdefault(activity, {})[alternative] = place
        draft = _Draft(type_.net.net, type_.encoding)
        self._ran: dict[int, int] = {}
        """By place of an alternative, the place that is marked until it is left."""
        self._busy: dict[str, int] = {}
        """By activity, the place that is marked until it comes to rest."""
        for activity, ways in self.active.items():
            places, at_rest = runner.control[activity]
            rest = bits_of(at_rest)
            empty = [draft.unmarked(place) for place in bits_of(places & ~at_rest)]
            self._busy[activity] = draft.remember([*rest, *empty])
            for place in ways.values():
                self._ran[place] = draft.remember([draft.unmarked(place)])
        for place in runner.timed:
            self._ran[place] = draft.remember([draft.unmarked(place)])
        behind: dict[int, list[int]] = {}
        for place, ran in self._ran.items():
            behind.setdefault(type_.encoding.bit(place)[0], []).append(ran)
        for activity, ways in self.active.items():
            last = max(type_.encoding.bit(place)[0] for place in ways.values())
            behind[last].append(self._busy[activity])
        order = [
            p for level, place in enumerate(type_.encoding.places) for p in (place, *behind.get(level, ()))
        ]
        net = draft.built()
        self.encoding = Encoding(net, tuple(order), DEFAULT_MEMORY)
        self.level = [self.encoding.level[place] for place in type_.encoding.places]
        self._prepared = KernelNet(net)
        self._label = {t: label for label, t in enumerate(self._prepared.transitions)}
        count = len(net.places)
        self._kernel = KernelSteps(
            self._prepared.kernel,
            self._prepared.initial,
            list(self.encoding.places),
            [(place, self.encoding.level[kept]) for place, kept in self.encoding.partner.items()],
            DEFAULT_MEMORY,
            MOST_KEPT,
            FEW_CASES,
        )
        assert count == len(self.encoding.places) + len(self.encoding.partner)

    def reaction(self, transition: int) -> EventReaction | None:
        """What an event does in all states that enable its transition; ``None`` where that is not found."""
        type_ = self.type
        within = type_.before if transition == type_.net.start else type_.inside
        states = self._begun(self._taken(within), transition)
        if not states:
            return None
        label = self._label[transition]
        try:
            found = self._kernel.after(states, label)
            if found is None:
                return None
            _, left, firings = found
            whole = states - left
            steps = self._kernel.function(whole, firings) or b"" if whole else b""
            if not steps:
                left = states
            if left:
                covering = self._kernel.cover(left, label, MOST_SINGLY)
                if covering is None or not covering[2]:
                    return None
                steps += covering[0]
        except (MemoryLimit, StateLimit):
            return None
        return EventReaction(self, states, steps)

    def left(self, place: int) -> int:
        """The level that is unmarked after an event where what a place says was left."""
        return self.encoding.level[self._ran[place]]

    def idled(self, activity: str) -> int:
        """The level that is unmarked after an event where an activity has come to rest."""
        return self.encoding.level[self._busy[activity]]

    def _taken(self, states: Zdd) -> Zdd:
        """Some states of the type, on this store, with nothing to remember."""
        layout = self.type.layout
        rows = array("I", states.subset(unmarked=range(layout.first_slot, layout.store.levels)).to_bytes())
        if rows[0] < len(self.level):
            rows[0::3] = array("I", [self.level[level] for level in rows[0::3]])
        else:
            rows[0] = self.encoding.store.levels
        return self.encoding.store.from_bytes(rows.tobytes())

    def _begun(self, states: Zdd, transition: int) -> Zdd:
        """Those of some states that enable a transition, as an event begins there: what runs is marked."""
        encoding, safe = self.encoding, self.encoding.net.safe_transitions[transition]
        asked = (*safe.consume, *safe.read)
        states = encoding.restricted(states, asked)
        also = {place: [ran] for place, ran in self._ran.items()}
        for activity, ways in self.active.items():
            for place in ways.values():
                also[place].append(self._busy[activity])
        for place, those in also.items():
            running = encoding.restricted(states, [place])
            event = encoding.store.event([], sorted(encoding.levels(those)))
            states = (states - running) | running.images([event])
        return states


class _Draft:
    """A net to which places and internal transitions are added, which come before all others."""

    def __init__(self, net: PetriNet, encoding: Encoding) -> None:
        self._net = net
        self._places = list(net.places)
        self._consume = [dict(t.consume) for t in net.transitions]
        self._produce = [dict(t.produce) for t in net.transitions]
        self._changes = incidence(net)
        self._added: list[Transition] = []
        self._complement = dict(encoding.partner) | {kept: p for p, kept in encoding.partner.items()}

    def unmarked(self, place: int) -> int:
        """The place that is marked where another one is not."""
        if place not in self._complement:
            new = self._place(1 - self._places[place].initial)
            for t, change in self._changes[place].items():
                (self._consume if change > 0 else self._produce)[t][new] = abs(change)
            self._complement[place] = new
        return self._complement[place]

    def remember(self, marked: Sequence[int]) -> int:
        """A place that loses its token as soon as some places are marked."""
        before, after = self._place(1), self._place(0)
        read = tuple((p, 1) for p in sorted(set(marked)))
        self._added.append(Transition(f"remembered {before}", ((before, 1),), ((after, 1),), read))
        return before

    def built(self) -> PetriNet:
        """The net."""
        old = [
            replace(
                t,
                consume=_arcs(consume),
                produce=_arcs(produce),
                rank=t.rank + 1 if t.internal else t.rank,
            )
            for t, consume, produce in zip(self._net.transitions, self._consume, self._produce, strict=True)
        ]
        return PetriNet(self._net.name, tuple(self._places), (*old, *self._added), priorities=True)

    def _place(self, initial: int) -> int:
        self._places.append(Place(f"remembered place {len(self._places)}", initial))
        return len(self._places) - 1


def _arcs(weights: Mapping[int, int]) -> Arcs:
    return tuple(sorted(weights.items()))


class EventReaction:
    """What an event does in all states that enable its transition, on the store of a remembering net.

    Args:
        remembering: The net.
        states: The states, as the event begins.
        steps: Its big steps from them.
    """

    def __init__(self, remembering: Remembering, states: Zdd, steps: bytes) -> None:
        self.remembering = remembering
        self.states = states
        store = remembering.encoding.store
        self._back = choices(store, steps, "back", ())
        self._ahead = choices(store, steps, "ahead", ())
        self.nothing = store.empty()
        self.ends = states.images(self._ahead)
        self._led: dict[int, Zdd] = {}
        self._touched = _touched(steps)

    def leading(self, level: int) -> Zdd:
        """The states after which a level is marked."""
        if level not in self._touched:
            return self.states.subset([level])
        if level not in self._led:
            goal = self.ends.subset([level])
            self._led[level] = goal.images(self._back, within=self.states) if goal else goal
        return self._led[level]

    def flipping(self, level: int) -> Zdd:
        """The states after which a level is not what it is in them."""
        if level not in self._touched:
            return self.nothing
        before, after = self.states.subset([level]), self.leading(level)
        return (before - after) | (after - before)

    def before(self, place: int) -> Zdd:
        """The states that mark a place."""
        return self.remembering.encoding.restricted(self.states, [place])

    def after(self, place: int) -> Zdd:
        """The states after which a place is marked."""
        level, reverse = self.remembering.encoding.bit(place)
        return self.states - self.leading(level) if reverse else self.leading(level)

    def left(self, place: int) -> Zdd:
        """The states in which an alternative or a timed objective runs, given by its place, and is left."""
        return self.before(place) - self.leading(self.remembering.left(place))

    def idled(self, activity: str) -> Zdd:
        """The states in which an activity runs and comes to rest."""
        running = self.union(map(self.before, self.remembering.active[activity].values()))
        return running - self.leading(self.remembering.idled(activity))

    def union(self, sets: Iterable[Zdd]) -> Zdd:
        """The union of some sets."""
        return reduce(or_, sets, self.nothing)


def _touched(steps: bytes) -> set[int]:
    """The levels that some big steps change."""
    touched = set[int]()
    if is_function(steps):
        end = 2 + memoryview(steps).cast("I")[1]
        rows = array("I", steps[8 : 4 * end])
        touched = {level for level, touch in zip(rows[0::4], rows[1::4], strict=True) if touch < 2}
        steps = steps[4 * end :]
    for words in each_step(steps):
        touched.update(word >> 2 for word in words if word & 3 < 2)
    return touched
