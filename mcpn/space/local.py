"""Local graphs: the alternatives graph of one section, from every state of its hardware.

The paper's future work ("generating local graph dedicated to each objective instead of generating a complete
graph for the whole mission"). Between two sections every activity is stopped and every software resource is
gone, so that all a section hands on is its *interface state*: its outcome, and which of its hardware is out
of service. This premise is checked on each local graph, not believed; and where two sections in a row share
more than hardware, their junction is proved confluent on the net of both.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from mcpn.errors import ConfluenceError, LimitError, SemanticsError
from mcpn.mission.flatten import ObjectivesGraph, Section
from mcpn.mission.usage import Usage
from mcpn.net.compose import MissionNet
from mcpn.net.petri import PetriNet
from mcpn.net.sections import LocalPart, Renaming, junction_part, section_part
from mcpn.net.templates import TemplateSet
from mcpn.space.alternatives import AlternativesGraph
from mcpn.space.confluence import direct_with_proof, prove_confluent
from mcpn.space.graph import Ints, Mask

Outcome: TypeAlias = Literal["success", "failure"]
OUTCOMES: tuple[Outcome, Outcome] = ("success", "failure")
DEFAULT_MAX_STATES = 1_000_000
MAX_FAULTY = 16
"""Hardware that can fail in one section: its interface states are listed, two to this power."""

Progress: TypeAlias = Callable[[int, int], None]
"""Called after each local graph and junction with how many are done and how many there are."""


class PremiseError(SemanticsError):
    """A section hands on more than the state of its hardware, so that local graphs do not tell the mission's.

    Args:
        section: The section's name.
        place: A place that differs at the section's exit from what it was at its entry.
        runs: One that shows it, in the local net.
    """

    def __init__(self, section: str, place: str, runs: list[list[str]]) -> None:
        self.section = section
        self.place = place
        super().__init__(
            f"section {section} does not leave the place {place} as it was at its entry, so local graphs do "
            "not tell the mission's: use --engine explicit or symbolic",
            runs,
        )


@dataclass(frozen=True, eq=False)
class LocalGraph:
    """The alternatives graph of one type of sections.

    Its states are those before the entry (one for each interface state), those inside, and those after.

    Args:
        part: The section that stands for its type.
        net: Its local net.
        graph: The graph.
    """

    part: LocalPart
    net: MissionNet
    graph: AlternativesGraph

    @cached_property
    def faulty(self) -> tuple[str, ...]:
        """Hardware that can fail, by its bit in masks."""
        return self.part.faulty

    @cached_property
    def out_of_service(self) -> Ints:
        """By state, the mask of the hardware out of service, shape (states,)."""
        masks = np.zeros(self.graph.states, np.int64)
        for bit, name in enumerate(self.faulty):
            (place,) = self.net.by_role["oos", name]
            masks |= self.graph.marked(place).astype(np.int64) << bit
        return masks

    @cached_property
    def ended(self) -> Mapping[Outcome, Mask]:
        """States after the section, by its outcome, shape (states,) each."""
        return {
            "success": self.graph.marked(self.net.success),
            "failure": self.graph.marked(self.net.failure),
        }

    @cached_property
    def before(self) -> Mask:
        """States before the entry, shape (states,)."""
        return self.graph.marked(self.net.beginning)

    @cached_property
    def inside(self) -> Mask:
        """States of the section itself, shape (states,)."""
        return ~(self.before | self.ended["success"] | self.ended["failure"])

    @cached_property
    def entry(self) -> Ints:
        """By mask of hardware out of service at the entry, the first state inside, shape (masks,)."""
        graph = self.graph
        starts = self.before[graph.sources] & ~self.before[graph.targets]
        found = np.full(1 << len(self.faulty), -1, np.int64)
        found[self.out_of_service[graph.sources[starts]]] = graph.targets[starts]
        return found

    @cached_property
    def leaving(self) -> Mapping[Outcome, Ints]:
        """Edges that leave the section, by its outcome."""
        inside = self.inside[self.graph.sources]
        return {o: np.flatnonzero(inside & self.ended[o][self.graph.targets]) for o in OUTCOMES}

    @cached_property
    def edges_inside(self) -> Mask:
        """Edges between states inside, shape (edges,)."""
        return self.inside[self.graph.sources] & self.inside[self.graph.targets]

    def check_premise(self, section: str) -> None:
        """Compares each state after the section with the one before it of the same hardware.

        Raises:
            PremiseError: Some place differs.
        """
        graph, net = self.graph, self.net
        aside = np.zeros_like(graph.markings[0])
        for place in (net.beginning, net.success, net.failure):
            aside[place // 64] |= np.uint64(1) << np.uint64(place % 64)
        markings = graph.markings & ~aside
        idle = np.zeros((1 << len(self.faulty), markings.shape[1]), np.uint64)
        idle[self.out_of_service[self.before]] = markings[self.before]
        after = np.flatnonzero(self.ended["success"] | self.ended["failure"])
        different = markings[after] != idle[self.out_of_service[after]]
        if different.any():
            state = int(after[np.flatnonzero(different.any(axis=1))[0]])
            changed = markings[state] ^ idle[self.out_of_service[state]]
            place = next(p for p in range(len(net.net.places)) if int(changed[p // 64]) >> p % 64 & 1)
            run = graph.run_to(np.arange(graph.states) == state) or []
            raise PremiseError(section, net.net.places[place].name, [graph.events(run)])


@dataclass(frozen=True, eq=False)
class PlacedSection:
    """A section of the mission with the local graph of its type.

    Args:
        section: The section.
        part: What it uses; its elements stand in the order of those of the local graph's own.
        local: The graph of its type.
    """

    section: Section
    part: LocalPart
    local: LocalGraph

    @cached_property
    def faulty(self) -> tuple[str, ...]:
        """Hardware of this section that can fail, by its bit in the masks of the local graph."""
        return self.part.faulty

    @cached_property
    def renaming(self) -> Renaming:
        """From the names in the local graph to the section's own."""
        return Renaming(self.local.part, self.part)

    def net(self, templates: TemplateSet | None = None) -> MissionNet:
        """The section's own local net: that of its type, with its own names."""
        return self.part.net(templates)


