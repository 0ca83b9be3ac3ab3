"""The verdicts of a mission, each with the run that shows it.

Required verdicts are those a mission must satisfy to be flown; informative ones tell more. A verdict is
``None`` where an earlier one failed in a way that leaves it unknown.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from mcpn.check.modes import Mode, functioning_modes
from mcpn.check.runs import Step, replay, run_in_words
from mcpn.errors import ConfluenceError, DivergenceError, McpnError, Problem, SemanticsError, UnsafeError
from mcpn.mission.usage import Usage
from mcpn.mission.warnings import never_entered
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event, What
from mcpn.space.alternatives import AlternativesGraph, by_reduction
from mcpn.space.explicit import Progress, explore
from mcpn.space.graph import Mask, StateGraph
from mcpn.space.local.composite import Composite
from mcpn.space.symbolic import SymbolicSpace

REQUIRED = ("safe", "bounded", "confluent", "deadlock_free", "success_reachable", "can_always_finish")
INFORMATIVE = ("failure_reachable", "unselectable")


@dataclass(frozen=True)
class Verdict:
    """One verdict.

    Args:
        name: One of :data:`REQUIRED` or :data:`INFORMATIVE`.
        holds: The answer, or ``None`` where it is not known.
        explanation: One sentence on what was found.
        runs: Witness or counterexample runs, the shortest first; two where two are needed.
    """

    name: str
    holds: bool | None
    explanation: str = ""
    runs: tuple[tuple[Step, ...], ...] = ()

    @property
    def required(self) -> bool:
        """Whether a mission must satisfy it."""
        return self.name in REQUIRED


@dataclass(frozen=True)
class MissionCheck:
    """All that one check of a mission found.

    Args:
        mission_net: The mission's net.
        verdicts: By name, required ones first.
        markings: The markings graph, where it was built.
        alternatives: The alternatives graph, where it exists.
        modes: Functioning modes by objective.
        unselectable: What can never be selected, entered or used, with its line.
        composite: The local graphs glued, where they were built instead.
        space: The reachable markings as a diagram, where they were built instead.
    """

    mission_net: MissionNet
    verdicts: dict[str, Verdict]
    markings: StateGraph | None = None
    alternatives: AlternativesGraph | None = None
    modes: dict[str, list[Mode]] = field(default_factory=dict)
    unselectable: tuple[Problem, ...] = ()
    composite: Composite | None = None
    space: SymbolicSpace | None = None

    @property
    def stable_sizes(self) -> tuple[int, int] | None:
        """Stable states and event edges of the whole mission, exact; ``None`` where they are not known."""
        if self.space is not None and self.space.stable is not None and self.verdicts["confluent"].holds:
            # Every event leads from a stable marking to one stable marking.
            fired, transitions = self.space.fired, self.mission_net.net.transitions
            return self.space.stable.count(), sum(n for t, n in fired.items() if not transitions[t].internal)
        graph = self.composite or self.alternatives
        return None if graph is None else (graph.states, graph.edges)

    @property
    def marking_sizes(self) -> tuple[int, int] | None:
        """Reachable markings and firings between them, exact; ``None`` where they were not counted."""
        graph = self.space or self.markings
        return None if graph is None else (graph.states, graph.edges)

    @property
    def passed(self) -> bool:
        """Whether every required verdict holds."""
        return all(self.verdicts[name].holds for name in REQUIRED)


def check_mission(
    mission_net: MissionNet, *, max_states: int | None = None, progress: Progress | None = None
) -> MissionCheck:
    """Checks a mission on its explicit markings graph.

    Args:
        mission_net: The mission's net.
        max_states: Limit on the markings; the explorer's own by default.
        progress: Called now and then with states and edges.

    Returns:
        Every verdict, with its runs.

    Raises:
        LimitError: A limit was hit.
    """
    verdicts = {name: Verdict(name, None, "not known") for name in (*REQUIRED, *INFORMATIVE)}

    def note(name: str, holds: bool | None, explanation: str, runs: Sequence[Sequence[Step]] = ()) -> None:
        verdicts[name] = Verdict(name, holds, explanation, tuple(tuple(run) for run in runs))

    limits = {} if max_states is None else {"max_states": max_states}
    try:
        markings = explore(mission_net.net, progress=progress, **limits)
    except UnsafeError as error:
        note("safe", False, str(error), told(mission_net, error))
        return MissionCheck(mission_net, verdicts)
    note("safe", True, "no firing puts a second token in a place")
    note("bounded", True, "a 1-safe net is bounded")
    alternatives: AlternativesGraph | None = None
    try:
        alternatives = by_reduction(markings)
        note("confluent", True, alternatives.proof or "")
    except (ConfluenceError, DivergenceError) as error:
        note("confluent", False, explain_error(mission_net, error), told(mission_net, error))
    graph: StateGraph = markings if alternatives is None else alternatives
    for verdict in _reachability(mission_net, graph):
        verdicts[verdict.name] = verdict
    unselectable = find_unselectable(mission_net.usage, _happened(mission_net, graph))
    note(
        "unselectable", bool(unselectable), f"{len(unselectable)} found" if unselectable else "nothing found"
    )
    modes = dict(functioning_modes(mission_net, graph))
    return MissionCheck(mission_net, verdicts, markings, alternatives, modes, unselectable)


class _Reached(NamedTuple):
    """What a run to some states, or that there is none, says."""

    good: bool
    found: str
    none: str


_REACHED = {
    "deadlock_free": _Reached(
        False,
        "a marking that is no end of the mission allows no event",
        "every marking but the mission's ends allows some event",
    ),
    "success_reachable": _Reached(True, "a run leads to success", "no run leads to mission success"),
    "can_always_finish": _Reached(
        False,
        "after this run the mission can no longer end",
        "from every marking some run leads to an end of the mission",
    ),
    "failure_reachable": _Reached(True, "a run leads to failure", "no run leads to mission failure"),
}


def verdict_of(name: str, run: Sequence[Step] | None) -> Verdict:
    """The verdict that a run to what it asks for decides, whichever engine looked for one.

    Args:
        name: ``deadlock_free`` (a run to a dead marking that is no end), ``success_reachable``,
            ``can_always_finish`` (to where no end is reached any more) or ``failure_reachable``.
        run: The run, or ``None`` where there is none.
    """
    good, found, none = _REACHED[name]
    return Verdict(name, not good, none) if run is None else Verdict(name, good, found, (tuple(run),))


def _reachability(mission_net: MissionNet, graph: StateGraph) -> list[Verdict]:
    """Verdicts that the same definitions give on the markings graph and on the alternatives graph."""
    success, failure = graph.marked(mission_net.success), graph.marked(mission_net.failure)
    finished = success | failure
    goals: dict[str, Mask] = {
        "deadlock_free": graph.dead & ~finished,
        "success_reachable": success,
        "can_always_finish": ~graph.reaching(finished),
        "failure_reachable": failure,
    }
    runs = {name: graph.run_to(goal) for name, goal in goals.items()}
    return [
        verdict_of(name, None if run is None else run_in_words(mission_net, graph, run))
        for name, run in runs.items()
    ]


@dataclass(frozen=True)
class Happened:
    """What can happen in a mission, whichever engine found it.

    Args:
        selected: Alternatives that are active somewhere, as ``activity.alternative``.
        entered: Objectives that run somewhere.
        events: Events that happen somewhere.
    """

    selected: frozenset[str]
    entered: frozenset[str]
    events: frozenset[Event]


def _happened(mission_net: MissionNet, graph: StateGraph) -> Happened:
    fired = set(np.unique(graph.labels).tolist())
    happened = {t.event for i, t in enumerate(mission_net.net.transitions) if i in fired and t.event}
    selected, entered = (
        {name for place, name in mission_net.saying(kind).items() if graph.marked(place).any()}
        for kind in ("active", "objective")
    )
    return Happened(frozenset(selected), frozenset(entered), frozenset(happened))


def find_unselectable(usage: Usage, happened: Happened) -> tuple[Problem, ...]:
    """Alternatives never selected, objectives never entered or never left, resources never used.

    Args:
        usage: Static facts of the mission.
        happened: What can happen in it.

    Returns:
        Each with its line in the mission, in the order of files and lines.
    """
    found, used = list[Problem](), set[str]()
    for activity in usage.mission.activities:
        if activity.name not in usage.started:
            continue
        for alternative in activity.alternatives:
            name = f"{activity.name}.{alternative.name}"
            if name in happened.selected:
                used.update(alternative.consumes)
            else:
                found.append(Problem(alternative.source, f"alternative {name} can never be selected"))
    for section in usage.graph.walk():
        if section.name not in happened.entered:
            found.append(Problem(section.source, f"objective {section.name} can never be entered"))
            continue
        for what, verb in ((What.SUCCESS, "succeed"), (What.FAILURE, "fail")):
            if Event(what, section.name) not in happened.events:
                found.append(Problem(section.source, f"objective {section.name} can never {verb}"))
    found.extend(map(never_entered, usage.graph.never_entered()))
    for resource in (*usage.mission.hardware, *usage.mission.software):
        if resource.name not in used:
            found.append(Problem(resource.source, f"resource {resource.name} is never used"))
    return tuple(
        sorted(found, key=lambda p: (str(p.source and p.source.file), (p.source and p.source.line) or 0))
    )


def told(mission_net: MissionNet, error: SemanticsError) -> tuple[tuple[Step, ...], ...]:
    """The runs of an error: its events in words, and the internal firings where two runs part."""
    runs = []
    for run in map(list, error.runs):
        last_event = max(
            (i for i, name in enumerate(run) if _event(mission_net, name) is not None), default=-1
        )
        steps = [
            Step(step.event, step.words.split(":")[0]) for step in replay(mission_net, run[: last_event + 1])
        ]
        steps += [Step(name, f"internal: {name}") for name in run[last_event + 1 :]]
        runs.append(tuple(steps))
    return tuple(runs)


def _event(mission_net: MissionNet, name: str) -> Event | None:
    net = mission_net.net
    return net.transitions[net.transition_index[name]].event


def explain_error(mission_net: MissionNet, error: McpnError) -> str:
    """The error, with the contentions that may be its reason."""
    contentions = mission_net.usage.contentions
    if isinstance(error, ConfluenceError) and contentions:
        return f"{error} ({'; '.join(str(contention) for contention in contentions)})"
    return str(error)
