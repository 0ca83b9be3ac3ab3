"""What the failure of one resource does to an objective and to the mission, as claims in cells of a row."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import NamedTuple, TypeAlias

from mcpn.answers.kinds.of_cells import OF_CELLS
from mcpn.answers.verdicts.modes import Situation
from mcpn.mission.core.objectives_graph import Branch, ElementarySection, ParallelSection
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.mission.robot import Crash
from mcpn.mission.static.resource_use import Usage


class Severity(IntEnum):
    """What a failure costs, the worst last.

    *Lost* means that no run leads to success any more. The robot is lost where none leads to a safe
    abort either; of a mission that cannot abort nothing is said of the robot.
    """

    NO_EFFECT = 0
    """Nothing changes: what was in use goes on, whatever could succeed still can."""
    DEGRADED = 1
    """The functioning mode changes; the objective and the mission can succeed."""
    OBJECTIVE_LOST = 2
    """The objective's present run can no longer succeed without repair; the mission loses nothing more."""
    MISSION_LOST_UNLESS_REPAIRED = 3
    """The mission can succeed only if hardware is repaired."""
    MISSION_LOST = 4
    """The mission can no longer succeed, whatever is repaired."""
    ROBOT_LOST_UNLESS_REPAIRED = 5
    """The mission can end safely, in success or a safe abort, only if hardware is repaired."""
    ROBOT_LOST = 6
    """The mission can no longer end safely, whatever is repaired."""

    @property
    def words(self) -> str:
        """The class in words."""
        return self.name.lower().replace("_", " ")


CELLS = {kind.name: kind.cell for kind in OF_CELLS}
"""What a cell says, by the name of a kind of claim."""


class Cell(NamedTuple):
    """A claim in a cell of the table, but for the hardware and the objective of its row.

    Args:
        kind: The name of its kind.
        names: What it names besides.
        given: Under which condition, in words.
        ways: Alternatives of which its formula speaks, each with its activity.
    """

    kind: str
    names: tuple[str, ...] = ()
    given: str = ""
    ways: tuple[tuple[str, str], ...] = ()

    @property
    def words(self) -> str:
        """What the cell says."""
        return CELLS[self.kind].format("", "", *self.names, given=self.given)


Told: TypeAlias = tuple[Cell, ...]
"""What a cell says of one case."""
Column: TypeAlias = tuple[Told, ...]
"""What a cell says, case by case."""


def in_words(column: Column) -> str:
    """A cell of the table.

    Examples:
        >>> in_words(((Cell("comes_to_stop", ("film",)),), (Cell("comes_to_stop", ("dive",)),)))
        'film stops; or dive stops'
    """
    cases = ((_SEPARATE if told[0].kind == _HERE else ", ").join(c.words for c in told) for told in column)
    return "; or ".join(dict.fromkeys(cases))


_HERE, _SEPARATE = "changes_nothing_here", "; "
NOT_HERE = f"{CELLS[_HERE]}{_SEPARATE}"
"""Begins what is said of a loss that changes nothing but in other branches, or later."""


class Loss(NamedTuple):
    """What can no longer be reached.

    Args:
        unrepaired: Whether the mission can succeed only by repairs.
        for_ever: Whether it can no longer succeed.
        unsafe_unrepaired: Whether it can end safely only by repairs; ``None`` of a mission that
            cannot abort.
        unsafe_for_ever: Whether it can no longer end safely; ``None`` there too.
    """

    unrepaired: bool
    for_ever: bool
    unsafe_unrepaired: bool | None = None
    unsafe_for_ever: bool | None = None

    @property
    def kind(self) -> str:
        """The kind of claim that says what it means for the mission."""
        if self.unsafe_unrepaired is None:
            if self.for_ever:
                return "mission_lost"
            return "by_repair" if self.unrepaired else "spared"
        if self.unsafe_for_ever:
            return "robot_lost"
        if self.unsafe_unrepaired:
            return "safe_by_repair_alone" if self.for_ever else "safe_by_repair"
        if self.for_ever:
            return "safe_alone"
        return "by_repair_or_safe" if self.unrepaired else "spared"


