"""Where a mission reaches an event without one outcome: the second premise of composition.

The symbolic proof (:mod:`mcpn.spaces.stable.confluence_by_sets`) is tried on the local net of each type,
from every state of its hardware. Where it leaves conflicts open, what is behind the markings that the
mission passes is explored, once for markings that evolve alike (:mod:`mcpn.spaces.stable.representatives`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NoReturn

from mcpn._kernel import Zdd
from mcpn.composite.composite import CompositeSpace, TwoOutcomes
from mcpn.composite.explored_section import Explored
from mcpn.composite.glued import CompositeSet, SectionSets
from mcpn.composite.section_type import ALL, SectionType
from mcpn.composite.sections import Stage
from mcpn.drawing.local_nets import local_net
from mcpn.drawing.sections import junction_part
from mcpn.mission.core.objectives_graph import Section
from mcpn.nets.petri import Marking
from mcpn.spaces.diagrams.encoding import distinct
from mcpn.spaces.diagrams.internal_evolution import behind, leading, passing
from mcpn.spaces.stable.confluence_by_sets import prove_confluent
from mcpn.spaces.stable.nearest_nonconfluence import fault_by
from mcpn.spaces.stable.representatives import without_one_end
from mcpn.spaces.stable.run_to_completion import fault_after
from mcpn.steps import Doing, step


def refuse_nonconfluent(composite: CompositeSpace, explored: Mapping[SectionType, Explored]) -> None:
    """Looks for an event without one outcome, on the markings of each type's local net.

    Raises:
        ConfluenceError: An event that the mission comes to has two outcomes; both runs are given.
        DivergenceError: After an event that the mission comes to internal evolution need not end.
    """
    # What is small is known soon: an error is found before large sections are proved.
    for type_, known in sorted(explored.items(), key=lambda pair: pair[1].space.reachable.nodes()):
        stages = [stage for stage in composite.sections.values() if stage.type is type_]
        step(Doing.PROVING_SECTION, section=stages[0].name)
        if known.ends and not known.conflicts:
            continue
        encoding, begun = type_.encoding, composite.empty
        for stage in stages:
            begun |= _begun(composite, stage)
        marking = without_one_end(encoding, begun)
        if marking is not None:
            _raise_before(composite, stages, behind(encoding, begun)[0], marking)


def _begun(composite: CompositeSpace, stage: Stage) -> Zdd:
    """Markings just after the events of a section that the mission comes to, and after its entry."""
    type_, everything, hardware = stage.type, composite.everything, composite.empty
    for before in composite.into[stage.name]:  # a section whose entry has no end has no state
        for route, states in composite.stages[before].leave(everything.of(before)):
            if route == stage.name:
                hardware |= states
    events, entering = type_.encoding.events, type_.from_slots(hardware, stage.slots, None)
    own = distinct(events[t] for t in type_.graph.waiting)
    return everything.of(stage.name).images(own) | entering.images([events[type_.net.start]])


def _raise_before(
    composite: CompositeSpace, stages: Sequence[Stage], transient: Zdd, marking: Marking
) -> NoReturn:
    """Raises the error of an event after which sections of a type reach a marking of such runs."""
    type_, layout, everything = stages[0].type, composite.layout, composite.everything
    encoding = type_.encoding
    here = layout.opened(encoding.set_of(marking), layout.all_slots) & transient
    ending = leading(encoding, here, passing(encoding, transient))
    for stage in stages:
        for t in type_.graph.waiting:
            before, met = ending.images([encoding.undoing[t]]), SectionSets()
            if t != type_.net.start:
                met.add(stage.name, before & everything.of(stage.name))
            else:
                hardware = type_.to_slots(before & type_.before, stage.slots, None)
                for earlier in (composite.stages[name] for name in composite.into[stage.name]):
                    leaving = earlier.type.before_step(earlier.ends({stage.name: hardware}), ALL)
                    met.add(earlier.name, leaving & everything.of(earlier.name))
            if met:
                event = stage.transitions[t] if t != type_.net.start else None
                _raise(composite, CompositeSet(composite, met), event)
    raise AssertionError("the marking comes after some event of the mission")


def _raise(composite: CompositeSpace, here: CompositeSet, transition: int | None) -> NoReturn:
    """Raises the error of an event, or of any, in some states, with runs of the whole mission."""
    begin, net = composite.initial.pick(), composite.net
    assert begin is not None, "there is an initial state"
    try:
        run = composite.run(begin, here, composite.everything - here)
    except TwoOutcomes as nearer:  # then that is the error, whichever of the events there it is
        run, transition = nearer.run, None
    assert run is not None, "the mission comes there"
    fired = [edge.transition for edge in run]
    for last in net.enabled(composite.marking(run[-1].target if run else begin)):
        if transition in (None, last):
            events = [t for t in (*fired, last) if not net.transitions[t].internal]
            error = fault_by(net, events) or fault_after(net, events)
            if error is not None:
                raise error
    raise AssertionError("what is not confluent in the section's net is not in the mission's")


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
        step(Doing.PROVING_JUNCTION, section=first.name, successor=second.name)
        part = junction_part(composite.mission_net.usage, first, second)
        prove_confluent(local_net(part, composite.whole.templates).net)


def sharing_pairs(composite: CompositeSpace) -> Iterator[tuple[Section, Section]]:
    """Sections in a row that share activities or hardware: one that is left, one that is entered."""
    graph = composite.mission_net.graph
    uses = {
        name: {("activity", a.name) for a in stage.part.used.activities}
        | {("hardware", h.name) for h in stage.part.used.hardware}
        for name, stage in composite.sections.items()
    }
    for first in graph.sections:
        for second in {target.name: target for target in graph.targets(first)}.values():
            if uses[first.name] & uses[second.name]:
                yield first, second
