"""Runs of a mission through its sections, found on the composite and told in mission words."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from mcpn.check.runs import Step, replay, what_happens
from mcpn.net.events import START, Event, What
from mcpn.net.templates import TemplateSet
from mcpn.space.local.composite import ENDS, Composite, Tear
from mcpn.space.local.interface import HardwareStates
from mcpn.space.local.placing import PlacedSection
from mcpn.space.local.protocol import OUTCOMES, Outcome

Layer = dict[str, Any]
"""By section, states of its local space that runs of one length lead to and no shorter ones."""


@dataclass(frozen=True)
class Leg:
    """One section of a journey.

    Args:
        placed: The section.
        entry: Mask of its hardware out of service at its entry.
        transitions: Event transitions of its local net from the first state inside on; the last one leaves
            the section, but for a journey that ends inside.
        left: Mask of its hardware out of service where the next section is entered.
        toggled: Other hardware that fails or recovers meanwhile, before the section is left: names and
            whether they fail.
    """

    placed: PlacedSection
    entry: int
    transitions: tuple[int, ...]
    left: int = 0
    toggled: tuple[tuple[str, bool], ...] = ()


class Journeys:
    """Finds short runs through the sections of a composite, breadth first on sets of states.

    What hardware does that a section does not use is not counted: a run found is shortest but for that.
    Runs are looked for first in which such hardware is in service when it comes to be used.

    Args:
        composite: The mission's composite.
    """

    def __init__(self, composite: Composite) -> None:
        self.composite = composite
        self._waves = [_Wave(composite, free=False), _Wave(composite, free=True)]

    def find(self, ends: Iterable[str] = (), states: Mapping[str, Any] | None = None) -> list[Leg] | None:
        """A short run to an end of the mission, or to some state inside a section.

        Args:
            ends: ``succeed`` or ``fail``, where such an end will do.
            states: By section, the states of its local space that will do.

        Returns:
            The run section by section, or ``None`` where there is none.
        """
        wanted = frozenset(ends)
        found = self._nearest(lambda _, name: self._goals(name, wanted, states or {}))
        return None if found is None else self._with_toggles(found[1])

    def _nearest(self, goals: Callable[[_Wave, str], Iterable[_Goal]]) -> tuple[_Wave, list[Leg]] | None:
        """A short run to a goal of some section, and the wave in which it was found."""
        for wave in self._waves:
            for length, layer in enumerate(wave.layers()):
                for name, reached in layer.items():
                    for goal in goals(wave, name):
                        legs = wave.back(length, name, reached, goal)
                        if legs is not None:
                            return wave, legs
        return None

    def to_tear(self, tear: Tear) -> list[Leg]:
        """A short run to the state before an event without one outcome; to the entry if that is the event.

        Args:
            tear: Where the mission comes to it.
        """
        name, here = tear.section.section.name, tear.here
        if here.event != START:
            legs = self.find(states={name: here.states})
            assert legs is not None, "the mission comes there"
            return legs
        entering = tear.section.local.hardware(here.states, tear.section.frame)
        if tear.section is self.composite.first:
            return [Leg(tear.section, entering.pick(), ())]
        return self._into(tear.section, entering)

    def _into(self, target: PlacedSection, hardware: HardwareStates) -> list[Leg]:
        """A short run that enters a section with its hardware in one of some states."""

        def goals(wave: _Wave, name: str) -> Iterator[_Goal]:
            placed = self.composite.by_name[name]
            yield _Goal(placed.ending(wave.ends_into(placed, target, hardware)), inside=False)

        found = self._nearest(goals)
        assert found is not None, "the mission enters it so"
        wave, legs = found
        left = legs[-1].placed.frame.of_mask(legs[-1].left)
        entry = (hardware & left.seen_by(target.frame, free=wave.free)).pick()
        return self._with_toggles([*legs, Leg(target, entry, ())])

    def _goals(self, name: str, ends: frozenset[str], states: Mapping[str, Any]) -> Iterator[_Goal]:
        if name in states:
            yield _Goal(states[name], inside=True)
        for outcome in OUTCOMES:
            if self.composite.route(name, outcome) in ends:
                yield _Goal(self.composite.by_name[name].local.ended[outcome], inside=False)

    def _with_toggles(self, legs: list[Leg]) -> list[Leg]:
        """The legs with what other hardware must do before each next section is entered."""
        out = dict.fromkeys(self.composite.faulty, False)
        found: list[Leg] = []
        for leg, following in zip(legs, [*legs[1:], None], strict=True):
            out |= _out(leg.placed, leg.entry)
            if following is None:
                found.append(leg)
                break
            out |= _out(leg.placed, leg.left)
            wanted = _out(following.placed, following.entry)
            found.append(replace(leg, toggled=tuple((h, o) for h, o in wanted.items() if out[h] != o)))
        return found


def _out(placed: PlacedSection, mask: int) -> dict[str, bool]:
    return {name: bool(mask >> bit & 1) for bit, name in enumerate(placed.faulty)}


@dataclass(frozen=True)
class _Goal:
    """States that a run is to lead to: inside a section, or after it."""

    states: Any
    inside: bool


class _Wave:
    """Layers of states by the length of runs to them, made as far as they are asked for.

    Args:
        composite: The mission's composite.
        free: Whether hardware that the section before did not use comes in any state, or in service.
    """

    def __init__(self, composite: Composite, *, free: bool) -> None:
        self.composite = composite
        self.free = free
        first = composite.first
        begin = first.frame.everything if free else first.frame.in_service
        self.entered: dict[str, HardwareStates] = {first.section.name: begin}
        self._layers: list[Layer] = [{first.section.name: first.entered(begin)}]
        self.seen: Layer = dict(self._layers[0])

    def layers(self) -> Iterator[Layer]:
        """Layer by layer, until nothing is new."""
        length = 0
        while True:
            if length == len(self._layers):
                self._layers.append(self._next(self._layers[-1]))
            if not self._layers[length]:
                return
            yield self._layers[length]
            length += 1

    def _next(self, layer: Layer) -> Layer:
        found: Layer = {}
        for name, states in layer.items():
            placed = self.composite.by_name[name]
            after = placed.local.after(states)
            self._add(found, name, after & placed.local.inside)
            for outcome in OUTCOMES:
                route, ended = self.composite.route(name, outcome), after & placed.local.ended[outcome]
                if route not in ENDS and ended:
                    self._enter(found, placed.local.hardware(ended, placed.frame), route)
        return found

    def _enter(self, found: Layer, left: HardwareStates, name: str) -> None:
        target = self.composite.by_name[name]
        known = self.entered.get(name, target.frame.nothing)
        arriving = left.seen_by(target.frame, free=self.free) - known
        if arriving:
            self.entered[name] = known | arriving
            self._add(found, name, target.entered(arriving))

    def _add(self, found: Layer, name: str, states: Any) -> None:
        new = states - self.seen[name] if name in self.seen else states
        if new:
            self.seen[name] = self.seen[name] | new if name in self.seen else new
            found[name] = found[name] | new if name in found else new

    # --- back from a goal ---

    def back(self, length: int, name: str, reached: Any, goal: _Goal) -> list[Leg] | None:
        """A run to a goal from states of a layer, or ``None`` where the goal is not among or behind them."""
        placed = self.composite.by_name[name]
        transitions: list[int] = []
        left = 0
        if goal.inside:
            at = reached & goal.states
            if not at:
                return None
            at = placed.local.pick(at)
        else:
            if not placed.local.after(reached) & goal.states:
                return None
            step = placed.local.step_into(goal.states, reached)
            assert step is not None, "some of the states are one event before the goal"
            transitions, at = [step[0]], step[1]
            left = placed.local.hardware(step[2], placed.frame).pick()
        legs: list[Leg] = []
        while True:
            length, at = self._to_entry(length, placed, at, transitions)
            entries = placed.entries(at) & self.entered[placed.section.name]
            if length == 0:
                legs.append(Leg(placed, entries.pick(), tuple(reversed(transitions)), left))
                return legs[::-1]
            length -= 1
            before, transition, at, ended = self._before(self._layers[length], placed, entries)
            exit_states = before.local.hardware(ended, before.frame)
            entry = (entries & exit_states.seen_by(placed.frame, free=self.free)).pick()
            legs.append(Leg(placed, entry, tuple(reversed(transitions)), left))
            placed, transitions, left = before, [transition], exit_states.pick()

    def _to_entry(
        self, length: int, placed: PlacedSection, at: Any, transitions: list[int]
    ) -> tuple[int, Any]:
        """Back inside a section as far as the layers go; adds the transitions passed, last first."""
        name = placed.section.name
        while length and name in self._layers[length - 1]:
            step = placed.local.step_into(at, self._layers[length - 1][name])
            if step is None:
                break
            transitions.append(step[0])
            at, length = step[1], length - 1
        return length, at

    def _before(
        self, layer: Layer, placed: PlacedSection, entries: HardwareStates
    ) -> tuple[PlacedSection, int, Any, Any]:
        """One step out of a section of a layer into one that is entered so: a transition, its two ends."""
        for name, states in layer.items():
            before = self.composite.by_name[name]
            ends = self.ends_into(before, placed, entries)
            step = before.local.step_into(before.ending(ends), states) if ends else None
            if step is not None:
                return before, *step
        raise AssertionError("a section is entered from one of the layer before")

    def ends_into(
        self, before: PlacedSection, placed: PlacedSection, entries: HardwareStates
    ) -> dict[Outcome, HardwareStates]:
        """How a section may end for another to be entered with its hardware in one of some states."""
        if not self.free:
            entries = entries.in_service([h for h in entries.frame.names if h not in before.faulty])
        fitting = entries.seen_by(before.frame)
        routes = ((outcome, self.composite.route(before.section.name, outcome)) for outcome in OUTCOMES)
        return {outcome: fitting for outcome, route in routes if route == placed.section.name}


def told(legs: list[Leg], templates: TemplateSet | None = None) -> list[Step]:
    """A journey event by event, in mission words.

    Args:
        legs: The journey.
        templates: Those that the mission is composed with.
    """
    steps: list[Step] = []
    for number, leg in enumerate(legs):
        mission_net = leg.placed.net(templates)
        net = mission_net.net
        names = {t.event: t.name for t in reversed(net.transitions) if t.event}
        failed = [h for i, h in enumerate(leg.placed.faulty) if leg.entry >> i & 1]
        # Of the two transitions with which a resource fails, that of a free one.
        begin = [names[Event(What.OUT_OF_SERVICE, h)] for h in failed]
        firings = [
            names[START],
            *(net.transitions[t].name for t in leg.transitions),
        ]
        local_steps = replay(mission_net, [*begin, *firings])
        if number == 0:
            steps += local_steps[: len(failed) + 1]
        else:
            _, _, changes = local_steps[len(failed)].words.partition(": ")
            steps[-1] = Step(steps[-1].event, f"{steps[-1].words}: {changes}" if changes else steps[-1].words)
        inside = local_steps[len(failed) + 1 :]
        leaves = number + 1 < len(legs)
        steps += inside[: len(inside) - leaves]
        mission = mission_net.mission.name
        for name, fails in leg.toggled:
            toggle = Event(What.OUT_OF_SERVICE if fails else What.REPAIRED, name)
            steps.append(Step(toggle, what_happens(toggle, mission)))
        if leaves:
            end = net.transitions[leg.transitions[-1]].event
            assert end is not None, "only events lead out of a section"
            steps.append(Step(end, what_happens(end, mission)))
    return steps
