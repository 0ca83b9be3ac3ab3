"""The verdicts of a mission, each with the run that shows it, by any engine.

Required verdicts are those that a mission must satisfy to be flown; informative ones tell more. A verdict is
``None`` where an earlier one failed in a way that leaves it unknown. Only how a space is made, and with which
errors, depends on the engine; every question is asked once, of :class:`mcpn.space.algebra.Space`.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

from mcpn.check.choice import Asked, Choice, answered
from mcpn.check.modes import Mode
from mcpn.check.spaces import Engine, alternatives_by, markings_by
from mcpn.check.verdicts.modes import functioning_modes
from mcpn.check.verdicts.unselectable import find_unselectable
from mcpn.errors import ConfluenceError, DivergenceError, Problem, SemanticsError, UnsafeError
from mcpn.mission.flatten import ObjectivesGraph
from mcpn.mission.model import SUCCEED
from mcpn.net.compose import MissionNet
from mcpn.net.templates import TemplateSet
from mcpn.notebook import Told
from mcpn.space.algebra import S, Space
from mcpn.space.markings.explicit import DEFAULT_MAX_STATES, Progress
from mcpn.space.run import Run, run_of_fewest_events, transitions_of
from mcpn.space.stable.clash import explained
from mcpn.space.stable.nearest import nearest_fault
from mcpn.steps import step

REQUIRED = ("safe", "bounded", "confluent", "deadlock_free", "success_reachable", "can_always_finish")
INFORMATIVE = ("failure_reachable", "unselectable")

UNDECIDED_UNSAFE = "not decided: the net is not 1-safe, so that its states cannot be explored"
UNDECIDED_LOCAL = (
    "not decided: the mission is not confluent, so that composition has no one state to go on from; "
    "--engine explicit or symbolic decides it"
)


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
    runs: tuple[Run, ...] = ()

    @property
    def runs_of_events(self) -> tuple[Run, ...]:
        """The runs as a designer reads them: without internal firings, each once."""
        return tuple(dict.fromkeys(run.of_events for run in self.runs))

    @property
    def required(self) -> bool:
        """Whether a mission must satisfy it."""
        return self.name in REQUIRED


@dataclass(frozen=True)
class MissionCheck(Told):
    """All that one check of a mission found.

    Args:
        mission_net: The mission's net.
        verdicts: By name, required ones first.
        markings: The markings graph, where the engine makes it.
        alternatives: The alternatives graph, where it exists.
        stable_sizes: Stable states and event edges of the whole mission, exact; ``None`` where not known.
        modes: Functioning modes by objective.
        unselectable: What can never be selected, entered or used, with its line.
        choice: The engine that answered.
    """

    mission_net: MissionNet
    verdicts: dict[str, Verdict]
    markings: Space[Any] | None = None
    alternatives: Space[Any] | None = None
    stable_sizes: tuple[int, int] | None = None
    modes: dict[str, list[Mode]] = field(default_factory=dict)
    unselectable: tuple[Problem, ...] = ()
    choice: Choice = field(default_factory=lambda: Choice("explicit"))

    def __repr__(self) -> str:
        verdicts = ", ".join(f"{name}: {verdict.holds}" for name, verdict in self.verdicts.items())
        return f"<check of the mission {self.mission_net.mission.name}: {verdicts}>"

    @cached_property
    def marking_sizes(self) -> tuple[int, int] | None:
        """Reachable markings and firings between them, exact; ``None`` where they were not counted."""
        if self.markings is None:
            return None
        firings = self.markings.firings(self.markings.everything)
        return self.markings.everything.count(), sum(firings.values())

    @property
    def failing(self) -> list[str]:
        """Required verdicts that do not hold."""
        return [name for name in REQUIRED if self.verdicts[name].holds is False]

    @property
    def undecided(self) -> dict[str, str]:
        """By verdict that is not known, the reason."""
        return {name: v.explanation for name, v in self.verdicts.items() if v.holds is None}

    @property
    def passed(self) -> bool:
        """Whether every required verdict holds."""
        return all(self.verdicts[name].holds for name in REQUIRED)


def check(
    mission_net: MissionNet,
    *,
    engine: Asked = "auto",
    max_states: int | None = None,
    progress: Progress | None = None,
    executor: Executor | None = None,
    templates: TemplateSet | None = None,
) -> MissionCheck:
    """Checks a mission.

    Args:
        mission_net: The mission's net.
        engine: Arrays, diagrams, composition, which does not explore the net of the whole, or ``auto``, see
            :mod:`mcpn.check.choice`.
        max_states: Limit on states that are listed one by one.
        progress: Called now and then with states and edges, or with local spaces done and to do.
        executor: Where composition explores sections; this process by default.
        templates: Those that the mission was composed with, for composition; the paper's by default.

    Returns:
        Every verdict, with its runs.

    Raises:
        PremiseError: Composition cannot answer, since a section hands on more than the state of its hardware.
        LimitError: A limit was hit.
    """

    def by(choice: Choice) -> MissionCheck:
        return _checked(mission_net, choice, None if choice.brief else progress, executor, templates)

    found, choice = answered(by, mission_net, engine=engine, on="alternatives", max_states=max_states)
    return replace(found, choice=choice)


def _checked(
    mission_net: MissionNet,
    choice: Choice,
    progress: Progress | None,
    executor: Executor | None,
    templates: TemplateSet | None,
) -> MissionCheck:
    """Every verdict, by one engine."""
    engine, max_states = choice.engine, choice.max_states
    verdicts = {name: Verdict(name, None) for name in (*REQUIRED, *INFORMATIVE)}
    limit = DEFAULT_MAX_STATES if max_states is None else max_states
    markings: Space[Any] | None = None
    alternatives: Space[Any] | None = None
    try:
        if engine == "local":
            from mcpn.space.local.composing import Options, composite_space

            options = Options(templates, executor, progress)
            alternatives = composite_space(mission_net, options)
            proof = "each type of section, and each way from one to the next, proved on its own net"
        else:
            graph = markings_by(mission_net.net, engine, limit, progress, tokens=False)
            markings = graph
            alternatives, proof = alternatives_by(graph, limit)
        verdicts["confluent"] = Verdict("confluent", True, proof)
    except UnsafeError as error:
        verdicts["safe"] = Verdict("safe", False, str(error), _runs_of(mission_net, error))
        return MissionCheck(mission_net, _undecided(verdicts, UNDECIDED_UNSAFE))
    except (ConfluenceError, DivergenceError) as error:
        verdicts["confluent"] = _not_confluent(mission_net, error, engine)
    space = alternatives or markings
    if space is None:
        return MissionCheck(mission_net, _undecided(verdicts, UNDECIDED_LOCAL))
    verdicts["safe"] = Verdict("safe", True, "no firing puts a second token in a place")
    verdicts["bounded"] = Verdict("bounded", True, "a 1-safe net is bounded")
    for verdict in _reachability(mission_net, space, settles=alternatives is not None):
        verdicts[verdict.name] = verdict
    step("counting what happens, and looking for what is never used")
    firings = space.firings(space.everything)
    unselectable = find_unselectable(mission_net, space, firings)
    text = f"{len(unselectable)} found" if unselectable else "nothing found"
    verdicts["unselectable"] = Verdict("unselectable", bool(unselectable), text)
    step("finding the functioning modes")
    modes = functioning_modes(mission_net, space)
    sizes = None if alternatives is None else (space.everything.count(), sum(firings.values()))
    return MissionCheck(mission_net, verdicts, markings, alternatives, sizes, modes, unselectable)


def _undecided(verdicts: dict[str, Verdict], reason: str) -> dict[str, Verdict]:
    """The verdicts, of which those that are not known say why."""
    return {n: Verdict(n, None, reason) if v.holds is None else v for n, v in verdicts.items()}


def _not_confluent(mission_net: MissionNet, error: SemanticsError, engine: Engine) -> Verdict:
    """The verdict on an event that has not one stable end; for arrays a nearer one is looked for."""
    if engine == "explicit":
        error = nearest_fault(mission_net.net) or error
    step("explaining an event with two outcomes")
    if isinstance(error, ConfluenceError):
        error = explained(mission_net, error)
    return Verdict("confluent", False, str(error), _runs_of(mission_net, error))


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


def _reachability(mission_net: MissionNet, space: Space[S], *, settles: bool) -> list[Verdict]:
    """Verdicts that a run to some states decides."""
    success, failure = space.marked([mission_net.success]), space.marked([mission_net.failure])
    finished = success | failure
    step("looking for states from which the mission cannot end")
    goals = {
        "deadlock_free": space.dead - finished,
        "success_reachable": success,
        "can_always_finish": space.everything - space.reaching(finished),
        "failure_reachable": failure,
    }
    found = []
    for name, goal in goals.items():
        step(f"looking for a run that decides {name}")
        good, there_is, there_is_none = _REACHED[name]
        run = None
        if goal:
            run = space.run(space.initial.pick(), goal) if settles else run_of_fewest_events(space, goal)
        if run is None:
            if name == "success_reachable":
                there_is_none += _no_way_to_success(mission_net.graph)
            found.append(Verdict(name, not good, there_is_none))
        else:
            shown = Run(space.net, transitions_of(run), settles=settles)
            found.append(Verdict(name, good, there_is, (shown,)))
    return found


def _no_way_to_success(graph: ObjectivesGraph) -> str:
    """Why no run succeeds, where the text alone says so."""
    routes = {r for s in graph.sections for r in (s.success, s.failure, *(i.target for i in s.interruptions))}
    if SUCCEED in routes:
        return ""
    return (
        ': no route of the mission leads to succeed; a block after which all is done says success="succeed", '
        "by default success leads to the next block"
    )


def _runs_of(mission_net: MissionNet, error: SemanticsError) -> tuple[Run, ...]:
    """The runs of an error, internal firings after the last event included."""
    index = mission_net.net.transition_index
    return tuple(_run_of(mission_net, run) for run in error.runs if all(name in index for name in run))


def _run_of(mission_net: MissionNet, names: Sequence[str]) -> Run:
    net = mission_net.net
    return Run(net, tuple(net.transition_index[name] for name in names), detailed=True)
