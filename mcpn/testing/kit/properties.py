"""Ready-made properties: what any set of templates owes, as functions of a mission composed with it.

>>> from mcpn.mission.xml import read_mission
>>> subject = Subject(read_mission("experiments/ulysse/mission.xml"), max_states=100_000)
>>> for holds in PROPERTIES.values():
...     holds(subject)

Each raises a :class:`~mcpn.testing.kit.subject.Violation` with a run, and passes over what it does not speak
of. A net that is not 1-safe breaks all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Literal, TypeAlias

import numpy as np

from mcpn.answers.spaces_by_engine import MissionSpaces
from mcpn.answers.template_equivalence import likeness_of
from mcpn.drawing.compose import compose
from mcpn.drawing.templates import TemplateSet
from mcpn.errors import ConfluenceError, DivergenceError, SemanticsError, UnsafeError
from mcpn.mission.core.objectives_graph import ObjectivesGraph
from mcpn.report.text import likeness_lines
from mcpn.spaces.markings.graph import Mask
from mcpn.testing.kit.contract import contract_of_arcs
from mcpn.testing.kit.promises import idle_again as idle_at_the_end
from mcpn.testing.kit.promises import invariants_of_units, promises_at_rest
from mcpn.testing.kit.subject import MOST_MARKINGS, Subject, Violation

Property: TypeAlias = Callable[[Subject], None]


def one_safe(subject: Subject) -> None:
    """No firing puts a second token in a place."""
    try:
        subject.markings  # noqa: B018
    except UnsafeError as error:
        raise Violation(str(error), error.runs, subject.net) from None


def unit_invariants(subject: Subject) -> None:
    """Each interface of a resource holds one token, in every marking."""
    one_safe(subject)
    invariants_of_units(subject)


def ending(subject: Subject) -> None:
    """Internal evolution ends, and from every marking some run leads to an end of the mission.

    Where activities contend they may wait for each other, or ask again and again: that is not looked at. Nor
    are ends of missions whose routes may lead round for ever.
    """
    one_safe(subject)
    if subject.mission_net.usage.contentions:
        return
    try:
        subject.reduced()
    except DivergenceError as error:
        raise Violation(str(error), error.runs, subject.net) from None
    except ConfluenceError:
        pass  # another property
    if any(map(_goes_round, subject.mission_net.usage.graphs())):
        return
    ends = np.zeros(subject.markings.states, np.bool_)
    for place in subject.mission_net.ends.values():
        ends |= subject.markings.marked(place)
    subject.require(subject.markings.reaching(ends), "no run leads from here to an end of the mission")


def _goes_round(graph: ObjectivesGraph) -> bool:
    """Whether what objectives come to, by themselves or as facts choose, may lead round for ever."""
    left = {
        section.name: {route for _, route in section.outcomes} | {case.target for _, case in section.cases}
        for section in graph.sections
    }
    while ends := [name for name, routes in left.items() if not routes & left.keys()]:
        for name in ends:
            del left[name]
    return bool(left)


def confluent(subject: Subject) -> None:
    """Each event has one outcome, whatever the order of internal firings; where nothing contends."""
    one_safe(subject)
    if subject.mission_net.usage.contentions:
        return
    try:
        subject.reduced()
    except ConfluenceError as error:
        raise Violation(str(error), error.runs, subject.net) from None
    except DivergenceError:
        pass  # another property


def idle_again(subject: Subject) -> None:
    """When the mission has ended, everything but the status of hardware is as before."""
    one_safe(subject)
    idle_at_the_end(subject)


def event_deterministic(subject: Subject) -> None:
    """In no stable marking may one event fire two transitions."""
    one_safe(subject)
    graph = subject.markings
    for state in np.flatnonzero(subject.stable).tolist():
        events = [subject.net.transitions[t].event for t, _ in graph.successors(state)]
        for event in events:
            if events.count(event) > 1:
                raise subject.violation(state, f"the event {event} fires several transitions")


def refused_for_a_reason(subject: Subject) -> None:
    """No event leads to a refusal while an alternative of the activity is possible.

    Possible, whatever the templates, is an alternative that needs hardware alone, all of it in service. Where
    activities contend, others may hold it. Who was refused before the event may stay so: it evaluates again
    when it is started again.
    """
    one_safe(subject)
    found = subject.mission_net
    if found.usage.contentions:
        return
    try:
        graph = subject.reduced()
    except (ConfluenceError, DivergenceError):
        return  # other properties

    def said(role: Literal["refused", "oos", "known"], name: str) -> Mask:
        marked = np.zeros(graph.states, np.bool_)
        for place in found.by_role.get((role, name), ()):
            marked |= graph.marked(place)
        return marked

    for activity in found.core.activities:
        refused = said("refused", activity.name)
        if not refused.any() or activity.requires or found.usage.may_wait(activity.name):
            continue
        fresh = refused[graph.targets] & ~refused[graph.sources]
        for way in activity.alternatives:
            if way.requires or not found.usage.hardware.keys() >= {*way.consumes}:
                continue
            out = np.zeros(graph.states, np.bool_)
            for name in way.consumes:
                out |= said("oos", name) | said("known", name)
            for edge in np.flatnonzero(fresh & ~out[graph.targets]).tolist():
                raise subject.after(graph, edge, f"{activity.name} is refused, and {way.name} was possible")


def contract_kept(subject: Subject) -> None:
    """Transitions touch other templates only as the contract says; at rest all have answered.

    At rest means in stable markings: hardware is free, busy or out of service, and each activity of an
    objective runs, waits or is refused.
    """
    contract_of_arcs(subject)
    one_safe(subject)
    promises_at_rest(subject)


PROPERTIES: Mapping[str, Property] = {
    "one_safe": one_safe,
    "unit_invariants": unit_invariants,
    "contract_kept": contract_kept,
    "ending": ending,
    "confluent": confluent,
    "refused_for_a_reason": refused_for_a_reason,
    "idle_again": idle_again,
    "event_deterministic": event_deterministic,
}
"""By name, what holds of every mission; in the order in which one looks for the cause of a fault."""


def no_dead_transition(subject: Subject) -> None:
    """Every transition fires in some run: of missions that need all of what is drawn.

    Templates may draw what a mission does not need, so this is asked of chosen missions alone. Those are
    named first whose places are each marked at some time: the others wait for what these should have put.
    """
    one_safe(subject)
    fired = {*np.unique(subject.markings.labels).tolist()}
    dead = [t for t in range(len(subject.net.transitions)) if t not in fired]
    if not dead:
        return
    marked = {p for p in range(len(subject.net.places)) if subject.markings.marked(p).any()}
    arcs = {t: subject.net.transitions[t] for t in dead}
    needs = {t: {p for p, _ in (*arcs[t].consume, *arcs[t].read)} for t in dead}
    first = [t for t in dead if needs[t] <= marked] or dead
    named, behind = (
        ", ".join(subject.net.transitions[t].name for t in dead if (t in first) is way)
        for way in (True, False)
    )
    raise Violation(f"never fired: {named}" + (f"; nor what comes behind: {behind}" if behind else ""))


def behaves_as(templates: TemplateSet, *, name: str = "the others") -> Property:
    """The property that a mission behaves as with other templates, event by event.

    Args:
        templates: The others.
        name: What they are called where it does not.
    """

    def holds(subject: Subject) -> None:
        composed = compose(subject.mission_net.mission, templates)
        other = MissionSpaces(composed, templates=templates).bound(max_states=MOST_MARKINGS)
        names = ("these", name)
        try:
            found = likeness_of(subject.spaces.bound(max_states=MOST_MARKINGS), other, names=names)
        except SemanticsError as error:
            raise Violation(str(error), error.runs, subject.net) from None
        if found.difference is not None:
            raise Violation("\n".join(likeness_lines(found, names, subject.mission_net.mission.name)))

    return holds
