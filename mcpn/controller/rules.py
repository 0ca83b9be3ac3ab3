"""From big steps to the rules of a modular controller (:mod:`mcpn.controller.modular`)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import groupby
from operator import attrgetter, or_, xor

import numpy as np

from mcpn._kernel import BigSteps as KernelSteps
from mcpn._kernel import MemoryLimit, StateLimit, Zdd
from mcpn.answers.verdicts.modes import said_as
from mcpn.composite.composite import CompositeSpace
from mcpn.composite.layout import idle_places
from mcpn.composite.section_type import SectionType
from mcpn.controller.decisions import EventParts
from mcpn.controller.hierarchy import placed_machines
from mcpn.controller.machine import Ordered, Ordering, situations
from mcpn.controller.modular import Effect, ModularController, Rule, Rules, Shown, StatusBits
from mcpn.controller.ordering_states import conditions
from mcpn.controller.reaction import EventReaction, Remembering
from mcpn.controller.reduce import Cube, levels_of, reduced
from mcpn.controller.run_to_completion import Runner, Stopped
from mcpn.controller.sizes import count_steps, each_step, representatives
from mcpn.drawing.status import Element
from mcpn.errors import LimitError
from mcpn.events import Event
from mcpn.spaces.markings.explicit import KernelNet
from mcpn.spaces.markings.graph import StateGraph, pack
from mcpn.spaces.stable.big_steps import FEW_CASES, MOST_KEPT, MOST_STEPS, is_function

FEW_RULES = 50
"""Big steps of one event up to which each is a rule: where they are more, its parts are looked for."""


def modular_controller(composite: CompositeSpace) -> ModularController:
    """Generates the controller of a mission with rules for each type of section.

    Args:
        composite: The mission's composite.

    Raises:
        LimitError: A section has no big steps.
    """
    types = {type_: _Maker(type_, name).rules() for type_, name in representatives(composite).items()}
    return ModularController(
        composite.mission_net.core.name,
        composite.layout.hardware,
        composite.mission_net.graph.entry,
        placed_machines(composite, {type_: rules.events for type_, rules in types.items()}),
        tuple(types.values()),
    )


class _Singly:
    """Finds the big steps of an event one by one.

    Args:
        type_: The type of sections.
    """

    def __init__(self, type_: SectionType) -> None:
        self._type = type_
        self._net = type_.net.net
        self._prepared = KernelNet(self._net)
        self._label = {t: label for label, t in enumerate(self._prepared.transitions)}
        self._slots = range(type_.layout.first_slot, type_.layout.store.levels)
        self._kernel: KernelSteps | None = None

    def _begun(self) -> KernelSteps:
        encoding = self._type.encoding
        beside = [-1] * (self._type.layout.store.levels - len(encoding.places))
        return KernelSteps(
            self._prepared.kernel,
            self._prepared.initial,
            [*encoding.places, *beside],
            [(place, encoding.level[kept]) for place, kept in encoding.partner.items()],
            encoding.memory_limit,
            MOST_KEPT,
            FEW_CASES,
        )

    def steps(self, transition: int, most: int) -> bytes | None:
        """The big steps of an event; ``None`` where there are more than allowed, or one has no outcome."""
        type_, safe = self._type, self._net.safe_transitions[transition]
        states = type_.before if transition == type_.net.start else type_.inside
        states = states.subset(unmarked=self._slots)
        states = type_.encoding.restricted(states, (*safe.consume, *safe.read))
        if not states:
            return b""
        self._kernel = self._kernel or self._begun()
        found = None
        with suppress(MemoryLimit, StateLimit):
            found = self._kernel.cover(states, self._label[transition], most)
        if found is None:
            self._kernel = None  # which has come to trouble
        return found[0] if found is not None and found[2] else None


@dataclass(frozen=True, slots=True)
class _Way:
    """A big step restricted to a set of states, which is not empty.

    Args:
        transition: The transition of its event.
        asked: The levels that it has a literal on; masks have a bit for each level.
        marked: Those of them that are marked.
        changes: The levels that change.
        states: The states, in all of which it has the same outcome.
    """

    transition: int
    asked: int
    marked: int
    changes: int
    states: Zdd


@dataclass(frozen=True, slots=True)
class _Shown(_Way):
    """A big step with its run in one of its states, from which the actions are computed.

    Args:
        before: The marking of that state, a bit for each place.
        after: The marking after the run.
        stopped: What the run does to activities and objectives.
    """

    before: int
    after: int
    stopped: Stopped


class _Maker:
    """Makes the rules of one type of sections.

    Args:
        type_: The type.
        section: The name of the section that stands for it.

    Raises:
        LimitError: It has no big steps.
    """

    def __init__(self, type_: SectionType, section: str) -> None:
        self.type = type_
        self.net = type_.net
        self.encoding = type_.encoding
        self.runner = Runner(type_.net)
        self.exits = {self._mask([place]): exit_ for exit_, place in type_.net.exits.items()}
        active: dict[str, list[int]] = {}
        for place, name in type_.net.saying("active").items():
            active.setdefault(name.split(".", 1)[0], []).append(place)
        self.active = active
        objective = {name: place for place, name in type_.net.saying("objective").items()}
        self.naming: dict[str, list[int]] = {}
        for section_ in type_.net.graph.walk():
            for activity in section_.activities:
                if section_.name in objective:
                    self.naming.setdefault(activity, []).append(objective[section_.name])
        self._running = {activity: self._mask(places) for activity, places in active.items()}
        """By activity, the levels that say that it runs."""
        self._resting = {
            activity: (self._mask(levels_of(places)), self._mask_of(at_rest))
            for activity, (places, at_rest) in self.runner.control.items()
        }
        """By activity, the levels of its own places, and those of them marked while it is idle."""
        said = [place for role in ("objective", "pending", "done") for place in type_.net.saying(role)]
        homeless = self.encoding.restricted(type_.inside, (), said)
        running = [place for places in active.values() for place in places]
        # The order of actions depends on the section, which objectives name. If something may run in a state
        # with none of these places marked, rules must ask for them, too.
        self.home = said if any(self.encoding.restricted(homeless, [p]) for p in running) else []
        self.ordering = Ordering(type_.net.usage, type_.net.graph)
        self.shown, self.carried = self._saying()
        self.steps = dict[int, bytes]()
        """By transition, the big steps of its event, where they are few."""
        self.products = dict[int, EventParts]()
        """By transition, the parts of its event, where its big steps are many."""
        self._part_events(section)

    def _part_events(self, section: str) -> None:
        """Finds which events have few big steps, and of the others the parts."""
        transitions, known = self.net.net.transitions, self.type.steps
        singly = _Singly(self.type)
        remembering: Remembering | None = None
        for t in range(len(transitions)) if known is None else sorted(known):
            if transitions[t].internal or self.net.net.safe_transitions[t].blocked:
                continue
            found = None if known is None else known[t]
            assert found is not None or known is None, "nothing dies"
            steps = singly.steps(t, FEW_RULES) if found is None or is_function(found) else found
            if steps is None or count_steps(steps) > FEW_RULES:
                remembering = remembering or Remembering(self.type, self.runner)
                if parts := self._parts(remembering.reaction(t)):
                    self.products[t] = parts
                    continue
                if steps is None:
                    steps = singly.steps(t, MOST_STEPS)
            if steps is None:
                raise LimitError(
                    f"section {section}: its events have too many big steps to be told by rules, or one need "
                    "not have one outcome where the mission never comes: it has no modular controller"
                )
            self.steps[t] = steps

    def _parts(self, reaction: EventReaction | None) -> EventParts | None:
        """The parts of an event; ``None`` where it has none."""
        if reaction is None or self.home:
            return None
        planned = conditions(self.net, self.ordering, reaction)
        if planned is None:
            return None
        exits = {exit_: reaction.after(place) for exit_, place in self.net.exits.items()}
        spoken = {said >> 1 for said in (*(said for *_, said in self.shown), *self.carried)}
        return EventParts(reaction, planned, exits, spoken, {said >> 1 for said in self.carried})

    def rules(self) -> Rules:
        """The rules."""
        ways = self._settled([way for t in self.steps for way in self._ways(t)])
        markings = [marking for way in ways for marking in (way.before, way.after)]
        ordered = Ordered(self.net, situations(self.net, markings))
        transitions = self.net.net.transitions
        taken = {way.transition for way in ways} | self.products.keys()
        found = {_event(transitions[t].event) for t in taken if t != self.net.start}
        numbers = {event: number for number, event in enumerate(sorted(found))}
        cubes = list[Cube]()
        for i, way in enumerate(ways):
            t = way.transition
            starts = t == self.net.start
            event = -1 if starts else numbers[_event(transitions[t].event)]
            safe = self.net.net.safe_transitions[t]
            enabling = 0 if starts else self._mask((*safe.consume, *safe.read))
            to = next((exit_ for exits, exit_ in self.exits.items() if way.changes & exits), None)
            actions = ordered.actions(2 * i, 2 * i + 1, way.stopped)
            cubes.append(
                Cube(event, t, way.asked, way.marked, enabling, way.changes, (actions, to), way.states)
            )
        return self._told(tuple(numbers), cubes)

    def _told(self, events: tuple[Event, ...], cubes: list[Cube]) -> Rules:
        """Shortens rules (:func:`reduced`) and renumbers the levels that are left as bits."""
        part, levels = self.type.part, len(self.encoding.places)
        bits = {said >> 1 for said in (*(said for *_, said in self.shown), *self.carried)}
        bits.update(literal >> 1 for t in self.products for literal in self._enabling(t))
        while True:  # what a rule asks for must be right after each event
            bits = self._closed(bits)
            shorter, needed = reduced(cubes, bits)
            if (bits := self._closed(needed)) <= needed:
                break
        number = {level: bit for bit, level in enumerate(sorted(bits))}

        def renumbered(literal: int) -> int:
            after, level = divmod(literal >> 1, levels)
            return 2 * (after * len(number) + number[level]) | literal & 1

        def bits_of(levels: int) -> tuple[int, ...]:
            return tuple(bit for level, bit in number.items() if levels >> level & 1)

        effects: dict[Effect, int] = {}
        rules = []

        def rule(event: int, literals: Iterable[int], effect: Effect) -> None:
            rules.append(
                Rule(event, tuple(map(renumbered, literals)), effects.setdefault(effect, len(effects)))
            )

        for event, literals, changes, (actions, to) in shorter:
            rule(event, literals, Effect(bits_of(changes), actions, to))
        nothing, behind = Effect((), ()), len(events)
        for t, parts in self.products.items():
            done = parts.always
            then = tuple(range(behind - len(events), behind - len(events) + len(parts.all)))
            effect = Effect(bits_of(done.changes), done.actions, done.to, then)
            rule(self._number(t, events), self._enabling(t), effect)
            for each in parts.all:
                effect = Effect(bits_of(each.changes), each.actions, each.to)
                for literals, does in each.rules:
                    rule(behind, literals, effect if does else nothing)
                behind += 1
        rules.sort(key=lambda rule: rule.event)  # stable
        flips: dict[Element, int] = dict.fromkeys(part.carried, 0)
        for place, (flag, _) in idle_places(self.net).items():
            flips[flag] |= self._mask([place])
        return Rules(
            hardware=part.faulty,
            once=part.once,
            facts=part.entry_flags,
            events=events,
            bits=len(number),
            idle=bits_of(sum(1 << level for level in self.encoding.marked_levels(self.net.net.initial))),
            status=tuple(
                StatusBits(bits_of(levels), renumbered(said))
                for levels, said in zip(flips.values(), self.carried, strict=True)
            ),
            shown=tuple(Shown(kind, name, renumbered(said)) for kind, name, said in self.shown),
            entries=tuple(rule for rule in rules if rule.event < 0),
            rules=tuple(rule for rule in rules if 0 <= rule.event < len(events)),
            parts=tuple(
                tuple(alike) for event, alike in groupby(rules, attrgetter("event")) if event >= len(events)
            ),
            effects=tuple(effects),
        )

    def _closed(self, bits: set[int]) -> set[int]:
        """Some levels, with those for which parts ask that decide them; they are decided then."""
        closed, more = set[int](), bits
        while not more <= closed:
            closed = closed | more
            for parts in self.products.values():
                parts.decide(closed)
            more = {level for parts in self.products.values() for level in parts.asked}
        return closed

    def _number(self, transition: int, events: Sequence[Event]) -> int:
        if transition == self.net.start:
            return -1
        return events.index(_event(self.net.net.transitions[transition].event))

    def _enabling(self, transition: int) -> tuple[int, ...]:
        """Literals that ask for what a transition consumes and reads, but for the start."""
        safe = self.net.net.safe_transitions[transition]
        asked = () if transition == self.net.start else (*safe.consume, *safe.read)
        return tuple({self._literal(place): None for place in asked})

    def _saying(self) -> tuple[list[tuple[str, str, int]], list[int]]:
        """The literals that say what is shown, and those of the status of what sections hand on."""
        part, literal = self.type.part, self._literal
        shown = [
            (kind, name, literal(place))
            for place, (role, name) in self.net.roles.items()
            if (kind := said_as(role)) is not None and kind not in ("out_of_service", "facts")
        ]
        places = (self.net.flag_bits[flag] for flag in part.carried)
        return shown, [literal(place) ^ reverse for place, reverse in places]

    def _ways(self, transition: int) -> Iterator[_Way]:
        """The big steps of an event; of the start in states before the entry, of others in states inside."""
        rows = self.steps[transition]
        assert rows is not None, "nothing dies"
        within = self.type.before if transition == self.net.start else self.type.inside
        for words in each_step(rows):
            asked = marked = changes = 0
            for word in words:
                level, what = 1 << (word >> 2), word & 3  # consumed, produced, read, read to be empty
                asked |= level
                marked |= level if what in (0, 2) else 0
                changes |= level if what < 2 else 0
            states = within.subset(levels_of(marked), levels_of(asked & ~marked))
            if states:
                yield _Way(transition, asked, marked, changes, states)

    def _settled(self, ways: list[_Way]) -> list[_Shown]:
        """Big steps, split until each has the same actions in all of its states, with a run in one of them.

        In each round every big step that is not done is run in one of its states, and split or done.
        """
        settled: list[_Way] = ways
        while open_ := [i for i, way in enumerate(settled) if not isinstance(way, _Shown)]:
            shown = self._shown([settled[i] for i in open_])
            parts: dict[int, Sequence[_Way]] = {
                i: self._split(way) for i, way in zip(open_, shown, strict=True)
            }
            settled = [part for i, way in enumerate(settled) for part in parts.get(i, (way,))]
        return [way for way in settled if isinstance(way, _Shown)]

    def _shown(self, ways: Sequence[_Way]) -> list[_Shown]:
        """Big steps, each with its run in one of its states; the kernel computes the runs."""
        beginning = self.type.layout.first_slot
        pairs = []
        for way in ways:
            levels = way.states.pick()
            assert levels is not None, "there are some"
            marking = self._packed(level for level in levels if level < beginning)
            pairs.append((marking, marking ^ self._flipped(way.changes)))
        net, count = self.net.net, len(ways)
        edges = StateGraph(
            net,
            pack((marking for pair in pairs for marking in pair), len(net.places)),
            np.arange(1, 2 * count + 2, dtype=np.int64) // 2,
            np.arange(1, 2 * count, 2, dtype=np.int64),
            np.array([way.transition for way in ways], np.int64),
        )
        numbers, kinds = self.runner.passages(edges)
        return [
            _Shown(way.transition, way.asked, way.marked, way.changes, way.states, *pair, kinds[number])
            for way, pair, number in zip(ways, pairs, numbers.tolist(), strict=True)
        ]

    def _split(self, way: _Shown) -> Sequence[_Way]:
        """The big step where its actions are the same in all of its states, else two with fewer states."""
        deciding = self._deciding(way, self._mask_of(way.before))
        if deciding is None:
            return (way,)
        level, states = 1 << deciding, way.states
        sides = (0, states.subset(unmarked=[deciding])), (level, states.subset([deciding]))
        asked = way.asked | level
        return [
            _Way(way.transition, asked, way.marked | side, way.changes, some) for side, some in sides if some
        ]

    def _deciding(self, way: _Shown, before: int) -> int | None:
        """A level without a literal that differs between the states and may change the actions, if any."""
        active, states = self.active, way.states
        touched = set(way.stopped.activities)
        for activity, levels in self._running.items():
            if levels & way.changes:
                touched.add(activity)
        places = [p for a in touched for p in (*active[a], *self.naming.get(a, ()))] + self.home
        left = self._mask(places) & ~way.asked
        if states.subset(levels_of(before & left), levels_of(~before & left)) != states:
            return self._parting(states, left)
        for activity in way.stopped.activities:
            levels, at_rest = self._resting[activity]
            left = levels & ~way.asked
            if not left:
                continue
            resting = states.subset(levels_of(at_rest & left), levels_of(~at_rest & left))
            if resting and resting != states:
                return self._parting(states, left)
        return None

    def _parting(self, states: Zdd, among: int) -> int:
        """A level that is marked in some states and not in others."""
        for level in levels_of(among):
            marked = states.subset([level])
            if marked and marked != states:
                return level
        raise AssertionError("states that differ on some levels differ on one")

    def _literal(self, place: int) -> int:
        level, reverse = self.encoding.bit(place)
        return 2 * level | (not reverse)

    def _mask(self, places: Iterable[int]) -> int:
        """The levels that encode some places."""
        return sum({1 << self.encoding.bit(place)[0] for place in places})

    @cached_property
    def _flips(self) -> list[int]:
        """By level, the places that change as it does, a bit for each."""
        flips = [1 << place for place in self.encoding.places]
        for dropped, kept in self.encoding.partner.items():
            flips[self.encoding.level[kept]] |= 1 << dropped
        return flips

    def _flipped(self, levels: int) -> int:
        """The places that change as some levels do."""
        return reduce(or_, (self._flips[level] for level in levels_of(levels)), 0)

    def _packed(self, levels: Iterable[int]) -> int:
        """A marking as :class:`Runner` has it, from its marked levels."""
        unmarked = sum(1 << dropped for dropped in self.encoding.partner)
        return reduce(xor, (self._flips[level] for level in levels), unmarked)

    def _mask_of(self, marking: int) -> int:
        """The marked levels of such a marking."""
        level = self.encoding.level
        return sum(1 << level[place] for place in levels_of(marking) if place in level)


def _event(event: Event | None) -> Event:
    assert event is not None, "big steps are of events"
    return event
