"""Stable states as pictures: local graphs, alternatives graphs, controllers.

A state is a box with what the robot does in it, a curve an event. Where there are too many states to be read,
those that run the same are drawn as one box, whatever hardware is out of service beside them; the whole
mission is drawn by its sections.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from mcpn.answers.spaces_by_engine import MissionSpaces
from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.controller.hierarchy import SectionMachine, TableController, section_machine
from mcpn.controller.machine import PlannedAction
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.forgetful import forgetful
from mcpn.drawing.local_nets import local_net, part_of
from mcpn.events import Event, What
from mcpn.mission.core.objectives_graph import ObjectivesGraph, names_in
from mcpn.report.pictures.drawing import Drawing
from mcpn.report.pictures.graph import Arrow, Cluster, Graph, Node, drawing
from mcpn.report.pictures.objectives_graph import ENDS, objectives_picture
from mcpn.report.words import what_happens
from mcpn.spaces.stable.alternatives import AlternativesGraph

MOST_STATES = 16
"""States of a section up to which each has a box of its own."""

MOST_WHOLE = 24
"""Boxes up to which a mission is drawn in one piece."""

MOST_LINES = 3
"""Events beside one curve; all of them are in its title."""

MOST_ORDERED = 60
"""Events up to which what the controller does stands beside the curves: with more a picture is pages wide."""

MOST_BOXES, MOST_MODES = 60, 20
"""Boxes up to which states of a section are drawn, and up to which each way to run is one of them.

