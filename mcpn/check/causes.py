"""Failure causes of a mission, all together: what a report shows and the command line prints.

Which hardware must be lost for the mission and each objective to fail, when; which events decide it, in which
functioning mode; the shortest runs that show it; how much the mission survives from each section on.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from mcpn.check.cutsets import CutSet, Losses, Moment, Nonmonotone
from mcpn.check.losing import CriticalEvent, Goal, Outlook
from mcpn.check.runs import Step, run_in_words
from mcpn.check.scenarios import Run, Scenarios
from mcpn.errors import InputError
from mcpn.net.compose import MissionNet
from mcpn.space.alternatives import AlternativesGraph


@dataclass(frozen=True)
class GoalCauses:
    """Why one goal fails.

    Args:
        name: Of the mission or the objective.
        cut_sets: Minimal cut sets: of the mission at its start, of an objective at its entry.
        moments: Minimal cut sets by moment, see :class:`mcpn.check.cutsets.Moment`.
        critical: Events that cross into the losing region where nothing is repaired.
        critical_with_repairs: The same where hardware may be repaired.
        runs: For each of the cut sets a shortest run to failure, where there is one.
        nonmonotone: A pair of sets for which more failures are better, where there is one.
    """

    name: str
    cut_sets: list[CutSet]
    moments: dict[str, list[CutSet]]
    critical: list[CriticalEvent]
    critical_with_repairs: list[CriticalEvent]
    runs: dict[CutSet, tuple[Step, ...] | None]
    nonmonotone: Nonmonotone | None

    @property
    def critical_events(self) -> list[str]:
        """Names of the events after which only a repair helps, or nothing."""
        return sorted({critical.event for critical in self.critical})


@dataclass(frozen=True)
class Survival:
    """What the mission survives from one moment on.

    Args:
        section: The section just entered; ``None`` for the start.
        cut_sets: Minimal cut sets of the mission at that moment.
        always: So many failures are survived whichever they are; ``None`` where success is out of reach.
        at_most: The most failures of one run to success; ``None`` where there is none.
        run: Such a run, from the start of the mission.
    """

    section: str | None
    cut_sets: list[CutSet]
    always: int | None
    at_most: int | None
    run: tuple[Step, ...] | None


@dataclass(frozen=True)
class Causes:
    """Failure causes of a mission.

    Args:
        mission_net: The mission's net.
        outlook: Its chances on the alternatives graph.
        mission: Why the mission fails.
        objectives: Why each elementary objective fails, by its name.
        survival: What the mission survives from its start and from the entry of each section.
    """

    mission_net: MissionNet
    outlook: Outlook
    mission: GoalCauses
    objectives: Mapping[str, GoalCauses]
    survival: list[Survival]


def find_causes(
    mission_net: MissionNet, graph: AlternativesGraph, objectives: Iterable[str] | None = None
) -> Causes:
    """The failure causes of a mission.

    Args:
        mission_net: The mission's net.
        graph: Its alternatives graph.
        objectives: Elementary objectives to look at, all by default.

    Returns:
        Everything but the tables and numbers that :mod:`mcpn.check.fmeca` and :mod:`mcpn.check.risk` give.

    Raises:
        InputError: The mission has no such objective.
        LimitError: More hardware resources or minimal cut sets than the limits allow.
    """
    outlook = Outlook(mission_net, graph)
    losses = Losses(outlook)
    scenarios = Scenarios(losses)
    names = list(outlook.objectives) if objectives is None else list(objectives)
    for name in names:
        if name not in outlook.objectives:
            known = ", ".join(outlook.objectives)
            raise InputError.at(mission_net.mission.source, f"no objective {name}; expected one of {known}")

    def told(run: Run | None) -> tuple[Step, ...] | None:
        return None if run is None else tuple(run_in_words(mission_net, graph, run))

    def causes(goal: Goal) -> GoalCauses:
        moments = {
            moment.value: losses.listed(losses.cut_sets(goal, moment, goal.name))
            for moment in Moment
            if goal.kind == "objective" or moment is not Moment.ENTRY
        }
        cut_sets = moments[(Moment.ENTRY if goal.kind == "objective" else Moment.START).value]
        return GoalCauses(
            goal.name,
            cut_sets,
            moments,
            outlook.critical(goal, repairs=False),
            outlook.critical(goal, repairs=True),
            {names: told(scenarios.to_failure(goal, names)) for names in cut_sets},
            losses.nonmonotone(goal),
        )

    def survival(section: str | None) -> Survival:
        robust = scenarios.robustness(section)
        moment = Moment.START if section is None else Moment.ENTRY
        cut_sets = losses.listed(losses.cut_sets(outlook.mission, moment, section))
        return Survival(section, cut_sets, robust.always, robust.at_most, told(robust.run))

    sections = [section.name for section in mission_net.graph.sections]
    return Causes(
        mission_net,
        outlook,
        causes(outlook.mission),
        {name: causes(outlook.objectives[name]) for name in names},
        [survival(section) for section in (None, *sections)],
    )
