"""What a person reads on a terminal: counts, engines, likeness of templates, runs, answers, vocabulary."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

from mcpn.report.terminal import Terminal
from mcpn.report.words import (
    in_words,
    what_happens,
)

if TYPE_CHECKING:
    from mcpn.answers.template_equivalence import Likeness
    from mcpn.answers.vocabulary import NamedWord, Vocabulary
    from mcpn.drawing.compose import MissionNet
    from mcpn.events import Event
    from mcpn.logic.session import Answer
    from mcpn.logic.witness import Witness
    from mcpn.nets.petri import PetriNet
    from mcpn.spaces.engines import Choice, NoSpace


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
            print_witness(terminal, mission_net, witness, 4)
        else:
            for index, t in enumerate(witness.firings):
                if index == witness.cycle_firing:
                    terminal.print("from here on for ever:", indent=4)
                terminal.print(net.transitions[t].name, indent=4)
            for note in witness.notes:
                terminal.print(note, indent=4)
    for choice in dict.fromkeys(answer.choice for answer in answers):
        print_choice(choice)


def print_witness(terminal: Terminal, mission_net: MissionNet, witness: Witness, indent: int) -> None:
    """Prints the run that shows an answer on a mission, what of it repeats, and what it shows where."""
    print_steps(terminal, in_words(mission_net, witness.run), indent=indent, identifiers=True)
    if witness.cycle is not None:
        events = [str(e) for t in witness.repeated if (e := mission_net.net.transitions[t].event)]
        terminal.print(f"for ever: {' '.join(events) or 'internal firings'}", indent=indent)
    for note in witness.notes:
        terminal.print(note, indent=indent)


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
