"""Failure causes as objects for JSON, rows for CSV, and tables on a terminal."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcpn.check.causes.cutsets import CutSet
from mcpn.check.causes.effects import Severity
from mcpn.check.causes.find import Causes, GoalCauses, Survival
from mcpn.check.causes.fmeca import Row
from mcpn.check.causes.prospects import CriticalEvent
from mcpn.errors import InputError, Source
from mcpn.files import write_atomically
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event
from mcpn.report.terminal import Terminal
from mcpn.report.text import print_counts, print_steps
from mcpn.report.words import in_words, what_happens
from mcpn.sentences import enumeration
from mcpn.space.run import Run

if TYPE_CHECKING:
    from mcpn.check.causes.risk import Risk

Classes = Mapping[Severity, str]
"""A user's own names of the severity classes."""

STANDARD: Classes = {severity: severity.words for severity in Severity}

COLUMNS = (
    "hardware",
    "objective",
    "section",
    "local_effect",
    "objective_effect",
    "mission_effect",
    "detection",
    "compensation",
    "recovery",
    "severity",
    "with_others",
)


def safe(name: str, cut_sets: Sequence[CutSet]) -> str:
    """When a mission can end neither in success nor in abort, by its minimal cut sets.

    >>> safe("survey", [("motor",)])
    'survey can end neither in success nor in abort if motor'
    """
    if not cut_sets:
        return f"{name} can succeed or be aborted whatever hardware fails"
    if () in cut_sets:
        return f"{name} can never succeed nor be aborted"
    lost = ", or if ".join(map(enumeration, cut_sets))
    return f"{name} can end neither in success nor in abort if {lost}"


def condition(name: str, cut_sets: Sequence[CutSet]) -> str:
    """When something fails, by its minimal cut sets.

    >>> condition("going_up", [("thruster_actuator",), ("GPS_sensor", "IMU_sensor")])
    'going_up fails if thruster_actuator, or if GPS_sensor and IMU_sensor'
    >>> condition("filming", [])
    'filming can succeed whatever hardware fails'
    """
    if not cut_sets:
        return f"{name} can succeed whatever hardware fails"
    if () in cut_sets:
        return f"{name} can never succeed"
    return f"{name} fails if " + ", or if ".join(map(enumeration, cut_sets))


# --- objects -------------------------------------------------------------------------------------------


def causes_object(causes: Causes, *, runs: bool = True) -> dict[str, Any]:
    """Failure causes as what JSON holds.

    Args:
        causes: Failure causes of a mission.
        runs: Whether runs are looked for and told; without them their keys are left out.

    Returns:
        ``objectives``, by qualified name, and ``mission``, each with ``cut_sets`` (sorted lists of hardware
        names), ``critical_events`` (names of events that cross into the losing region without repairs) and
        what stands behind them; ``survival``, the start first, then each section.
    """
    return {
        "mission": _goal(causes.mission, runs),
        **({} if causes.safety is None else {"safety": _goal(causes.safety, runs, of=safe)}),
        "objectives": {name: _goal(goal, runs) for name, goal in causes.objectives.items()},
        "survival": [
            {
                "section": found.section,
                "cut_sets": _lists(found.cut_sets),
                "always": found.always,
                "at_most": found.at_most,
                **({"run": _events(found.run)} if runs else {}),
            }
            for found in causes.survival
        ],
    }


def _events(run: Run | None) -> list[str] | None:
    return None if run is None else [str(event) for event in run.events]


def _goal(
    goal: GoalCauses, runs: bool, of: Callable[[str, Sequence[CutSet]], str] = condition
) -> dict[str, Any]:
    return {
        "cut_sets": _lists(goal.cut_sets),
        "critical_events": _texts(goal.critical_events),
        "condition": of(goal.name, goal.cut_sets),
        "moments": {moment: _lists(cut_sets) for moment, cut_sets in goal.moments.items()},
        "critical": {
            "without_repairs": _all_critical(goal.critical),
            "with_repairs": _all_critical(goal.critical_with_repairs),
        },
        **({"runs": _runs(goal)} if runs else {}),
        "monotone": goal.nonmonotone is None,
    }


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


