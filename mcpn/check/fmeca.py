"""Failure modes, effects and criticality: a row for each hardware resource and objective that it touches.

Every entry is read from the graph: the edges at which the resource goes out of service while the objective
runs, in runs without repairs in which objectives fail only where they must. A row tells what the failure does
when all other hardware is in service, and with which other failures it does worse.

Source: the columns are those of IEC 60812 (FMEA and FMECA), reduced to what a mission says.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import TypeAlias

import numpy as np

from mcpn.check.losing import Outlook
from mcpn.check.modes import Situation, situation
from mcpn.mission.flatten import Branch, ElementarySection, ParallelSection
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.space.graph import Ints, Mask

Others: TypeAlias = tuple[str, ...]
"""Other hardware that is out of service already, sorted."""


class Severity(IntEnum):
    """What a failure costs, the worst last. *Lost* means that no run leads to success any more."""

    NO_EFFECT = 0
    """Nothing changes: what was in use goes on, whatever could succeed still can."""
    DEGRADED = 1
    """The functioning mode changes; the objective and the mission can succeed."""
    OBJECTIVE_LOST = 2
    """The objective's present run can no longer succeed without repair; the mission can."""
    MISSION_LOST_UNLESS_REPAIRED = 3
    """The mission can succeed only if hardware is repaired."""
    MISSION_LOST = 4
    """The mission can no longer succeed, whatever is repaired."""

    @property
    def words(self) -> str:
        """The class in words."""
        return self.name.lower().replace("_", " ")


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
        severity: With all other hardware in service.
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


@dataclass(frozen=True)
class _Case:
    """What one edge does: the failure of one resource in one state."""

    before: Situation
    after: Situation
    back: Situation
    objective_lost: bool
    mission_lost: bool
    lost_for_ever: bool
    objective_regained: bool
    mission_regained: bool


def fmeca(outlook: Outlook) -> list[Row]:
    """The table of a mission.

    Args:
        outlook: The mission on its alternatives graph.

    Returns:
        Rows in the mission's order of hardware, then of objectives; those pairs are left out whose failure
        makes no difference in any company.
    """
    return list(_Table(outlook).rows())


