"""Which engine a question is asked of, and why: the order for nets (answers/spaces_by_engine.py: missions).

Where the user names no engine (``auto``), the engines are asked in the order of what they promise, and the
first that answers is taken. Of a net a diagram holds all markings, however many there are; the order for
missions is that of :mod:`mcpn.answers.spaces_by_engine`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple, TypeVar, get_args

from mcpn.errors import InputError, LimitError, PremiseError
from mcpn.spaces.engine_names import EXPLICIT, PYEDA, SYMBOLIC, Asked, Engine, On
from mcpn.spaces.markings.explicit import MAX_MARKINGS

SMALL = 100_000
"""Limit on markings where stable states are few.

Markings are listed besides where their number is asked for, or where an event has two outcomes.
"""

FEW_FIRINGS = 500_000
"""Limit on firings, those of the proof included, up to which ``auto`` lists stable states.

States may be few and yet have many events that each concern all of the mission: diagrams take them at once.
"""

Found = TypeVar("Found")


class Choice(NamedTuple):
    """An engine that is asked, or that has answered.

    Args:
        engine: The engine.
        why: Why this one; ``None`` where it was named.
        max_states: Its limit on states that are listed; ``None`` for its own.
        allowed: The user's limit; ``max_states`` may be lower where states are few. ``None`` for none.
        brief: Whether it ends soon, whatever the mission is: it lists stable states, of which there are few.
    """

    engine: Engine
    why: str | None = None
    max_states: int | None = None
    allowed: int | None = None
    brief: bool = False

    def __str__(self) -> str:
        return f"engine {self.engine}" if self.why is None else f"engine {self.engine}: {self.why}"

    @property
    def limit(self) -> int:
        """The most states that it lists."""
        return MAX_MARKINGS if self.max_states is None else self.max_states

    def second_limit(self, most: int) -> int:
        """Limit on states of a second graph: its own limit; where that one is for few states, ``most``."""
        if not self.brief:
            return self.limit
        return most if self.allowed is None else min(most, self.allowed)


class NoSpace(NamedTuple):
    """An answer that needed no space.

    Args:
        why: How the answer was found without a space.
        engine: The word that stands in the place of an engine's name.
    """

    why: str
    engine: Literal["search"] = "search"

    def __str__(self) -> str:
        return f"engine {self.engine}: {self.why}"


def answered(ask: Callable[[Choice], Found], choices: Iterator[Choice]) -> tuple[Found, Choice]:
    """The first answer to a question, and whose it is.

    Args:
        ask: Asks one engine.
        choices: Who may be asked, one after the other.

    Raises:
        LimitError: No engine stays within its limits; the error is that of the last.
        PremiseError: The same, where only composition was asked.
    """
    choice = next(choices)
    while True:
        try:
            return ask(choice), choice
        except (LimitError, PremiseError) as error:
            other = next(choices, None)
            if other is None:
                raise
            choice = other._replace(why=other.why or f"{choice.engine} gives no answer: {error}")


def refuse_unknown(engine: str = "auto", on: str | None = None) -> None:
    """Refuses a word that names no engine or no graph: another engine would answer in its name.

    Args:
        engine: The engine that is asked.
        on: The graph; ``None`` for the default.

    Raises:
        InputError: One of them is unknown.
    """
    if engine not in get_args(Asked):
        beside = ", which only counts markings" if engine == PYEDA else ""
        expected = ", ".join(get_args(Asked))
        raise InputError.at(None, f"found the engine {engine!r}{beside}, expected one of {expected}")
    if on is not None and on not in get_args(On):
        raise InputError.at(None, f"found the graph {on!r}, expected one of {', '.join(get_args(On))}")


def choices_of_net(engine: Asked, max_states: int | None = None) -> Iterator[Choice]:
    """The engines to ask for the markings of a net, the one that promises most first.

    Args:
        engine: Who is asked.
        max_states: The user's limit on states that are listed one by one.
    """
    if engine == "search":
        raise LimitError("engine search builds no space: what is left stays open")
    if engine != "auto":
        yield Choice(engine, max_states=max_states)
        return
    yield Choice(SYMBOLIC, "a diagram holds all markings, however many they are", max_states)
    yield Choice(EXPLICIT, max_states=max_states)
