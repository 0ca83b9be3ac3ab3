"""Failure causes on a terminal: what losses cost, runs that show it, critical events, FMECA."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from mcpn.answers.causes.effects import Severity
from mcpn.answers.causes.effects import in_words as cell_words
from mcpn.answers.causes.find import Causes
from mcpn.answers.causes.fmeca import Row
from mcpn.answers.causes.minimal_cut_sets import CutSet
from mcpn.answers.claims.claim import Claim, sentences
from mcpn.answers.claims.unasked import MOST_TOLD, run_of
from mcpn.drawing.compose import MissionNet
from mcpn.report.failures.fmeca_table import ALONE, STANDARD, Classes, fmeca_rows
from mcpn.report.failures.sentences import (
    at_worst,
    critical,
    headlines,
    of_objectives,
    survived,
)
from mcpn.report.terminal import Terminal
from mcpn.report.text import print_steps
from mcpn.report.words import folded, in_words, of_all_copies
from mcpn.sentences import enumeration
from mcpn.spaces.run import Run

LAST = "from here on there is no way without a repair, and the mission need not end"
"""Behind a run that ends where a goal is out of reach, and the mission has not ended."""


def print_causes(causes: Causes, claims: Sequence[Claim]) -> None:
    """Prints the claims on losses, runs that show some of them, what is survived, and critical events.

    Args:
        causes: Of a mission, or of some of its objectives.
        claims: On them.
    """
    terminal, mission_net = Terminal(), causes.mission_net
    for said in headlines(causes, claims):
        terminal.print(said, style="bold")
    _print_sentences(terminal, "objectives", of_objectives(causes))
    _print_survival(terminal, causes)
    for said in sentences(claim for claim in claims if claim.kind == "used" and not claim.holds):
        terminal.print(said, indent=2)
    goals = [("success", causes.mission)]
    goals += [] if causes.safety is None else [("a safe end", causes.safety)]
    for end, goal in goals:
        for lost, run in goal.runs.items():
            _print_run(
                terminal, causes.mission_net, f"a run {_by(lost)} to where there is no way to {end}", run
            )
    for verb in ("defeat", "endanger"):
        for claim in at_worst(claims, verb)[:MOST_TOLD]:
            if (shown := run_of(claim)) is not None:
                terminal.print()
                terminal.print(claim.sentence, style="bold")
                terminal.print(f"by {shown.words}", indent=2, hang=2)
    start = causes.survival[0]
    _print_run(terminal, mission_net, "a run to success with the most losses", start.run)
    if start.safety is not None and start.safety.run != start.run:
        _print_run(terminal, mission_net, "a run to a safe end with the most losses", start.safety.run)
    for verb in ("defeat", "endanger"):
        heading = "critical events" if verb == "defeat" else "critical events for a safe end"
        _print_sentences(terminal, heading, critical(causes, claims, verb))


def _print_sentences(terminal: Terminal, heading: str, told: Iterable[str]) -> None:
    """Sentences below a heading, where there are some."""
    for number, said in enumerate(told):
        if not number:
            terminal.print()
            terminal.print(heading, style="bold")
        terminal.print(said, indent=2, hang=2)


def _print_survival(terminal: Terminal, causes: Causes) -> None:
    """Moments at which the same is survived stand together; nothing where nothing may be lost."""
    moments_told = [(moments, told) for moments, told in survived(causes) if told]
    if not moments_told:
        return
    terminal.print()
    unaided = [goal.unaided for goal in (causes.mission, causes.safety) if goal is not None]
    helpers = enumeration([*dict.fromkeys(name for each in unaided if each for name in each.helpers)])
    with_help = f", with the help of {helpers}" if helpers else ""
    terminal.print(f"what the mission survives{with_help}", style="bold")
    for moments, told in moments_told:
        terminal.print(moments, indent=2, hang=2)
        for said in told:
            terminal.print(said, indent=6)


def _by(lost: CutSet) -> str:
    return f"with the loss of {enumeration(lost)}" if lost else "without any loss"


def _print_run(terminal: Terminal, mission_net: MissionNet, what: str, run: Run | None) -> None:
    if run is None:
        return
    terminal.print()
    terminal.print(f"{what}:", style="bold")
    steps = list(in_words(mission_net, run))
    print_steps(terminal, steps, indent=2)
    if not any("the mission ends in" in words for _, words in steps):
        terminal.print(LAST, indent=2, style="dim")


def print_left_out(found: Sequence[Mapping[str, Any]]) -> None:
    """Prints what the answer on a mission of many objectives does not hold, and how to ask for it."""
    for each in found:
        said = f"of {each['objectives']} objectives this is not told: {each['what']}; {each['ask']}"
        Terminal().print(said, style="yellow")


def print_fmeca(rows: Sequence[Row], mission_net: MissionNet, classes: Classes = STANDARD) -> None:
    """Prints the table in short: what fails while what runs, what happens, how bad it is.

    Objectives on which a resource has the same effect stand together, their rounds and tries as one.

    Args:
        rows: The table.
        mission_net: The mission's net.
        classes: Names of severities.
    """
    terminal = Terminal()
    shared: dict[str, dict[tuple[str, str, str], list[str]]] = {}
    for row, told in zip(rows, fmeca_rows(rows, classes), strict=True):
        routes = (told for told in row.columns["compensation"] if told[0].kind.startswith("failure_"))
        leads = [cell_words((told,)) for told in routes]
        effects = [t for t in (row.local_effect, *leads) if t != "none"]
        effect = of_all_copies(mission_net, "; ".join(effects))
        key = told["severity"], told["with_others"], effect
        shared.setdefault(row.hardware, {}).setdefault(key, []).append(row.objective)
    terminal.print()
    terminal.print("what each failure does", style="bold")
    terminal.print(ALONE, indent=2)
    for hardware, effects_of in shared.items():
        terminal.print()
        terminal.print(f"if {hardware} fails", style="bold")
        nothing = classes[Severity.NO_EFFECT], "", ""
        for (severity, with_others, effect), objectives in effects_of.items():
            if (severity, with_others, effect) == nothing and len(effects_of) > 1:
                continue
            terminal.print(f"during {', '.join(folded(mission_net, objectives))}", indent=2)
            terminal.print(severity + (f"; {with_others}" if with_others else ""), indent=6)
            if effect:
                terminal.print(effect, indent=6)
        if nothing in effects_of and len(effects_of) > 1:
            terminal.print(f"during all others: {nothing[0]}", indent=2)
