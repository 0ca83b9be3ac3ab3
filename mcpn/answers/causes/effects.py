"""What the failure of one resource does to an objective and to the mission, and the words that say so."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import NamedTuple, TypeAlias

from mcpn.answers.verdicts.modes import Situation
from mcpn.mission.expansion.faults import Crash
from mcpn.mission.flatten import Branch, ElementarySection, ParallelSection
from mcpn.mission.model import ABORT, FAIL, SUCCEED
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
    def words(self) -> str:
        """What it means for the mission."""
        if self.unsafe_unrepaired is None:
            if self.for_ever:
                return "cannot succeed any more"
            return "can succeed only if repaired" if self.unrepaired else "can still succeed"
        if self.unsafe_for_ever:
            return "can no longer end safely"
        if self.unsafe_unrepaired:
            return f"can end safely only if repaired{', and no longer succeed' * self.for_ever}"
        if self.for_ever:
            return "can end safely, but no longer succeed"
        return "can succeed only if repaired, or end safely" if self.unrepaired else "can still succeed"


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
        elsewhere: By objective in other branches of the same block, what it does there, in words.
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
    elsewhere: tuple[tuple[str, str], ...] = ()
    found: bool = False
    repaired: bool = True

    def objective_effect(self) -> str:
        """What it means for the objective."""
        if self.objective_lost:
            return "cannot succeed any more"
        return "goes on in another mode" if self.before != self.after else "none"

    def mission_effect(self) -> str:
        """What it means for the mission, of which a failure of little severity takes nothing."""
        lost_before = self.loss.unrepaired and self.severity <= Severity.OBJECTIVE_LOST
        return self.loss.words + ", as before it" * lost_before

    def detection(self, usage: Usage, hardware: str) -> str:
        """How the failure of some hardware is noticed."""
        resource = usage.hardware[hardware]
        if isinstance(resource, Crash):
            return f"at once: {resource.activity} has crashed"
        if resource.detected == "late":
            finding = [a.name for a in usage.activities.values() if hardware in a.detects]
            if self.found:
                return f"by {finding[0]}, which runs"
            later = f"late, by {finding[0]} when it runs" if finding else "late"
            return f"{later}, or as an objective fails that uses it"
        users = [
            activity
            for activity, chosen in self.before.mode.items()
            for alternative in usage.activities[activity].alternatives
            if alternative.name == chosen and hardware in alternative.consumes
        ]
        if users:
            return f"at once, by the error to {' and '.join(users)}"
        return "by its event alone: not in use here"

    def compensation(self, section: ElementarySection, around: Ancestors) -> str:
        """What replaces the resource, or where the objective's failure leads."""
        if self.objective_lost:
            return route(section, around)
        after = self.after.mode
        taken = [after[a] for a, was in self.before.mode.items() if after.get(a, was) != was]
        if taken:
            return f"{', '.join(taken)} instead"
        return "none" if self.loss.unrepaired else "none needed"

    def recovery(self, usage: Usage, hardware: str) -> str:
        """What happens when the resource is ready again while the objective still runs."""
        if not self.repaired:
            resource = usage.hardware[hardware]
            unnoticed = (
                not isinstance(resource, Crash) and resource.detected == "late" and resource.repairable
            )
            return "none before its loss is noticed" if unnoticed else "none: it is not repaired"
        if self.objective_lost:
            regained = self._regained()
            again = f", then the mission can {regained}" if regained else ""
            if self.objective_regained:
                return f"the objective can succeed again{again}"
            return f"none before the objective has failed{again}"
        if self.loss.unrepaired and self.before == self.after:
            regained = self._regained()
            return f"the mission can {regained} again" if regained else "none"
        if self.back.mode == self.after.mode:
            return (
                "none needed" if self.back.mode == self.before.mode else "at the next start of the activity"
            )
        return "the former mode" if self.back.mode == self.before.mode else "another mode"

    def _regained(self) -> str:
        """What the mission can do again when the resource is ready again."""
        if self.mission_regained:
            return "succeed"
        return "end safely" if self.safety_regained else ""


Ancestors: TypeAlias = Sequence[tuple[ParallelSection, Branch]]
"""The parallel blocks around an objective, each with the branch that it stands in, the outermost first."""


