"""Local graphs: the stable states of each section on its own, each type of sections once.

The paper's future work ("generating local graph dedicated to each objective instead of generating a complete
graph for the whole mission"). Between two sections every activity is stopped and every software resource is
gone, so that all a section hands on is its *interface state*: its outcome, and which of its hardware is out
of service. This premise is checked on each local space, not believed; that the junction of two sections is
confluent is true by the templates (:mod:`mcpn.space.local.junction`).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.flatten import ObjectivesGraph, Section
from mcpn.mission.usage import Usage
from mcpn.net.compose import MissionNet
from mcpn.net.petri import PetriNet
from mcpn.net.sections import LocalPart, Renaming, section_part
from mcpn.net.templates import TemplateSet
from mcpn.space.alternatives import AlternativesGraph, direct
from mcpn.space.confluence import direct_with_proof
from mcpn.space.local.diagram import LocalDiagram
from mcpn.space.local.graph import LocalGraph
from mcpn.space.local.interface import Frame, HardwareSpace, HardwareStates
from mcpn.space.local.protocol import LocalSpace, Outcome
from mcpn.space.symbolic import SymbolicSpace, reach

DEFAULT_MAX_STATES = 1_000_000
MOST_LISTED = 8
"""Hardware that can fail in one section up to which its states are listed; with more they are a diagram."""

Progress: TypeAlias = Callable[[int, int], None]
"""Called after each local graph and junction with how many are done and how many there are."""


@dataclass(frozen=True)
class Making:
    """How local spaces are made.

    Args:
        templates: The set of templates that the mission is composed with, the paper's by default; with
            another no two sections, and no two junctions, are taken for one type.
        executor: Where sections are explored and junctions proved; in this process one after the other by
            default.
        max_states: How many states a local graph, or a junction decided edge by edge, may list; a section
            with more has a diagram.
        most_listed: With more hardware that can fail a section has a diagram at once; ``None`` to list the
            states of every section.
        progress: Called after each local space and each junction, with how many of their kind there are.
    """

    templates: TemplateSet | None = None
    executor: Executor | None = None
    max_states: int = DEFAULT_MAX_STATES
    most_listed: int | None = MOST_LISTED
    progress: Progress | None = None


AS_USUAL = Making()


@dataclass(frozen=True, eq=False)
class PlacedSection:
    """A section of the mission with the local space of its type.

    Sets of states are those of the local space; sets of hardware states have the section's own names.

    Args:
        section: The section.
        part: What it uses; its elements stand in the order of those of the local space's own.
        local: The space of its type.
        space: The mission's hardware.
    """

    section: Section
    part: LocalPart
    local: LocalSpace
    space: HardwareSpace

    @cached_property
    def faulty(self) -> tuple[str, ...]:
        """Hardware of this section that can fail, by its bit in masks."""
        return self.part.faulty

    @cached_property
    def frame(self) -> Frame:
        """The same, as what sets of hardware states are about."""
        return self.space.frame(self.faulty)

    @cached_property
    def renaming(self) -> Renaming:
        """From the names in the local space to the section's own."""
        return Renaming(self.local.part, self.part)

    @property
    def listed(self) -> LocalGraph:
        """The local space as a graph whose states are listed."""
        assert isinstance(self.local, LocalGraph), "asked for where every section is listed"
        return self.local

    def net(self, templates: TemplateSet | None = None) -> MissionNet:
        """The section's own local net: that of its type, with its own names."""
        return self.part.net(templates)

    def entered(self, hardware: HardwareStates) -> Any:
        """First states inside after the section is entered with some states of its hardware."""
        return self.local.begin(self.local.with_hardware(self.local.before, hardware))

    def entries(self, inside: Any) -> HardwareStates:
        """With which states of its hardware the section is entered in some states inside."""
        return self.local.hardware(self.local.beginnings(inside), self.frame)

    def exits(self, outcome: Outcome, inside: Any) -> HardwareStates:
        """With which states of its hardware the section ends so, one event after states inside."""
        return self.local.hardware(self.local.after(inside) & self.local.ended[outcome], self.frame)

    def ending(self, ends: Mapping[Outcome, HardwareStates]) -> Any:
        """States after the section, by outcomes and the states of its hardware then."""
        local = self.local
        goals = [local.with_hardware(local.ended[outcome], states) for outcome, states in ends.items()]
        found = local.ended["success"] - local.ended["success"]
        for goal in goals:
            found = found | goal
        return found


