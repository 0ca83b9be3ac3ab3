"""From a mission to its composite: each type of sections explored once, its premises checked.

Composition rests on two premises. *Idle at the exit*: a section hands on its exit and the state of the
hardware, everything else is as it was; this is checked on each local net. *Confluence*: internal evolution
after each event has one stable end, within a section and where one section leads to the next; this is proved
on the local net of each type and on the net of each type of junction, and where the proof fails, the states
in which it fails are looked for among those that the mission comes to.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeAlias

from mcpn.errors import LimitError
from mcpn.net.compose import MissionNet
from mcpn.net.mortal import mortal
from mcpn.net.petri import PetriNet
from mcpn.net.sections import SectionParts, Used
from mcpn.net.templates import TemplateSet
from mcpn.space.diagrams.symbolic import SymbolicSpace, reach
from mcpn.space.local.composite import CompositeSpace
from mcpn.space.local.layout import IMMORTAL, MORTAL, Layout
from mcpn.space.local.nonconfluent import refuse_nonconfluent, refuse_open_junctions
from mcpn.space.local.section_type import SectionType
from mcpn.space.local.sections import Elements, PlacedSection, Placement
from mcpn.space.stable.nearest import nearest_fault
from mcpn.steps import step

Progress: TypeAlias = Callable[[int, int], None]
"""Called after each local space and junction with how many are done and how many there are."""


@dataclass(frozen=True)
class Options:
    """How a composite is made.

    Args:
        templates: The set of templates that the mission is composed with, the paper's by default; with
            another no two sections are taken for one type.
        executor: Where sections are explored; in this process one after the other by default.
        progress: Called after each local space.
        mortal: Whether hardware may die (:mod:`mcpn.net.mortal`).
    """

    templates: TemplateSet | None = None
    executor: Executor | None = None
    progress: Progress | None = None
    mortal: bool = False


AS_USUAL = Options()


def composite_space(mission_net: MissionNet, options: Options = AS_USUAL) -> CompositeSpace:
    """The alternatives graph of a mission by composition.

    Args:
        mission_net: The mission's net; it is not explored.
        options: How the composite is made.

    Returns:
        The composite. With ``mortal`` its net is that of :func:`mcpn.net.mortal.mortal`.

    Raises:
        PremiseError: A section hands on more than the state of its hardware.
        ConfluenceError: An event that the mission comes to has two outcomes.
        DivergenceError: After an event that the mission comes to internal evolution need not end.
        UnsafeError: A local net is not 1-safe.
        LimitError: A limit was hit.
    """
    usage, graph, templates = mission_net.usage, mission_net.graph, options.templates
    if usage.contentions and not options.mortal:
        step("looking for a clash near the start of the mission")
        error = nearest_fault(mission_net.net)  # a clash near the start is found at once
        if error is not None:
            raise error
    alone = SectionParts(usage).alone
    parts = {section.name: alone(section) for section in graph.sections}
    kinds = {name: part.type if templates is None else name for name, part in parts.items()}
    first: dict[Hashable, str] = {}
    for name in parts:
        first.setdefault(kinds[name], name)  # the first section of a type stands for it
    nets = {kind: _net(parts[name].net(templates), options) for kind, name in first.items()}
    explored: dict[Hashable, SymbolicSpace] = {}
    results = results_of([(reach, net.net) for net in nets.values()], options.executor)
    for number, (kind, name) in enumerate(first.items(), 1):
        step(f"exploring section {name}{_of_types(number, len(first))}")
        with in_section(name):
            explored[kind] = next(results)
        if options.progress:
            options.progress(number, len(first))
    hardware = [h.name for h in usage.mission.hardware if ("oos", h.name) in mission_net.by_role]
    most = max(len(space.encoding.places) for space in explored.values())
    layout = Layout(hardware, MORTAL if options.mortal else IMMORTAL, most)
    types = {k: SectionType(parts[name], nets[k], explored[k], layout) for k, name in first.items()}
    for kind, name in first.items():
        step(f"checking what section {name} hands on")
        types[kind].check_premise(name, explored[kind])
    step("joining the sections")
    elements = Elements(mortal(mission_net) if options.mortal else mission_net)
    placements: dict[tuple[SectionType, Used], Placement] = {}
    placed = []
    for section in graph.sections:
        part, type_ = parts[section.name], types[kinds[section.name]]
        key = type_, part.used
        if key not in placements:
            placements[key] = Placement(type_, part, elements, templates)
        placed.append(PlacedSection(section, part, placements[key]))
    composite = CompositeSpace(elements, layout, placed)
    if not options.mortal:  # what may die behaves as what may not
        if templates is not None:
            refuse_open_junctions(composite)
        refuse_nonconfluent(composite, {types[k]: explored[k] for k in types})
    return composite


def _of_types(number: int, of: int) -> str:
    return f" (type {number} of {of})" if of > 1 else ""


def _net(local: MissionNet, options: Options) -> MissionNet:
    return mortal(local) if options.mortal else local


Job: TypeAlias = tuple[Callable[[PetriNet], Any], PetriNet]


def results_of(jobs: list[Job], executor: Executor | None) -> Iterator[Any]:
    """The results of jobs, in their order, wherever they run; what a job raises is raised here."""
    futures = [executor.submit(call, net) for call, net in jobs] if executor else []
    for number, (call, net) in enumerate(jobs):
        yield futures[number].result() if executor else call(net)


@contextmanager
def in_section(name: str) -> Iterator[None]:
    """Says of a limit in which section it was hit."""
    try:
        yield
    except LimitError as error:
        raise LimitError(f"in section {name}: {error}") from error
