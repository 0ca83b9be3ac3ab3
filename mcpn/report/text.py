"""What a person reads of a mission on a terminal: verdicts, modes, runs, answers, sizes."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

from mcpn.report.terminal import Terminal
from mcpn.report.words import (
    MOST_NAMED,
    in_words,
    modes_together,
    skipped_in_words,
    unhandled_in_words,
    what_happens,
    wrong_in_words,
)
from mcpn.sentences import counted, shortened
from mcpn.spaces.engine_names import LOCAL

if TYPE_CHECKING:
    from mcpn.answers.safety import SafetyAnswer
    from mcpn.answers.template_equivalence import Likeness
    from mcpn.answers.verdicts.mission import MissionCheck, Verdict
    from mcpn.answers.vocabulary import NamedWord, Vocabulary
    from mcpn.composite.composite import CompositeSpace
    from mcpn.drawing.compose import MissionNet
    from mcpn.logic.session import Answer
    from mcpn.logic.witness import Witness
    from mcpn.nets.events import Event
    from mcpn.nets.petri import PetriNet
    from mcpn.spaces.engines import Choice, NoSpace
    from mcpn.spaces.run import Run

SENTENCES: Mapping[str, tuple[str, str, str]] = {
    "nominal_success": (
        "While nothing fails, the mission succeeds, or goes on where that is meant.",
        "While nothing fails, the mission does not do what its blocks say.",
        "Whether the mission succeeds while nothing fails is not known.",
    ),
    "success_reachable": (
        "The mission can succeed.",
        "The mission can never succeed.",
        "Whether the mission can succeed is not known.",
    ),
    "failure_reachable": (
        "The mission can fail.",
        "The mission can never fail.",
        "Whether the mission can fail is not known.",
    ),
    "abort_reachable": (
        "The mission can be aborted: not accomplished, and safe as far as its text says.",
        "The mission is never aborted.",
        "Whether the mission can be aborted is not known.",
    ),
    "abort_by_failure": (
        "It can be aborted by the failure of what should make it safe.",
        "No abort is reached by the failure of what should make it safe.",
        "Whether an abort is reached by the failure of what should make it safe is not known.",
    ),
    "can_always_end_safely": (
        "Whatever has happened, the mission can still succeed or be aborted.",
        "The mission can reach a state from which it can neither succeed nor be aborted.",
        "Whether the mission can always end safely is not known.",
    ),
    "can_always_finish": (
        "Whatever has happened, the mission can still end.",
        "The mission can reach a state from which it cannot end.",
        "Whether the mission can always end is not known.",
    ),
    "events_handled": (
        "Every event that must be handled is handled, or changes nothing while its answer runs.",
        "An event that must be handled is ignored.",
        "Whether every event that must be handled is handled is not known.",
    ),
    "deadlock_free": (
        "In every state before the mission ends some event is possible.",
        "The robot can get stuck: no event is possible, and the mission has not ended.",
        "Whether the robot can get stuck is not known.",
    ),
    "confluent": (
        "The reaction to an event is always the same, and ends.",
        "The reaction to an event depends on chance, or never ends.",
        "Whether the reaction to an event is always the same is not known.",
    ),
    "safe": (
        "Nothing is started or counted twice.",
        "Something can be started or counted twice.",
        "Whether something can be started twice is not known.",
    ),
    "bounded": (
        "Nothing piles up without end.",
        "Something can pile up without end.",
        "Whether something can pile up is not known.",
    ),
    "unselectable": (
        "Some parts of the mission can never be used; the warnings name them.",
        "Every part of the mission can be used.",
        "Whether every part of the mission can be used is not known.",
    ),
}
"""Sentences of each verdict: where it holds, where it fails, where it is not known; in reading order."""

_INFORMATIVE = "note"


MOST_OF_IGNORED = 200
"""Letters with which the objectives are named that ignore an event."""


def print_counts(counts: Mapping[str, object]) -> None:
    """Prints names and values in two columns; what is not known is left out."""
    terminal = Terminal()
    known = {name.replace("_", " "): value for name, value in counts.items() if value is not None}
    width = max(map(len, known), default=0)
    for name, value in known.items():
        shown = f"{value:.3f}" if isinstance(value, float) else str(value)
        terminal.print(f"{name.ljust(width)}  {shown}")


def print_choice(choice: Choice | NoSpace) -> None:
    """Prints which engine answered, and why it was asked."""
    Terminal().print(str(choice), style="dim")


def print_likeness(found: Likeness, names: tuple[str, str], mission: str) -> None:
    """Prints how two sets of templates compare on a mission."""
    terminal = Terminal()
    rows: list[tuple[str, ...]] = [("templates", "places", "transitions", "stable states", "event edges")]
    for name, sizes in zip(names, found.sizes, strict=True):
        counts = (sizes.places, sizes.transitions, sizes.states, sizes.edges)
        rows.append((name, *("" if count is None else str(count) for count in counts)))
    terminal.columns(rows)
    for line in likeness_lines(found, names, mission):
        terminal.print(line)


def likeness_lines(found: Likeness, names: tuple[str, str], mission: str) -> Iterator[str]:
    """Whether two sets of templates behave the same, or a run after which they do not, side by side."""
    parted = found.difference
    if parted is None:
        if found.sizes[0].reason:
            yield f"Neither has an alternatives graph: {found.sizes[0].reason}"
        elif found.isomorphic:
            yield "The same happens with both: the alternatives graphs are isomorphic."
        else:
            yield "The same happens with both: the alternatives graphs are bisimilar."
        return
    yield f"They differ: {parted.message}"
    yield "run:" if parted.events else "before anything happens"
    for number, event in enumerate(parted.events):
        yield f"  {number + 1}. {event}: {what_happens(event, mission)}"
        columns = [each[number] if number < len(each) else ("not possible",) for each in parted.firings]
        columns = [(name, *column) for name, column in zip(names, columns, strict=True)]
        width = max(map(len, columns[0]))
        for one, other in zip_longest(*columns, fillvalue=""):
            yield f"       {one.ljust(width)}  {other}".rstrip()


def print_steps(
    terminal: Terminal, steps: Iterable[tuple[Event | str, str]], *, indent: int, identifiers: bool = False
) -> None:
    """Prints a run, one event a line, numbered.

    In a pipe or a file each event is followed by its identifier in brackets, as formulas, controllers and
    ``mcpn simulate --events`` write and read it.

    Args:
        terminal: Where.
        steps: The events of a run and what happens at each.
        indent: Spaces before it.
        identifiers: Whether to say identifiers on a terminal, too.
    """
    for number, (event, words) in enumerate(steps, 1):
        identifier = f"  [{event}]" if identifiers or not terminal.watched else ""
        terminal.print(f"{number}. {words}{identifier}", indent=indent, hang=3)


def print_answers(answers: Sequence[Answer], net: PetriNet, mission_net: MissionNet | None = None) -> None:
    """Prints answers to formulas with the runs that show them."""
    terminal = Terminal()
    for answer in answers:
        colour, word = ("green", "holds") if answer.holds else ("red", "fails")
        terminal.print(f"{word}  {answer.formula}", style=colour, hang=7)
        witness = answer.witness
        if mission_net is not None:
            _print_witness(terminal, mission_net, witness, 4)
        else:
            for index, t in enumerate(witness.firings):
                if index == witness.cycle_firing:
                    terminal.print("from here on for ever:", indent=4)
                terminal.print(net.transitions[t].name, indent=4)
            for note in witness.notes:
                terminal.print(note, indent=4)
    for choice in dict.fromkeys(answer.choice for answer in answers):
        print_choice(choice)


def _print_witness(terminal: Terminal, mission_net: MissionNet, witness: Witness, indent: int) -> None:
    """The run that shows an answer on a mission, what of it repeats, and what it shows where."""
    print_steps(terminal, in_words(mission_net, witness.run), indent=indent, identifiers=True)
    if witness.cycle is not None:
        events = [str(e) for t in witness.repeated if (e := mission_net.net.transitions[t].event)]
        terminal.print(f"for ever: {' '.join(events) or 'internal firings'}", indent=indent)
    for note in witness.notes:
        terminal.print(note, indent=indent)


def _print_requirements(terminal: Terminal, check: MissionCheck) -> None:
    """Each requirement in its author's words, and why where it is not met."""
    if check.requirements:
        terminal.print()
        terminal.print("requirements", style="bold")
    for answer in check.requirements:
        mark, colour = {True: ("ok", "green"), False: ("FAIL", "red"), None: ("?", "yellow")}[answer.met]
        if not (answer.required or answer.met):
            mark, colour = _INFORMATIVE, "yellow"
        asked = answer.asked
        if answer.met and any(each.event in asked.events for each in check.ignored):
            mark, colour = "!", "yellow"
        terminal.print(f"{mark:4} {asked.words} ({asked.name})", style=colour, indent=2, hang=5)
        for sentence in unhandled_in_words(asked, check.changing_nothing):
            terminal.print(sentence, indent=7)
        if answer.met:
            if answer.says_nothing_of:
                terminal.print(answer.says_nothing_of, indent=7, style="dim")
            continue
        if asked.sentence not in asked.words:
            terminal.print(asked.sentence, indent=7)
        terminal.print(answer.reason or f"{asked.text} {_FOUND[bool(answer.holds)]}", indent=7)
        if answer.witness is not None:
            _print_witness(terminal, check.mission_net, answer.witness, 9)
        if answer.advice:
            terminal.print(answer.advice, indent=7)


