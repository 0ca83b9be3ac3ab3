"""A prompt that reads commands from a person or a pipe, until the input ends."""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence

import click

from mcpn.errors import InputError, Source


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
