"""Runs that a file tells: events one after the other."""

from __future__ import annotations

import json
import re
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.errors import DivergenceError, InputError, LimitError, Source
from mcpn.files import read_bounded
from mcpn.nets.events import Event, What
from mcpn.nets.game import TokenGame
from mcpn.report.nets import arcs_in_words, marking_in_words, tokens_of
from mcpn.report.terminal import plain
from mcpn.runtime.journal import JournalError, read_journal
from mcpn.runtime.tables import spelled

if TYPE_CHECKING:
    from mcpn.controller.simulator import Change, Simulation


def events_of_file(path: Path) -> Iterator[tuple[int, Event | None, bool]]:
    """Reads a run: as other commands print it, a JSON list, or a journal of the runtime (JSON lines).

    Args:
        path: The file.

    Yields:
        A line, its event, ``None`` where a heading begins another run, and whether a controller refused it.

    Raises:
        InputError: A line holds no event.
    """
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
        yield from ((1, Event.parse(item), False) for item in listed)
        return
    if text.lstrip().startswith("{"):
        yield from _of_journal(path, text)
        return
    within_step = False
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        # A step as other commands print it, perhaps on several lines: "1. GPS fails  [GPS_EV_OOS]".
        identifier = re.fullmatch(r".*\[([^\s\[]+)\]\s*", line)
        if identifier is not None:
            yield number, Event.parse(identifier[1]), False
        within_step = identifier is None and (within_step or re.fullmatch(r"\d+\.", words[0]) is not None)
        if identifier is not None or within_step:
            continue
        if line.rstrip().endswith(":") or words[0] == "run":
            yield number, None, False
        elif len(words) == 1 or Event.parse(words[0]).what is not What.DECLARED:
            yield number, Event.parse(words[0]), False
        else:
            expected = "expected an event, or a heading that ends in a colon"
            raise InputError.at(Source(str(path), number), f"found {words[0][:80]!r}, {expected}")


def _of_journal(path: Path, text: str) -> Iterator[tuple[int, Event | None, bool]]:
    try:
        for told in read_journal(text.splitlines()):
            yield told.line, Event.parse(told.event), told.refused
    except JournalError as error:
        raise InputError.at(Source(str(path), error.line), str(error)) from error


# --- A prompt that reads commands from a person or a pipe, until the input ends ---------------------------


class Prompt(ABC):
    """A session at a prompt.

    Args:
        quiet: Whether nothing is printed but errors.
    """

    what: str
    """What is typed by number or name, with its article: ``an event``."""
    words: tuple[str, ...]
    """The commands."""

    def __init__(self, quiet: bool) -> None:
        self.quiet = quiet

    @abstractmethod
    def possible(self) -> list[str]:
        """Names of what may happen now."""

    @abstractmethod
    def show(self) -> None:
        """Says where the session stands."""

    @abstractmethod
    def command(self, text: str) -> str | None:
        """Carries out a command, or says what is wrong with it."""

    def say(self, text: str) -> None:
        """Prints a line."""
        if not self.quiet:
            click.echo(text)

    def prompt(self) -> None:
        """Reads commands until the input ends; in a pipe the first that is wrong ends with an error.

        Raises:
            InputError: A command from a pipe cannot be carried out.
        """
        if sys.stdin is None:
            what = "it is closed: expected events there, or --events, --random or --nominal"
            raise InputError.at(Source("standard input"), what)
        person = sys.stdin.isatty()
        if person:
            _complete(lambda: [*self.possible(), *self.words])
            self.say(f"Type {self.what}'s number or name; help shows what else.")
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

    def chosen(self, word: str) -> int | str:
        """Which of what may happen a number, a name or the beginning of a name means; else what is wrong."""
        possible = self.possible()
        if word.isascii() and word.isdigit() and word not in possible:
            if not 1 <= int(word[:9]) <= len(possible):
                return f"found the number {word[:20]}, expected one from 1 to {len(possible)}"
            return int(word) - 1
        found = _matching(word, possible)
        if len(found) == 1:
            return found[0]
        if found:
            return f"{word} is the beginning of several: {', '.join(possible[i] for i in found)}"
        what = self.what.partition(" ")[2]
        return f"found {word[:80]!r}, expected a possible {what} (state shows them) or a command (help)"


def _matching(word: str, names: Sequence[str]) -> list[int]:
    exact = [i for i, name in enumerate(names) if name == word]
    return exact or [i for i, name in enumerate(names) if name.startswith(word)]


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


# --- A mission played at a prompt, or from a file of events -----------------------------------------------

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