Nobody can follow the curves between more.
"""


@dataclass(frozen=True)
class DrawnEvent:
    """An event from one state to another.

    Args:
        source: Number of a state, or ``None`` before the section is entered.
        target: Number of a state, or the outcome.
        event: What happens.
        actions: What the controller then does, where that is to be shown.
    """

    source: int | None
    target: int | str
    event: Event
    actions: tuple[PlannedAction, ...] = ()


def local_drawing(
    spaces: MissionSpaces, section: str, *, actions: bool = False, merged: bool = False
) -> Drawing:
    """The picture of the local graph of a section.

    Args:
        spaces: The mission's spaces.
        section: The section's name.
        actions: Whether each event shows what the controller does: the picture of the section's controller.
        merged: Whether states that run the same are one box, however few they are.

    Raises:
        InputError: There is no such section.
        SemanticsError: It is not safe, or not confluent.
        LimitError: It has too many states.
    """
    local, graph = spaces.local(section)
    if actions:
        part = part_of(spaces.mission, section)
        machine = section_machine(local, graph, part, forgetful(local_net(part, spaces.templates))[1])
        return machine_drawing(machine, f"Controller of the section {section}")
    return local_graph_drawing(local, graph, section, merged=merged)


def local_graph_drawing(
    local: MissionNet, graph: AlternativesGraph, section: str, *, merged: bool = False
) -> Drawing:
    """Draws a local graph that has been built already."""
    name = f"Local graph of the section {section}"
    return drawing(states_picture(name, *states_within(local, graph), merged=merged))


def machine_drawing(machine: SectionMachine, name: str) -> Drawing:
    """The picture of a machine with its actions."""
    passages = [DrawnEvent(m.source, m.target, machine.events[m.event], m.actions) for m in machine.moves]
    start = Event(What.START, "")
    passages += [DrawnEvent(None, e.target, start, e.actions) for e in machine.entries if e]
    picture = states_picture(name, machine.states, passages, actions=True)
    if len(picture.nodes) > MOST_MODES:
        picture = states_picture(name, machine.states, passages, actions=True, by_objectives=True)
    return drawing(picture)


def controller_drawing(controller: TableController) -> Drawing:
    """The picture of a controller: its sections with the sizes of their machines, and the routes."""
    name = f"Controller of the mission {controller.mission}"
    if len(controller.sections) == 1:
        return machine_drawing(controller.types[0], name)
    nodes = [Node("", ("start",), "node")]
    for section in controller.sections:
        machine = controller.types[section.type]
        sizes = f"{len(machine.states)} states, {len(machine.moves)} edges"
        nodes.append(Node(section.name, (section.name, sizes), "node", f"machine {section.type}: {sizes}"))
    edges = [Arrow("", controller.initial, "success", title="the mission starts")]
    for section in controller.sections:
        for outcome, route in section.routes.items():
            kind = outcome if outcome in ("success", "failure") else "event"
            lines = () if kind == outcome else (outcome,)
            edges.append(Arrow(section.name, route, kind, lines, f"{section.name}: {outcome}"))
    reached = {edge.target for edge in edges}
    nodes += [Node(key, (word,), f"node {word}") for key, word in ENDS.items() if key in reached]
    return drawing(Graph(name, nodes, edges))


def alternatives_drawing(mission_net: MissionNet, graph: AlternativesGraph) -> Drawing:
    """The picture of an alternatives graph: what runs, by section; of a long mission its sections alone."""
    states, passages = states_within(mission_net, graph)
    name = f"Alternatives graph of the mission {mission_net.mission.name}: {graph.states:,} states"
    section_of = sections_of(mission_net.graph)
    if len({_runs(state) for state in states}) <= MOST_WHOLE:
        return drawing(states_picture(f"{name}, by what runs", states, passages, section_of))
    counts: dict[str, int] = {}
    for state in states:
        for section in dict.fromkeys(section_of[o] for o in (*state.objectives, *state.pending, *state.done)):
            counts[section] = counts.get(section, 0) + 1
    notes = {section: f"{count:,} states" for section, count in counts.items()}
    return drawing(objectives_picture(mission_net.graph, f"{name}, by section", notes))


def graph_drawing(graph: AlternativesGraph) -> Drawing:
    """The picture of an alternatives graph of a net alone: its states are numbers."""
    nodes = [Node(f"s{n}", (str(n),), "node", f"state {n}") for n in range(graph.states)]
    labels: dict[tuple[int, int], list[str]] = {}
    for edge in range(graph.edges):
        ends = int(graph.sources[edge]), int(graph.targets[edge])
        labels.setdefault(ends, []).append(str(graph.event(edge)))
    edges = [
        Arrow(f"s{source}", f"s{target}", "arc", tuple(events[:MOST_LINES]), ", ".join(events))
        for (source, target), events in labels.items()
    ]
    return drawing(Graph(f"Alternatives graph of {graph.net.name}", nodes, edges))


def sections_of(graph: ObjectivesGraph) -> dict[str, str]:
    """By objective and by branch, at any depth, the section of the mission that it stands in."""
    return {name: section.name for section in graph.sections for name in names_in(section)}


def states_within(
    mission_net: MissionNet, graph: AlternativesGraph
) -> tuple[list[Situation], list[DrawnEvent]]:
    """States between start and end, and what leads to them, between them and out of them."""
    markings = [graph.marking(state) for state in range(graph.states)]
    said = [situation(mission_net, marking) for marking in markings]
    exits: dict[int, str] = {}
    for number, marking in enumerate(markings):
        for name, place in mission_net.exits.items():
            if marking[place]:
                exits[number] = name
    waiting = {n for n, marking in enumerate(markings) if marking[mission_net.beginning]}
    numbers = [n for n in range(graph.states) if n not in waiting and n not in exits]
    new = {old: number for number, old in enumerate(numbers)}
    passages = []
    for edge in range(graph.edges):
        source, target = int(graph.sources[edge]), int(graph.targets[edge])
        if source in exits or target in waiting:
            continue
        end: int | str = exits[target] if target in exits else new[target]
        passages.append(DrawnEvent(new.get(source), end, graph.event(edge)))
    return [said[n] for n in numbers], passages


def _runs(state: Situation) -> Hashable:
    """What runs in a state, whatever hardware is out of service."""
    pairs = (tuple(sorted(chosen.items())) for chosen in (state.mode, state.waiting))
    return state.objectives, state.pending, state.done, *pairs, state.refused


def _under_way(state: Situation) -> Hashable:
    """Which objectives run in a state, are about to and have ended, in whatever mode."""
    return state.objectives, state.pending, state.done


def states_picture(
    name: str,
    states: Sequence[Situation],
    passages: Sequence[DrawnEvent],
    section_of: Mapping[str, str] | None = None,
    *,
    actions: bool = False,
    merged: bool = False,
    by_objectives: bool = False,
) -> Graph:
    """States as boxes, events as curves.

    Args:
        name: What the picture shows.
        states: By number.
        passages: Events.
        section_of: By objective its section, where each section has a frame of its own.
        actions: Whether to write what the controller does beside each event.
        merged: Whether states that run the same are one box, however few they are.
        by_objectives: Whether states in which the same objectives run are one box, whatever their modes.
    """
    merged = merged or by_objectives or section_of is not None or len(states) > MOST_STATES
    same = _under_way if by_objectives else _runs
    groups: dict[Hashable, list[int]] = {}
    for number, state in enumerate(states):
        groups.setdefault(same(state) if merged else number, []).append(number)
    key_of = {number: f"s{key}" for key, members in enumerate(groups.values()) for number in members}
    if merged and section_of is None:
        alike = "in which the same objectives run" if by_objectives else "that run the same"
        name += f": {len(states):,} states, those {alike} as one"
    if actions and len(passages) > MOST_ORDERED:
        name += ": what it orders is in the titles of the curves"
    nodes, clusters = [Node("enter", ("start",), "node")], dict[str, Cluster]()
    for members in groups.values():
        state = states[members[0]]
        cluster = None
        if section_of is not None:
            section = next((section_of[o] for o in (*state.objectives, *state.pending)), "")
            cluster = clusters.setdefault(section, Cluster(f"c{len(clusters)}", section)).key
        if by_objectives:
            modes = {_runs(states[member]) for member in members}
            state = replace(state, mode={}, waiting={}, refused=())
            lines = (*_lines(state, merged=True, count=1), f"{len(modes)} modes, {len(members)} states")
        else:
            lines = tuple(_lines(state, merged=merged, count=len(members)))
        nodes.append(Node(key_of[members[0]], lines, "node", _title(state, merged=merged), cluster))
    outcomes = dict.fromkeys(p.target for p in passages if isinstance(p.target, str))
    nodes += [
        Node(f"end {end}", (end,), f"node {end}" if end in ("success", "failure", "abort") else "node")
        for end in outcomes
    ]
    return Graph(name, nodes, list(_edges(passages, key_of, actions)), list(clusters.values()))


def _edges(passages: Sequence[DrawnEvent], key_of: Mapping[int, str], actions: bool) -> Iterator[Arrow]:
    """One curve for all events of a kind between two boxes; hardware's failure and return as one."""
    found: dict[tuple[str, str, str], dict[Event, str]] = {}
    for p in passages:
        source = "enter" if p.source is None else key_of[p.source]
        target = f"end {p.target}" if isinstance(p.target, str) else key_of[p.target]
        if source != target:
            said = "; ".join(_order(action) for action in p.actions) if actions else ""
            found.setdefault((source, target, _KINDS.get(p.event.what, "arc")), {}).setdefault(p.event, said)
    for (source, target, kind), events in found.items():
        both = False
        if kind == "arc" and not actions:
            there = {_undone(event) for event in events}
            what = {event.what for event in events}
            both = len(what) == 1 and there == found.get((target, source, kind), {}).keys()
            if both and what == {What.REPAIRED}:
                continue  # drawn with the failures
        told, written = [], []
        for event, said in events.items():
            words = "" if event.what is What.START else _happens(event) + (" ⇄ works again" if both else "")
            told.append("\n".join(filter(None, (words, said))))
            written.append(told[-1] if len(passages) <= MOST_ORDERED else words)
        told, written = ([*dict.fromkeys(filter(None, texts))] for texts in (told, written))
        lines = [line for text in written[:MOST_LINES] for line in text.split("\n")]
        if len(written) > MOST_LINES:
            lines.append(f"and {len(written) - MOST_LINES} more")
        yield Arrow(source, target, kind, tuple(lines), "; ".join(t.replace("\n", ": ") for t in told), both)