@dataclass(frozen=True)
class Case:
    """One thing that a failure does.

    Args:
        severity: How severe it is.
        before: What the activities whose mode changes do before it.
        after: What they do after it.
        back: What they do when the resource is ready again.
        already_lost: Whether the objective could not succeed any more before it.
        objective_lost: Whether the objective can no longer succeed after it.
        loss: What the mission can no longer reach.
        objective_regained: Whether the objective can succeed again when the resource is ready again.
        mission_regained: Whether the mission can.
        safety_regained: Whether the mission can end safely again.
        elsewhere: By objective in other branches of the same block, what it changes there.
        found: Where the failure is detected late: whether its detection may be the next event.
        repaired: Whether its repair may be the next event: not of what is never repaired, and not before a
            late loss is noticed.
    """

    severity: Severity
    before: Situation
    after: Situation
    back: Situation
    already_lost: bool
    objective_lost: bool
    loss: Loss
    objective_regained: bool = False
    mission_regained: bool = False
    safety_regained: bool = False
    elsewhere: tuple[tuple[str, Told], ...] = ()
    found: bool = False
    repaired: bool = True

    def objective_effect(self) -> Told:
        """What it means for the objective."""
        if self.objective_lost:
            return (Cell(f"objective_lost{'_before' * self.already_lost}"),)
        return (Cell("goes_on_otherwise" if self.before != self.after else "objective_unchanged"),)

    def mission_effect(self) -> Told:
        """What it means for the mission, of which a failure of little severity takes nothing."""
        lost_before = self.loss.unrepaired and self.severity <= Severity.OBJECTIVE_LOST
        return (Cell(self.loss.kind + "_before" * lost_before),)

    def detection(self, usage: Usage, hardware: str) -> Told:
        """How the failure of some hardware is noticed."""
        resource = usage.hardware[hardware]
        if isinstance(resource, Crash):
            return (Cell("seen_as_crash", (resource.activity,)),)
        if resource.detected == "late":
            finding = [a.name for a in usage.activities.values() if hardware in a.detects]
            if self.found:
                return (Cell("found_next", (finding[0],)),)
            return (Cell("found_by", (finding[0],)) if finding else Cell("found_late"),)
        users = {
            activity: chosen
            for activity, chosen in self.before.mode.items()
            for alternative in usage.activities[activity].alternatives
            if alternative.name == chosen and hardware in alternative.consumes
        }
        if users:
            return (Cell("seen_by_error", (" and ".join(users),), ways=tuple(users.items())),)
        return (Cell("seen_by_event"),)

    def compensation(self, section: ElementarySection, around: Ancestors) -> Told:
        """What replaces the resource, or where the objective's failure leads."""
        if self.objective_lost:
            return route(section, around)
        after = self.after.mode
        taken = {a: after[a] for a, was in self.before.mode.items() if after.get(a, was) != was}
        if taken:
            return (Cell("replaced", (", ".join(taken.values()),), ways=tuple(taken.items())),)
        return (Cell("not_replaced" if self.loss.unrepaired else "no_need_to_replace"),)

    def recovery(self, usage: Usage, hardware: str) -> Told:
        """What happens when the resource is ready again while the objective still runs."""
        if not self.repaired:
            resource = usage.hardware[hardware]
            unnoticed = (
                not isinstance(resource, Crash) and resource.detected == "late" and resource.repairable
            )
            return (Cell("repaired_once_found" if unnoticed else "never_repaired"),)
        if self.objective_lost:
            objective = Cell("objective_regained" if self.objective_regained else "objective_not_regained")
            return (objective, *self._regained("_then"))
        if self.loss.unrepaired and self.before == self.after:
            return self._regained() or (Cell("nothing_regained"),)
        if self.back.mode == self.after.mode:
            same = self.back.mode == self.before.mode
            return (Cell("no_return_needed" if same else "returns_at_next_start"),)
        if self.back.mode != self.before.mode:
            return (Cell("other_mode"),)
        after = self.after.mode
        ways = tuple((a, was) for a, was in self.before.mode.items() if after.get(a, was) != was)
        return (Cell("former_mode", ways=ways),)

    def _regained(self, then: str = "") -> Told:
        """What the mission can do again when the resource is ready again."""
        if self.mission_regained:
            return (Cell(f"success_regained{then}"),)
        return (Cell(f"safety_regained{then}"),) if self.safety_regained else ()


Ancestors: TypeAlias = Sequence[tuple[ParallelSection, Branch]]
"""The parallel blocks around an objective, each with the branch that it stands in, the outermost first."""


