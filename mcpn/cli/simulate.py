"""Playing a mission at a prompt, from a file of events, or at random."""

from __future__ import annotations

import json
import random
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.shared import FILE, emit_json, import_option, json_option, limit_option
from mcpn.errors import InputError, LimitError, Source

if TYPE_CHECKING:
    from mcpn.controller.simulator import Change, Simulation
    from mcpn.net.events import Event

HELP = """\
an event's number, its name, or the beginning of its name: it happens
undo                 take back the last event
restart              go back to the beginning
goto success         take the events of a shortest run to the mission's success
goto failure         the same to its failure
goto abort           the same to its abort
goto cut set         let fail the fewest hardware that rules out success
goto cut set A B     let fail these
run                  the events taken so far
state                what runs and what may happen
help, quit"""
COMMANDS = (
    "undo",
    "restart",
    "goto success",
    "goto failure",
    "goto abort",
    "goto cut set",
    "run",
    "state",
    "help",
    "quit",
)


@click.command()
@click.argument("mission", type=FILE)
@click.option("--events", type=FILE, help="Replay a file: what check and causes print as a run, or JSON.")
@click.option("--random", "steps", type=click.IntRange(min=0), help="Take this number of events at random.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of the events at random.")
@limit_option
@import_option
@json_option
def simulate(
    mission: Path,
    events: Path | None,
    steps: int | None,
    seed: int,
    max_states: int | None,
    import_root: Path | None,
    as_json: bool,
) -> None:
    """Play MISSION event by event: type an event and see what changes.

    All that is shown is computed by the mission's net, not by its controller. Events are read from standard
    input, unless a file or a number of random ones is given.
    """
    from mcpn.controller.simulator import MAX_VISITED, Simulation
    from mcpn.study import open_study

    simulation = Simulation(
        open_study(mission, import_root=import_root).mission_net, max_states or MAX_VISITED
    )
    session = _Session(simulation, quiet=as_json)
    if events is not None:
        session.replay(events)
    if steps is not None:
        rng = random.Random(seed)
        for _ in range(steps):
            possible = simulation.possible
            if not possible or simulation.situation.outcome:
                break
            session.take(rng.choice(possible))
    if events is None and steps is None:
        session.prompt()
    elif not as_json:
        session.show()
    if as_json:
        from mcpn.report.simulation import change_object

        name = simulation.mission_net.mission.name
        emit_json(
            {
                "steps": [change_object(change, name) for change in session.taken],
                "possible": [str(event) for event in simulation.possible],
                "outcome": simulation.situation.outcome,
            }
        )


