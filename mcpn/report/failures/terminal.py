"""Failure causes on a terminal."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import TYPE_CHECKING

from mcpn.answers.causes.cutsets import CutSet
from mcpn.answers.causes.effects import Severity
from mcpn.answers.causes.find import Causes, GoalCauses
from mcpn.answers.causes.fmeca import Row
from mcpn.drawing.compose import MissionNet
from mcpn.events import ENDING, Event, What
from mcpn.report.failures.tables import STANDARD, Classes, fmeca_rows
from mcpn.report.terminal import Terminal
from mcpn.report.text import print_counts, print_steps
from mcpn.report.words import folded, in_words, of_all_copies, what_happens
from mcpn.sentences import enumeration
from mcpn.spaces.run import Run

if TYPE_CHECKING:
    from mcpn.answers.causes.interval_bounds import Within
    from mcpn.answers.causes.risk import Risk
from mcpn.report.failures.sentences import (
    IMPORTANCE,
    condition,
    headlines,
    ranked,
    risk_counts,
    survived,
    without_a_rate,
)

LEADS = "critical events for {0}: after them, in some states, no run without a repair leads to {0}"


def print_causes(causes: Causes) -> None:
    """Prints conditions of failure, what is survived, runs to failure, and critical events."""
    terminal, mission_net = Terminal(), causes.mission_net
    for told in headlines(causes):
        terminal.print(told, style="bold")
    shared: dict[tuple[CutSet, ...], list[str]] = {}
    for name, goal in causes.objectives.items():
        shared.setdefault(tuple(goal.cut_sets), []).append(name)
    for cut_sets, names in shared.items():
        terminal.print(condition(", ".join(folded(mission_net, names)), cut_sets), indent=2)
    terminal.print()
    _print_survival(terminal, causes)
    safety = causes.safety
    ends = [("failure" if safety is None else "no success", causes.mission)]
    ends += [] if safety is None else [("no safe end", safety)]
    for end, goal in ends:
        for lost, run in goal.runs.items():
            _print_run(terminal, mission_net, f"{end} {_by(lost)}", run)
    start = causes.survival[0]
    _print_run(terminal, mission_net, "success in spite of the most failures", start.run)
    if start.safety is not None and start.safety.run != start.run:
        _print_run(terminal, mission_net, "a safe end in spite of the most failures", start.safety.run)
    _print_critical(terminal, causes, causes.mission, LEADS.format("success"))
    if safety is not None:
        _print_critical(terminal, causes, safety, LEADS.format("a safe end"))
    for goal in (causes.mission, *causes.objectives.values()):
        if goal.nonmonotone is not None:
            fewer = enumeration(goal.nonmonotone.lost or ("nothing",))
            more = enumeration(goal.nonmonotone.larger)
            told = f"{goal.name} may be lost with {fewer}, but not with {more}"
            terminal.print(f"not monotone: {told}", style="yellow")


def _print_survival(terminal: Terminal, causes: Causes) -> None:
    """Moments that survive the same stand together."""
    shared: dict[tuple[str, ...], list[str | None]] = {}
    for found in causes.survival:
        shared.setdefault(tuple(survived(found)), []).append(found.section)
    unaided = [goal.unaided for goal in (causes.mission, causes.safety) if goal is not None]
    helped = any(each is not None and each.helpers for each in unaided)
    terminal.print(f"what the mission survives{', with this help' * helped}", style="bold")
    for told, sections in shared.items():
        if len(shared) == 1:
            moments = "from its start and from each section on"
        else:
            named = ", ".join(_sections(causes.mission_net, [name for name in sections if name]))
            moments = " and ".join(
                [*(["from its start"] if None in sections else []), *([f"from {named} on"] if named else [])]
            )
        terminal.print(f"{moments}: {told[0]}", indent=2)
        for further in told[1:]:
            terminal.print(further, indent=6)
    if causes.unused:
        terminal.print(f"never used, so that its loss costs nothing: {', '.join(causes.unused)}", indent=2)


def _sections(mission_net: MissionNet, names: Sequence[str]) -> list[str]:
    """Sections by name, their copies together; one may be a parallel block."""
    return mission_net.graph.copies.told(names, [s.name for s in mission_net.graph.sections])


def _by(lost: CutSet) -> str:
    return f"by {enumeration(lost)}" if lost else "without any loss"


def _print_run(terminal: Terminal, mission_net: MissionNet, what: str, run: Run | None) -> None:
    if run is None:
        return
    terminal.print()
    terminal.print(f"{what}:", style="bold")
    steps = list(in_words(mission_net, run))
    print_steps(terminal, steps, indent=2)
    if not any("the mission ends in" in words for _, words in steps):
        terminal.print(
            "from here on no run without a repair helps; the mission need not end", indent=2, style="dim"
        )


def _print_critical(terminal: Terminal, causes: Causes, goal: GoalCauses, heading: str) -> None:
    """Events that decide, those that do so at the same moments together, with their identifiers.

    Ends of objectives need no moments: they come while the objective runs. Those of one kind stand together.
    """
    for_good = {critical.event for critical in goal.critical_with_repairs}
    during: dict[Event, dict[str, None]] = {}
    for critical in goal.critical or ():
        during.setdefault(critical.event, {}).update(dict.fromkeys(critical.objectives or ("",)))
    if not during:
        return
    terminal.print()
    terminal.print(heading, style="bold")
    shared: dict[frozenset[str], list[Event]] = {}
    ends: dict[tuple[What, str], list[Event]] = {}
    for event, objectives in during.items():
        if event.what in ENDING and event.element in causes.objectives:
            ends.setdefault((event.what, event.reason), []).append(event)
        else:
            shared.setdefault(frozenset(objectives), []).append(event)
    for moments, events in shared.items():
        for event in events:
            never = ", and in some no repair helps" * (event in for_good)
            terminal.print(f"{what_happens(event, causes.mission.name)}{never}  [{event}]", indent=2)
        terminal.print(_moments_in_words(causes, moments), indent=6)
    for events in ends.values():
        first = what_happens(events[0], causes.mission.name)
        if len(events) == 1:
            terminal.print(f"{first}  [{events[0]}]", indent=2)
            continue
        names = folded(causes.mission_net, [event.element for event in events])
        terminal.print(first.replace(f"objective {events[0].element}", "one of these objectives"), indent=2)
        terminal.print(", ".join(names), indent=6)


def _moments_in_words(causes: Causes, moments: frozenset[str]) -> str:
    """While what runs, or but for what, whichever is shorter; nothing runs before the start."""
    everything = (*causes.prospects.sections, "")  # causes may be those of some objectives alone

    def running(names: Collection[str]) -> str:
        told = folded(causes.mission_net, [name for name in everything if name and name in names])
        told = (
            [f"{told[0]} runs" if len(told) == 1 else f"one of these runs: {', '.join(told)}"] if told else []
        )
        return ", or ".join([f"while {one}" for one in told] + ["before the start"] * ("" in names))

    within, without = running(moments), running({*everything} - moments)
    if not without:
        return "at any moment"
    return within if len(within) <= len(without) else f"at any moment, but not {without}"


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
        leads = [t for t in row.compensation.split("; or ") if t.startswith("its failure")]
        effects = [t for t in (row.local_effect, *leads) if t != "none"]
        effect = of_all_copies(mission_net, "; ".join(effects))
        key = told["severity"], told["with_others"], effect
        shared.setdefault(row.hardware, {}).setdefault(key, []).append(row.objective)
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


def print_risk(numbers: Risk) -> None:
    """Prints probabilities, degraded modes and importances, and which events do not count in them."""
    print_counts({name: f"{value:.6g}" for name, value in risk_counts(numbers)})
    if numbers.importance:
        Terminal().print(IMPORTANCE)
    if numbers.unrated:
        Terminal().print(without_a_rate(numbers))


def print_within(numbers: Within, time: str) -> None:
    """Prints how probable each end is by a time, which is given as the user wrote it."""
    ends = {"success": numbers.success, "abort": numbers.abort, "failure": numbers.failure}
    print_counts({f"{end} within {time}": f"{value:.6g}" for end, value in ends.items() if value is not None})
    Terminal().print(f"within {time}: each is off by {numbers.error:.1e} at most")


def print_slopes(numbers: Risk, slopes: Mapping[str, float]) -> None:
    """Prints the derivatives of success where they put the hardware in another order than its importance."""
    order = ranked({name: -slope for name, slope in slopes.items()})
    if order != ranked({name: numbers.importance[name] for name in slopes}):
        Terminal().print(
            "by the derivative of success by their failure rates, per failure an hour, they rank otherwise:"
        )
        told = {f"derivative by {name}": f"{slopes[name]:.6g}" for name in order}
        print_counts(told)


def print_bounds(bounds: Mapping[str, tuple[float, float]], means: str) -> None:
    """Prints bounds of probabilities, rounded outward, and what the other numbers took for intervals."""
    told = ((end, outward(a, ROUND_FLOOR), outward(b, ROUND_CEILING)) for end, (a, b) in bounds.items())
    print_counts({f"{end} for all rates in their intervals": f"{low} .. {high}" for end, low, high in told})
    Terminal().print(f"the other numbers are {means}")


def outward(bound: float, rounding: str) -> str:
    """A bound with 6 digits, which is still one."""
    return f"{float(Context(prec=6, rounding=rounding).create_decimal_from_float(bound)):g}"
