"""Where a mission comes to an event without one outcome: the second premise of composition.

The symbolic proof (:mod:`mcpn.space.stable.confluence`) is tried on the local net of each type, from every
state of its hardware. Where it leaves conflicts open, they are looked for in what the mission passes and
followed both ways (:mod:`mcpn.space.stable.joining`); where internal evolution may have no end, a marking is
looked for from which it has none.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NoReturn

from mcpn._kernel import Zdd
from mcpn.net.events import Event
from mcpn.net.petri import Marking
from mcpn.net.sections import junction_part
from mcpn.space.diagrams.symbolic import SymbolicSpace
from mcpn.space.local.composite import CompositeSpace
from mcpn.space.local.runs import TwoOutcomes
from mcpn.space.local.section_type import SectionType
from mcpn.space.local.sections import PlacedSection
from mcpn.space.local.sets import CompositeSet
from mcpn.space.stable.alternatives import fault_after
from mcpn.space.stable.confluence import endless_runs, open_conflicts, prove_confluent
from mcpn.space.stable.joining import EndlessRun, Joining, calm, parting_among
from mcpn.space.stable.nearest import fault_by
from mcpn.steps import step


def refuse_nonconfluent(composite: CompositeSpace, explored: dict[SectionType, SymbolicSpace]) -> None:
    """Raises an error where internal evolution of the mission depends on the interleaving, or need not end.

    Args:
        composite: The mission's composite.
        explored: By type, the markings of its local net.

    Raises:
        ConfluenceError: An event that the mission comes to has two outcomes; both runs are given.
        DivergenceError: After an event that the mission comes to internal evolution need not end.
    """
    # What is small is known soon: an error is found before large sections are proved.
    for type_, space in sorted(explored.items(), key=lambda pair: pair[1].reachable.nodes()):
        step(f"proving section {_first_of(composite, type_)} confluent")
        conflicts = list(open_conflicts(space))
        if not (conflicts or space.endless):
            continue
        sections = [placed for placed in composite.sections.values() if placed.type is type_]
        begun = nowhere = type_.layout.store.empty()
        for placed in sections:  # one whose entry has no end is entered, and has no state
            inside = composite.everything.parts.get(placed.name, nowhere)
            begun |= type_.begun(inside, composite.entering(placed))
        encoding, endless, marking = type_.encoding, bool(space.endless), None
        try:
            found = parting_among(
                encoding, calm(encoding, begun, conflicts), conflicts, Joining(type_.net.net)
            )
            marking = None if found is None else found[0]
        except EndlessRun:
            endless = True
        if marking is None and endless:
            levels = endless_runs(encoding, begun.saturate(encoding.internal)).pick()
            marking = None if levels is None else encoding.marking(levels)
        if marking is not None:
            _raise_before(composite, type_, sections, begun.saturate(encoding.internal), marking)


def _first_of(composite: CompositeSpace, type_: SectionType) -> str:
    """The first section of a type."""
    return next(name for name, placed in composite.sections.items() if placed.type is type_)


def _raise_before(
    composite: CompositeSpace,
    type_: SectionType,
    sections: list[PlacedSection],
    transient: Zdd,
    marking: Marking,
) -> NoReturn:
    """Raises the error of an event after which sections of a type come to a marking of such runs."""
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
    raise AssertionError("the marking comes after some event of the mission")


def _met_at(
    composite: CompositeSpace, placed: PlacedSection, transition: int, states: Zdd
) -> Iterator[tuple[CompositeSet, int | None]]:
    """States of the mission before such an event, and the event's transition; ``None`` for an entry's."""
    if transition != placed.type.net.start:
        inside = composite.everything.parts.get(placed.name)
        if inside and (here := composite.of({placed.name: inside & states})):
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
    try:
        run = composite.run(begin, here, composite.everything - here)
    except TwoOutcomes as nearer:  # then that is the error, whichever of the events there it is
        run, transition = nearer.run, None
    assert run is not None, "the mission comes there"
    state = run[-1].target if run else begin
    events = [_event(composite, edge.transition) for edge in run]
    for next_one in composite.net.enabled(composite.marking(state)):
        if transition in (None, next_one):
            run_on = [*events, _event(composite, next_one)]
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
        step(f"proving the way from section {first.name} to {second.name} confluent")
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
