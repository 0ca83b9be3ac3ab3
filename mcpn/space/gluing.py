"""From a mission to its composite: local spaces, junctions, and whether the mission comes where one fails."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import replace

from mcpn.errors import ConfluenceError, DivergenceError, LimitError, SemanticsError, UnsafeError
from mcpn.mission.flatten import ObjectivesGraph
from mcpn.mission.usage import Usage
from mcpn.net.petri import PetriNet
from mcpn.net.templates import TemplateSet
from mcpn.space.alternatives import confluence_error, divergence_error
from mcpn.space.composite import Composite
from mcpn.space.junction import open_junctions
from mcpn.space.local import (
    DEFAULT_MAX_STATES,
    MOST_LISTED,
    PlacedSection,
    Progress,
    listed,
    local_graphs,
)
from mcpn.space.local_diagram import Undecided
from mcpn.space.local_graph import LocalGraph


def glue(
    usage: Usage,
    graph: ObjectivesGraph,
    *,
    templates: TemplateSet | None = None,
    executor: Executor | None = None,
    max_states: int = DEFAULT_MAX_STATES,
    most_listed: int | None = MOST_LISTED,
    progress: Progress | None = None,
) -> Composite:
    """Makes the composite of a mission, and judges all that the mission comes to.

    Args:
        usage: Static facts of the mission.
        graph: Its objectives graph.
        templates: The set of templates that the mission is composed with; the paper's by default.
        executor: Where states are listed and junctions proved; in this process by default.
        max_states: How many states a local graph may list; a section with more has a diagram.
        most_listed: With more hardware that can fail a section has a diagram at once; ``None`` to list the
            states of every section.
        progress: Called after each local space and each junction, with how many of their kind there are.

    Returns:
        The composite.

    Raises:
        PremiseError: A section hands on more than the state of its hardware.
        ConfluenceError: In a state that the mission comes to, internal evolution depends on interleaving.
        DivergenceError: It need not end.
        UnsafeError: A local net is not 1-safe.
        LimitError: A limit was hit.
    """
    placed = local_graphs(
        usage,
        graph,
        templates=templates,
        executor=executor,
        max_states=max_states,
        most_listed=most_listed,
        progress=progress,
    )
    junctions = open_junctions(
        usage, graph, placed, templates=templates, executor=executor, max_states=max_states, progress=progress
    )
    composite = Composite(usage, graph, tuple(placed), tuple(junctions))
    while (found := next(composite.torn(), None)) is not None:
        where, error = found
        if not isinstance(error, Undecided):
            raise _told(composite, where, error, templates)
        composite = _listed_instead(composite, where, error, max_states)
    return composite


def judged_everywhere(
    usage: Usage,
    graph: ObjectivesGraph,
    *,
    templates: TemplateSet | None = None,
    executor: Executor | None = None,
    max_states: int = DEFAULT_MAX_STATES,
) -> list[PlacedSection]:
    """The sections of a mission, or some of them, confluent for all states of their hardware.

    Args:
        usage: Static facts of the mission.
        graph: The sections.
        templates: The set of templates that the mission is composed with; the paper's by default.
        executor: Where states are listed and junctions proved; in this process by default.
        max_states: How many states a local graph may list.

    Returns:
        The sections, the states of each listed.

    Raises:
        SemanticsError: As for :func:`glue`, also where the mission never comes.
        LimitError: A limit was hit.
    """
    placed = local_graphs(
        usage, graph, templates=templates, executor=executor, max_states=max_states, most_listed=None
    )
    alone = Composite(usage, graph, tuple(placed))
    for p in placed:
        for error in p.local.torn(p.local.inside, p.local.before):
            raise _told(alone, p.section.name, error, templates)
    for junction in open_junctions(
        usage, graph, placed, templates=templates, executor=executor, max_states=max_states
    ):
        for error in junction.torn(junction.first.local.inside):
            raise _told(
                alone, f"{junction.first.section.name} to {junction.second.section.name}", error, templates
            )
    return placed


def _listed_instead(composite: Composite, name: str, error: Undecided, max_states: int) -> Composite:
    """The composite with the states of a section listed that its diagram does not decide."""
    local = composite.by_name[name].local
    graph = listed(local.net.net, max_states)
    if isinstance(graph, LimitError):
        raise LimitError(f"in section {name}: {error} is left open by diagrams, and listing has {graph}")
    instead = LocalGraph(local.part, local.net, graph)
    sections = [replace(p, local=instead) if p.local is local else p for p in composite.sections]
    of = {p.section.name: p for p in sections}
    junctions = [replace(j, first=of[j.first.section.name]) for j in composite.junctions]
    return Composite(composite.usage, composite.graph, tuple(sections), tuple(junctions))


def _told(
    composite: Composite, where: str, error: SemanticsError, templates: TemplateSet | None
) -> SemanticsError:
    """The error in a section's own names, with where it is and which contentions may be its reason."""
    if where in composite.by_name:
        placed = composite.by_name[where]
        error = _renamed(error, placed, templates)
    if isinstance(error, UnsafeError):
        return error
    usage = composite.usage
    found = (*usage.contentions, *usage.exchanges) if isinstance(error, ConfluenceError) else ()
    reason = f" ({'; '.join(map(str, found))})" if found else ""
    sections = "sections" if where not in composite.by_name else "section"
    return type(error)(f"in {sections} {where}: {error}{reason}", error.runs)


def _renamed(error: SemanticsError, placed: PlacedSection, templates: TemplateSet | None) -> SemanticsError:
    """An error of the section that stands for a type, told of another section of it."""
    old, new = placed.local.net.net, placed.net(templates).net
    runs = [list(_names(run, old, new)) for run in error.runs]
    if isinstance(error, UnsafeError):
        places = {p.name: new.places[i].name for i, p in enumerate(old.places)}
        marking = [places[name] for name in error.marking]
        return UnsafeError(places[error.place], runs[0][-1], marking, runs[0][:-1])
    if isinstance(error, DivergenceError):
        return divergence_error(runs[0])
    return confluence_error(new, runs)


def _names(run: tuple[str, ...], old: PetriNet, new: PetriNet) -> Iterator[str]:
    for name in run:
        yield new.transitions[old.transition_index[name]].name
