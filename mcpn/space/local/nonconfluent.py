"""Where a mission comes to an event without one outcome: the second premise of composition.

The symbolic proof (:mod:`mcpn.space.confluence`) is tried on the local net of each type, from every state of
its hardware. Where it leaves conflicts open, they are looked for in what the mission reaches; where they
occur there, the states of the local net are listed and each event's interleavings are explored.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NoReturn

from mcpn._kernel import Zdd
from mcpn.errors import LimitError
from mcpn.net.events import Event
from mcpn.net.sections import junction_part
from mcpn.space.alternatives import direct, fault_after
from mcpn.space.confluence import open_conflicts, prove_confluent
from mcpn.space.local.composite import CompositeSpace
from mcpn.space.local.section_type import SectionType
from mcpn.space.local.sections import PlacedSection
from mcpn.space.local.sets import CompositeSet
from mcpn.space.symbolic import SymbolicSpace


def refuse_nonconfluent(
    composite: CompositeSpace, explored: dict[SectionType, SymbolicSpace], max_states: int
) -> None:
    """Raises an error where internal evolution of the mission depends on the interleaving, or need not end.

    Args:
        composite: The mission's composite.
        explored: By type, the markings of its local net.
        max_states: How many states of a local net may be listed where the symbolic proof leaves it open.

    Raises:
        ConfluenceError: An event that the mission comes to has two outcomes; both runs are given.
        DivergenceError: After an event that the mission comes to internal evolution need not end.
        LimitError: It is open, and a local net has too many states to be listed.
    """
    for type_, space in explored.items():
        sections = [
            p for p in composite.sections.values() if p.type is type_ and p.name in composite.everything.parts
        ]
        conflicts = list(open_conflicts(space))
        if (conflicts or space.endless) and _is_met(composite, type_, space, sections, conflicts):
            _judge_by_list(composite, type_, sections, max_states)


def _is_met(
    composite: CompositeSpace,
    type_: SectionType,
    space: SymbolicSpace,
    sections: list[PlacedSection],
    conflicts: list[tuple[int, int]],
) -> bool:
    """Whether a transient marking that the mission passes has such a conflict, or need not end."""
    begun = type_.layout.store.empty()
    for placed in sections:
        begun |= type_.begun(composite.everything.parts[placed.name], composite.entering(placed))
    transient = begun.saturate(type_.encoding.internal)
    if space.endless:
        endless = type_.layout.opened(
            type_.layout.store.from_bytes(space.endless.to_bytes()), type_.layout.all_slots
        )
        if transient & endless:
            return True
    safe, encoding = type_.net.net.safe_transitions, type_.encoding
    conditions = [
        encoding.condition((*safe[t].consume, *safe[t].read, *safe[u].consume, *safe[u].read))
        for t, u in conflicts
    ]
    return transient.first([c for c in conditions if c is not None]) >= 0


def _judge_by_list(
    composite: CompositeSpace, type_: SectionType, sections: list[PlacedSection], max_states: int
) -> None:
    net = type_.net.net
    try:
        listed = direct(net, tear=True, max_states=max_states)
    except LimitError as error:
        names = ", ".join(placed.name for placed in sections[:1])
        raise LimitError(
            f"section {names}: internal transitions conflict, and whether the outcome depends on their order "
            f"takes a list of its states ({error})"
        ) from error
    states: dict[int, Zdd] = {}
    for state, transition, _ in listed.torn:
        levels = type_.encoding.marked_levels(listed.marking(state))
        one = type_.layout.store.singleton(levels)
        states[transition] = states[transition] | one if transition in states else one
    for placed in sections:
        for transition, nonconfluent in states.items():
            opened = type_.layout.opened(nonconfluent, type_.layout.all_slots)
            for here, event in _met_at(composite, placed, transition, opened):
                _raise(composite, here, event)


def _met_at(
    composite: CompositeSpace, placed: PlacedSection, transition: int, states: Zdd
) -> Iterator[tuple[CompositeSet, int | None]]:
    """States of the mission before such an event, and the event's transition; ``None`` for an entry's."""
    if transition != placed.type.net.start:
        here = composite.of({placed.name: composite.everything.parts[placed.name] & states})
        if here:
            yield here, placed.transitions[transition]
        return
    hardware = placed.type.to_slots(states & placed.type.before, placed.faulty)
    here = composite.leaving_for(placed.name, hardware)
    if here:
        yield here, None


def _raise(composite: CompositeSpace, here: CompositeSet, transition: int | None) -> NoReturn:
    """Raises the error of an event in some states, with runs of the whole mission."""
    begin = composite.initial.pick()
    assert begin is not None, "there is an initial state"
    run = composite.run(begin, here, composite.everything - here)
    assert run is not None, "the mission comes there"
    state = run[-1].target if run else begin
    events = [_event(composite, edge.transition) for edge in run]
    for edge in composite.edges(state):
        if transition is None or edge.transition == transition:
            found = fault_after(composite.net, [*events, _event(composite, edge.transition)])
            if found is not None:
                raise found
    raise AssertionError("what is not confluent in the section's net is not in the mission's")


def _event(composite: CompositeSpace, transition: int) -> Event:
    event = composite.net.transitions[transition].event
    assert event is not None, "only events lead from one stable marking to another"
    return event


def refuse_open_junctions(composite: CompositeSpace) -> None:
    """Proves the junctions of a mission whose templates are the caller's own confluent.

    The paper's templates make every junction confluent whose sections are (``papers/composition.md``). Of a
    caller's own nothing is known, so each junction of sections that share anything is proved on the net of
    both.

    Raises:
        SemanticsError: A junction is not confluent for some state of its hardware.
        LimitError: A limit was hit.
    """
    for first, second in sharing_pairs(composite):
        part = junction_part(composite.mission_net.usage, first.section, second.section)
        prove_confluent(part.net(first.templates).net)


def sharing_pairs(composite: CompositeSpace) -> Iterator[tuple[PlacedSection, PlacedSection]]:
    """Sections in a row that share activities or hardware: one that is left, one that is entered."""
    graph, sections = composite.mission_net.graph, composite.sections
    for first in graph.sections:
        for name in dict.fromkeys(target.name for target in graph.targets(first)):
            if not _used(sections[first.name]).isdisjoint(_used(sections[name])):
                yield sections[first.name], sections[name]


def _used(placed: PlacedSection) -> set[tuple[str, str]]:
    parts = placed.part.parts
    return {("activity", a.name) for a in parts.activities} | {("hardware", h.name) for h in parts.hardware}
