"""What a person reads on a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.console import Console
from rich.table import Table

from mcpn.check.logic.questions import Answer
from mcpn.check.modes import Mode
from mcpn.check.verdicts.mission import MissionCheck, Verdict
from mcpn.errors import Problem
from mcpn.net.compose import MissionNet
from mcpn.net.petri import PetriNet
from mcpn.report.terminal import terminal
from mcpn.report.words import in_words
from mcpn.space.compare import Measurement
from mcpn.space.local.composite_space import CompositeSpace


def print_counts(counts: Mapping[str, object]) -> None:
    """Prints names and values in two columns; what is not known is left out."""
    table = Table(show_header=False, box=None, pad_edge=False)
    for name, value in counts.items():
        if value is not None:
            shown = f"{value:.3f}" if isinstance(value, float) else str(value)
            table.add_row(name.replace("_", " "), shown)
    terminal().print(table)


def print_comparison(found: Sequence[Measurement]) -> None:
    """Prints what each engine found and took, and its speed against the slowest."""
    ran = [m for m in found if m.sizes is not None]
    slowest = max((m.seconds for m in ran), default=0.0)
    counted = ("states", "edges", "stable_states", "dead_states")
    heads = ("engine", "states", "edges", "stable", "dead", "seconds", "speed", "MB", "nodes")
    table = Table(*heads)
    for m in ran:
        sizes = ["" if (size := (m.sizes or {})[name]) is None else str(size) for name in (*counted, "nodes")]
        took = (f"{m.seconds:.3f}", f"{slowest / m.seconds:.1f} x", str(m.megabytes))
        table.add_row(m.engine, *sizes[:-1], *took, sizes[-1])
    console = terminal()
    console.print(table)
    for m in found:
        if m.sizes is None:
            console.print(f"{m.engine}: {m.reason}")


def print_answers(answers: Sequence[Answer], net: PetriNet, mission_net: MissionNet | None = None) -> None:
    """Prints answers to formulas with the runs that show them."""
    console = terminal()
    for answer in answers:
        colour, word = ("green", "holds") if answer.holds else ("red", "fails")
        console.print(f"{word}  {answer.formula}", style=colour)
        witness = answer.witness
        if mission_net is not None:
            for event, words in in_words(mission_net, witness.run):
                console.print(f"    {event!s:34} {words}")
        else:
            for index, t in enumerate(witness.firings):
                if index == witness.cycle_firing:
                    console.print("    from here on for ever:")
                console.print(f"    {net.transitions[t].name}")
        if mission_net is not None and witness.cycle is not None:
            events = [str(e) for t in witness.repeated if (e := net.transitions[t].event)]
            console.print(f"    for ever: {' '.join(events) or 'internal firings'}")
        for note in witness.notes:
            console.print(f"    {note}")


def print_check(
    check: MissionCheck, warnings: Sequence[Problem], seconds: float, *, internal: bool = False
) -> None:
    """Prints a mission's sizes, verdicts with their runs, functioning modes and warnings.

    Args:
        check: What was found.
        warnings: What reading the mission found suspicious.
        seconds: Time for all of it.
        internal: Whether runs show the internal firings that decide the outcome.
    """
    console = terminal()
    net = check.mission_net.net
    sizes = [f"{len(net.places)} places", f"{len(net.transitions)} transitions"]
    if check.marking_sizes is not None:
        states, edges = check.marking_sizes
        sizes.append(f"{states} markings, {edges} edges")
    if check.stable_sizes is not None:
        states, edges = check.stable_sizes
        sizes.append(f"{states} stable states, {edges} event edges")
    if isinstance(check.alternatives, CompositeSpace):
        sections = check.alternatives.sections.values()
        sizes.append(f"{len(sections)} sections of {len({id(placed.type) for placed in sections})} types")
    console.print(
        f"mission {check.mission_net.mission.name}: {'; '.join(sizes)}; {seconds:.2f} s", style="bold"
    )
    console.print()
    for verdict in check.verdicts.values():
        _print_verdict(console, check.mission_net, verdict, internal)
    console.print()
    _print_modes(console, check.modes)
    contentions = check.mission_net.usage.contentions
    warnings = [*warnings, *check.unselectable, *(Problem(c.source, f"{c}") for c in contentions)]
    for problem in dict.fromkeys(warnings):
        console.print(f"warning: {problem}", style="yellow")
    if check.passed:
        console.print("all required verdicts hold", style="green")
    else:
        console.print("verdicts fail", style="red")


def _print_verdict(console: Console, mission_net: MissionNet, verdict: Verdict, internal: bool) -> None:
    answer = {True: "yes", False: "no", None: "not known"}[verdict.holds]
    colour = "dim" if not verdict.required else "green" if verdict.holds else "red"
    console.print(f"{verdict.name:18} {answer:10} {verdict.explanation}", style=colour)
    runs = verdict.runs if internal else verdict.runs_of_events
    for number, run in enumerate(runs, 1):
        if len(runs) > 1:
            console.print(f"    run {number}")
        for event, words in in_words(mission_net, run):
            console.print(f"    {event!s:34} {words}")


def _print_modes(console: Console, modes: Mapping[str, list[Mode]]) -> None:
    if not modes:
        return
    table = Table("objective", "functioning modes (alternatives that differ from their activity's name)")
    for objective, found in modes.items():
        rows = [", ".join(f"{a}: {alt}" for a, alt in mode.items() if a != alt) or "one" for mode in found]
        table.add_row(objective, "\n".join(rows) or "none")
    console.print(table)
