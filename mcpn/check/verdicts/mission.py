"""The verdicts of a mission, each with the run that shows it, by any engine.

Required verdicts are those that a mission must satisfy to be flown; informative ones tell more. A verdict is
``None`` where an earlier one failed in a way that leaves it unknown. Only how a space is made, and with which
errors, depends on the engine; every question is asked once, of :class:`mcpn.space.algebra.Space`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from mcpn.check.modes import Mode, functioning_modes
from mcpn.check.spaces import Asked, Choice, Engine, alternatives_by, answered, markings_by
from mcpn.check.verdicts.unselectable import find_unselectable
from mcpn.errors import ConfluenceError, DivergenceError, Problem, SemanticsError, UnsafeError
from mcpn.mission.flatten import ObjectivesGraph
from mcpn.mission.model import SUCCEED
from mcpn.net.compose import MissionNet
from mcpn.net.templates import TemplateSet
from mcpn.notebook import Told
from mcpn.space.algebra import S, Space
from mcpn.space.markings.explicit import Progress
from mcpn.space.run import Run, run_of_fewest_events, transitions_of
from mcpn.space.stable.clash import explained
from mcpn.space.stable.nearest import nearest_fault
from mcpn.steps import step

if TYPE_CHECKING:
    from concurrent.futures import Executor

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
            :mod:`mcpn.check.spaces`.
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
    markings: Space[Any] | None = None
    alternatives: Space[Any] | None = None
    try:
        if choice.engine == "local":
            from mcpn.space.local.composing import composite_space

            alternatives = composite_space(
                mission_net, templates=templates, executor=executor, progress=progress
            )
            proof = "each type of section, and each way from one to the next, proved on its own net"
        else:
            graph = markings_by(mission_net.net, choice, progress, tokens=False)
            markings = graph
            alternatives, proof = alternatives_by(graph, choice.limit)
        confluent = Verdict("confluent", True, proof)
    except UnsafeError as error:
        unsafe = Verdict("safe", False, str(error), _runs_of(mission_net, error))
        return MissionCheck(mission_net, _every([unsafe], UNDECIDED_UNSAFE))
    except (ConfluenceError, DivergenceError) as error:
        confluent = _not_confluent(mission_net, error, choice.engine)
    space = alternatives or markings
    if space is None:
        return MissionCheck(mission_net, _every([confluent], UNDECIDED_LOCAL))
    safe = Verdict("safe", True, "no firing puts a second token in a place")
    bounded = Verdict("bounded", True, "a 1-safe net is bounded")
    reachability = _reachability(mission_net, space, settles=alternatives is not None)
    step("counting what happens, and looking for what is never used")
    firings = space.firings(space.everything)
    never = find_unselectable(mission_net, space, firings)
    unselectable = Verdict("unselectable", bool(never), f"{len(never)} found" if never else "nothing found")
    step("finding the functioning modes")
    return MissionCheck(
        mission_net,
        _every([safe, bounded, confluent, *reachability, unselectable]),
        markings,
        alternatives,
        None if alternatives is None else (space.everything.count(), sum(firings.values())),
        functioning_modes(mission_net, space),
        never,
    )


def _every(found: Sequence[Verdict], reason: str = "") -> dict[str, Verdict]:
    """By name every verdict; those that were not found are not known, for a reason."""
    known = {verdict.name: verdict for verdict in found}
    return {name: known.get(name, Verdict(name, None, reason)) for name in (*REQUIRED, *INFORMATIVE)}


def _not_confluent(mission_net: MissionNet, error: SemanticsError, engine: Engine) -> Verdict:
    """The verdict on an event that has not one stable end; for arrays a nearer one is looked for."""
    if engine == "explicit":
        error = nearest_fault(mission_net.net) or error
    step("explaining an event with two outcomes")
    if isinstance(error, ConfluenceError):
        error = explained(mission_net, error)
    return Verdict("confluent", False, str(error), _runs_of(mission_net, error))


def _reachability(mission_net: MissionNet, space: Space[S], *, settles: bool) -> Iterator[Verdict]:
    """Verdicts that a run to some states decides."""
    success, failure = space.marked([mission_net.success]), space.marked([mission_net.failure])
    finished = success | failure
    step("looking for states from which the mission cannot end")
    for name, goal, good, there_is, there_is_none in (
        (
            "deadlock_free",
            space.dead - finished,
            False,
            "a marking that is no end of the mission allows no event",
            "every marking but the mission's ends allows some event",
        ),
        (
            "success_reachable",
            success,
            True,
            "a run leads to success",
            f"no run leads to mission success{'' if success else _no_way_to_success(mission_net.graph)}",
        ),
        (
            "can_always_finish",
            space.everything - space.reaching(finished),
            False,
            "after this run the mission can no longer end",
            "from every marking some run leads to an end of the mission",
        ),
        ("failure_reachable", failure, True, "a run leads to failure", "no run leads to mission failure"),
    ):
        step(f"looking for a run that decides {name}")
        run = None
        if goal:
            run = space.run(space.initial.pick(), goal) if settles else run_of_fewest_events(space, goal)
        if run is None:
            yield Verdict(name, not good, there_is_none)
        else:
            yield Verdict(name, good, there_is, (Run(space.net, transitions_of(run), settles=settles),))


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
    net, index = mission_net.net, mission_net.net.transition_index
    runs = (names for names in error.runs if all(name in index for name in names))
    return tuple(Run(net, tuple(index[name] for name in names), detailed=True) for names in runs)