def local_graphs(usage: Usage, graph: ObjectivesGraph, making: Making = AS_USUAL) -> list[PlacedSection]:
    """Explores each type of sections once.

    A section whose internal evolution depends on interleaving is no error here: its space tells where
    (:meth:`mcpn.space.local.protocol.LocalSpace.torn`); the composite asks whether the mission comes there.

    Args:
        usage: Static facts of the mission.
        graph: Its objectives graph.
        making: How local spaces are made.

    Returns:
        Every section with its local space, in document order.

    Raises:
        PremiseError: A section hands on more than the state of its hardware.
        UnsafeError: A section with a diagram has a local net that is not 1-safe.
        LimitError: A limit was hit.
    """
    templates, most_listed = making.templates, making.most_listed
    parts = {section.name: section_part(usage, section) for section in graph.sections}
    kinds = {name: part.type if templates is None else name for name, part in parts.items()}
    types: dict[Hashable, str] = {}
    for name in parts:
        types.setdefault(kinds[name], name)  # the first section of a type stands for it
    nets = {kind: parts[name].net(templates) for kind, name in types.items()}
    jobs: list[Job] = []
    for kind, name in types.items():
        small = most_listed is None or len(parts[name].faulty) <= most_listed
        jobs.append((listed if small else as_diagram, nets[kind].net, making.max_states))
    results = results_of(jobs, making.executor)
    locals_: dict[Hashable, LocalSpace] = {}
    for number, (kind, name) in enumerate(types.items()):
        with in_section(name):
            found = next(results)
            if isinstance(found, LimitError):
                if most_listed is None:
                    raise found
                found = reach(nets[kind].net)
            part, net = parts[name], nets[kind]
            is_graph = isinstance(found, AlternativesGraph)
            locals_[kind] = LocalGraph(part, net, found) if is_graph else LocalDiagram(part, net, found)
            locals_[kind].check_premise(name)
        if making.progress:
            making.progress(number + 1, len(types))
    space = HardwareSpace([h.name for h in usage.mission.hardware if h.faulty])
    return [PlacedSection(s, parts[s.name], locals_[kinds[s.name]], space) for s in graph.sections]


def listed(net: PetriNet, max_states: int) -> AlternativesGraph | LimitError:
    """The alternatives graph of a local net; where its internal evolution is not confluent, torn.

    Args:
        net: The net.
        max_states: How many stable states it may have; more are told of as an error that is returned.
    """
    try:
        try:
            return direct_with_proof(net, max_states=max_states)
        except SemanticsError:
            return direct(net, tear=True, max_states=max_states)
    except LimitError as error:
        return error


def as_diagram(net: PetriNet, max_states: int) -> SymbolicSpace:
    """The markings of a local net as a diagram, of which there may be any number."""
    return reach(net)


Job: TypeAlias = tuple[Callable[[PetriNet, int], Any], PetriNet, int]


def results_of(jobs: list[Job], executor: Executor | None) -> Iterator[Any]:
    """The results of jobs, in their order, wherever they run; what a job raises is raised here."""
    futures = [executor.submit(call, net, limit) for call, net, limit in jobs] if executor else []
    for number, (call, net, limit) in enumerate(jobs):
        yield futures[number].result() if executor else call(net, limit)


@contextmanager
def in_section(name: str) -> Iterator[None]:
    """Says of a limit in which section it was hit."""
    try:
        yield
    except LimitError as error:
        raise LimitError(f"in section {name}: {error}") from error