# --- FMECA ---------------------------------------------------------------------------------------------


def fmeca_rows(rows: Sequence[Row], classes: Classes = STANDARD) -> list[dict[str, str]]:
    """The table as texts, by column.

    Args:
        rows: The table.
        classes: Names of severities.
    """
    return [
        {
            **{column: str(getattr(row, column)) for column in COLUMNS[:-2]},
            "severity": classes[row.severity],
            "with_others": "; ".join(
                f"{classes[severity]} with {' or with '.join(map(enumeration, sets))}"
                for severity, sets in row.with_others
            ),
        }
        for row in rows
    ]


def check_table_name(path: Path) -> None:
    """Whether a table can be written to a file of this name.

    Raises:
        InputError: Its suffix is neither ``.csv`` nor ``.json``.
    """
    if path.suffix.lower() not in (".csv", ".json"):
        raise InputError.at(Source(str(path)), f"found the suffix {path.suffix!r}, expected .csv or .json")


def save_fmeca(rows: Sequence[Row], path: Path, classes: Classes = STANDARD) -> None:
    """Writes the table, whole or not at all.

    Args:
        rows: The table.
        path: A file ``.csv`` or ``.json``.
        classes: Names of severities.

    Raises:
        InputError: Another suffix, or the file cannot be written.
    """
    check_table_name(path)
    told = fmeca_rows(rows, classes)
    if path.suffix.lower() == ".csv":
        text = io.StringIO(newline="")
        writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(told)
        write_atomically(path, text.getvalue())
    else:
        write_atomically(path, json.dumps(told, ensure_ascii=False, indent=1) + "\n")


# --- terminal ------------------------------------------------------------------------------------------


def print_causes(causes: Causes) -> None:
    """Prints conditions of failure, what is survived, runs to failure, and critical events."""
    terminal = Terminal()
    terminal.print(condition(causes.mission.name, causes.mission.cut_sets), style="bold")
    if causes.safety is not None:
        terminal.print(safe(causes.safety.name, causes.safety.cut_sets), style="bold")
    shared: dict[tuple[CutSet, ...], list[str]] = {}
    for name, goal in causes.objectives.items():
        shared.setdefault(tuple(goal.cut_sets), []).append(name)
    for cut_sets, names in shared.items():
        told = condition(", ".join(names), cut_sets)
        if len(names) > 1:
            told = told.replace(" fails if ", " fail if ")
        terminal.print(told, indent=2)
    terminal.print()
    _print_survival(terminal, causes.survival)
    for lost, run in causes.mission.runs.items():
        what = f"failure by {enumeration(lost)}" if lost else "failure without any loss"
        _print_run(terminal, causes.mission_net, what, run)
    most = causes.survival[0].run
    _print_run(terminal, causes.mission_net, "success in spite of the most failures", most)
    _print_critical(terminal, causes)
    for goal in (causes.mission, *causes.objectives.values()):
        if goal.nonmonotone is not None:
            fewer = enumeration(goal.nonmonotone.lost or ("nothing",))
            more = enumeration(goal.nonmonotone.larger)
            told = f"{goal.name} may be lost with {fewer}, but not with {more}"
            terminal.print(f"not monotone: {told}", style="yellow")


def _print_survival(terminal: Terminal, survival: Sequence[Survival]) -> None:
    """Moments that survive the same stand together."""
    shared: dict[tuple[tuple[CutSet, ...], int | None, int | None], list[str | None]] = {}
    for found in survival:
        shared.setdefault((tuple(found.cut_sets), found.always, found.at_most), []).append(found.section)
    terminal.print("what the mission survives", style="bold")
    for (cut_sets, always, at_most), sections in shared.items():
        if len(shared) == 1:
            moments = "at any moment"
        else:
            named = ", ".join(name for name in sections if name)
            moments = " and ".join(
                [*(["from its start"] if None in sections else []), *([f"from {named} on"] if named else [])]
            )
        losses = ", or of ".join(enumeration(names) for names in cut_sets if names)
        if always is None or at_most is None:
            told = "the mission can no longer succeed"
        elif not losses:
            told = "no loss of hardware defeats the mission"
        else:
            told = f"the loss of {losses} defeats it; it survives {_survived(always, at_most)}"
        terminal.print(f"{moments}: {told}", indent=2)


