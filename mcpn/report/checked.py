"""What ``check`` and the questions of safety print: claims with their runs, modes, warnings, sizes."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from mcpn.answers.claims.claim import sentences, told
from mcpn.answers.claims.made import claims_of
from mcpn.answers.claims.of_check import of_verdict
from mcpn.answers.claims.unasked import DEFEATING, UNASKED, runs_of_unasked, unasked
from mcpn.answers.kinds.by_name import OF_VERDICTS
from mcpn.report.terminal import Terminal
from mcpn.report.text import print_choice, print_steps, print_witness
from mcpn.report.words import MOST_NAMED, in_words, modes_together, skipped_in_words, wrong_in_words
from mcpn.sentences import counted, shortened
from mcpn.spaces.engine_names import LOCAL

if TYPE_CHECKING:
    from mcpn.answers.claims.claim import Claim
    from mcpn.answers.safety import SafetyAnswer
    from mcpn.answers.verdicts.mission import MissionCheck, Verdict
    from mcpn.composite.composite import CompositeSpace
    from mcpn.drawing.compose import MissionNet
    from mcpn.spaces.run import Run

_INFORMATIVE = "note"

IDLE = ("ignored", "answered_already", "loss_unnoticed", "loss_unnoticed_later", "loss_found_in_time")
"""Kinds of claims on events that change nothing, and on losses that are noticed late: below the verdicts."""


def print_check(
    check: MissionCheck,
    seconds: float,
    *,
    internal: bool = False,
    told: Collection[str] = (),
    strict: bool = False,
) -> None:
    """Prints a mission's verdicts with their runs, functioning modes, warnings and sizes.

    Args:
        check: What was found.
        seconds: Time for all of it.
        internal: Whether runs show the internal firings that decide the outcome.
        told: Warnings that have been printed already.
        strict: Whether warnings let the mission fail.
    """
    terminal = Terminal()
    terminal.print(f"mission {check.mission_net.mission.name}", style="bold")
    _print_summary(terminal, check)
    terminal.print()
    shown: set[Run] = set()
    # A requirement that does not speak of an ignored event stands with the requirements.
    kinds = [kind for kind in (*DEFEATING, *UNASKED) if kind != "met_as_ignored"]
    claims = claims_of(check, {*IDLE, *kinds, "met_as_ignored"})
    for name in OF_VERDICTS:
        if name in check.verdicts:
            _print_verdict(terminal, check.mission_net, check.verdicts[name], internal, shown)
            shown.update(check.verdicts[name].runs)
            if name == "confluent" and check.verdicts[name].holds and check.mission_net.usage.contentions:
                terminal.print("of two that need the same resource, the second waits", indent=7, style="dim")
    for kind in IDLE:
        same = [claim for claim in claims if claim.kind == kind and claim.holds]
        for sentence in sentences(same, differ=1):
            terminal.print(f"{_INFORMATIVE:4} {sentence}", style="dim", indent=2, hang=5)
    runs = runs_of_unasked(claims, kinds)
    for _, said in unasked(claims, kinds):
        for sentence in said:
            terminal.print(f"{_INFORMATIVE:4} {sentence}", style="yellow", indent=2, hang=5)
            if sentence in runs:
                terminal.print(f"by {runs[sentence].words}", style="dim", indent=7, hang=2)
    _print_requirements(terminal, check, claims)
    if check.modes:
        terminal.print()
        _print_modes(terminal, check)
    terminal.print()
    _print_translated(terminal, check)
    told = frozenset(told)  # two branches that contend are a warning: there are as many as pairs
    for problem in map(str, check.warnings):
        if problem not in told:
            terminal.print(f"warning: {problem}", style="yellow")
    terminal.print(_sizes(check, seconds), style="dim")
    if (composite := _composite(check)) is not None:
        from mcpn.controller.sizes import foreseen

        terminal.print(f"controller: {foreseen(composite)}", style="dim")
    print_choice(check.choice)
    if strict and (warned := len(check.warnings)):
        several = "s" if warned > 1 else ""
        terminal.print(f"{warned} warning{several}, and none is allowed (--strict)", style="red")


def print_safety(found: Sequence[SafetyAnswer], mission_net: MissionNet) -> None:
    """Prints the answers to the questions of safety."""
    terminal = Terminal()
    terminal.print(f"mission {mission_net.mission.name}", style="bold")
    for each in found:
        unknown = ("?", "yellow") if each.applies else ("-", "dim")
        mark, colour = {True: ("ok", "green"), False: ("FAIL", "red"), None: unknown}[each.holds]
        terminal.print(f"{mark:4} {each.sentence} ({each.name})", style=colour, indent=2, hang=5)
        for line in (*each.why, *each.notes):
            terminal.print(line, indent=7)
        if each.run is not None:
            print_steps(terminal, in_words(mission_net, each.run), indent=9)


def _print_requirements(terminal: Terminal, check: MissionCheck, claims: Sequence[Claim]) -> None:
    """Each requirement in its author's words, and why where it is not met."""
    if check.requirements:
        terminal.print()
        terminal.print("requirements", style="bold")
    for answer in check.requirements:
        mark, colour = {True: ("ok", "green"), False: ("FAIL", "red"), None: ("?", "yellow")}[answer.met]
        if not (answer.required or answer.met):
            mark, colour = _INFORMATIVE, "yellow"
        asked = answer.asked
        silent = [c for c in claims if c.kind == "met_as_ignored" and c.holds and c.subject[0] == asked.name]
        if silent:
            mark, colour = "!", "yellow"
        terminal.print(f"{mark:4} {asked.words} ({asked.name})", style=colour, indent=2, hang=5)
        if silent:
            terminal.print(told(silent), indent=7)
        if answer.met:
            if answer.says_nothing_of:
                terminal.print(answer.says_nothing_of, indent=7, style="dim")
            continue
        if asked.sentence not in asked.words:
            terminal.print(asked.sentence, indent=7)
        terminal.print(answer.reason or f"{asked.text} {_FOUND[bool(answer.holds)]}", indent=7)
        if answer.witness is not None:
            print_witness(terminal, check.mission_net, answer.witness, 9)
        if answer.advice:
            terminal.print(answer.advice, indent=7)


