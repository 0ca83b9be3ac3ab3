"""Failure modes, effects and criticality: a row for each hardware resource and objective that it touches.

Every entry is read from a space of states: the edges at which the resource goes out of service while the
objective runs, in runs without repairs in which objectives fail only where they must. A row says what the
failure does when all other hardware is in service, and with which other failures it does worse.

Source: the columns are those of IEC 60812 (FMEA and FMECA), reduced to what a mission says.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any, Generic, TypeAlias

from mcpn.check.causes.prospects import Goal, Prospects
from mcpn.check.modes import Situation
from mcpn.mission.flatten import Branch, ElementarySection, ParallelSection
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.net.events import What
from mcpn.space.algebra import S, Space, partition
from mcpn.space.images import ImageStore

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


def fmeca(prospects: Prospects[S], objectives: Collection[str] | None = None) -> list[Row]:
    """The table of a mission.

    Args:
        prospects: The mission in a space of its alternatives graph.
        objectives: Those to look at; all by default.

    Returns:
        Rows in the mission's order of hardware, then of objectives; those pairs are left out whose failure
        makes no difference in any company.
    """
    return list(_Table(prospects).rows(objectives))


@dataclass(frozen=True)
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


class _Table(Generic[S]):
    def __init__(self, prospects: Prospects[S]) -> None:
        self.prospects = prospects
        self.space: Space[S] = prospects.space
        self.net = prospects.mission_net
        self.usage = prospects.mission_net.usage
        self.seen = self.space.reached(
            self.space.initial, transitions=prospects.unrepaired, guards=prospects.forced
        )
        self.lost = prospects.losing(prospects.mission, repairs=True)
        self.lost_unrepaired = prospects.losing(prospects.mission, repairs=False)
        self.oos = prospects.places("oos", prospects.hardware)
        self.degraded = self.space.marked(self.oos)
        self.images = ImageStore(len(self.oos))

    def rows(self, objectives: Collection[str] | None) -> Iterator[Row]:
        owners = {s.name: top.name for top in self.net.graph.sections for s in _elementary(top)}
        for hardware in self.prospects.hardware:
            for section in self.net.graph.walk():
                if objectives is None or section.name in objectives:
                    row = self.row(hardware, section, owners[section.name])
                    if row is not None:
                        yield row

    def row(self, hardware: str, section: ElementarySection, owner: str) -> Row | None:
        goal = self.prospects.objectives[section.name]
        usable = goal.running & self.seen
        failures = list(self.failures(hardware, goal, usable)) if usable else []
        if not any(failure.severities for failure in failures):
            return None
        chosen = self.in_least_company(failures)
        severity = max(
            (s for f in failures for s, states in f.severities.items() if states - self.degraded),
            default=Severity.NO_EFFECT,
        )
        cases = [self.case(hardware, state, t, goal) for t, state in self.distinct(chosen, goal)]
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
            tuple(self.with_others(failures, severity)),
        )

    # --- severity --------------------------------------------------------------------------------------

    def failures(self, hardware: str, goal: Goal[S], usable: S) -> Iterator[_Failures[S]]:
        for t in sorted(self.prospects.carrying(What.OUT_OF_SERVICE, hardware)):
            before = usable & self.space.enabling([t])
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
        changed = self.mode_changes(transition, left, goal)
        return found | ({Severity.DEGRADED: changed} if changed else {})

    def mode_changes(self, transition: int, before: S, goal: Goal[S]) -> S:
        """Those of some states in which an edge changes the mode of an objective."""
        changed = self.space.nothing
        if not before:
            return changed
        # Wherever the objective goes on the set is the same for all events, so that spaces may remember it.
        after = self.space.after(before, [transition]) | goal.running
        for place in self.mode_places(goal, before):
            marking = self.space.restricted(after, [place], ())
            kept = self.space.before(marking, [transition]) & before if marking else marking
            was = self.space.restricted(before, [place], ())
            changed = changed | (was - kept) | (kept - was)
        return changed

    def mode_places(self, goal: Goal[S], states: S) -> list[int]:
        """What the mode of an objective is made of: alternatives and refusals of all that serves it."""
        serving, roles = self.prospects.serving[goal.name], self.net.roles
        return sorted(
            place
            for place in self.space.varying(states)
            if (role := roles.get(place))
            and role[0] in ("active", "wait", "refused")
            and role[1].split(".", 1)[0] in serving
        )

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

    # --- words -----------------------------------------------------------------------------------------

    def in_least_company(self, failures: Sequence[_Failures[S]]) -> list[_Failures[S]]:
        """The failures with the fewest other resources out of service: none, wherever that occurs."""
        for size in range(len(self.oos) + 1):
            few = self.space.at_most(dict.fromkeys(self.oos, 1), size)
            chosen = [_Failures(f.transition, f.before & few, f.severities) for f in failures]
            if any(failure.before for failure in chosen):
                return chosen
        raise AssertionError("no state has more hardware out of service than there is")

    def distinct(self, failures: Sequence[_Failures[S]], goal: Goal[S]) -> Iterator[tuple[int, Any]]:
        """A transition and a state before it for each different thing that the failure does."""
        for failure in failures:
            effects = [part for states in failure.severities.values() if (part := states & failure.before)]
            rest = failure.before
            for states in effects:
                rest = rest - states
            for states in [*effects, rest] if rest else effects:
                yield from self.by_mode(failure.transition, states, goal)

    def by_mode(self, transition: int, states: S, goal: Goal[S]) -> Iterator[tuple[int, Any]]:
        """A state for each pair of modes before and after."""
        space, places, images = self.space, self.mode_places(goal, states), self.prospects.images
        for _, before in partition(space, states, places, images):
            for _, after in partition(space, space.after(before, [transition]), places, images):
                yield transition, (space.before(after, [transition]) & before).pick()

    def case(self, hardware: str, state: Any, transition: int, goal: Goal[S]) -> _Case:
        space, repairs = self.space, self.prospects.carrying(What.REPAIRED, hardware)
        target = next(e.target for e in space.edges(state) if e.transition == transition)
        again = next((e.target for e in space.edges(target) if e.transition in repairs), target)
        lost = self.prospects.losing(goal, repairs=False)

        def holds(member: Any, region: S) -> bool:
            return bool(space.single(member) & region)

        before, after, back = (self.mode(member, goal) for member in (state, target, again))
        return _Case(
            before,
            after,
            back,
            holds(target, lost),
            holds(target, self.lost_unrepaired),
            holds(target, self.lost),
            holds(target, lost) and not holds(again, lost),
            holds(target, self.lost_unrepaired) and not holds(again, self.lost_unrepaired),
        )

    def mode(self, member: Any, goal: Goal[S]) -> Situation:
        """The part of a state's mode that concerns an objective."""
        states = self.space.single(member)
        places = self.mode_places(goal, states)
        ((marked, _),) = partition(self.space, states, places, self.prospects.images)
        said = self.prospects.said(marked)
        return Situation(
            mode=dict(name.split(".", 1) for name in said["active"]),
            waiting=dict(name.split(".", 1) for name in said["wait"]),
            refused=said["refused"],
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