def _survived(always: int, at_most: int) -> str:
    def losses(number: int) -> str:
        return "1 loss" if number == 1 else f"{number} losses"

    if always == at_most:
        return f"any {losses(always)}" if always else "none"
    return f"at most {losses(at_most)}, and " + (
        f"any {losses(always)}" if always else "not every loss by itself"
    )


def _print_run(terminal: Terminal, mission_net: MissionNet, what: str, run: Run | None) -> None:
    if run is None:
        return
    terminal.print()
    terminal.print(f"{what}:", style="bold")
    print_steps(terminal, in_words(mission_net, run), indent=2)


def _print_critical(terminal: Terminal, causes: Causes) -> None:
    """Events that decide, those that do so at the same moments together, with their identifiers."""
    during: dict[Event, dict[str, None]] = {}
    for critical in causes.mission.critical or ():
        during.setdefault(critical.event, {}).update(dict.fromkeys(critical.objectives or ("",)))
    if not during:
        return
    shared: dict[frozenset[str], list[Event]] = {}
    for event, objectives in during.items():
        shared.setdefault(frozenset(objectives), []).append(event)
    terminal.print()
    terminal.print("critical events: after them nothing but repair can help", style="bold")
    everything = frozenset((*causes.objectives, ""))
    for moments, events in shared.items():
        for event in events:
            terminal.print(f"{what_happens(event, causes.mission.name)}  [{event}]", indent=2)
        names = sorted(moments - {""})
        if moments == everything:
            told = "at any moment"
        elif not names:
            told = "while no objective runs"
        else:
            running = f"{names[0]} runs" if len(names) == 1 else f"one of these runs: {', '.join(names)}"
            told = f"while {running}{', or none' if '' in moments else ''}"
        terminal.print(told, indent=6)


def print_fmeca(rows: Sequence[Row], classes: Classes = STANDARD) -> None:
    """Prints the table in short: what fails while what runs, what happens, how bad it is.

    Objectives on which a resource has the same effect stand together.
    """
    terminal = Terminal()
    shared: dict[str, dict[tuple[str, str, str], list[str]]] = {}
    for row, told in zip(rows, fmeca_rows(rows, classes), strict=True):
        leads = [t for t in row.compensation.split("; or ") if t.startswith("its failure")]
        effects = [t for t in (row.local_effect, *leads) if t != "none"]
        key = told["severity"], told["with_others"], "; ".join(effects)
        shared.setdefault(row.hardware, {}).setdefault(key, []).append(row.objective)
    for hardware, effects_of in shared.items():
        terminal.print()
        terminal.print(f"if {hardware} fails", style="bold")
        nothing = classes[Severity.NO_EFFECT], "", ""
        for (severity, with_others, effect), objectives in effects_of.items():
            if (severity, with_others, effect) == nothing and len(effects_of) > 1:
                continue
            terminal.print(f"during {', '.join(objectives)}", indent=2)
            terminal.print(severity + (f"; {with_others}" if with_others else ""), indent=6)
            if effect:
                terminal.print(effect, indent=6)
        if nothing in effects_of and len(effects_of) > 1:
            terminal.print(f"during all others: {nothing[0]}", indent=2)


def print_risk(numbers: Risk) -> None:
    """Prints probabilities, degraded modes and importances, and which events do not count in them."""
    counts = {
        "success": numbers.success,
        "failure": numbers.failure,
        "degraded modes": numbers.degraded_modes,
    }
    for hardware, value in sorted(numbers.importance.items(), key=lambda pair: -pair[1]):
        counts[f"importance of {hardware}"] = value
    print_counts({name: f"{value:.6g}" for name, value in counts.items()})
    if numbers.unrated:
        Terminal().print(without_a_rate(numbers))


def without_a_rate(numbers: Risk) -> str:
    """Says of events without a rate that the numbers leave them out."""
    several = len(numbers.unrated) > 1
    names = f"event{'s' * several} {', '.join(numbers.unrated)}"
    return f"{names} {'have' if several else 'has'} no rate: not counted in these numbers"
