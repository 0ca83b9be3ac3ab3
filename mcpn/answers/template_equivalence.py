"""Two sets of templates on one mission: whether the same happens, or a shortest run that tells them apart.

Compared are the alternatives graphs: which events are possible in each stable state, and the situation there
in mission words. With templates that keep their contract each event has one outcome: the graphs are
deterministic, and so bisimilar where each pair of states that the same run of events leads to allows the same
events and has the same situation. These pairs are walked breadth first; the first that differs ends a
shortest run. Events and situations name elements of the mission, so that the names of places do not matter.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import astuple, dataclass
from typing import Any

from mcpn.answers.spaces_by_engine import MissionSpaces
from mcpn.answers.verdicts.modes import situation
from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.templates import TemplateSet
from mcpn.errors import ConfluenceError, DivergenceError, LimitError, SemanticsError
from mcpn.events import Event
from mcpn.mission.model import Mission
from mcpn.nets.game import TokenGame
from mcpn.nets.petri import PetriNet
from mcpn.spaces.stable.alternatives import AlternativesGraph

Firings = tuple[tuple[str, ...], ...]
"""By event of a run, the internal transitions that fire after it."""


@dataclass(frozen=True)
class SetSizes:
    """What a mission comes to with one set of templates.

    Args:
        places: Of its net.
        transitions: Of its net.
        states: Stable states, ``None`` where there is no alternatives graph.
        edges: Edges between them.
        reason: Why there is none.
    """

    places: int
    transitions: int
    states: int | None = None
    edges: int | None = None
    reason: str = ""


@dataclass(frozen=True)
class SetDifference:
    """Where two sets of templates differ.

    Args:
        events: A shortest run of events after which they do.
        message: What differs then.
        firings: By set, the internal transitions that fire in its net after each of the events.
    """

    events: tuple[Event, ...]
    message: str
    firings: tuple[Firings, Firings]


@dataclass(frozen=True)
class Likeness:
    """How two sets of templates compare on one mission.

    Args:
        sizes: By set.
        difference: Where they differ; ``None`` where the same happens.
        isomorphic: Whether the two graphs are isomorphic: each state has exactly one counterpart.
    """

    sizes: tuple[SetSizes, SetSizes]
    difference: SetDifference | None
    isomorphic: bool


def likeness(
    mission: Mission,
    first: TemplateSet | None,
    second: TemplateSet | None,
    *,
    names: tuple[str, str] = ("first", "second"),
    max_states: int | None = None,
) -> Likeness:
    """Compares two sets of templates on a mission.

    Where neither has an alternatives graph, for the same kind of reason, they do not differ in what is
    compared.

    Args:
        mission: The mission.
        first: A set; ``None`` is the paper's.
        second: The other.
        names: What they are called where they differ.
        max_states: Limit on stable states.

    Raises:
        SemanticsError: An event fires several transitions with different outcomes.
        LimitError: A limit was hit.

    Examples:
        >>> from mcpn.mission.xml import read_mission
        >>> from mcpn.drawing.templates.compact import CompactTemplates
        >>> found = likeness(read_mission("experiments/ulysse/mission.xml"), None, CompactTemplates())
        >>> found.difference, found.isomorphic
        (None, True)
    """
    both = [(s, compose(mission, s)) for s in (first, second)]
    one, other = (MissionSpaces(net, templates=s).bound(max_states=max_states) for s, net in both)
    return likeness_of(one, other, names=names)


def likeness_of(
    first: MissionSpaces,
    second: MissionSpaces,
    *,
    names: tuple[str, str] = ("first", "second"),
) -> Likeness:
    """Compares two spaces of one mission, each composed with templates of its own.

    Raises:
        LimitError: A limit was hit.
    """
    one, other = (_listed(spaces) for spaces in (first, second))
    sizes = (_sizes(first.net, one), _sizes(second.net, other))
    nets = (first.mission, second.mission)
    if isinstance(one, SemanticsError) or isinstance(other, SemanticsError):
        return Likeness(sizes, _unlike(names, nets, (one, other)), isomorphic=False)
    walk = _Walk(names, nets, (one, other))
    difference = walk.difference()
    return Likeness(sizes, difference, isomorphic=difference is None and walk.one_to_one)


def _listed(spaces: MissionSpaces) -> AlternativesGraph | SemanticsError:
    try:
        return spaces.listed()
    except SemanticsError as error:
        return error


def _sizes(net: PetriNet, outcome: AlternativesGraph | SemanticsError) -> SetSizes:
    sizes = len(net.places), len(net.transitions)
    if isinstance(outcome, SemanticsError):
        return SetSizes(*sizes, reason=str(outcome))
    return SetSizes(*sizes, outcome.states, outcome.edges)


def _unlike(
    names: tuple[str, str],
    nets: tuple[MissionNet, MissionNet],
    outcomes: tuple[AlternativesGraph | SemanticsError, AlternativesGraph | SemanticsError],
) -> SetDifference | None:
    """The difference where a set has no alternatives graph; ``None`` where both lack it for like reasons."""
    kinds = [each.kind if isinstance(each, SemanticsError) else None for each in outcomes]
    if kinds[0] == kinds[1]:
        return None
    parts = [
        f"{name} has {'an alternatives graph' if kind is None else f'none: {each}'}"
        for name, kind, each in zip(names, kinds, outcomes, strict=True)
    ]
    number, error = next((i, each) for i, each in enumerate(outcomes) if isinstance(each, SemanticsError))
    run = error.runs[0] if error.runs else ()
    net = nets[number].net
    fired = [net.transition_index[name] for name in run if name in net.transition_index]
    events = tuple(event for t in fired if (event := net.transitions[t].event) is not None)
    if isinstance(error, ConfluenceError) and not events:
        events = tuple(map(Event.parse, error.events or ()))
    return SetDifference(events, "; ".join(parts), _both_firings(nets, events))


class _Walk:
    """The pairs of states that the same events lead to."""

    def __init__(
        self,
        names: tuple[str, str],
        nets: tuple[MissionNet, MissionNet],
        graphs: tuple[AlternativesGraph, AlternativesGraph],
    ) -> None:
        self.names, self.nets, self.graphs = names, nets, graphs
        self.before: dict[tuple[int, int], tuple[tuple[int, int], Event] | None] = {(0, 0): None}

    @property
    def one_to_one(self) -> bool:
        """Whether the pairs are a bijection of the states; known once all pairs have been walked."""
        pairs = len(self.before)
        return all(len({*side}) == pairs for side in zip(*self.before, strict=True))

    def difference(self) -> SetDifference | None:
        """The first pair that differs, breadth first."""
        queue = [(0, 0)]
        for pair in queue:  # which grows
            said = [_said(net, graph.marking(s)) for net, graph, s in self._sides(pair)]
            if said[0] != said[1]:
                return self._after(pair, "; ".join(self._differences(*said)))
            one, other = (self._onward(graph, s) for _, graph, s in self._sides(pair))
            if one.keys() != other.keys():
                event = min(one.keys() ^ other.keys(), key=str)
                which = self.names[event not in one]
                return self._after(pair, f"{event} may happen with {which} alone")
            for event, after in one.items():
                reached = after, other[event]
                if reached not in self.before:
                    self.before[reached] = pair, event
                    queue.append(reached)
        return None

    def _sides(self, pair: tuple[int, int]) -> Iterator[tuple[MissionNet, AlternativesGraph, int]]:
        return zip(self.nets, self.graphs, pair, strict=True)

    @staticmethod
    def _onward(graph: AlternativesGraph, state: int) -> dict[Event, int]:
        """By event, the state that it leads to; self-loops included."""
        targets = dict[Event, int]()
        for transition, after in graph.successors(state):
            event = graph.net.transitions[transition].event
            assert event is not None, "edges of the alternatives graph are events"
            if targets.setdefault(event, after) != after:
                raise SemanticsError(f"the event {event} fires several transitions, with different outcomes")
        return targets

    def _differences(self, one: dict[str, Any], other: dict[str, Any]) -> Iterator[str]:
        """The fields in which two situations differ, in words."""
        for name, value in one.items():
            if value != other[name]:
                said = zip(self.names, (value, other[name]), strict=True)
                both = ", ".join(f"{shown or 'none'} with {which}" for which, shown in said)
                yield f"{name.replace('_', ' ')}: {both}"

    def _after(self, pair: tuple[int, int], message: str) -> SetDifference:
        """A difference at a pair of states, with the run of events that leads there."""
        events: list[Event] = []
        step = self.before[pair]
        while step is not None:
            pair, event = step
            events.insert(0, event)
            step = self.before[pair]
        return SetDifference(tuple(events), message, _both_firings(self.nets, tuple(events)))


def _said(mission_net: MissionNet, marking: tuple[int, ...]) -> dict[str, Any]:
    """The fields of a situation, its lists sorted so that the order of places does not matter."""
    fields = situation(mission_net, marking)
    names = tuple(fields.__dataclass_fields__)
    return {
        name: sorted(value) if isinstance(value, tuple) else value
        for name, value in zip(names, astuple(fields), strict=True)
    }


def _both_firings(nets: tuple[MissionNet, MissionNet], events: tuple[Event, ...]) -> tuple[Firings, Firings]:
    one, other = (_firings(mission_net.net, events) for mission_net in nets)
    return one, other


def _firings(net: PetriNet, events: tuple[Event, ...]) -> Firings:
    """What fires inside a net after each event, as far as the events are possible."""
    game, firings = TokenGame(net), list[tuple[str, ...]]()
    game.settle()
    for event in events:
        possible = [t for t in game.enabled if net.transitions[t].event == event]
        if not possible:
            break
        game.fire(possible[0])
        try:
            firings.append(tuple(net.transitions[t].name for t in game.settle()))
        except (DivergenceError, LimitError):
            break  # internal evolution does not end
    return tuple(firings)