class _Table:
    def __init__(self, outlook: Outlook) -> None:
        self.outlook = outlook
        self.graph = outlook.graph
        self.net = outlook.mission_net
        self.usage = outlook.mission_net.usage
        self.seen = self.graph.reached(outlook.forced)
        mission = outlook.mission
        self.lost = outlook.losing(mission, repairs=True)
        self.lost_unrepaired = outlook.losing(mission, repairs=False)

    def rows(self) -> Iterator[Row]:
        owners = {s.name: top.name for top in self.net.graph.sections for s in _elementary(top)}
        for number, hardware in enumerate(self.outlook.hardware):
            for section in self.net.graph.walk():
                row = self.row(number, hardware, section, owners[section.name])
                if row is not None:
                    yield row

    def row(self, number: int, hardware: str, section: ElementarySection, owner: str) -> Row | None:
        outlook, graph = self.outlook, self.graph
        goal = outlook.objectives[section.name]
        usable = goal.running & self.seen
        edges = np.flatnonzero((outlook.failing == number) & usable[graph.sources])
        if not len(edges):
            return None
        lost = outlook.losing(goal, repairs=False)
        severities = self.severities(edges, lost, section)
        if not severities.any():
            return None
        others = outlook.out[graph.sources[edges]]
        alone = np.flatnonzero(~others.any(axis=1))
        severity = Severity(int(severities[alone].max(initial=0)))
        cases = [self.case(e, section, lost) for e in self.distinct(edges, severities, alone)]
        return Row(
            hardware,
            section.name,
            owner,
            _joined(_local_effect(c) for c in cases),
            _joined(_objective_effect(c) for c in cases),
            _joined(_mission_effect(c) for c in cases),
            _joined(self.detection(c, hardware, section) for c in cases),
            _joined(self.compensation(c, section) for c in cases),
            _joined(_recovery(c) for c in cases),
            severity,
            tuple(self.with_others(severities, others, severity)),
        )

    # --- severity --------------------------------------------------------------------------------------

    def severities(self, edges: Ints, lost: Mask, section: ElementarySection) -> Ints:
        """The severity of each edge: the worst threshold that it crosses."""
        before, after = self.graph.sources[edges], self.graph.targets[edges]
        found = np.where(self.mode_changes(edges, section), int(Severity.DEGRADED), int(Severity.NO_EFFECT))
        for severity, region in (
            (Severity.OBJECTIVE_LOST, lost),
            (Severity.MISSION_LOST_UNLESS_REPAIRED, self.lost_unrepaired),
            (Severity.MISSION_LOST, self.lost),
        ):
            found[region[after] & ~region[before]] = int(severity)
        return found

    def mode_changes(self, edges: Ints, section: ElementarySection) -> Mask:
        before, after = self.graph.sources[edges], self.graph.targets[edges]
        changed = np.zeros(len(edges), np.bool_)
        for column in self.mode_columns(section):
            changed |= column[before] != column[after]
        return changed

    def mode_columns(self, section: ElementarySection) -> list[Mask]:
        """What the mode of an objective is made of: alternatives and refusals of all that serves it."""
        mine = frozenset[str]().union(*(self.usage.closure(a) for a in section.activities))
        return [column for name, columns in self._columns.items() if name in mine for column in columns]

    @cached_property
    def _columns(self) -> dict[str, list[Mask]]:
        found: dict[str, list[Mask]] = {}
        for kind in ("active", "wait", "refused"):
            for place, name in self.net.saying(kind).items():
                found.setdefault(name.split(".")[0], []).append(self.graph.marked(place))
        return found

    def with_others(
        self, severities: Ints, others: Mask, alone: Severity
    ) -> Iterator[tuple[Severity, tuple[Others, ...]]]:
        """Severities beyond the one alone, with the minimal sets of hardware that bring them about."""
        for severity in Severity:
            if severity <= alone:
                continue
            rows = np.unique(others[severities == int(severity)], axis=0)
            sets = [frozenset(np.flatnonzero(row).tolist()) for row in rows]
            least = [s for s in sets if not any(t < s for t in sets)]
            if least:
                names = [tuple(sorted(self.outlook.hardware[h] for h in s)) for s in least]
                yield severity, tuple(sorted(names, key=lambda n: (len(n), n)))

    # --- words -----------------------------------------------------------------------------------------

    def distinct(self, edges: Ints, severities: Ints, alone: Ints) -> list[int]:
        """An edge for each different thing that the failure does alone.

        Where the resource never fails first, the edges with fewest others out stand for the row.
        """
        chosen = alone
        if not len(chosen):
            company = self.outlook.out[self.graph.sources[edges]].sum(axis=1)
            chosen = np.flatnonzero(company == company.min())
        kinds: dict[tuple[bytes, int], int] = {}
        active = [column for columns in self._columns.values() for column in columns]
        for i in chosen.tolist():
            edge = int(edges[i])
            ends = (int(self.graph.sources[edge]), int(self.graph.targets[edge]))
            marks = bytes(bool(column[end]) for column in active for end in ends)
            kinds.setdefault((marks, int(severities[i])), edge)
        return list(kinds.values())

    def case(self, edge: int, section: ElementarySection, lost: Mask) -> _Case:
        graph = self.graph
        source, target = int(graph.sources[edge]), int(graph.targets[edge])
        again = target
        for e in range(int(graph.offsets[target]), int(graph.offsets[target + 1])):
            if self.outlook.repaired[e] == self.outlook.failing[edge]:
                again = int(graph.targets[e])
        mine = frozenset[str]().union(*(self.usage.closure(a) for a in section.activities))
        before, after, back = (
            _within(situation(self.net, graph.marking(s)), mine) for s in (source, target, again)
        )
        return _Case(
            before,
            after,
            back,
            bool(lost[target]),
            bool(self.lost_unrepaired[target]),
            bool(self.lost[target]),
            bool(lost[target] and not lost[again]),
            bool(self.lost_unrepaired[target] and not self.lost_unrepaired[again]),
        )

    def detection(self, case: _Case, hardware: str, section: ElementarySection) -> str:
        users = [
            activity
            for activity, chosen in case.before.mode.items()
            for alternative in self.usage.activities[activity].alternatives
            if alternative.name == chosen and hardware in alternative.consumes
        ]
        if users:
            return f"at once, by the error to {' and '.join(users)}"
        return "by its event alone: not in use here"

    def compensation(self, case: _Case, section: ElementarySection) -> str:
        """What replaces the resource, or where the objective's failure leads."""
        if case.objective_lost:
            return self.route(section)
        after = case.after.mode
        taken = [after[a] for a, was in case.before.mode.items() if after.get(a, was) != was]
        return f"{', '.join(taken)} instead" if taken else "none needed"

    def route(self, section: ElementarySection) -> str:
        """Where the failure of an objective leads."""
        if section.failure not in (SUCCEED, FAIL):
            return f"its failure leads to {section.failure}"
        block, branch = self._owners.get(section.name, (None, None))
        if block is None or branch is None:
            return f"its failure ends the mission in {'success' if section.failure == SUCCEED else 'failure'}"
        if section.failure == SUCCEED:
            return f"its failure is a success of {branch.name}"
        return f"its failure fails {block.name}" if branch.mandatory else f"{block.name} does not need it"

    @cached_property
    def _owners(self) -> dict[str, tuple[ParallelSection, Branch]]:
        """The innermost parallel block of each objective, and its branch there."""
        return {
            inner.name: (block, branch)
            for block in self.net.graph.all_sections()
            if isinstance(block, ParallelSection)
            for branch in block.branches
            for inner in branch.graph.sections
        }


