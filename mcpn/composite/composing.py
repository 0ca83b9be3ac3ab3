"""From a mission to its composite: each type of sections explored once, its premises checked.

Composition rests on two premises. *Idle at the exit*: a section hands on its exit, the state of the hardware
and what has happened once, everything else is as it was; this is checked on each local net. *Confluence*:
internal evolution after each event has one stable end, within a section and where one section leads to the
next; this is proved on the local net of each type, while its stable states are listed or else on a diagram of
its markings, and on the net of each type of junction of a caller's own templates. Where the proof fails, the
states in which it fails are looked for among those that the mission comes to.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from mcpn.composite.clash_sentences import in_mission_words
from mcpn.composite.composite import CompositeSpace
from mcpn.composite.explored_section import Explored, explore_and_prove, explore_local
from mcpn.composite.layout import Layout
from mcpn.composite.section_type import SectionType
from mcpn.composite.sections import WholeNet
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.forgetful import forgetful
from mcpn.drawing.local_nets import local_net, part_of
from mcpn.drawing.permanent_loss import crashing_anytime, mortal
from mcpn.drawing.sections import refuse_wide
from mcpn.drawing.templates import TemplateSet
from mcpn.drawing.templates.named import looks_at_no_names
from mcpn.errors import ConfluenceError, DivergenceError, LimitError, WorkersError
from mcpn.nets.petri import PetriNet
from mcpn.spaces.stable.nearest_nonconfluence import FIRST_FIRINGS, nearest_fault
from mcpn.spaces.stable.run_to_completion import MAX_STABLE_STATES
from mcpn.steps import Doing, step
from mcpn.workers import workers

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from mcpn.spaces.stable.alternatives import AlternativesGraph
from mcpn.composite.nonconfluent_sections import refuse_nonconfluent, refuse_open_junctions


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
        may_die: Whether hardware may die (:mod:`mcpn.drawing.permanent_loss`).

    Returns:
        The composite. With ``may_die`` its net is that of :func:`mcpn.drawing.permanent_loss.mortal`.

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
    alone = mission_net.section_parts.alone
    parts = {section.name: alone(section) for section in mission_net.graph.sections}
    renamable = looks_at_no_names(templates)
    first: dict[Hashable, str] = {}  # by type, its first section, which stands for it
    representative = {
        name: first.setdefault(part.type if renamable else name, name) for name, part in parts.items()
    }
    refuse_wide(parts[name] for name in first.values())
    with_death, with_crashes = (mortal, crashing_anytime) if may_die else (_itself, _itself)
    immortal = {name: with_crashes(local_net(parts[name], templates)) for name in first.values()}
    nets = {name: with_death(net) for name, net in immortal.items()}
    explored: dict[str, Explored] = {}
    dying = [net.net if may_die else None for net in nets.values()]
    results = _explored([net.net for net in immortal.values()], dying)
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
    if not may_die or mission_net.core.crashes:
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


def _explored(nets: Sequence[PetriNet], dying: Sequence[PetriNet | None]) -> Iterator[Explored]:
    """Explores some nets, and yields results in their order; workers send proofs, too."""
    executor = workers()
    each = list(zip(nets, dying, strict=True))
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

    It forgets what has happened once (:mod:`mcpn.drawing.permanent_loss`).

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

    local, _ = forgetful(local_net(part_of(mission_net, name), templates))
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