_KINDS = {
    What.SUCCESS: "success",
    What.FAILURE: "failure",
    What.TIMEOUT: "failure",
    What.DECLARED: "event",
}


def _undone(event: Event) -> Event | None:
    """The event that undoes a failure of hardware (its repair), and the other way round."""
    other = {What.OUT_OF_SERVICE: What.REPAIRED, What.REPAIRED: What.OUT_OF_SERVICE}.get(event.what)
    return None if other is None else Event(other, event.element)


def _happens(event: Event) -> str:
    """An event in as few words as are clear beside a curve."""
    if event.what is What.SUCCESS:
        return f"{_last(event.element)} succeeds"
    if event.what is What.FAILURE:
        return f"{_last(event.element)} fails{f' for {event.reason}' * bool(event.reason)}"
    if event.what is What.TIMEOUT:
        return f"the time of {_last(event.element)} is over"
    return what_happens(event, "")


def _last(name: str) -> str:
    return name.rsplit(".", 1)[-1]


def _order(action: PlannedAction) -> str:
    what = action.activity or action.hardware or action.objective or ""
    if action.verb == "select" and action.alternative not in (None, action.activity):
        return f"select {what}: {action.alternative}"
    return f"{action.verb} {what}"


def _lines(state: Situation, *, merged: bool, count: int) -> Iterator[str]:
    """What a box says."""
    yield ", ".join(_last(name) for name in state.objectives) or "about to begin"
    for name in state.pending:
        yield f"next: {_last(name)}"
    for activity, way in state.mode.items():
        if activity != way:
            yield f"{activity}: {way}"
    for activity in state.waiting:
        yield f"waits: {activity}"
    for activity in state.refused:
        yield f"no way: {activity}"
    if not merged:
        for name in state.out_of_service:
            yield f"{name} out"
    elif count > 1:
        yield f"{count} states"


def _title(state: Situation, *, merged: bool) -> str:
    mode = ", ".join(f"{a}: {way}" if a != way else a for a, way in state.mode.items())
    told = [f"objectives {', '.join(state.objectives) or 'none'}", f"runs {mode or 'nothing'}"]
    if state.out_of_service and not merged:
        told.append(f"out of service {', '.join(state.out_of_service)}")
    return "; ".join(told)