def local_graphs(
    usage: Usage,
    graph: ObjectivesGraph,
    *,
    templates: TemplateSet | None = None,
    executor: Executor | None = None,
    max_states: int = DEFAULT_MAX_STATES,
    progress: Progress | None = None,
) -> list[PlacedSection]:
    """Explores each type of sections once, and proves what gluing them rests on.

    Args:
        usage: Static facts of the mission.
        graph: Its objectives graph.
        templates: The set of templates; without the paper's no two sections are taken for one type.
        executor: Where local graphs are made; in this process one after the other by default.
        max_states: How many states a local graph may have.
        progress: Called after each local graph and junction.

    Returns:
        Every section with its local graph, in document order.

    Raises:
        PremiseError: A section hands on more than the state of its hardware.
        ConfluenceError: Internal evolution of a section, or from one to the next, depends on interleaving;
            sections are judged for all states of their hardware, whether the mission enters them so or not.
        DivergenceError: It need not end.
        UnsafeError: A local net is not 1-safe.
        LimitError: A local graph has too many states, or a section too much hardware that can fail.
    """
    parts = {section.name: section_part(usage, section) for section in graph.sections}
    kinds = {name: part.type if templates is None else name for name, part in parts.items()}
    types: dict[Hashable, str] = {}
    for name in parts:
        types.setdefault(kinds[name], name)  # the first section of a type stands for it
    for name in types.values():
        if len(parts[name].faulty) > MAX_FAULTY:
            raise LimitError(
                f"section {name} uses {len(parts[name].faulty)} hardware resources that can fail: the limit "
                f"of local graphs is {MAX_FAULTY}"
            )
    junctions = _junctions(usage, graph, parts)
    nets = {kind: parts[name].net(templates) for kind, name in types.items()}
    jobs: list[Job] = [(direct_with_proof, net.net, max_states) for net in nets.values()]
    jobs += [(prove_confluent, part.net(templates).net, max_states) for part in junctions.values()]
    results = _results(jobs, executor, progress)
    locals_ = {}
    for (kind, name), net in zip(types.items(), nets.values(), strict=True):
        with _told(f"section {name}", usage):
            explored = next(results)
        assert isinstance(explored, AlternativesGraph), "local graphs are asked for before junctions"
        locals_[kind] = LocalGraph(parts[name], net, explored)
        locals_[kind].check_premise(name)
    for between in junctions:
        with _told(" to ".join(between), usage):
            next(results)
    return [PlacedSection(s, parts[s.name], locals_[kinds[s.name]]) for s in graph.sections]


def _junctions(
    usage: Usage, graph: ObjectivesGraph, parts: Mapping[str, LocalPart]
) -> dict[tuple[str, str], LocalPart]:
    """Pairs of sections in a row that share activities, one for each type of pair.

    Sections that share hardware only meet at its places alone: releasing and taking it do not compete.
    """
    found: dict[object, tuple[tuple[str, str], LocalPart]] = {}
    for first in graph.sections:
        used = {a.name for a in parts[first.name].parts.activities}
        for second in graph.targets(first):
            if not used.isdisjoint(a.name for a in parts[second.name].parts.activities):
                part = junction_part(usage, first, second)
                found.setdefault(part.type, ((first.name, second.name), part))
    return dict(found.values())


Found: TypeAlias = AlternativesGraph | str
"""A local graph, or the proof of a junction in words."""

Job: TypeAlias = tuple[Callable[..., Found], PetriNet, int]


def _results(jobs: list[Job], executor: Executor | None, progress: Progress | None) -> Iterator[Found]:
    """The results of jobs, in their order, wherever they run; what a job raises is raised here."""
    futures = [executor.submit(call, net, max_states=limit) for call, net, limit in jobs] if executor else []
    for number, (call, net, limit) in enumerate(jobs):
        result = futures[number].result() if executor else call(net, max_states=limit)
        if progress:
            progress(number + 1, len(jobs))
        yield result


@contextmanager
def _told(where: str, usage: Usage) -> Iterator[None]:
    """Says of an error in which sections it is, and which contentions may be its reason."""
    try:
        yield
    except ConfluenceError as error:
        found = (*usage.contentions, *usage.exchanges)
        reason = f" ({'; '.join(map(str, found))})" if found else ""
        raise ConfluenceError(f"in {where}: {error}{reason}", error.runs) from error