def route(section: ElementarySection, around: Ancestors) -> str:
    """Where the failure of an objective leads, and where that for a reason leads elsewhere."""
    ways: dict[str, list[str]] = {}
    for reason, target in section.reasons:
        elsewhere = _route(replace(section, failure=target), around)
        ways.setdefault(elsewhere, []).append(reason)
    plain = _route(section, around)
    named = (f"{way} for {' or '.join(reasons)}" for way, reasons in ways.items() if way != plain)
    return ", ".join((plain, *named))


def _route(section: ElementarySection, around: Ancestors) -> str:
    """Where the failure of an objective leads."""
    if section.failure not in _ENDS:
        again = _TRY.search(section.name) and _TRY.sub("", section.name) == _TRY.sub("", section.failure)
        return f"the objective's failure leads to {'its next try' if again else section.failure}"
    if not around:
        return f"the objective's failure ends the mission in {_ENDS[section.failure]}"
    block, branch = around[-1]
    if section.failure == ABORT:
        return f"the objective's failure aborts {block.name}"
    if section.failure == SUCCEED:
        return f"the objective's failure is a success of {branch.name}"
    if block.failing == 1 and block.needed is None and not branch.mandatory:
        # As the last child ends, the mandatory ones decide.
        return f"the objective's failure fails {block.name} while another child runs"
    if block.failing == 1 or (branch.mandatory and (block.needed is None or block.hasty)):
        return f"the objective's failure fails {block.name}"
    counts = []
    if block.needed is not None:
        counts.append(f"{block.name} needs {block.needed} of {len(block.branches)}")
    if block.failing is not None and block.failing <= len(block.branches) - (block.needed or 0):
        # Success that is decided at the same moment counts first, as the last child ends.
        last = " while another child runs" if block.needed is None else ""
        counts.append(f"{block.failing} failures fail {block.name}{last}")
    return ", ".join(counts) or f"{block.name} does not need it"


_ENDS = {SUCCEED: "success", FAIL: "failure", ABORT: "abort"}
_TRY = re.compile(r"_try[0-9]+")
NOT_HERE = "none here; "
"""Begins what is said of a loss that changes nothing but in other branches, or later."""


def joined(texts: Iterable[str]) -> str:
    """The different texts, each once.

    Examples:
        >>> joined(["film stops", "dive stops"])
        'film stops; or dive stops'
    """
    return "; or ".join(dict.fromkeys(texts))


def changes(before: Situation, after: Situation) -> str:
    """What changes in a mode; empty where nothing does."""
    found = [
        f"{activity}: {was} -> {after.mode[activity]}"
        for activity, was in before.mode.items()
        if after.mode.get(activity, was) != was
    ]
    found += [f"{a} has no possible alternative" for a in after.refused if a not in before.refused]
    found += [f"{a} waits" for a in after.waiting if a not in before.waiting]
    found = found or [f"{a} stops" for a in before.mode if a not in after.mode]
    found = found or [f"{a} runs" for a in after.mode if a not in before.mode]
    return ", ".join(found)


def worth_telling(cases: Sequence[Case]) -> list[Case]:
    """The cases of a row of the table, the worst first.

    A case without effect is left out where another case has one. A case in which the objective was lost
    already is left out where a case in which it was still open has the same severity.
    """
    open_to = {case.severity for case in cases if not case.already_lost}
    kept = [case for case in cases if not (case.already_lost and case.severity in open_to)]
    kept.sort(key=lambda case: case.severity, reverse=True)
    return [case for case in kept if case.severity] or kept


def local_effect(cases: Sequence[Case]) -> str:
    """How the mode of an objective changes; if it does not, the changes in other branches, or later."""
    found = [changed for case in cases if (changed := changes(case.before, case.after))]
    if found or not any(case.severity for case in cases):
        return joined(found) or "none"
    if any(case.objective_lost and not case.already_lost for case in cases):
        return "none at once; the objective cannot succeed any more"
    elsewhere = dict.fromkeys(
        words
        for case in cases
        for words in ([f"in {name}, {changed}" for name, changed in case.elsewhere] or ["needed later"])
    )
    return f"{NOT_HERE}{'; '.join(sorted(elsewhere, key='needed later'.__eq__))}"
