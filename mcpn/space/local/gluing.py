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
from mcpn.space.local.composite import Composite, Tear
from mcpn.space.local.diagram import Undecided
from mcpn.space.local.graph import LocalGraph
from mcpn.space.local.junction import open_junctions
from mcpn.space.local.placing import (
    DEFAULT_MAX_STATES,
    MOST_LISTED,
    PlacedSection,
    Progress,
    listed,
    local_graphs,
)


def glue(
    usage: Usage,
    graph: ObjectivesGraph,
    *,
    templates: TemplateSet | None = None,
    executor: Executor | None = None,
    max_states: int = DEFAULT_MAX_STATES,
    most_listed: int | None = MOST_LISTED,
    strict: bool = True,
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
        strict: Whether to raise where the mission comes to what is not confluent or need not end; else
            :meth:`mcpn.space.local.composite.Composite.torn` tells it.
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
    while (tear := next(composite.torn(), None)) is not None and isinstance(tear.here.error, Undecided):
        composite = _listed_instead(composite, tear.section, tear.here.error, max_states)
    if tear is not None and strict:
        raise error_of(composite, tear, templates)
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
        for here in p.local.torn(p.local.inside, p.local.before):
            raise error_of(alone, Tear(p, None, here), templates)
    for junction in open_junctions(
        usage, graph, placed, templates=templates, executor=executor, max_states=max_states
    ):
        for here in junction.torn(junction.first.local.inside):
            raise error_of(alone, Tear(junction.first, junction.second, here), templates)
    return placed


def _listed_instead(
    composite: Composite, section: PlacedSection, error: Undecided, max_states: int
) -> Composite:
    """The composite with the states of a type of sections listed that its diagram does not decide."""
    local, name = section.local, section.section.name
    graph = listed(local.net.net, max_states)
    if isinstance(graph, LimitError):
        raise LimitError(
            f"in section {name}: diagrams leave {error} open, and listing its states takes {graph}"
        )
    instead = LocalGraph(local.part, local.net, graph)
    sections = [replace(p, local=instead) if p.local is local else p for p in composite.sections]
    of = {p.section.name: p for p in sections}
    junctions = [replace(j, first=of[j.first.section.name]) for j in composite.junctions]
    return Composite(composite.usage, composite.graph, tuple(sections), tuple(junctions))


def error_of(composite: Composite, tear: Tear, templates: TemplateSet | None) -> SemanticsError:
    """The error of a tear in its sections' own names, with where it is and what may be its reason.

    Args:
        composite: The mission's composite.
        tear: Where the mission comes to what is not confluent or need not end.
        templates: Those that the mission is composed with.
    """
    error, name = tear.here.error, tear.section.section.name
    if tear.onward is None:
        error, where = _renamed(error, tear.section, templates), f"section {name}"
    else:
        where = f"sections {name} to {tear.onward.section.name}"
    if isinstance(error, UnsafeError):
        return error
    text = str(error)
    if tear.here.event == "MISSION_EV_START" and tear.section is not composite.first:
        text = text.replace("after MISSION_EV_START", "at its entry")
    usage = composite.usage
    found = (*usage.contentions, *usage.exchanges) if isinstance(error, ConfluenceError) else ()
    reason = f" ({'; '.join(map(str, found))})" if found else ""
    return type(error)(f"in {where}: {text}{reason}", error.runs)


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