_FOUND = {True: "holds, and is to fail", False: "fails"}


def _print_summary(terminal: Terminal, check: MissionCheck) -> None:
    """What whoever reads one line reads: whether all that is required holds."""
    if check.passed:
        asked, met = check.requirements, sum(bool(answer.met) for answer in check.requirements)
        counted = f", and {met} of {len(asked)} requirements are met" if asked else ""
        terminal.print(f"all required verdicts hold{counted}", style="green")
    else:
        if check.failing:
            terminal.print(f"verdicts fail: {', '.join(check.failing)}", style="red")
        if unknown := [*check.undecided, *check.unanswered]:
            terminal.print(f"not decided: {', '.join(unknown)}", style="yellow")
        if check.violated:
            terminal.print(f"requirements violated: {', '.join(check.violated)}", style="red")


def _print_translated(terminal: Terminal, check: MissionCheck) -> None:
    """What a mission that was made of a behaviour tree says of that tree."""
    all_translated = check.mission_net.mission.translated
    if not all_translated:
        return
    from mcpn.trees.ledger import WORDS, Kind, of_translated

    for translated in all_translated:
        made, survives = of_translated(translated)
        terminal.print(f"{made}. {survives}")
        if translated.description:
            terminal.print(f"  warning: {translated.description}", style="yellow")
        for each in translated.approximations:
            why = f": {each.description}" if each.description else ""
            terminal.print(f"  line {each.line}: {each.node} is {WORDS[Kind(each.kind)]}{why}", style="dim")


def _sizes(check: MissionCheck, seconds: float) -> str:
    net = check.mission_net.net
    sizes = [counted(len(net.places), "place"), counted(len(net.transitions), "transition")]
    if check.sizes_seen is not None:
        states, edges = check.sizes_seen
        sizes.append(f"{counted(states, 'marking')}, {counted(edges, 'edge')}")
    if check.stable_sizes is not None:
        states, edges = check.stable_sizes
        sizes.append(f"{counted(states, 'stable state')}, {counted(edges, 'event edge')}")
    if (composite := _composite(check)) is not None:
        sections = composite.sections.values()
        types = len({id(placed.type) for placed in sections})
        sizes.append(f"{counted(len(sections), 'section')} of {counted(types, 'type')}")
    return "; ".join([*sizes, f"{seconds:.2f} s"])


def _composite(check: MissionCheck) -> CompositeSpace | None:
    """The mission's composite, where the check has made it."""
    if check.choice.engine != LOCAL:
        return None
    from mcpn.composite.composite import CompositeSpace

    return check.alternatives if isinstance(check.alternatives, CompositeSpace) else None


def _print_verdict(
    terminal: Terminal,
    mission_net: MissionNet,
    verdict: Verdict,
    internal: bool,
    shown: Collection[Run],
) -> None:
    """A sentence and the verdict's name; why, where it is not as it should be; the runs that show it.

    What goes wrong on a run to success is said before it, and a run that has been shown is not shown again.
    """
    sentence = of_verdict(verdict).sentence
    mark, colour = {True: ("ok", "green"), False: ("FAIL", "red"), None: ("?", "yellow")}[verdict.holds]
    if not verdict.required:
        mark, colour = _INFORMATIVE, "dim"
    line = f"{mark:4} {sentence:58} {verdict.name}"
    if terminal.width is not None and len(line) + 2 > terminal.width:
        line = f"{mark:4} {sentence} ({verdict.name})"
    terminal.print(line, style=colour, indent=2, hang=5)
    unwelcome = verdict.required or verdict.name == "abort_by_failure"
    if unwelcome and verdict.holds is not verdict.required:
        if verdict.explanation:
            terminal.print(verdict.explanation, indent=7)
    elif verdict.skipped:
        terminal.print(skipped_in_words(verdict.skipped), indent=7)
    if verdict.name == "success_reachable" and verdict.runs:
        if verdict.runs[0] in shown:
            terminal.print("by the run above", indent=7)
            return
        if wrong := wrong_in_words(mission_net, verdict.runs[0]):
            terminal.print(wrong, indent=7)
    runs = verdict.runs if internal else verdict.runs_of_events
    for number, run in enumerate(runs, 1):
        if len(runs) > 1:
            terminal.print(f"run {number}", indent=7)
        print_steps(terminal, in_words(mission_net, run), indent=9)
    if verdict.cycle is not None:
        terminal.print(f"for ever from event {verdict.cycle + 1} on", indent=9)


def _print_modes(terminal: Terminal, check: MissionCheck) -> None:
    """Objectives of the same functioning modes together."""
    terminal.print("functioning modes", style="bold")
    for ways, objectives in modes_together(check).items():
        terminal.print(shortened(objectives, MOST_NAMED), indent=2)
        if not ways:
            terminal.print("never runs", indent=6)
        elif ways == ("",):
            terminal.print("always in the same way", indent=6)
        else:
            for way in ways:
                terminal.print(way or "with the alternatives that are named like their activities", indent=6)
