"""Failure causes of a mission, all together: what a report shows and the command line prints.

Which hardware must be lost for the mission and each objective to fail, when; which events decide it, in which
functioning mode; the shortest runs that show it; how much the mission survives from each section on.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from mcpn.check.cutsets import CutSet, Losses, Moment, Nonmonotone
from mcpn.check.families import ALWAYS, Families, Family
from mcpn.check.local_losses import DEFAULT_LOCAL_STATES, LocalLosses
from mcpn.check.losing import CriticalEvent, Goal, Outlook
from mcpn.check.runs import Step, run_in_words
from mcpn.check.scenarios import Run, Scenarios
from mcpn.errors import InputError
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event


@dataclass(frozen=True)
class GoalCauses:
    """Why one goal fails.

    Args:
        name: Of the mission or the objective.
        cut_sets: Minimal cut sets: of the mission at its start, of an objective at its entry.
        moments: Minimal cut sets by moment, see :class:`mcpn.check.cutsets.Moment`.
        critical: Events that cross into the losing region where nothing is repaired; ``None`` for a mission
            by composition in which resources contend, or with a parallel block too large for a local graph.
        critical_with_repairs: The same where hardware may be repaired.
        runs: For each of the cut sets a shortest run to failure, where there is one; empty without the graph
            of the whole mission.
        nonmonotone: A pair of sets for which more failures are better, where there is one.
    """

    name: str
    cut_sets: list[CutSet]
    moments: dict[str, list[CutSet]]
    critical: list[CriticalEvent] | None
    critical_with_repairs: list[CriticalEvent]
    runs: dict[CutSet, tuple[Step, ...] | None]
    nonmonotone: Nonmonotone | None

    @property
    def critical_events(self) -> list[Event] | None:
        """The events after which only a repair helps, or nothing."""
        return None if self.critical is None else sorted({critical.event for critical in self.critical})


@dataclass(frozen=True)
class Survival:
    """What the mission survives from one moment on.

    Args:
        section: The section just entered; ``None`` for the start.
        cut_sets: Minimal cut sets of the mission at that moment.
        always: So many resources may be lost whichever they are; ``None`` where success is out of reach.
        at_most: So many may be lost at most; ``None`` where success is out of reach.
        run: A run through that moment to success with the most failures on the way, where a graph of the
            whole mission tells.
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
        mission: Why the mission fails.
        objectives: Why each elementary objective fails, by its name.
        survival: What the mission survives from its start and from the entry of each section.
    """

    mission_net: MissionNet
    mission: GoalCauses
    objectives: Mapping[str, GoalCauses]
    survival: list[Survival]

    def of(self, objectives: Iterable[str]) -> Causes:
        """The same with some elementary objectives alone.

        Raises:
            InputError: The mission has no such objective.
        """
        chosen = list(objectives)
        for name in chosen:
            if name not in self.objectives:
                expected = f"expected one of {', '.join(self.objectives)}"
                source = self.mission_net.mission.source
                raise InputError.at(source, f"no objective {name}; {expected}")
        return replace(self, objectives={name: self.objectives[name] for name in chosen})


def find_causes(mission_net: MissionNet, outlook: Outlook) -> Causes:
    """The failure causes of a mission on the graph of the whole mission.

    Args:
        mission_net: The mission's net.
        outlook: The mission on its alternatives graph.

    Returns:
        Everything but the tables and numbers that :mod:`mcpn.check.fmeca` and :mod:`mcpn.check.risk` give.

    Raises:
        LimitError: More hardware resources or minimal cut sets than the limits allow.
    """
    losses = Losses(outlook)
    scenarios = Scenarios(losses)

    def told(run: Run | None) -> tuple[Step, ...] | None:
        return None if run is None else tuple(run_in_words(mission_net, outlook.graph, run))

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
        moment = Moment.START if section is None else Moment.ENTRY
        lost = losses.cut_sets(outlook.mission, moment, section)
        return _survival(
            section, lost, losses.families, losses.hardware, told(scenarios.most_failures(section))
        )

    sections = [section.name for section in mission_net.graph.sections]
    return Causes(
        mission_net,
        causes(outlook.mission),
        {name: causes(outlook.objectives[name]) for name in outlook.objectives},
        [survival(section) for section in (None, *sections)],
    )


def find_causes_locally(mission_net: MissionNet, *, max_states: int = DEFAULT_LOCAL_STATES) -> Causes:
    """The failure causes of a mission by composition, where the graph of the whole mission is too large.

    Args:
        mission_net: The mission's net.
        max_states: How many stable states the graph of a section may have.

    Returns:
        Cut sets at every moment (the worst one only where it can be told), critical events, and what is
        survived; no runs.

    Raises:
        LimitError: A section has too many states, or there are too many hardware resources or cut sets.
        ConfluenceError: The outcome of a section depends on the interleaving.
    """
    local = LocalLosses(mission_net.usage, max_states=max_states)

    def listed(family: Family) -> list[CutSet]:
        names = [tuple(sorted(local.hardware[h] for h in m)) for m in local.families.members(family)]
        return sorted(names, key=lambda members: (len(members), members))

    name = mission_net.mission.name
    known = [m for m in Moment if m is not Moment.SOMETIME or local.worst_known]
    moments = {m.value: listed(local.mission_at(m)) for m in known if m is not Moment.ENTRY}
    events = local.critical()
    with_repairs = local.critical_with_repairs()
    mission = GoalCauses(name, moments[Moment.START.value], moments, events, with_repairs, {}, None)
    during = {m.value: local.objective_at(m) for m in known if m is not Moment.START}
    found = {}
    for objective in (section.name for section in mission_net.graph.walk()):
        # An objective that no run enters can never succeed.
        moments = {m: listed(functions.get(objective, ALWAYS)) for m, functions in during.items()}
        critical, repairable = (local.critical_of(objective, repairs) for repairs in (False, True))
        found[objective] = GoalCauses(
            objective, moments[Moment.ENTRY.value], moments, critical, repairable, {}, None
        )
    sections: list[tuple[str | None, Family]] = [(None, local.mission)]
    sections += [(s.name, local.mission_entering(s.name)) for s in local.entered]
    survival = [_survival(s, lost, local.families, local.hardware, None) for s, lost in sections]
    return Causes(mission_net, mission, found, survival)


def _survival(
    section: str | None,
    lost: Family,
    families: Families,
    hardware: Sequence[str],
    run: tuple[Step, ...] | None,
) -> Survival:
    """What the mission survives where a loss function holds."""
    cut_sets = [tuple(sorted(hardware[h] for h in members)) for members in families.members(lost)]
    ordered = sorted(cut_sets, key=lambda names: (len(names), names))
    least, needed = families.least(lost), families.least(families.dual(lost))
    always = None if least == 0 else families.elements if least is None else least - 1
    at_most = None if needed is None else families.elements - needed
    return Survival(section, ordered, always, at_most, run)