class EventSession(Prompt):
    """A mission that is played, and what is printed of it.

    Args:
        simulation: The mission.
        quiet: Whether nothing is printed but errors.
    """

    what = "an event"
    words = (
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

    def __init__(self, simulation: Simulation, quiet: bool) -> None:
        super().__init__(quiet)
        self.simulation = simulation
        self.taken: list[Change] = []

    def possible(self) -> list[str]:
        """Names of the events that may happen now."""
        return [str(event) for event in self.simulation.possible]

    def show(self) -> None:
        """Prints what runs, and what may happen."""
        from mcpn.report.simulation import state_lines

        for line in state_lines(self.simulation):
            self.say(line)

    def take(self, event: Event) -> bool:
        """Takes an event and says what it changes; whether it was possible."""
        from mcpn.report.simulation import change_lines

        change = self.simulation.take(event)
        if change is None:
            return False
        self.taken.append(change)
        for line in change_lines(change, self.simulation.mission_net):
            self.say(line)
        return True

    def play_nominal(self) -> None:
        """Takes the run on which nothing fails, and says where it does not succeed."""
        from mcpn.controller.run import awaited, nominal_run

        simulation = self.simulation

        def take(event: Event) -> int:
            self.take(event)
            return simulation.marking

        nominal_run(lambda: simulation.possible, take, awaited(simulation.mission_net.mission))
        if simulation.situation.outcome is None:
            self.say("the run without failures goes on for ever, or nothing can succeed here: see mcpn check")

    # --- from a file ---

    def replay(self, path: Path) -> None:
        """Takes the events of a file.

        Raises:
            InputError: A line holds no event, one that is not possible there, or one that was refused by a
                controller and is possible.
        """
        known = {str(t.event) for t in self.simulation.mission_net.net.transitions if t.event is not None}
        for line, said, refused in events_of_file(path):
            event = None if said is None else Event.parse(spelled(str(said), known))
            if event is None:
                self.simulation.restart()
                self.taken.clear()
            elif refused:
                if event in self.simulation.possible:
                    message = f"found {event} refused by the controller, which is possible here"
                    raise InputError.at(Source(str(path), line), message)
            elif not self.take(event):
                possible = ", ".join(map(str, self.simulation.possible)) or "none"
                message = f"found {event}, which is not possible here; expected one of: {possible}"
                raise InputError.at(Source(str(path), line), message)

    # --- from a person, or a pipe ---

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
                return self.fail(hardware)
            case ["goto", *_]:
                return "found another goto, expected success, failure, abort or cut set"
            case [word]:
                return self.one_event(word)
            case _:
                return f"found {text[:80]!r}, expected an event or a command (help shows them)"
        return None

    def undo(self) -> str | None:
        """Takes back the last event."""
        event = self.simulation.undo()
        if event is None:
            return "nothing to undo"
        self.taken.pop()
        self.say(f"taken back: {event}")
        self.show()
        return None

    def one_event(self, word: str) -> str | None:
        """Takes an event by number or name, or says what is wrong."""
        chosen = self.chosen(word)
        if isinstance(chosen, str):
            return chosen
        self.take(self.simulation.possible[chosen])
        self.show()
        return None

    def goto(self, outcome: str) -> str | None:
        """Takes the events of a shortest run to an end of the mission."""
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

    def fail(self, hardware: list[str]) -> str | None:
        """Lets hardware fail: what is named, or a smallest cut set."""
        from mcpn.nets.events import Event, What

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
            return "no small set of hardware resources rules out success from here"
        if not chosen:
            return "success is ruled out already unless something is repaired"
        for name in chosen:
            if name not in working:
                return f"found {name[:80]!r}, expected hardware in service: {', '.join(working) or 'none'}"
        self.take_all([Event(What.OUT_OF_SERVICE, name) for name in chosen])
        return None

    def take_all(self, events: list[Event]) -> None:
        """Takes events one after the other, and says each."""
        for event in events:
            self.say(f"> {event}")
            self.take(event)
        self.show()


# --- The token game at a prompt: internal transitions too, one by one, back and forward -------------------

HELP_WITH_TOKENS = """\
a transition's number, its name, or the beginning of its name: it fires
back                 take back the last firing
forward              fire again what was taken back
settle               fire internal transitions until none is enabled
restart              go back to the initial marking
run                  the transitions fired so far
state                the tokens, and what may fire
help, quit"""


class TokenSession(Prompt):
    """A net that is played, and what is printed of it.

    Args:
        game: The net.
        quiet: Whether nothing is printed but errors.
    """

    what = "a transition"
    words = ("back", "forward", "settle", "restart", "run", "state", "help", "quit")

    def __init__(self, game: TokenGame, quiet: bool) -> None:
        super().__init__(quiet)
        self.game = game
        self._transitions = game.net.transitions

    def possible(self) -> list[str]:
        """Names of the enabled transitions."""
        return [self._transitions[t].name for t in self.game.enabled]

    def show(self) -> None:
        """Prints the tokens, and what may fire with its arcs."""
        self.say(
            plain(f"marked  {marking_in_words(tokens_of(self.game.net, self.game.marking)) or 'nothing'}")
        )
        enabled = self.game.enabled
        if not enabled:
            self.say("no transition is enabled")
        for number, transition in enumerate(enabled, 1):
            self.say(plain(f"{number:4}  {arcs_in_words(self.game.net, transition)}"))

    def fire(self, transition: int) -> None:
        """Fires an enabled transition, and says what it changed."""
        before = self.game.marking
        self.game.fire(transition)
        self._tell(before, transition)

    def _tell(self, before: tuple[int, ...], transition: int) -> None:
        changed = [
            f"{place.name} {old} -> {new}"
            for place, old, new in zip(self.game.net.places, before, self.game.marking, strict=True)
            if old != new
        ]
        self.say(plain(f"{self._transitions[transition].name}: {', '.join(changed) or 'nothing changes'}"))

    def command(self, text: str) -> str | None:
        """Carries out a command, or says what is wrong with it."""
        before = self.game.marking
        match text.split():
            case [] | ["state"]:
                pass
            case ["help"]:
                self.say(HELP_WITH_TOKENS)
                return None
            case ["run"]:
                for transition in self.game.run:
                    self.say(plain(f"    {self._transitions[transition].name}"))
                return None
            case ["restart"]:
                self.game.restart()
            case ["back" | "forward" as way]:
                moved = self.game.back() if way == "back" else self.game.forward()
                if moved is None:
                    return f"nothing to go {way} to"
                self._tell(before, moved)
            case ["settle"]:
                try:
                    fired = self.game.settle()
                except (DivergenceError, LimitError) as error:
                    return str(error)
                for transition in fired:
                    self.say(plain(f"    {self._transitions[transition].name}"))
            case _:
                chosen = self.chosen(text)
                if isinstance(chosen, str):
                    return chosen
                self.fire(self.game.enabled[chosen])
        self.show()
        return None
