"""Failure modes, effects and criticality: a row for each hardware resource and objective that it touches.

Every entry is read from a space of states: all edges at which the resource goes out of service while the
objective runs, however the mission has come there, also after repairs and after objectives that failed by
themselves. A row says the worst that the failure does when all other hardware is in service, and with which
other hardware out of service it does worse.

Source: the columns are those of IEC 60812 (FMEA and FMECA), reduced to what a mission says.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import compress
from typing import Generic, TypeAlias

from mcpn.check.causes.effects import (
    Case,
    Severity,
    Words,
    changes,
    joined,
    local_effect,
    mission_effect,
    objective_effect,
    recovery,
    worth_telling,
)
from mcpn.check.causes.prospects import Goal, Prospects
from mcpn.check.modes import Situation
from mcpn.mission.flatten import ElementarySection, ParallelSection
from mcpn.net.events import What
from mcpn.net.templates import Role
from mcpn.space.algebra import S, Space
from mcpn.space.images import ImageStore
from mcpn.steps import step

Others: TypeAlias = tuple[str, ...]
"""Other hardware that is out of service already, sorted."""


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Args:
        hardware: What fails.
        objective: The elementary objective that runs.
        section: The section of the mission's graph that it belongs to: itself, or its parallel block.
        local_effect: What changes in the functioning mode.
        objective_effect: What it means for the objective.
        mission_effect: What it means for the mission.
        detection: Where the failure is seen.
        compensation: What replaces it, or where the objective's failure leads.
        recovery: What happens when the resource is ready again while the objective still runs.
        severity: The worst with all other hardware in service, however the mission has come there.
        with_others: Worse severities, each with the minimal sets of other hardware that must be out already.
    """

    hardware: str
    objective: str
    section: str
    local_effect: str
    objective_effect: str
    mission_effect: str
    detection: str
    compensation: str
    recovery: str
    severity: Severity
    with_others: tuple[tuple[Severity, tuple[Others, ...]], ...]

    @property
    def worst(self) -> Severity:
        """The severity in the worst company."""
        return max((self.severity, *(severity for severity, _ in self.with_others)))


@dataclass(frozen=True, eq=False)
class _Failures(Generic[S]):
    """Edges of one transition by which one resource fails while one objective runs.

    Args:
        transition: The transition.
        before: The states before it.
        severities: Those of them by the severity of what it does, no effect left out.
    """

    transition: int
    before: S
    severities: dict[Severity, S]


def fmeca(prospects: Prospects[S], objectives: Collection[str] | None = None) -> list[Row]:
    """The table of a mission.

    Args:
        prospects: The mission in a space of its alternatives graph.
        objectives: Those to look at; all by default.

    Returns:
        A row for each resource that may fail and each objective that may run, in the mission's order of
        hardware, then of objectives; also where the failure has no effect, so that no pair is missing.
    """
    return list(_Table(prospects).rows(objectives))


