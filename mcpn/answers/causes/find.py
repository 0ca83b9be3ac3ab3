"""Failure causes of a mission, all together: what a report shows and the command line prints.

Which hardware must be lost for the mission and each objective to fail, when; which events decide it, in which
functioning mode; the shortest runs that show it; how much the mission survives from each section on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Unpack

from mcpn.answers.causes.minimal_cut_sets import CutSet, CutSets, Moment, Nonmonotone, Unaided
from mcpn.answers.causes.prospects import CriticalEvent, Goal, Prospects
from mcpn.answers.spaces_by_engine import MissionSubject, spaces_of
from mcpn.answers.verdicts.unreachable import selected_and_entered
from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError
from mcpn.events import Event
from mcpn.mission.core.objectives_graph import Section
from mcpn.notebook import Told
from mcpn.spaces.algebra import Space
from mcpn.spaces.engine_names import Asking
from mcpn.spaces.engines import Choice, answered
from mcpn.spaces.run import Run
from mcpn.steps import Doing, step


@dataclass(frozen=True, eq=False)
class GoalCauses(Told):
    """Why one goal fails.

    Args:
        name: Of the mission or the objective.
        moments: Minimal cut sets by moment, see :class:`mcpn.answers.causes.minimal_cut_sets.Moment`.
        critical: Events that lead into the losing region where nothing is repaired.
        critical_with_repairs: The same where hardware may be repaired.
        nonmonotone: A pair of sets for which more failures are better, where there is one.
        find_run: Looks for a short run to failure by a cut set.
        unaided: Of the mission: what defeats it where no declared event happens and no time is over.
    """

    name: str
    moments: dict[str, list[CutSet]]
    critical: list[CriticalEvent]
    critical_with_repairs: list[CriticalEvent]
    nonmonotone: Nonmonotone | None
    find_run: Callable[[CutSet], Run | None]
    unaided: Unaided | None = None

    @property
    def cut_sets(self) -> list[CutSet]:
        """Minimal cut sets: of the mission at its start, of an objective at its entry."""
        return self.moments.get(Moment.ENTRY.value, self.moments[Moment.START.value])

    @property
    def only_at_worst(self) -> list[CutSet]:
        """Minimal cut sets at the worst moment that are none at the start, or entry; all lose something."""
        known = [set(lost) for lost in self.cut_sets]
        found = self.moments.get(Moment.SOMETIME.value, [])
        return [lost for lost in found if lost and not any(each <= set(lost) for each in known)]

    @property
    def critical_events(self) -> list[Event]:
        """The events after which only a repair helps, or nothing."""
        return sorted({critical.event for critical in self.critical})

    @cached_property
    def runs(self) -> dict[CutSet, Run | None]:
        """For each of the cut sets a shortest run to failure, where there is one."""
        return {names: self.find_run(names) for names in self.cut_sets}


@dataclass(frozen=True, eq=False)
class Survival:
    """What the mission survives from one moment on.

    Args:
        section: The section just entered; ``None`` for the start.
        cut_sets: Minimal cut sets of the mission at that moment.
        always: Most resources that may be lost whichever they are; ``None`` where success is out of reach.
        at_most: Size of the largest set that may be lost; ``None`` where success is out of reach.
        find_run: Looks for a run through that moment to success with the most failures on the way.
        safety: The same of a safe end, success or abort; ``None`` of a mission that cannot abort.
    """

    section: str | None
    cut_sets: list[CutSet]
    always: int | None
    at_most: int | None
    find_run: Callable[[], Run | None]
    safety: Survival | None = None

    @cached_property
    def run(self) -> Run | None:
        """A run through that moment to success with the most failures on the way, where there is one."""
        return self.find_run()


@dataclass(frozen=True, eq=False)
class Causes(Told):
    """Failure causes of a mission.

    Args:
        mission_net: The mission's net.
        prospects: The mission in the space that was asked.
        mission: Why the mission fails.
        objectives: Why each elementary objective fails, by its name.
        survival: What the mission survives from its start and from the entry of each section.
        choice: The engine that answered.
        safety: Why it ends neither in success nor in abort; ``None`` of a mission that cannot abort.
    """

    mission_net: MissionNet
    prospects: Prospects[Any]
    mission: GoalCauses
    objectives: Mapping[str, GoalCauses]
    survival: list[Survival]
    choice: Choice
    safety: GoalCauses | None = None

    def __repr__(self) -> str:
        def lost(goal: GoalCauses) -> str:
            return "; ".join(" and ".join(cut_set) for cut_set in goal.cut_sets) or "no hardware"

        name, safety = self.mission.name, self.safety
        if safety is None:
            return f"<causes of the mission {name}: fails without {lost(self.mission)}>"
        unsafe = f"no safe end without {lost(safety)}"
        return f"<causes of the mission {name}: no success without {lost(self.mission)}, {unsafe}>"

    @property
    def unsafe_aborts(self) -> tuple[str, ...]:
        """Objectives that should make the robot safe: an abort by their failure is no safe end."""
        aborts = self.prospects.aborts
        return () if aborts is None else aborts.unsafe

    @cached_property
    def unused(self) -> tuple[str, ...]:
        """The declared hardware that may fail, and that no alternative consumes that is ever selected."""
        selected, _ = selected_and_entered(self.mission_net, self.prospects.space)
        every = self.mission_net.usage.activities.values()
        ways = ((f"{activity.name}.{way.name}", way) for activity in every for way in activity.alternatives)
        used = {resource for name, way in ways if name in selected for resource in way.consumes}
        declared = self.mission_net.core.declared_hardware
        return tuple(h.name for h in declared if h.faulty and h.name not in used)

    def of(self, objectives: Iterable[str]) -> Causes:
        """The causes of some elementary objectives only, with all of their copies.

        Raises:
            InputError: A name means none.
        """
        chosen: dict[str, GoalCauses] = {}
        for name in objectives:
            copies = self.mission_net.graph.copies.meant(name)
            found = {copy: self.objectives[copy] for copy in copies if copy in self.objectives}
            if not found:
                message = f"no objective {name}; expected one of {', '.join(self.objectives)}"
                raise InputError.at(self.mission_net.core.source, message)
            chosen |= found
        return replace(self, objectives=chosen)


def find_causes(
    subject: MissionSubject,
    **asked: Unpack[Asking],
) -> Causes:
    """The failure causes of a mission: all but the tables of ``fmeca`` and the numbers of ``risk``.

    All engines give the same answers; runs are shortest but for composition, where they pass as few sections
    as can be. The arguments are those of :func:`mcpn.answers.verdicts.mission.check`.

    Raises:
        SemanticsError: The mission is not 1-safe or not confluent.
        LimitError: A limit was hit: on states, memory or minimal cut sets.

    See Also:
        :mod:`mcpn.answers.causes.fmeca`: what each single loss does, objective by objective.
        :mod:`mcpn.answers.causes.chain`: how probable it all is.

    Examples:
        >>> from mcpn.drawing.compose import compose
        >>> from mcpn.mission.model import Objective
        >>> from mcpn.testing.by_hand import activity, hw, mission, robot
        >>> film = activity("film", ("camera",), ("sonar",))
        >>> small = mission(robot(hw("camera", "sonar"), film), Objective(name="see", activities=("film",)))
        >>> find_causes(compose(small)).objectives["see"].cut_sets
        [('camera', 'sonar')]
    """
    spaces = spaces_of(subject, **asked)
    mission_net = spaces.mission

    def both(by: Choice) -> tuple[Space[Any], Space[Any]]:
        living = spaces.space(by, "alternatives")
        return living, spaces.space(by, "alternatives", may_die=True)

    (living, dying), choice = answered(both, spaces.choices("alternatives"))
    step(Doing.FINDING_NEEDS)
    prospects, cuts = Prospects(mission_net, living, spaces.max_states), CutSets(mission_net, dying)

    def causes(goal: Goal[Any], dying: Goal[Any], section: Section | None = None) -> GoalCauses:
        step(Doing.FINDING_CAUSES, objective="the mission" if section is None else goal.name)
        found = cuts.found(dying, section)
        return GoalCauses(
            goal.name,
            {moment.value: minimal for moment, minimal in found.minimal.items()},
            prospects.critical(goal, repairs=False),
            prospects.critical(goal, repairs=True),
            found.nonmonotone,
            partial(prospects.to_failure, goal),
            cuts.unaided(dying) if section is None else None,
        )

    def survival(section: Section | None) -> Survival:
        name = None if section is None else section.name
        step(Doing.FINDING_SURVIVAL_FROM if name else Doing.FINDING_SURVIVAL, section=name)

        def survives(goal: Goal[Any], dying: Goal[Any], safety: Survival | None = None) -> Survival:
            lost = cuts.defeating(dying, Moment.ENTRY if section else Moment.START, section)
            cut_sets, survived = cuts.minimal(lost), cuts.images.everything - lost
            always = at_most = None
            if survived:
                always = len(cut_sets[0]) - 1 if cut_sets else len(cuts.hardware)
                at_most = cuts.images.sized(survived)
            run = partial(prospects.most_failures, goal, section)
            return Survival(name, cut_sets, always, at_most, run, safety)

        living, dying = prospects.safety, cuts.safety
        safety = None if living is None or dying is None else survives(living, dying)
        return survives(prospects.mission, cuts.mission, safety)

    return Causes(
        mission_net,
        prospects,
        causes(prospects.mission, cuts.mission),
        {
            name: causes(prospects.objectives[name], cuts.objectives[name], section)
            for name, section in prospects.sections.items()
        },
        [survival(section) for section in (None, *mission_net.graph.sections)],
        choice,
        None if prospects.safety is None or cuts.safety is None else causes(prospects.safety, cuts.safety),
    )
