"""Failure causes as objects for JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from mcpn.answers.causes.find import Causes, GoalCauses, Survival
from mcpn.answers.causes.minimal_cut_sets import CutSet, Unaided
from mcpn.answers.causes.prospects import CriticalEvent
from mcpn.answers.claims import Claim
from mcpn.events import Event
from mcpn.report.failures.sentences import conditions, kept, losses, spared
from mcpn.spaces.run import Run

if TYPE_CHECKING:
    from mcpn.answers.causes.ends_by_time import Within
    from mcpn.answers.causes.risk import Risk


def causes_object(causes: Causes, claims: Sequence[Claim], *, runs: bool = True) -> dict[str, Any]:
    """Failure causes as an object for JSON.

    Args:
        causes: Failure causes of a mission.
        claims: On them.
        runs: Whether runs are computed and included; without them their keys are left out.

    Returns:
        ``objectives``, by qualified name, and ``mission``, each with ``cut_sets`` (sorted lists of hardware
        names), ``critical_events`` (names of events that cross into the losing region without repairs) and
        the details of both; ``claims`` on losses; ``survival``, from the start first, then from each section.
    """
    goals = [("mission", "defeat", causes.mission)]
    goals += [] if causes.safety is None else [("safety", "endanger", causes.safety)]
    return {
        **{key: _goal(goal, runs, _said(causes, claims, verb)) for key, verb, goal in goals},
        **({"unsafe_aborts": list(causes.unsafe_aborts)} if causes.unsafe_aborts else {}),
        "objectives": {
            name: _goal(goal, runs, conditions(goal, name)) for name, goal in causes.objectives.items()
        },
        "claims": [claim.to_json() for claim in claims],
        "survival": [_survival(found, runs) for found in causes.survival],
    }


def _said(causes: Causes, claims: Sequence[Claim], verb: str) -> list[str]:
    """Which losses do harm, or which do none, or why there are none."""
    return losses(claims, verb) or kept(claims, verb, causes.unused) or spared(causes, verb)


def left_out(objectives: int, what: Sequence[str]) -> list[dict[str, Any]]:
    """What the answer on a mission of many objectives does not hold, and how to ask for it.

    Args:
        objectives: How many there are.
        what: What it does not hold.
    """
    return [{"what": each, "objectives": objectives, "ask": _ASK[each]} for each in what]


EFFECTS, RUNS = "what each failure does during each objective", "the runs by which objectives are lost"
_ASK = {
    EFFECTS: "--objective NAME tells it of one, --fmeca FILE of all",
    RUNS: "--objective NAME shows those of one",
}


def _survival(found: Survival, runs: bool) -> dict[str, Any]:
    safety = found.safety
    return {
        "section": found.section,
        **_level(found, runs),
        **({} if safety is None else {"safety": _level(safety, runs)}),
    }


def _level(found: Survival, runs: bool) -> dict[str, Any]:
    return {
        "cut_sets": _lists(found.cut_sets),
        "always": found.always,
        "at_most": found.at_most,
        **({"run": _events(found.run)} if runs else {}),
    }


def _events(run: Run | None) -> list[str] | None:
    return None if run is None else [str(event) for event in run.events]


def _goal(goal: GoalCauses, runs: bool, said: Sequence[str]) -> dict[str, Any]:
    return {
        "cut_sets": _lists(goal.cut_sets),
        "critical_events": _texts(goal.critical_events),
        **({} if goal.unaided is None else {"unaided": _unaided(goal.unaided)}),
        "condition": " ".join(said),
        "moments": {moment: _lists(cut_sets) for moment, cut_sets in goal.moments.items()},
        "critical": {
            "without_repairs": _all_critical(goal.critical),
            "with_repairs": _all_critical(goal.critical_with_repairs),
        },
        **({"runs": _runs(goal)} if runs else {}),
        "monotone": goal.nonmonotone is None,
    }


def _unaided(found: Unaided) -> dict[str, Any]:
    return {"cut_sets": _lists(found.cut_sets), "helpers": list(found.helpers)}


def _runs(goal: GoalCauses) -> list[dict[str, Any]]:
    return [{"cut_set": list(names), "events": _events(run)} for names, run in goal.runs.items()]


def _texts(events: Sequence[Event]) -> list[str]:
    return [str(event) for event in events]


def _all_critical(found: Sequence[CriticalEvent]) -> list[dict[str, Any]]:
    return [_critical(critical) for critical in found]


def _critical(critical: CriticalEvent) -> dict[str, Any]:
    return {
        "event": str(critical.event),
        "objectives": list(critical.objectives),
        "mode": critical.mode,
        "edges": critical.edges,
    }


def _lists(cut_sets: Sequence[CutSet]) -> list[list[str]]:
    return [list(names) for names in cut_sets]


def risk_object(numbers: Risk) -> dict[str, Any]:
    """Numbers of risk as an object for JSON; those of aborts are left out where the mission cannot abort."""
    return given(numbers)


def given(numbers: Risk | Within) -> dict[str, Any]:
    """Numbers as an object for JSON, without those that there are none of."""
    return {name: value for name, value in asdict(numbers).items() if value is not None}
