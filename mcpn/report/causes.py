"""Failure causes as objects for JSON, rows for CSV, and tables on a terminal."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from mcpn.check.causes.conditions import enumeration, sentence
from mcpn.check.causes.cutsets import CutSet
from mcpn.check.causes.find import Causes, GoalCauses
from mcpn.check.causes.fmeca import Row, Severity
from mcpn.check.causes.prospects import CriticalEvent
from mcpn.check.causes.risk import Risk
from mcpn.errors import InputError, Source
from mcpn.files import write_atomically
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event
from mcpn.report.terminal import terminal
from mcpn.report.words import in_words
from mcpn.space.run import Run

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


def _goal(goal: GoalCauses, runs: bool) -> dict[str, Any]:
    return {
        "cut_sets": _lists(goal.cut_sets),
        "critical_events": _texts(goal.critical_events),
        "condition": sentence(goal.name, goal.cut_sets),
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
    console = terminal()
    console.print(sentence(causes.mission.name, causes.mission.cut_sets), style="bold")
    for name, goal in causes.objectives.items():
        console.print(f"  {sentence(name, goal.cut_sets)}")
    console.print()
    table = Table("from the entry of", "the mission is lost with", "survives any", "at most")
    for found in causes.survival:
        lost = "\n".join(enumeration(names) if names else "nothing more" for names in found.cut_sets)
        counts = ["-" if n is None else str(n) for n in (found.always, found.at_most)]
        table.add_row(found.section or "the start", lost or "no loss of hardware", *counts)
    console.print(table)
    for names, run in causes.mission.runs.items():
        what = f"by {enumeration(names)}" if names else "without any loss of hardware"
        _print_run(console, causes.mission_net, f"failure {what}", run)
    most = causes.survival[0].run
    _print_run(console, causes.mission_net, "success in spite of the most failures", most)
    _print_critical(console, causes.mission)
    for goal in (causes.mission, *causes.objectives.values()):
        if goal.nonmonotone is not None:
            lost = enumeration(goal.nonmonotone.lost or ("nothing",))
            larger = enumeration(goal.nonmonotone.larger)
            told = f"{goal.name} may be lost with {lost}, but not with {larger}"
            console.print(f"not monotone: {told}", style="yellow")


def _print_run(console: Console, mission_net: MissionNet, what: str, run: Run | None) -> None:
    if run is None:
        return
    console.print(f"\n{what}:")
    for event, words in in_words(mission_net, run):
        console.print(f"    {event!s:34} {words}")


def _print_critical(console: Console, goal: GoalCauses) -> None:
    during: dict[str, dict[str, None]] = {}
    for critical in goal.critical:
        during.setdefault(str(critical.event), {}).update(
            dict.fromkeys(critical.objectives or ("no objective",))
        )
    if during:
        table = Table("critical event: after it nothing but repair can help", "while one of these runs")
        for event, objectives in during.items():
            table.add_row(event, "\n".join(objectives))
        console.print()
        console.print(table)


def print_fmeca(rows: Sequence[Row], classes: Classes = STANDARD) -> None:
    """Prints the table in short: what fails where, what happens, how bad it is.

    Objectives on which a resource has the same effect share a line.
    """
    table = Table()
    for header in ("hardware", "objectives", "effect and compensation", "severity", "worse in company"):
        table.add_column(header, overflow="fold")
    shared: dict[tuple[str, ...], list[str]] = {}
    for row, told in zip(rows, fmeca_rows(rows, classes), strict=True):
        effects = [t for t in (row.local_effect, row.compensation) if t not in ("none", "none needed")]
        key = row.hardware, "; ".join(effects), told["severity"], told["with_others"]
        shared.setdefault(key, []).append(row.objective)
    for (hardware, *cells), objectives in shared.items():
        table.add_row(hardware, "\n".join(objectives), *cells)
    terminal().print(table)


def print_risk(numbers: Risk) -> None:
    """Prints probabilities, degraded modes and importances."""
    table = Table(show_header=False, box=None, pad_edge=False)
    for name, value in asdict(numbers).items():
        if name != "importance":
            table.add_row(name.replace("_", " "), f"{value:.6g}")
    for hardware, value in sorted(numbers.importance.items(), key=lambda pair: -pair[1]):
        table.add_row(f"importance of {hardware}", f"{value:.6g}")
    terminal().print(table)
