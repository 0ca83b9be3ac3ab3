"""From a mission to its composite: local spaces, junctions, and whether the mission comes where one fails."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from mcpn.errors import ConfluenceError, DivergenceError, LimitError, SemanticsError, UnsafeError
from mcpn.mission.flatten import ObjectivesGraph
from mcpn.mission.usage import Usage
from mcpn.net.petri import PetriNet
from mcpn.net.sections import junction_part
from mcpn.net.templates import TemplateSet
from mcpn.space.alternatives import confluence_error, divergence_error
from mcpn.space.clash import explained
from mcpn.space.local.composite import Composite, Tear
from mcpn.space.local.diagram import Undecided
from mcpn.space.local.graph import LocalGraph
from mcpn.space.local.junction import open_junctions
from mcpn.space.local.placing import AS_USUAL, Making, PlacedSection, listed, local_graphs


def glue(
    usage: Usage, graph: ObjectivesGraph, making: Making = AS_USUAL, *, strict: bool = True
) -> Composite:
    """Makes the composite of a mission, and judges all that the mission comes to.

    Args:
        usage: Static facts of the mission.
        graph: Its objectives graph.
        making: How local spaces are made.
        strict: Whether to raise where the mission comes to what is not confluent or need not end; else
            :attr:`mcpn.space.local.composite.Composite.tear` tells it.

    Returns:
        The composite.

    Raises:
        PremiseError: A section hands on more than the state of its hardware.
        ConfluenceError: In a state that the mission comes to, internal evolution depends on interleaving.
        DivergenceError: It need not end.
        UnsafeError: A local net is not 1-safe.
        LimitError: A limit was hit.
    """
    composite = _put_together(usage, graph, making)
    while (tear := composite.tear) is not None and isinstance(tear.here.error, Undecided):
        composite = _listed_instead(composite, tear.section, tear.here.error, making.max_states)
    if tear is not None and strict:
        raise error_of(composite, tear, making.templates)
    return composite


def refuse_interruptions(graph: ObjectivesGraph) -> None:
    """Refuses missions whose sections may be left by more than success and failure.

    Raises:
        LimitError: An event may interrupt a section.
    """
    for section in graph.all_sections():
        for interruption in section.interruptions:
            where = f"{interruption.source}: " if interruption.source else ""
            raise LimitError(
                f"{where}the event {interruption.event} may interrupt {section.name}, which this does "
                "not take yet: use --engine explicit or symbolic, and controller --flat"
            )


def judged_everywhere(
    usage: Usage, graph: ObjectivesGraph, making: Making = AS_USUAL
) -> tuple[PlacedSection, ...]:
    """The sections of a mission, or some of them, confluent for all states of their hardware.

    Args:
        usage: Static facts of the mission.
        graph: The sections.
        making: How local spaces are made; the states of every section are listed.

    Returns:
        The sections.

    Raises:
        SemanticsError: As for :func:`glue`, also where the mission never comes.
        LimitError: A limit was hit.
    """
    composite = _put_together(usage, graph, replace(making, most_listed=None))
    for p in composite.sections:
        for here in p.local.torn(p.local.inside, p.local.before):
            raise error_of(composite, Tear(p, None, here), making.templates)
    for junction in composite.junctions:
        for here in junction.torn(junction.first.local.inside):
            raise error_of(composite, Tear(junction.first, junction.second, here), making.templates)
    return composite.sections


def _put_together(usage: Usage, graph: ObjectivesGraph, making: Making) -> Composite:
    refuse_interruptions(graph)
    placed = local_graphs(usage, graph, making)
    junctions = open_junctions(usage, graph, placed, making)
    return Composite(usage, graph, tuple(placed), tuple(junctions))


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
    if isinstance(error, ConfluenceError):
        part = tear.section.part
        if tear.onward is not None:
            part = junction_part(composite.usage, tear.section.section, tear.onward.section)
        return explained(part.net(templates), error)
    return type(error)(f"in {where}: {error}", error.runs)


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