class _Table(Generic[S]):
    def __init__(self, prospects: Prospects[S]) -> None:
        self.prospects = prospects
        self.space: Space[S] = prospects.space
        self.net = prospects.mission_net
        self.usage = prospects.mission_net.usage
        self.lost = prospects.losing(prospects.mission, repairs=True)
        self.lost_unrepaired = prospects.losing(prospects.mission, repairs=False)
        self.oos = prospects.places("oos", prospects.hardware)
        self.some_out = self.space.marked(self.oos)
        self.images = ImageStore(len(self.oos))
        self.words = Words(self.usage, self.net.graph)
        self.sections = {section.name: section for section in self.net.graph.walk()}
        self.consumers_first = list(self.usage.suppliers_first())[::-1]
        self._modes: dict[str, dict[int, S]] = {}

    def rows(self, objectives: Collection[str] | None) -> Iterator[Row]:
        owners = {s.name: top.name for top in self.net.graph.sections for s in _elementary(top)}
        for hardware in self.prospects.hardware:
            for section in self.net.graph.walk():
                if objectives is None or section.name in objectives:
                    step(f"finding what the failure of {hardware} does during {section.name}")
                    failures = list(self.failures(hardware, self.prospects.objectives[section.name]))
                    if failures:
                        yield self.row(hardware, section, owners[section.name], failures)

    def row(self, hardware: str, section: ElementarySection, owner: str, failures: list[_Failures[S]]) -> Row:
        # Hardware can be repaired while an objective runs, so that each may run with all other in service.
        cases = [case for f in failures for case in self.cases(f, hardware, section)]
        cases = worth_telling(cases)
        severity = max((case.severity for case in cases), default=Severity.NO_EFFECT)
        return Row(
            hardware,
            section.name,
            owner,
            local_effect(cases),
            joined(objective_effect(c) for c in cases),
            joined(mission_effect(c) for c in cases),
            joined(self.words.detection(c, hardware) for c in cases),
            joined(self.words.compensation(c, section) for c in cases),
            joined(recovery(c) for c in cases),
            severity,
            tuple(self.with_others(failures, severity)),
        )

    # --- severity --------------------------------------------------------------------------------------

    def failures(self, hardware: str, goal: Goal[S]) -> Iterator[_Failures[S]]:
        for t in sorted(self.prospects.carrying(What.OUT_OF_SERVICE, hardware)):
            before = self.space.enabling([t]) & goal.running if goal.running else goal.running
            if before:
                yield _Failures(t, before, self.severities(t, before, goal))

    def severities(self, transition: int, before: S, goal: Goal[S]) -> dict[Severity, S]:
        """The states before an edge by the worst threshold that it crosses."""
        found: dict[Severity, S] = {}
        left = before
        for severity, region in (
            (Severity.MISSION_LOST, self.lost),
            (Severity.MISSION_LOST_UNLESS_REPAIRED, self.lost_unrepaired),
            (Severity.OBJECTIVE_LOST, self.prospects.losing(goal, repairs=False)),
        ):
            crossing = (self.space.before(region, [transition]) & left) - region if region else region
            if crossing:
                found[severity] = crossing
                left = left - crossing
        changed = self.space.nothing
        if left:
            for states in self.modes(goal).values():
                changed = changed | self.changing(states, transition, left)
        return found | ({Severity.DEGRADED: changed} if changed else {})

    def changing(self, states: S, transition: int, before: S) -> S:
        """Those of some states from which an edge leads into or out of others."""
        kept = self.space.before(states, [transition]) if states else states
        return ((states - kept) | (kept - states)) & before

    def modes(self, goal: Goal[S]) -> dict[int, S]:
        """The mode of an objective: by place of what serves it, the states in which that serves it now.

        An activity serves an objective that starts it, or that another serves by an alternative which
        consumes what this one produces. A branch beside the objective may keep it running without that.
        """
        if goal.name not in self._modes:
            self._modes[goal.name] = self._mode_of(goal)
        return self._modes[goal.name]

    def _mode_of(self, goal: Goal[S]) -> dict[int, S]:
        space, by_role = self.space, self.net.by_role
        serving, varying = self.prospects.serving[goal.name], set(space.varying(goal.running))
        serves = dict.fromkeys(serving, space.nothing) | dict.fromkeys(
            self.sections[goal.name].activities, goal.running
        )
        found: dict[int, S] = {}
        for name in filter(serves.__contains__, self.consumers_first):
            states = serves[name]
            roles: list[tuple[Role, tuple[str, ...]]] = [(("refused", name), ())]
            for way in self.usage.activities[name].alternatives:
                started_as = f"{name}.{way.name}"
                roles += [(("active", started_as), way.consumes), (("wait", started_as), way.consumes)]
            for role, consumes in roles:
                for place in varying.intersection(by_role.get(role, ())):
                    marked = space.restricted(states, [place], ()) if states else states
                    if marked:
                        found[place] = marked
                        for producer in {of for r in consumes if (of := self.usage.producer.get(r))}:
                            serves[producer] = serves[producer] | marked
        return dict(sorted(found.items()))

    def with_others(
        self, failures: Sequence[_Failures[S]], alone: Severity
    ) -> Iterator[tuple[Severity, tuple[Others, ...]]]:
        """Severities beyond the one alone, with the minimal sets of hardware that bring them about."""
        for severity in Severity:
            if severity <= alone:
                continue
            family = self.images.nothing
            for failure in failures:
                if severity in failure.severities:
                    family |= self.space.image(failure.severities[severity], self.oos, self.images)
            least = self.images.minimal(family)
            if least:
                names = [tuple(sorted(self.prospects.hardware[h] for h in s)) for s in least]
                yield severity, tuple(sorted(names, key=lambda n: (len(n), n)))

    # --- what happens, case by case ----------------------------------------------------------------------

    def cases(self, failure: _Failures[S], hardware: str, section: ElementarySection) -> Iterator[Case]:
        """The different things that a failure does when all other hardware is in service."""
        alone = failure.before - self.some_out
        for severity in sorted(failure.severities, reverse=True):
            states = failure.severities[severity] - self.some_out
            alone = alone - states
            if states:
                yield from self.distinct(severity, states, failure.transition, hardware, section)
        if alone:
            yield self.without_effect(alone, self.prospects.objectives[section.name])

    def without_effect(self, states: S, goal: Goal[S]) -> Case:
        """That nothing changes, told of the states with the best prospects."""
        idle, lost = Situation(), self.prospects.losing(goal, repairs=False)
        best = states - lost or states
        hopeless, without_hope = not states - lost, not best - self.lost
        mission_lost = without_hope or not best - self.lost_unrepaired
        return Case(
            Severity.NO_EFFECT,
            idle,
            idle,
            idle,
            hopeless,
            hopeless,
            mission_lost,
            without_hope,
            False,
            False,
            "",
        )

    def distinct(
        self, severity: Severity, states: S, transition: int, hardware: str, section: ElementarySection
    ) -> Iterator[Case]:
        """Some states before a failure, by what it does to the objective's mode and its prospects."""
        space, goal = self.space, self.prospects.objectives[section.name]
        lost = self.prospects.losing(goal, repairs=False)
        repairs = self.prospects.carrying(What.REPAIRED, hardware)

        def coming_to(region: S) -> S:
            return space.before(region, [transition]) if region else region

        def coming_back_to(region: S) -> S:
            return coming_to(space.before(region, repairs)) if region else region

        modes = self.modes(goal)
        changed = [p for p, marked in modes.items() if self.changing(marked, transition, states)]
        asked = [
            lost,
            *(coming_to(region) for region in (lost, self.lost_unrepaired, self.lost)),
            *(coming_back_to(region) for region in (lost, self.lost_unrepaired)),
            *(modes[p] for p in changed),
            *(coming_to(modes[p]) for p in changed),
            *(coming_back_to(modes[p]) for p in changed),
        ]
        n = len(changed)
        for answers, those in _atoms(states, asked):
            already, gone, unrepaired, ever, still_gone, still_unrepaired, *marked = answers
            before, after, back = (
                self.situation(compress(changed, marked[i * n : (i + 1) * n])) for i in range(3)
            )
            yield Case(
                severity,
                before,
                after,
                back,
                already,
                gone,
                unrepaired,
                ever,
                gone and not still_gone,
                unrepaired and not still_unrepaired,
                self.elsewhere(those, transition, section.name) if before == after else "",
            )

    def elsewhere(self, states: S, transition: int, name: str) -> str:
        """What a failure does to the modes of other objectives that run at the same time, in words."""
        found = []
        for other in self._beside.get(name, ()):
            goal = self.prospects.objectives[other]
            there = states & goal.running
            modes = self.modes(goal) if there else {}
            changed = [p for p, marked in modes.items() if self.changing(marked, transition, there)]
            asked = [modes[p] for p in changed]
            asked += [self.space.before(modes[p], [transition]) for p in changed]
            told = dict.fromkeys(
                changes(self.situation(compress(changed, answers)), self.situation(compress(changed, after)))
                for answers, _ in _atoms(there, asked)
                if changed and (after := answers[len(changed) :]) != answers[: len(changed)]
            )
            if told:
                found.append(f"in {other}, {' or '.join(told)}")
        return "; ".join(found)

    @cached_property
    def _beside(self) -> dict[str, list[str]]:
        """By objective, those that may run at the same time: of other branches of the blocks around it."""
        found: dict[str, list[str]] = {}
        for block in self.net.graph.all_sections():
            if isinstance(block, ParallelSection):
                branches = [[s.name for s in branch.graph.walk()] for branch in block.branches]
                for i, names in enumerate(branches):
                    others = [n for j, other in enumerate(branches) if j != i for n in other]
                    for name in names:
                        found.setdefault(name, []).extend(others)
        return found

    def situation(self, marked: Iterable[int]) -> Situation:
        """What some places of modes say."""
        said = self.prospects.said(marked)
        return Situation(
            mode=dict(name.split(".", 1) for name in said["active"]),
            waiting=dict(name.split(".", 1) for name in said["wait"]),
            refused=said["refused"],
        )


def _elementary(section: ElementarySection | ParallelSection) -> Iterator[ElementarySection]:
    if isinstance(section, ElementarySection):
        yield section
    else:
        for branch in section.branches:
            yield from branch.graph.walk()


def _atoms(states: S, asked: Sequence[S]) -> Iterator[tuple[tuple[bool, ...], S]]:
    """Some states by which of some sets hold them, with the answers; those that more sets hold first."""
    parts: list[tuple[tuple[bool, ...], S]] = [((), states)]
    for region in asked:
        halves = [
            ((*answers, inside), half)
            for answers, those in parts
            for inside, half in ((True, those & region), (False, those - region))
        ]
        parts = [(answers, half) for answers, half in halves if half]
    yield from parts