def _elementary(section: ElementarySection | ParallelSection) -> Iterator[ElementarySection]:
    if isinstance(section, ElementarySection):
        yield section
    else:
        for branch in section.branches:
            yield from branch.graph.walk()


def _within(found: Situation, activities: frozenset[str]) -> Situation:
    """The part of a situation that concerns some activities."""
    return Situation(
        mode={a: alternative for a, alternative in found.mode.items() if a in activities},
        waiting={a: alternative for a, alternative in found.waiting.items() if a in activities},
        refused=tuple(a for a in found.refused if a in activities),
    )


def _joined(told: Iterator[str]) -> str:
    return "; or ".join(dict.fromkeys(told))


def _local_effect(case: _Case) -> str:
    changes = [
        f"{activity}: {was} -> {case.after.mode[activity]}"
        for activity, was in case.before.mode.items()
        if case.after.mode.get(activity, was) != was
    ]
    changes += [
        f"{a} has no possible alternative" for a in case.after.refused if a not in case.before.refused
    ]
    changes += [f"{a} waits" for a in case.after.waiting if a not in case.before.waiting]
    if not changes:
        changes = [f"{a} stops" for a in case.before.mode if a not in case.after.mode]
    return ", ".join(changes) or "none"


def _objective_effect(case: _Case) -> str:
    if case.objective_lost:
        return "cannot succeed any more"
    return "goes on in another mode" if case.before.mode != case.after.mode else "none"


def _mission_effect(case: _Case) -> str:
    if case.lost_for_ever:
        return "cannot succeed any more"
    return "can succeed only if repaired" if case.mission_lost else "can still succeed"


def _recovery(case: _Case) -> str:
    if case.objective_lost:
        again = ", then the mission can succeed" if case.mission_regained else ""
        if case.objective_regained:
            return f"the objective can succeed again{again}"
        return f"none before the objective has failed{again}"
    if case.back.mode == case.after.mode:
        return "none needed" if case.back.mode == case.before.mode else "at the next start of the activity"
    return "the former mode" if case.back.mode == case.before.mode else "another mode"
