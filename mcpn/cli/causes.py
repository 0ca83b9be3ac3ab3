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
from mcpn.errors import InputError, LimitError

if TYPE_CHECKING:
    from mcpn.check.losing import Outlook
    from mcpn.net.compose import MissionNet
    from mcpn.report.causes import Classes


@click.command()
@click.argument("mission", type=FILE)
@click.option("--engine", type=click.Choice(["explicit", "local"]), default="explicit", show_default=True)
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
    engine: str,
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
    """Tell what makes MISSION fail: minimal sets of lost hardware, critical events, what each loss does.

    The engine local glues graphs of the mission's sections and needs no graph of the whole; runs, the FMECA
    table and numbers of risk are of the engine explicit.
    """
    from dataclasses import asdict

    from mcpn.check.causes import find_causes, find_causes_locally
    from mcpn.check.conditions import minimal_formula
    from mcpn.check.fmeca import fmeca as table_of
    from mcpn.files import write_atomically
    from mcpn.report import causes as report
    from mcpn.report.openpsa import open_psa

    started = time.perf_counter()
    classes = _classes(severities)
    if fmeca is not None:
        report.check_table_name(fmeca)
    mission_net = mission_net_of(mission, import_root)
    limits = {} if max_states is None else {"max_states": max_states}
    outlook = None
    if engine == "explicit":
        outlook = _outlook(mission_net, limits, as_json)
        every = find_causes(mission_net, outlook)
    else:
        for option, given in (("--fmeca", fmeca is not None), ("--rates", rates)):
            if given:
                raise InputError.at(None, f"{option} needs the graph of the whole mission: --engine explicit")
        every = find_causes_locally(mission_net, **limits)
    found = every.of(objectives) if objectives else every
    goals = {found.mission.name: found.mission, **found.objectives}
    formulas = {name: minimal_formula(goal.cut_sets).text for name, goal in goals.items()} if formula else {}
    rows = table_of(outlook) if outlook else []
    numbers = None
    if outlook and rates:
        from mcpn.check.risk import risk

        numbers = risk(outlook)
    if openpsa is not None:
        cut_sets = {name: goal.cut_sets for name, goal in every.objectives.items()}
        write_atomically(openpsa, open_psa(mission_net.usage, every.mission.cut_sets, cut_sets))
    if fmeca is not None:
        report.save_fmeca(rows, fmeca, classes)
    if as_json:
        document: dict[str, Any] = report.causes_object(found)
        if formulas:
            document["formulas"] = formulas
        if numbers is not None:
            document["risk"] = asdict(numbers)
        emit_json(document | {"engine": engine, "seconds": time.perf_counter() - started})
        return
    report.print_causes(found)
    for name, text in formulas.items():
        click.echo(f"{name}: {text}")
    if rows:
        report.print_fmeca([r for r in rows if not objectives or r.objective in objectives], classes)
    if numbers is not None:
        report.print_risk(numbers)


def _outlook(mission_net: MissionNet, limits: dict[str, int], quiet: bool) -> Outlook:
    """The mission on its alternatives graph, unless that is bound to be too large."""
    from mcpn.check.losing import Outlook
    from mcpn.space.alternatives import DEFAULT_MAX_STATES
    from mcpn.space.confluence import direct_with_proof

    # Before the mission begins any set of hardware may be out of service, each in a stable state of its own.
    faulty = sum(h.faulty for h in mission_net.mission.hardware)
    most = limits.get("max_states", DEFAULT_MAX_STATES)
    if 2**faulty > most:
        found = (
            f"{faulty} hardware resources that may fail have 2^{faulty} states, the limit on states is {most}"
        )
        raise LimitError(f"{found}: use --engine local")
    with progress_line(quiet) as progress:
        return Outlook(mission_net, direct_with_proof(mission_net.net, progress=progress, **limits))


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
