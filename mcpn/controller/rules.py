"""From big steps to the rules of a modular controller (:mod:`mcpn.controller.modular`)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from mcpn._kernel import Zdd
from mcpn.check.verdicts.modes import said_as
from mcpn.controller.hierarchy import placed_machines
from mcpn.controller.machine import Ordered, situations
from mcpn.controller.modular import Effect, ModularController, Rule, Rules, Shown, Status
from mcpn.controller.reduce import Cube, levels_of, reduced
from mcpn.controller.run import Passage, Runner
from mcpn.controller.sizes import each_step, standing
from mcpn.errors import LimitError
from mcpn.net.events import Event
from mcpn.net.sections import Element
from mcpn.space.diagrams.encoding import Encoding
from mcpn.space.local.composite import CompositeSpace
from mcpn.space.local.layout import idle_places
from mcpn.space.local.section_type import SectionType
from mcpn.space.markings.explicit import KernelNet
from mcpn.space.stable.big_steps import MOST_STEPS, is_function, reach_in_big_steps


def modular_controller(composite: CompositeSpace) -> ModularController:
    """Generates the controller of a mission with rules for each type of section.

    Args:
        composite: The mission's composite.

    Raises:
        LimitError: A section has no big steps.
    """
    types = {type_: _Maker(type_, name).rules() for type_, name in standing(composite).items()}
    return ModularController(
        composite.mission_net.mission.name,
        composite.layout.hardware,
        composite.mission_net.graph.entry,
        placed_machines(composite, {type_: rules.events for type_, rules in types.items()}),
        tuple(types.values()),
    )


def big_steps(type_: SectionType, section: str) -> Mapping[int, bytes | None]:
    """The big steps of a type of sections.

    Raises:
        LimitError: It has none.
    """
    if type_.steps is None:
        raise LimitError(
            f"section {section}: its events have too many big steps to be told by rules, or one need not "
            "have one outcome where the mission never comes: it has no modular controller"
        )
    if not any(steps is not None and is_function(steps) for steps in type_.steps.values()):
        return type_.steps
    encoding = Encoding(type_.net.net, type_.encoding.places, type_.encoding.memory_limit)
    found = reach_in_big_steps(KernelNet(type_.net.net), encoding, MOST_STEPS)
    if found is None:
        raise LimitError(f"section {section}: its events have too many big steps to be told by rules")
    return found[1]


@dataclass(slots=True)
class _Way:
    """A big step of some states, and what happens in one of them.

    Masks have a bit for each level.
    """

    transition: int
    asked: int
    marked: int
    changes: int
    states: Zdd
    levels: list[int]
    """The marked levels of one of them."""


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
        self.steps = big_steps(type_, section)
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
        said = [place for role in ("objective", "pending", "done") for place in type_.net.saying(role)]
        homeless = self.encoding.restricted(type_.inside, (), said)
        running = [place for places in active.values() for place in places]
        # Where no objective says which section it is of, nothing may run, or the order of actions is unknown.
        self.home = said if any(self.encoding.restricted(homeless, [p]) for p in running) else []

    def rules(self) -> Rules:
        """The rules."""
        ways = [way for t in self.steps for way in self._ways(t)]
        markings, passages = list[int](), list[Passage]()
        for way in ways:
            marking = self._packed(way.levels)
            passage = self.runner.fire(marking, way.transition)
            markings += [marking, passage.marking]
            passages.append(passage)
        ordered = Ordered(self.net, situations(self.net, markings))
        transitions = self.net.net.transitions
        found = {
            _event(transitions[way.transition].event) for way in ways if way.transition != self.net.start
        }
        numbers = {event: number for number, event in enumerate(sorted(found))}
        cubes = list[Cube]()
        for i, (way, passage) in enumerate(zip(ways, passages, strict=True)):
            t = way.transition
            starts = t == self.net.start
            event = -1 if starts else numbers[_event(transitions[t].event)]
            safe = self.net.net.safe_transitions[t]
            enabling = 0 if starts else self._mask((*safe.consume, *safe.read))
            to = next((exit_ for exits, exit_ in self.exits.items() if way.changes & exits), None)
            actions = ordered.actions(2 * i, 2 * i + 1, passage)
            cubes.append(
                Cube(event, t, way.asked, way.marked, enabling, way.changes, (actions, to), way.states)
            )
        return self._told(tuple(numbers), cubes)

    def _told(self, events: tuple[Event, ...], cubes: list[Cube]) -> Rules:
        """The rules on bits, numbered as they are spoken of."""
        part, literal = self.type.part, self._literal
        shown = [
            (kind, name, literal(place))
            for place, (role, name) in self.net.roles.items()
            if (kind := said_as(role)) is not None and kind not in ("out_of_service", "facts")
        ]
        reverse = dict[str, bool]()
        saying = {("hardware", name): place for place, name in self.net.saying("oos").items()}
        saying |= {("once", name): place for place, name in self.net.saying("happened").items()}
        for flag in part.flags:
            saying["fact", flag], reverse[flag] = self.net.true_of_fact(flag)
        carried = [literal(saying[of]) ^ reverse.get(of[1], False) for of in part.carried]
        spoken = {told >> 1 for told in (*(told for *_, told in shown), *carried)}
        found, bits = reduced(cubes, spoken)
        number = {level: bit for bit, level in enumerate(sorted(bits))}

        def renumbered(told: int) -> int:
            return 2 * number[told >> 1] | told & 1

        def those(levels: int) -> tuple[int, ...]:
            return tuple(bit for level, bit in number.items() if levels >> level & 1)

        effects: dict[Effect, int] = {}
        rules = []
        for event, literals, changes, (actions, to) in found:
            effect = effects.setdefault(Effect(those(changes), actions, to), len(effects))
            rules.append(Rule(event, tuple(map(renumbered, literals)), effect))
        rules.sort(key=lambda rule: rule.event)  # stable
        flips: dict[Element, int] = dict.fromkeys(part.carried, 0)
        for place, (of, _, _) in idle_places(self.net).items():
            flips[of] |= self._mask([place])
        return Rules(
            part.faulty,
            part.once,
            part.flags,
            events,
            len(number),
            those(sum(1 << level for level in self.encoding.marked_levels(self.net.net.initial))),
            tuple(
                Status(those(levels), renumbered(told))
                for levels, told in zip(flips.values(), carried, strict=True)
            ),
            tuple(Shown(kind, name, renumbered(told)) for kind, name, told in shown),
            tuple(rule for rule in rules if rule.event < 0),
            tuple(rule for rule in rules if rule.event >= 0),
            tuple(effects),
        )

    # --- big steps, split where actions need it ---

    def _ways(self, transition: int) -> Iterator[_Way]:
        """The big steps of an event, of states before the entry for the start, and inside for others."""
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
            yield from self._split(_Way(transition, asked, marked, changes, states, []))

    def _split(self, way: _Way) -> Iterator[_Way]:
        """A big step of some states, or several of parts of them, each with the same actions throughout."""
        states = way.states
        picked = states.pick()
        if picked is None:
            return
        way.levels = [level for level in picked if level < self.type.layout.first_slot]
        passage = self.runner.fire(self._packed(way.levels), way.transition)
        before = sum(1 << level for level in way.levels)
        assert self._mask_of(passage.marking) == before ^ way.changes, (
            "a big step is the outcome of its event"
        )
        deciding = self._deciding(way, passage, before)
        if deciding is None:
            yield way
            return
        level = 1 << deciding
        for marked in (0, level):
            some = states.subset([deciding]) if marked else states.subset(unmarked=[deciding])
            yield from self._split(
                _Way(way.transition, way.asked | level, way.marked | marked, way.changes, some, [])
            )

    def _deciding(self, way: _Way, passage: Passage, before: int) -> int | None:
        """A level that the big step does not look at, that differs between its states, and may matter."""
        control, active, states = self.runner.control, self.active, way.states
        touched = set(passage.left)
        for activity, places in active.items():
            if self._mask(places) & way.changes:
                touched.add(activity)
        places = [p for a in touched for p in (*active[a], *self.naming.get(a, ()))] + self.home
        left = self._mask(places) & ~way.asked
        if states.subset(levels_of(before & left), levels_of(~before & left)) != states:
            return self._parting(states, left)
        for activity in passage.left:
            places = levels_of(control[activity][0])
            left = self._mask(places) & ~way.asked
            if not left:
                continue
            at_rest = self._mask_of(control[activity][1]) & left
            resting = states.subset(levels_of(at_rest), levels_of(~at_rest & left))
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

    # --- places, levels, markings ---

    def _literal(self, place: int) -> int:
        level, reverse = self.encoding.bit(place)
        return 2 * level | (not reverse)

    def _mask(self, places: Iterable[int]) -> int:
        """The levels that speak of some places."""
        return sum({1 << self.encoding.bit(place)[0] for place in places})

    def _packed(self, levels: list[int]) -> int:
        """A marking as :class:`Runner` has it, from its marked levels."""
        return sum(1 << place for place, tokens in enumerate(self.encoding.marking(levels)) if tokens)

    def _mask_of(self, marking: int) -> int:
        """The marked levels of such a marking."""
        return sum(1 << level for level, place in enumerate(self.encoding.places) if marking >> place & 1)


def _event(event: Event | None) -> Event:
    assert event is not None, "big steps are of events"
    return event
