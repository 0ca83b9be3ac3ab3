"""Failure causes: cut sets, critical events, FMECA, fault trees, numbers of risk."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn.cli.shared import (
    FILE,
    emit_json,
    import_option,
    json_option,
    limit_option,
    mission_net_of,
    progress_line,
)
from mcpn.errors import InputError

if TYPE_CHECKING:
    from mcpn.report.causes import Classes


@click.command()
@click.argument("mission", type=FILE)
@click.option(
    "--objective", "objectives", multiple=True, metavar="NAME", help="Look at this objective alone."
)
@click.option("--fmeca", type=FILE, help="Write the FMECA table: .csv or .json.")
@click.option("--openpsa", type=FILE, help="Write a fault tree in the Open-PSA format (XML).")
@click.option(
    "--rates", is_flag=True, help="Compute probabilities from the rates and durations of the mission."
)
@click.option("--formula", is_flag=True, help="Prove each condition a minimal formula (needs mcpn[pyeda]).")
@click.option(
    "--severity",
    "severities",
    multiple=True,
    metavar="CLASS=NAME",
    help='A name of your own for a severity class, for example "mission lost=I".',
)
@limit_option
@import_option
@json_option
def causes(
    mission: Path,
    objectives: tuple[str, ...],
    fmeca: Path | None,
    openpsa: Path | None,
    rates: bool,
    formula: bool,
    severities: tuple[str, ...],
    max_states: int | None,
    import_root: Path | None,
    as_json: bool,
) -> None:
    """Tell what makes MISSION fail: minimal sets of lost hardware, critical events, what each loss does."""
    from mcpn.check.causes import find_causes
    from mcpn.check.conditions import minimal_formula
    from mcpn.check.fmeca import fmeca as table_of
    from mcpn.check.risk import risk
    from mcpn.files import write_atomically
    from mcpn.report import causes as report
    from mcpn.report.openpsa import open_psa
    from mcpn.space.confluence import direct_with_proof

    started = time.perf_counter()
    classes = _classes(severities)
    mission_net = mission_net_of(mission, import_root)
    with progress_line(as_json) as progress:
        limits = {} if max_states is None else {"max_states": max_states}
        graph = direct_with_proof(mission_net.net, progress=progress, **limits)
    found = find_causes(mission_net, graph, objectives or None)
    goals = {found.mission.name: found.mission, **found.objectives}
    formulas = {name: minimal_formula(goal.cut_sets).text for name, goal in goals.items()} if formula else {}
    rows = table_of(found.outlook)
    numbers = risk(found.outlook) if rates else None
    if openpsa is not None:
        every = found if not objectives else find_causes(mission_net, graph)
        cut_sets = {name: goal.cut_sets for name, goal in every.objectives.items()}
        write_atomically(openpsa, open_psa(mission_net.usage, every.mission.cut_sets, cut_sets))
    if fmeca is not None:
        report.save_fmeca(rows, fmeca, classes)
    if as_json:
        from dataclasses import asdict

        document: dict[str, Any] = report.causes_object(found)
        if formulas:
            document["formulas"] = formulas
        if numbers is not None:
            document["risk"] = asdict(numbers)
        document["seconds"] = time.perf_counter() - started
        emit_json(document)
        return
    report.print_causes(found)
    for name, text in formulas.items():
        click.echo(f"{name}: {text}")
    report.print_fmeca([row for row in rows if not objectives or row.objective in objectives], classes)
    if numbers is not None:
        report.print_risk(numbers)


def _classes(given: tuple[str, ...]) -> Classes:
    """Severity classes with the names that the user gives."""
    from mcpn.check.fmeca import Severity
    from mcpn.report.causes import STANDARD

    known = {severity.words: severity for severity in Severity}
    classes = dict(STANDARD)
    for text in given:
        words, equals, name = text.partition("=")
        if words not in known or not equals:
            expected = ", ".join(f"{k}=NAME" for k in known)
            raise InputError.at(None, f"found --severity {text!r}, expected one of {expected}")
        classes[known[words]] = name
    return classes
