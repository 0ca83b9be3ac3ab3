"""Which engine answers where nobody names one: by static facts first, then by who gives an answer.

A small markings graph is listed: that is quick, people see its size, and its runs are shortest. A larger
one is held by sections; where composition refuses a mission or hits a limit, diagrams hold the whole.
Questions about all markings go to diagrams, beside which markings are listed as long as there are few.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, TypeAlias, TypeVar

from mcpn.check.spaces import Engine, On
from mcpn.errors import LimitError, PremiseError

if TYPE_CHECKING:
    from mcpn.net.compose import MissionNet

Asked: TypeAlias = Literal["auto", "explicit", "symbolic", "local"]
"""An engine by name, or ``auto``."""

SMALL = 100_000
"""Markings up to which a markings graph is listed without being asked for."""

Found = TypeVar("Found")


@dataclass(frozen=True, slots=True)
class Choice:
    """An engine that is asked, or that has answered.

    Args:
        engine: The engine.
        why: Why this one; ``None`` where it was named, or only others have refused so far.
        max_states: Its limit on states that are listed; ``None`` for its own.
        brief: Whether it ends soon, whatever the mission is: it lists the markings, of which there are few.
    """

    engine: Engine
    why: str | None = None
    max_states: int | None = None
    brief: bool = False

    def __str__(self) -> str:
        return f"engine {self.engine}" if self.why is None else f"engine {self.engine}: {self.why}"


def answered(
    ask: Callable[[Choice], Found],
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
        choice = Choice(engine, max_states=max_states)
        return ask(choice), choice
    refusal: LimitError | PremiseError | None = None
    refused = ""
    for choice in _choices(mission_net, on, max_states):
        try:
            why = choice.why or f"{refused} gives no answer: {refusal}"
            return ask(choice), replace(choice, why=why)
        except (LimitError, PremiseError) as error:
            refusal, refused = error, choice.engine
    assert refusal is not None, "some engine is asked"
    raise refusal


def _choices(mission_net: MissionNet | None, on: On, max_states: int | None) -> Iterator[Choice]:
    """The engines to ask, the one that promises most first."""
    if mission_net is None or on == "markings":
        yield Choice("symbolic", "a diagram holds all markings, however many they are", max_states)
        yield Choice("explicit", max_states=max_states)
        return
    limit = SMALL if max_states is None else min(SMALL, max_states)
    # Before the mission begins any set of hardware may be out of service, each in a marking of its own.
    faulty = sum(h.faulty for h in mission_net.mission.hardware)
    if 2**faulty <= limit:
        yield Choice("explicit", "the markings graph is small", limit, brief=True)
        many = f"there are more than {limit} markings"
    else:
        many = f"{faulty} hardware resources that may fail have 2^{faulty} states"
    sections = len(mission_net.graph.sections)
    own = "the one section is" if sections == 1 else f"each type of the {sections} sections is"
    yield Choice("local", f"{many}, so {own} explored on its own", max_states)
    yield Choice("symbolic", max_states=max_states)
