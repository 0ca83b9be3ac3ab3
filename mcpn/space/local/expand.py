"""The composite written out: the alternatives graph of the whole mission, for missions small enough."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from mcpn.errors import LimitError
from mcpn.net.compose import MissionNet
from mcpn.net.petri import PetriNet
from mcpn.space.alternatives import DEFAULT_MAX_STATES, AlternativesGraph
from mcpn.space.graph import pack
from mcpn.space.local.composite import ENDS, Composite
from mcpn.space.local.placing import PlacedSection
from mcpn.space.local.protocol import OUTCOMES

State = tuple[str, int, int]
"""A section's name (or begin, succeed, fail), a state of its local graph (0), hardware out of service."""

BEGIN = "begin"


def expand(
    composite: Composite, mission_net: MissionNet, *, max_states: int = DEFAULT_MAX_STATES
) -> AlternativesGraph:
    """Writes out the alternatives graph that a composite stands for.

    Args:
        composite: The mission's composite, the states of every section listed.
        mission_net: The net of the whole mission.
        max_states: How many states the graph may have.

    Returns:
        The graph, numbered as :func:`mcpn.space.alternatives.direct` numbers it.

    Raises:
        LimitError: The graph has more states than allowed.
    """
    if composite.states > max_states:
        raise LimitError(f"{composite.states} states, more than {max_states}: the limit on states was hit")
    writing = _Writing(composite, mission_net)
    start: State = (BEGIN, 0, 0)
    numbers, queue = {start: 0}, [start]
    offsets, targets, labels = [0], list[int](), list[int]()
    for state in queue:  # grows while it is walked
        for transition, after in sorted(writing.successors(state)):
            if numbers.setdefault(after, len(queue)) == len(queue):
                queue.append(after)
            targets.append(numbers[after])
            labels.append(transition)
        offsets.append(len(targets))
    words = pack(map(writing.marking, queue), len(mission_net.net.places))
    starts, ends, fired = (np.array(values, np.int64) for values in (offsets, targets, labels))
    proof = "each section's local graph proved confluent on its own net; junctions by the templates"
    return AlternativesGraph(mission_net.net, words, starts, ends, fired, "local", proof)


class _Writing:
    """Edges and markings of the whole, from those of the local graphs."""

    def __init__(self, composite: Composite, mission_net: MissionNet) -> None:
        self.composite = composite
        self.mission_net = mission_net
        self.net: PetriNet = mission_net.net
        self.bit = {name: i for i, name in enumerate(composite.faulty)}
        self.places = {p.section.name: _Places(p, mission_net, self.bit) for p in composite.sections}
        self.begin_only = sum(1 << p for p, tokens in enumerate(self.net.initial) if tokens)

    @cached_property
    def toggles(self) -> dict[str, tuple[int, int]]:
        """By hardware, the transitions with which it fails and recovers while nobody uses it."""
        found = {}
        for name in self.composite.faulty:
            (oos,) = self.mission_net.by_role["oos", name]
            mine = [
                (i, t)
                for i, t in enumerate(self.net.transitions)
                if t.event and t.provenance and (t.provenance.kind, t.provenance.name) == ("hardware", name)
            ]
            recover = next(i for i, t in mine if any(p == oos for p, _ in t.consume))
            idle = {p for p, tokens in enumerate(self.net.initial) if tokens}
            fail = next(i for i, t in mine if i != recover and all(p in idle for p, _ in t.consume))
            found[name] = fail, recover
        return found

    def successors(self, state: State) -> Iterator[tuple[int, State]]:
        name, at, mask = state
        used = self.places[name].placed.faulty if name in self.places else ()
        for hardware, bit in self.bit.items():
            if hardware not in used:
                yield self.toggles[hardware][mask >> bit & 1], (name, at, mask ^ 1 << bit)
        if name == BEGIN:
            yield self.mission_net.start, self.enter(self.composite.graph.entry, mask)
        elif name not in ENDS:
            yield from self.places_inside(self.places[name], at, mask)

    def places_inside(self, section: _Places, at: int, mask: int) -> Iterator[tuple[int, State]]:
        local, name = section.placed.listed, section.placed.section.name
        for label, after in local.graph.successors(at):
            outside = mask & ~section.all | section.whole_mask(int(local.out_of_service[after]))
            for outcome in OUTCOMES:
                if local.ended[outcome].mask[after]:
                    yield section.transitions[label], self.enter(self.composite.route(name, outcome), outside)
                    break
            else:
                yield section.transitions[label], (name, after, outside)

    def enter(self, name: str, mask: int) -> State:
        if name in ENDS:
            return name, 0, mask
        section = self.places[name]
        return name, int(section.placed.listed.entry[section.own_mask(mask)]), mask

    def marking(self, state: State) -> int:
        """A bit for each marked place of the whole net."""
        name, at, mask = state
        marked = self.begin_only
        for hardware, bit in self.bit.items():
            if mask >> bit & 1:
                marked = (
                    marked & ~self.of_hardware[hardware] | 1 << self.mission_net.by_role["oos", hardware][0]
                )
        if name == BEGIN:
            return marked
        marked &= ~(1 << self.mission_net.beginning)
        if name in ENDS:
            end = self.mission_net.success if ENDS[name] == "success" else self.mission_net.failure
            return marked | 1 << end
        section = self.places[name]
        local = section.placed.listed.graph.marking(at)
        marked &= ~section.mask
        return marked | sum(1 << section.index[p] for p, tokens in enumerate(local) if tokens)

    @cached_property
    def of_hardware(self) -> dict[str, int]:
        found = dict.fromkeys(self.bit, 0)
        for i, place in enumerate(self.net.places):
            if place.provenance and place.provenance.kind == "hardware" and place.provenance.name in found:
                found[place.provenance.name] |= 1 << i
        return found


class _Places:
    """Where the places, transitions and hardware of a section stand in the whole."""

    def __init__(self, placed: PlacedSection, mission_net: MissionNet, bit: dict[str, int]) -> None:
        self.placed = placed
        own = placed.net().net
        self.index = [mission_net.net.place_index[p.name] for p in own.places]
        self.transitions = [mission_net.net.transition_index.get(t.name, -1) for t in own.transitions]
        self.mask = sum(1 << p for p in self.index)
        self.bits = [bit[name] for name in placed.faulty]
        self.all = sum(1 << b for b in self.bits)

    def own_mask(self, whole: int) -> int:
        return sum((whole >> b & 1) << i for i, b in enumerate(self.bits))

    def whole_mask(self, own: int) -> int:
        return sum((own >> i & 1) << b for i, b in enumerate(self.bits))
