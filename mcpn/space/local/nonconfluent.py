"""Where a mission comes to an event without one outcome: the second premise of composition.

The symbolic proof (:mod:`mcpn.space.stable.confluence`) is tried on the local net of each type, from every
state of its hardware. Where it leaves conflicts open, they are looked for in what the mission passes and
followed both ways (:mod:`mcpn.space.stable.joining`). Only where internal evolution may have no end are
states of the local net listed and the interleavings of each event explored.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NoReturn

from mcpn._kernel import Zdd
from mcpn.errors import LimitError
from mcpn.net.events import Event
from mcpn.net.petri import Marking
from mcpn.net.sections import junction_part
from mcpn.space.diagrams.symbolic import SymbolicSpace
from mcpn.space.local.composite import CompositeSpace
from mcpn.space.local.section_type import SectionType
from mcpn.space.local.sections import PlacedSection
from mcpn.space.local.sets import CompositeSet
from mcpn.space.stable.alternatives import direct, fault_after
from mcpn.space.stable.confluence import open_conflicts, prove_confluent
from mcpn.space.stable.joining import EndlessRun, Joining, calm, parting_among
from mcpn.space.stable.nearest import fault_by


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
        conflicts = list(open_conflicts(space))
        if not (conflicts or space.endless):
            continue
        sections = [
            p for p in composite.sections.values() if p.type is type_ and p.name in composite.everything.parts
        ]
        if not _rejoin(composite, type_, space, sections, conflicts):
            _judge_by_list(composite, type_, sections, max_states)


def _rejoin(
    composite: CompositeSpace,
    type_: SectionType,
    space: SymbolicSpace,
    sections: list[PlacedSection],
    conflicts: list[tuple[int, int]],
) -> bool:
    """Whether both ways of each conflict that the mission passes lead to one marking again, and all runs end.

    Raises:
        ConfluenceError: Some do not, and here are the runs of the mission that show it.
    """
    begun = type_.layout.store.empty()
    for placed in sections:
        begun |= type_.begun(composite.everything.parts[placed.name], composite.entering(placed))
    if space.endless:
        endless = type_.layout.opened(
            type_.layout.store.from_bytes(space.endless.to_bytes()), type_.layout.all_slots
        )
        if begun.saturate(type_.encoding.internal) & endless:
            return False
    try:
        markings = calm(type_.encoding, begun, conflicts)
        found = parting_among(type_.encoding, markings, conflicts, Joining(type_.net.net))
    except EndlessRun:
        return False
    if found is not None:
        _raise_before(composite, type_, sections, begun.saturate(type_.encoding.internal), found[0])
    return found is None


def _raise_before(
    composite: CompositeSpace,
    type_: SectionType,
    sections: list[PlacedSection],
    transient: Zdd,
    marking: Marking,
) -> None:
    """Raises the error of an event after which sections of a type come to a marking where runs part."""
    encoding, layout = type_.encoding, type_.layout
    here = layout.opened(encoding.set_of(marking), layout.all_slots) & transient
    behind = here.saturate(encoding.internal_back, within=transient)
    before = [
        (t, behind.images([back]))
        for t, back in encoding.undoing.items()
        if not type_.net.net.transitions[t].internal
    ]
    for placed in sections:
        for transition, states in before:
            for met, event in _met_at(composite, placed, transition, states):
                _raise(composite, met, event)


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
            yield here, placed.transitions.whole[transition]
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
            run_on = [*events, _event(composite, edge.transition)]
            found = fault_by(composite.net, run_on) or fault_after(composite.net, run_on)
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
        prove_confluent(part.net(first.placement.templates).net)


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