_FOUND = {True: "holds, and is to fail", False: "fails"}


_MEANT = {
    "objectives": "objective(x) runs, pending(x) is about to",
    "blocks": "block(x) has an objective that runs",
    "activities": "activity(x) runs, alternative(x)=y, waiting(x), waiting(x)=y, refused(x)",
    "hardware": "oos(x) is out of service, available(x)",
    "software": "available(x): its producer runs",
    "facts": "fact(x)=v, fact(x) of a fact that is false or true",
    "events": "happens(x) is the next step of the path, event(x) may be",
    "ends": "words by themselves",
}
"""The kinds of words that formulas name, and how they do."""


def print_vocabulary(words: Vocabulary) -> None:
    """Prints the words of a mission, by kind, each with what it stands for."""
    from mcpn.answers.vocabulary import NamedActivity, NamedFact

    terminal = Terminal()
    terminal.print(f"words of the mission {words.mission}", style="bold")
    for kind, meant in _MEANT.items():
        named: Sequence[NamedWord | str] = getattr(words, kind)
        if not named:
            continue
        terminal.print()
        terminal.print(f"{kind}: {meant}", style="bold", hang=4)
        for word in named:
            if isinstance(word, str):
                terminal.print(word, indent=2)
                continue
            ways = word.alternatives if isinstance(word, NamedActivity) else ()
            ways = word.values if isinstance(word, NamedFact) else ways
            said = [f"one of {', '.join(ways)}"] if len(ways) > 1 else []
            first, *more = word.copies or ("",)
            said += (
                [f"any of {len(word.copies)}, {first} to {more[-1]}"] if more else [first] if first else []
            )
            said += [word.description] if word.description else []
            terminal.print(f"{word.name}{': ' * bool(said)}{'; '.join(said)}", indent=2, hang=4)


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
    for name in (*SENTENCES, *(name for name in check.verdicts if name not in SENTENCES)):
        if name in check.verdicts:
            _print_verdict(terminal, check.mission_net, check.verdicts[name], internal, shown)
            shown.update(check.verdicts[name].runs)
            if name == "confluent" and check.verdicts[name].holds and check.mission_net.usage.contentions:
                terminal.print("of two that need the same resource, the second waits", indent=7, style="dim")
    for idle in check.changing_nothing:
        lines = []
        if idle.objectives:
            lines.append(f"Ignored: {idle.event} while {_briefly(idle.words, idle.objectives)}.")
        if idle.answering:
            meanwhile = _briefly(idle.answering_words, idle.answering)
            lines.append(f"Answered already: {idle.event} while {meanwhile}, where it leads.")
        for line in lines:
            terminal.print(f"{_INFORMATIVE:4} {line}", style="dim", indent=2, hang=5)
    for sentence in (sentence for late in check.late for sentence in late.sentences):
        line = f"{_INFORMATIVE:4} Noticed late: {sentence}."
        terminal.print(line, style="dim", indent=2, hang=5)
    _print_requirements(terminal, check)
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


def _briefly(words: str, objectives: Sequence[str]) -> str:
    """What is said of some objectives, of many no more than how many they are and the first of them."""
    if len(words) <= MOST_OF_IGNORED:
        return words
    return f"one of {len(objectives)} objectives runs, {shortened(objectives)} (--json names them all)"


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


def sentence_of(verdict: Verdict) -> str:
    """What is said of a verdict in one line."""
    sentences = SENTENCES.get(verdict.name, (verdict.explanation,) * 3)
    return verdict.sentence or sentences[{True: 0, False: 1, None: 2}[verdict.holds]]


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
    sentence = sentence_of(verdict)
    mark, colour = {True: ("ok", "green"), False: ("FAIL", "red"), None: ("?", "yellow")}[verdict.holds]
    if not verdict.required:
        mark, colour = _INFORMATIVE, "dim"
    line = f"{mark:4} {sentence:58} {verdict.name}"
    if terminal.width is not None and len(line) + 2 > terminal.width:
        line = f"{mark:4} {sentence} ({verdict.name})"
    terminal.print(line, style=colour, indent=2, hang=5)
    unwelcome = verdict.required or verdict.name == "abort_by_failure"
    if unwelcome and verdict.holds is not verdict.required:
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
