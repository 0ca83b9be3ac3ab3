"""From a mission to its composite: each type of sections explored once, its premises checked.

Composition rests on two premises. *Idle at the exit*: a section hands on its exit, the state of the hardware
and what has happened once, everything else is as it was; this is checked on each local net. *Confluence*:
internal evolution after each event has one stable end, within a section and where one section leads to the
next; this is proved on the local net of each type, while its stable states are listed or else on a diagram of
its markings, and on the net of each type of junction of a caller's own templates. Where the proof fails, the
states in which it fails are looked for among those that the mission comes to.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, NoReturn

from mcpn._kernel import Zdd
from mcpn.composite.clash import in_mission_words
from mcpn.composite.composite import CompositeSet, CompositeSpace, SectionSets, TwoOutcomes
from mcpn.composite.layout import Layout
from mcpn.composite.section_type import ALL, Explored, SectionType, explore_and_prove, explore_local
from mcpn.composite.sections import Stage, WholeNet
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.mortal import crashing_anytime, forgetful, mortal
from mcpn.drawing.sections import SectionParts, junction_part, many_apart, part_of, refuse_wide
from mcpn.drawing.templates import TemplateSet
from mcpn.drawing.templates.named import looks_at_no_names
from mcpn.errors import ConfluenceError, DivergenceError, LimitError, WorkersError
from mcpn.mission.flatten import Section
from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.diagrams.encoding import behind, distinct, leading, passing
from mcpn.spaces.stable.completion import MAX_STABLE_STATES, fault_after
from mcpn.spaces.stable.confluence import prove_confluent, without_one_end
from mcpn.spaces.stable.falsification import FIRST_FIRINGS, fault_by, nearest_fault
from mcpn.steps import Doing, step
from mcpn.workers import workers

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from mcpn.spaces.stable.alternatives import AlternativesGraph


def composite_space(
    mission_net: MissionNet,
    *,
    templates: TemplateSet | None = None,
    may_die: bool = False,
) -> CompositeSpace:
    """The alternatives graph of a mission by composition.

    Args:
        mission_net: The mission's net; it is not explored.
        templates: Those that the mission is composed with, the paper's by default; with a caller's own no two
            sections are of one type.
        may_die: Whether hardware may die (:mod:`mcpn.drawing.mortal`).

    Returns:
        The composite. With ``may_die`` its net is that of :func:`mcpn.drawing.mortal.mortal`.

    Raises:
        PremiseError: A section hands on more than its exit and the status of what sections carry.
        ConfluenceError: An event that the mission comes to has two outcomes.
        DivergenceError: After an event that the mission comes to internal evolution need not end.
        UnsafeError: A local net is not 1-safe.
        LimitError: A limit was hit.

    See Also:
        :func:`mcpn.spaces.stable.alternatives.direct_with_proof`: the graph of the whole mission, listed.
        :mod:`mcpn.drawing.sections`: the nets that are explored instead.
    """
    usage = mission_net.usage
    if usage.contentions and not may_die:
        step(Doing.FINDING_CLASH)
        near = nearest_fault(mission_net.net, FIRST_FIRINGS)  # a clash near the start is found at once
        if near is not None:
            raise near
    alone = SectionParts(usage).alone
    parts = {section.name: alone(section) for section in mission_net.graph.sections}
    refuse_wide(parts.values())
    renamable = looks_at_no_names(templates)
    first: dict[Hashable, str] = {}  # by type, its first section, which stands for it
    representative = {
        name: first.setdefault(part.type if renamable else name, name) for name, part in parts.items()
    }
    with_death, with_crashes = (mortal, crashing_anytime) if may_die else (_itself, _itself)
    immortal = {name: with_crashes(parts[name].net(templates)) for name in first.values()}
    nets = {name: with_death(net) for name, net in immortal.items()}
    explored: dict[str, Explored] = {}
    dying = [net.net if may_die else None for net in nets.values()]
    wide = [many_apart(parts[name]) for name in nets]
    results = _explored([net.net for net in immortal.values()], dying, wide)
    for number, name in enumerate(nets, 1):
        step(Doing.EXPLORING, section=name, number=number, total=len(nets))
        with in_section(name):
            explored[name] = next(results)
    whole = WholeNet(with_death(mission_net), templates)
    layout = Layout(whole.mission_net, max(len(known.space.encoding.places) for known in explored.values()))
    types = {name: SectionType(parts[name], net, explored[name], layout) for name, net in nets.items()}
    for name, type_ in types.items():
        step(Doing.CHECKING_EXITS, section=name)
        type_.check_premise(name, explored[name])
    step(Doing.JOINING)
    stages = [
        whole.stage(s, parts[s.name], types[representative[s.name]]) for s in mission_net.graph.sections
    ]
    composite = CompositeSpace(whole, layout, stages)
    # Death only disables repairs, so the proof for the composite without it holds here, too. But with it
    # crashes happen at any moment (:func:`crashing_anytime`), which the proof there does not cover.
    if not may_die or mission_net.mission.crashes:
        if not renamable:
            refuse_open_junctions(composite)
        try:
            refuse_nonconfluent(composite, {types[name]: known for name, known in explored.items()})
        except (ConfluenceError, DivergenceError) as error:
            with in_mission_words(whole.mission_net):  # in which more happens than in the mission's own
                raise nearest_fault(whole.mission_net.net) or error from error
    return composite


def _itself(mission_net: MissionNet) -> MissionNet:
    return mission_net


def _explored(
    nets: Sequence[PetriNet], dying: Sequence[PetriNet | None], wide: Sequence[bool]
) -> Iterator[Explored]:
    """Explores some nets, and yields results in their order; workers send proofs, too."""
    executor = workers()
    each = list(zip(nets, dying, wide, strict=True))
    if executor is None:
        yield from (explore_local(*one) for one in each)
        return
    try:
        futures = [executor.submit(explore_and_prove, *one) for one in each]
        for future in futures:
            yield future.result()
    except Exception as error:
        if not _broke(executor, error):
            raise
        raise WorkersError(
            "a process that explored sections ended before its work was done: it was killed, as by a system "
            "that is out of memory; fewer of them (--jobs) need less at once"
        ) from error


def _broke(executor: Executor, error: Exception) -> bool:
    """Whether an error is that of processes which are no longer there.

    A pool that breaks while it starts a process closes what that one is to be given, and the error is then of
    files, closed or numbered anew: the pool itself says whether it is broken.
    """
    from concurrent.futures import BrokenExecutor

    if isinstance(error, OSError | ValueError):
        try:
            executor.submit(int)
        except RuntimeError as refused:
            return isinstance(refused, BrokenExecutor)
    return isinstance(error, BrokenExecutor)


def local_graph(
    mission_net: MissionNet,
    name: str,
    max_states: int | None = None,
    templates: TemplateSet | None = None,
) -> tuple[MissionNet, AlternativesGraph]:
    """The local net of a section and its alternatives graph, from every state of its hardware.

    It forgets what has happened once (:mod:`mcpn.drawing.mortal`).

    Args:
        mission_net: The mission's net.
        name: The section.
        max_states: Limit on its states.
        templates: Those that the mission is composed with, the paper's by default.

    Raises:
        InputError: There is no such section.
        SemanticsError: It is not safe, or not confluent.
        LimitError: It has too many states.
    """
    from mcpn.spaces.stable.alternatives import direct_with_proof  # which lists states in arrays

    local, _ = forgetful(part_of(mission_net, name).net(templates))
    limit = MAX_STABLE_STATES if max_states is None else max_states
    step(Doing.LISTING)
    with in_section(name), in_mission_words(local):
        return local, direct_with_proof(local.net, max_states=limit)


@contextmanager
def in_section(name: str) -> Iterator[None]:
    """Says of a limit in which section it was hit."""
    try:
        yield
    except LimitError as error:
        raise LimitError(f"in section {name}: {error}") from error


# --- Where a mission reaches an event without one outcome: the second premise of composition --------------
#
# The symbolic proof (:mod:`mcpn.spaces.stable.confluence`) is tried on the local net of each type, from every
# state of its hardware. Where it leaves conflicts open, what is behind the markings that the mission passes
# is explored, once for markings that evolve alike (:mod:`mcpn.spaces.stable.confluence`).


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
        prove_confluent(part.net(composite.whole.templates).net)


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
