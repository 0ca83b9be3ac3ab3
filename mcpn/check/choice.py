"""Which engine answers where nobody names one: by static facts first, then by who gives an answer.

A small markings graph is listed: that is quick, people see its size, and its runs are shortest. A larger
one is held by sections; where composition refuses a mission or hits a limit, diagrams hold the whole.
Questions about all markings go to diagrams, beside which markings are listed as long as there are few.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypeVar

from mcpn.check.spaces import Engine, On, space_of, stable_space
from mcpn.errors import LimitError, PremiseError
from mcpn.space.algebra import Space
from mcpn.space.markings.explicit import Progress

if TYPE_CHECKING:
    from mcpn.net.compose import MissionNet

Asked: TypeAlias = Literal["auto", "explicit", "symbolic", "local"]
"""An engine by name, or ``auto``."""

SMALL = 100_000
"""Markings up to which a markings graph is listed without being asked for."""

Found = TypeVar("Found")


@dataclass(frozen=True, slots=True)
class Choice:
    """Who has answered.

    Args:
        engine: The engine.
        why: Why this one; ``None`` where it was named.
    """

    engine: Engine
    why: str | None = None

    def __str__(self) -> str:
        return f"engine {self.engine}" if self.why is None else f"engine {self.engine}: {self.why}"


@dataclass(frozen=True, slots=True)
class Attempt:
    """One engine to ask.

    Args:
        engine: The engine.
        max_states: Its limit on states that are listed; ``None`` for its own.
        why: Why it is asked; ``None`` where only others have refused.
        brief: Whether it ends soon, whatever the mission is.
    """

    engine: Engine
    max_states: int | None
    why: str | None = None
    brief: bool = False


def answered(
    ask: Callable[[Attempt], Found],
    mission_net: MissionNet | None,
    *,
    engine: Asked,
    on: On,
    max_states: int | None = None,
) -> tuple[Found, Choice]:
    """The first answer to a question, and whose it is.

    Args:
        ask: Asks one engine.
        mission_net: The mission that is asked about; ``None`` for a net of no mission.
        engine: Who is asked; ``auto``: one after the other, until one answers.
        on: The graph that the question speaks of.
        max_states: The user's limit on states that are listed one by one.

    Raises:
        LimitError: No engine stays within its limits; the error is that of the last.
        PremiseError: The same, where only composition was asked.
    """
    if engine != "auto":
        return ask(Attempt(engine, max_states)), Choice(engine)
    refusal: LimitError | PremiseError | None = None
    refused = ""
    for attempt in _attempts(mission_net, on, max_states):
        try:
            why = attempt.why or f"{refused} gives no answer: {refusal}"
            return ask(attempt), Choice(attempt.engine, why)
        except (LimitError, PremiseError) as error:
            refusal, refused = error, attempt.engine
    assert refusal is not None, "some engine is asked"
    raise refusal


def _attempts(mission_net: MissionNet | None, on: On, max_states: int | None) -> Iterator[Attempt]:
    """The engines to ask, the one that promises most first."""
    if mission_net is None or on == "markings":
        yield Attempt("symbolic", max_states, "a diagram holds all markings, however many they are")
        yield Attempt("explicit", max_states)
        return
    limit = SMALL if max_states is None else min(SMALL, max_states)
    # Before the mission begins any set of hardware may be out of service, each in a marking of its own.
    faulty = sum(h.faulty for h in mission_net.mission.hardware)
    if 2**faulty <= limit:
        yield Attempt("explicit", limit, "the markings graph is small", brief=True)
        many = f"there are more than {limit} markings"
    else:
        many = f"{faulty} hardware resources that may fail have 2^{faulty} states"
    sections = len(mission_net.graph.sections)
    own = "the one section is" if sections == 1 else f"each type of the {sections} sections is"
    yield Attempt("local", max_states, f"{many}, so {own} explored on its own")
    yield Attempt("symbolic", max_states)


def stable_by(attempt: Attempt, mission_net: MissionNet, progress: Progress | None = None) -> Space[Any]:
    """The alternatives graph of a mission by one engine; a brief attempt lists the markings.

    Args:
        attempt: The engine and its limit.
        mission_net: The mission's net.
        progress: As for :func:`mcpn.check.spaces.stable_space`.

    Raises:
        SemanticsError: The mission is not 1-safe or not confluent.
        LimitError: A limit was hit.
    """
    engine, limit = attempt.engine, attempt.max_states
    if attempt.brief:
        return space_of(mission_net.net, mission_net, engine=engine, on="alternatives", max_states=limit)
    return stable_space(mission_net, engine=engine, max_states=limit, progress=progress)