def route(section: ElementarySection, around: Ancestors) -> Told:
    """Where the failure of an objective leads, and where that for a reason leads elsewhere."""
    ways: dict[Told, list[str]] = {}
    for reason, target in section.reasons:
        ways.setdefault(_route(replace(section, failure=target), around), []).append(reason)
    plain = _route(section, around)
    named = (
        cell._replace(given=f" for {' or '.join(reasons)}")
        for way, reasons in ways.items()
        if way != plain
        for cell in way
    )
    return (*plain, *named)


def _route(section: ElementarySection, around: Ancestors) -> Told:
    """Where the failure of an objective leads."""
    if section.failure not in _ENDS:
        again = _TRY.search(section.name) and _TRY.sub("", section.name) == _TRY.sub("", section.failure)
        return (Cell("failure_tries_again") if again else Cell("failure_leads", (section.failure,)),)
    if not around:
        return (Cell("failure_ends", (_ENDS[section.failure],)),)
    block, branch = around[-1]
    if section.failure == ABORT:
        return (Cell("failure_aborts", (block.name,)),)
    if section.failure == SUCCEED:
        return (Cell("failure_counts_as_success", (branch.name,)),)
    if block.failing == 1 and block.needed is None and not branch.mandatory:
        # As the last child ends, the mandatory ones decide.
        return (Cell("failure_fails_early", (block.name,)),)
    if block.failing == 1 or (branch.mandatory and (block.needed is None or block.hasty)):
        return (Cell("failure_fails", (block.name,)),)
    counts = list[Cell]()
    if block.needed is not None:
        counts.append(Cell("block_needs", (block.name, str(block.needed), str(len(block.branches)))))
    if block.failing is not None and block.failing <= len(block.branches) - (block.needed or 0):
        # Success that is decided at the same moment counts first, as the last child ends.
        early = "_early" if block.needed is None else ""
        counts.append(Cell(f"block_allows{early}", (block.name, str(block.failing))))
    return tuple(counts) or (Cell("block_does_without", (block.name,)),)


_ENDS = {SUCCEED: "success", FAIL: "failure", ABORT: "abort"}
_TRY = re.compile(r"_try[0-9]+")


def changes(before: Situation, after: Situation) -> Told:
    """What changes in a mode; nothing where nothing does."""
    found = [
        Cell("changes_alternative", (a, was, after.mode[a]))
        for a, was in before.mode.items()
        if after.mode.get(a, was) != was
    ]
    found += [Cell("has_no_alternative", (a,)) for a in after.refused if a not in before.refused]
    found += [Cell("comes_to_wait", (a,)) for a in after.waiting if a not in before.waiting]
    found = found or [Cell("comes_to_stop", (a,)) for a in before.mode if a not in after.mode]
    return tuple(found or [Cell("comes_to_run", (a,)) for a in after.mode if a not in before.mode])


def worth_telling(cases: Sequence[Case]) -> list[Case]:
    """The cases of a row of the table, the worst first.

    A case without effect is left out where another case has one. A case in which the objective was lost
    already is left out where a case in which it was still open has the same severity.
    """
    open_to = {case.severity for case in cases if not case.already_lost}
    kept = [case for case in cases if not (case.already_lost and case.severity in open_to)]
    kept.sort(key=lambda case: case.severity, reverse=True)
    return [case for case in kept if case.severity] or kept


def local_effect(cases: Sequence[Case]) -> Column:
    """How the mode of an objective changes; if it does not, the changes in other branches, or later."""
    found = [changed for case in cases if (changed := changes(case.before, case.after))]
    if found or not any(case.severity for case in cases):
        return each_once(found) or ((Cell("changes_nothing"),),)
    if any(case.objective_lost and not case.already_lost for case in cases):
        return ((Cell("lost_unseen"),),)
    elsewhere = dict.fromkeys(
        Cell(f"{cell.kind}_elsewhere", (*cell.names, name))
        for case in cases
        for name, changed in case.elsewhere
        for cell in changed
    )
    later = [Cell("needed_later")] * any(not case.elsewhere for case in cases)
    return ((Cell("changes_nothing_here"), *sorted(elsewhere, key=lambda cell: cell.words), *later),)


def each_once(told: Iterable[Told]) -> Column:
    """What is told of the cases, each once."""
    return tuple(dict.fromkeys(told))