class _Session:
    """A mission that is played, and what is printed of it.

    Args:
        simulation: The mission.
        quiet: Whether nothing is printed but errors.
    """

    def __init__(self, simulation: Simulation, quiet: bool) -> None:
        self.simulation = simulation
        self.quiet = quiet
        self.taken: list[Change] = []

    def say(self, text: str) -> None:
        if not self.quiet:
            click.echo(text)

    def show(self) -> None:
        from mcpn.report.simulation import state_lines

        for line in state_lines(self.simulation):
            self.say(line)

    def take(self, event: Event) -> bool:
        from mcpn.report.simulation import change_lines

        change = self.simulation.take(event)
        if change is None:
            return False
        self.taken.append(change)
        for line in change_lines(change, self.simulation.mission_net):
            self.say(line)
        return True

    # --- from a file ---

    def replay(self, path: Path) -> None:
        """Takes the events of a file.

        Raises:
            InputError: A line holds no event, or one that is not possible there.
        """
        for line, event in _events_of(path):
            if event is None:
                self.simulation.restart()
                self.taken.clear()
            elif not self.take(event):
                possible = ", ".join(map(str, self.simulation.possible)) or "none"
                message = f"found {event}, which is not possible here; expected one of: {possible}"
                raise InputError.at(Source(str(path), line), message)

    # --- from a person, or a pipe ---

    def prompt(self) -> None:
        """Reads commands until the input ends; in a pipe the first that is wrong ends with an error.

        Raises:
            InputError: A command from a pipe cannot be carried out.
        """
        person = sys.stdin.isatty()
        if person:
            _complete(lambda: [*map(str, self.simulation.possible), *COMMANDS])
            self.say("Type an event's number or name; help shows what else.")
        self.show()
        for number, text in enumerate(_commands(person), 1):
            if not person:
                self.say(f"> {text}")
            if text == "quit":
                return
            wrong = self.command(text)
            if wrong is not None:
                if not person:
                    raise InputError.at(Source("standard input", number), wrong)
                self.say(wrong)

    def command(self, text: str) -> str | None:
        """Carries out a command, or says what is wrong with it."""
        words = text.split()
        match words:
            case [] | ["state"]:
                self.show()
            case ["help"]:
                self.say(HELP)
            case ["undo"]:
                return self.undo()
            case ["restart"]:
                self.simulation.restart()
                self.taken.clear()
                self.show()
            case ["run"]:
                for event in self.simulation.run:
                    self.say(f"    {event}")
            case ["goto", ("success" | "failure" | "abort") as outcome]:
                return self.goto(outcome)
            case ["goto", "cut", "set", *hardware]:
                return self.cut(hardware)
            case ["goto", *_]:
                return "found a goto to elsewhere, expected success, failure, abort or cut set"
            case [word]:
                return self.one_event(word)
            case _:
                return f"found {text[:80]!r}, expected an event or a command (help shows them)"
        return None

    def undo(self) -> str | None:
        event = self.simulation.undo()
        if event is None:
            return "nothing to undo"
        self.taken.pop()
        self.say(f"taken back: {event}")
        self.show()
        return None

    def one_event(self, word: str) -> str | None:
        possible = self.simulation.possible
        if word.isascii() and word.isdigit():
            if not 1 <= int(word[:9]) <= len(possible):
                return f"found the number {word[:20]}, expected one from 1 to {len(possible)}"
            found = [possible[int(word) - 1]]
        else:
            exact = [event for event in possible if str(event) == word]
            found = exact or [event for event in possible if str(event).startswith(word)]
        if len(found) == 1:
            self.take(found[0])
            self.show()
            return None
        if found:
            return f"{word} is the beginning of several: {', '.join(map(str, found))}"
        return f"found {word[:80]!r}, expected a possible event (state shows them) or a command (help)"

    def goto(self, outcome: str) -> str | None:
        if self.simulation.situation.outcome:
            return "the mission has ended; undo or restart first"
        try:
            way = self.simulation.way_to(outcome)
        except LimitError as error:
            return str(error)
        if way is None:
            return f"no run leads to {outcome} from here"
        self.take_all(way)
        return None

    def cut(self, hardware: list[str]) -> str | None:
        from mcpn.net.events import Event, What

        if self.simulation.situation.outcome:
            return "the mission has ended; undo or restart first"
        working = [e.element for e in self.simulation.possible if e.what is What.OUT_OF_SERVICE]
        chosen: tuple[str, ...] | None = tuple(dict.fromkeys(hardware))
        if not hardware:
            try:
                chosen = self.simulation.cut_set()
            except LimitError as error:
                return str(error)
        if chosen is None:
            return "no few hardware resources rule out success from here"
        if not chosen:
            return "success is ruled out already unless something is repaired"
        for name in chosen:
            if name not in working:
                return f"found {name[:80]!r}, expected hardware in service: {', '.join(working) or 'none'}"
        self.take_all([Event(What.OUT_OF_SERVICE, name) for name in chosen])
        return None

    def take_all(self, events: list[Event]) -> None:
        for event in events:
            self.say(f"> {event}")
            self.take(event)
        self.show()


def _commands(person: bool) -> Iterator[str]:
    while True:
        try:
            yield input("> " if person else "").strip()
        except EOFError:
            return


def _complete(choices: Callable[[], list[str]]) -> None:
    """Completion by the tab key, where Python has readline."""
    try:
        import readline
    except ImportError:  # not on every system
        return

    def complete(text: str, state: int) -> str | None:
        line = readline.get_line_buffer().lstrip()
        found = [choice[len(line) - len(text) :] for choice in choices() if choice.startswith(line)]
        return found[state] if state < len(found) else None

    readline.set_completer(complete)
    readline.set_completer_delims(" ")
    readline.parse_and_bind("tab: complete")


def _events_of(path: Path) -> Iterator[tuple[int, Event | None]]:
    """The events of a file with their lines; ``None`` where a heading begins another run."""
    from mcpn.files import read_bounded
    from mcpn.net.events import Event, What

    try:
        text = read_bounded(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError.at(Source(str(path)), f"expected text in UTF-8: {error.reason}") from error
    if text.lstrip().startswith("["):
        try:
            listed = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise InputError.at(
                Source(str(path), getattr(error, "lineno", None)), f"no JSON: {error}"
            ) from error
        if not all(isinstance(item, str) for item in listed):
            raise InputError.at(Source(str(path)), "expected a JSON list of events")
        yield from ((1, Event.parse(item)) for item in listed)
        return
    within_step = False
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        # A step as other commands print it, perhaps on several lines: "1. GPS fails  [GPS_EV_OOS]".
        identifier = re.fullmatch(r".*\[(\S+)\]\s*", line)
        if identifier is not None:
            yield number, Event.parse(identifier[1])
        within_step = identifier is None and (within_step or re.fullmatch(r"\d+\.", words[0]) is not None)
        if identifier is not None or within_step:
            continue
        event = Event.parse(words[0])
        if event.what is not What.NAMED:
            yield number, event
        elif line.rstrip().endswith(":") or words[0] == "run":
            yield number, None
        else:
            expected = "expected an event, or a heading that ends in a colon"
            raise InputError.at(Source(str(path), number), f"found {words[0][:80]!r}, {expected}")
