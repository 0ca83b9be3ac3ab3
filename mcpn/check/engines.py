"""Which engine a question is asked of, and why.

Where the user names no engine (``auto``), static analysis orders the engines, and the first that answers is
taken. Stable states are listed, with the proof of confluence, where few are expected: that is quick, and the
runs are shortest. Where many are expected, composition holds them section by section; where composition
refuses a mission or hits a limit, decision diagrams hold the whole mission, as they hold all markings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, TypeAlias, TypeVar

from mcpn.errors import LimitError, PremiseError
from mcpn.space.markings.explicit import MAX_MARKINGS

if TYPE_CHECKING:
    from mcpn.net.compose import MissionNet

On: TypeAlias = Literal["markings", "alternatives"]
Engine: TypeAlias = Literal["explicit", "symbolic", "local"]
"""Arrays, decision diagrams or composition."""
Asked: TypeAlias = Literal["auto", "explicit", "symbolic", "local", "search"]
"""An engine by name, or ``auto``; ``search`` answers questions of logic without a space."""

FEW = 50_000
"""Limit on stable states times sections up to which ``auto`` lists stable states.

A question that is asked for each section, such as failure causes, costs that product on listed states.
"""

EXPECTED = 2
"""Stable states expected for each section and set of hardware out of service; most missions have 2 to 10."""

SMALL = 100_000
"""Limit on markings where stable states are few.

Markings are listed besides where their number is asked for, or where an event has two outcomes.
"""

MORTAL = 500_000
"""Limit on stable states of the mission whose hardware may die, where the mission itself has few."""

Found = TypeVar("Found")


@dataclass(frozen=True, slots=True)
class Choice:
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

    def beside(self, most: int) -> int:
        """Limit on states of a second graph: its own limit; where that one is for few states, ``most``."""
        if not self.brief:
            return self.limit
        return most if self.allowed is None else min(most, self.allowed)


@dataclass(frozen=True, slots=True)
class NoSpace:
    """An answer that needed no space.

    Args:
        why: How the answer was found without a space.
        engine: The word that stands in the place of an engine's name.
    """

    why: str
    engine: Literal["search"] = "search"

    def __str__(self) -> str:
        return f"engine {self.engine}: {self.why}"


def answered(
    ask: Callable[[Choice], Found],
    mission_net: MissionNet | None,
    *,
    engine: Asked,
    on: On,
    max_states: int | None = None,
) -> tuple[Found, Choice]:
    """The first answer to a question, and whose it is: of one engine after the other for ``auto``.

    Args:
        ask: Asks one engine.
        mission_net: The mission that is asked about; ``None`` for a net of no mission.
        engine: Who is asked.
        on: The graph that the question speaks of.
        max_states: The user's limit on states that are listed one by one.

    Raises:
        LimitError: No engine stays within its limits; the error is that of the last.
        PremiseError: The same, where only composition was asked.
    """
    choices = _choices(mission_net, engine, on, max_states)
    choice = next(choices)
    while True:
        try:
            return ask(choice), choice
        except (LimitError, PremiseError) as error:
            other = next(choices, None)
            if other is None:
                raise
            choice = replace(other, why=other.why or f"{choice.engine} gives no answer: {error}")


def _choices(
    mission_net: MissionNet | None, engine: Asked, on: On, max_states: int | None
) -> Iterator[Choice]:
    """The engines to ask, the one that promises most first."""
    if engine == "search":
        raise LimitError("engine search builds no space: what is left stays open")
    if engine != "auto":
        yield Choice(engine, max_states=max_states)
        return
    if mission_net is None or on == "markings":
        yield Choice("symbolic", "a diagram holds all markings, however many they are", max_states)
        yield Choice("explicit", max_states=max_states)
        return
    sections = len(mission_net.graph.sections)
    limit = FEW // max(sections, 1)
    limit = limit if max_states is None else min(limit, max_states)
    many = too_much_hardware(mission_net, limit) or _many_sections(mission_net, limit)
    if many is None:
        yield Choice("explicit", "the stable states are few", limit, max_states, brief=True)
        many = f"there are more than {limit} stable states"
    own = "the one section is" if sections == 1 else f"each type of the {sections} sections is"
    yield Choice("local", f"{many}, so {own} explored on its own", max_states)
    yield Choice("symbolic", max_states=max_states)


def expected_small(mission_net: MissionNet, max_states: int | None = None) -> bool:
    """Whether the stable states of a mission are listed before anything else is tried."""
    return next(_choices(mission_net, "auto", "alternatives", max_states)).brief


def too_much_hardware(mission_net: MissionNet, limit: int) -> str | None:
    """Why a mission has more states than a limit, where its hardware alone says so.

    Before it begins any set of hardware may be out of service, each in a stable state of its own. What stands
    for software that crashes is not: it fails only while it runs.
    """
    mission = mission_net.mission
    faulty = sum(h.faulty for h in mission.hardware) - sum(c.faulty for c in mission.crashes)
    return f"{faulty} hardware resources that may fail have 2^{faulty} states" if 2**faulty > limit else None


def _many_sections(mission_net: MissionNet, limit: int) -> str | None:
    """Why a mission is expected to have more stable states than a limit, where listing need not find it out.

    In each section that is entered any set of hardware may be out of service, in stable states of their own,
    and what has run may have crashed.
    """
    mission, started = mission_net.mission, mission_net.usage.started
    never = sum(c.faulty for c in mission.crashes if c.activity not in started)
    faulty = sum(h.faulty for h in mission.hardware) - never
    sections = len(mission_net.graph.sections)
    if 2**faulty * sections * EXPECTED <= limit:
        return None
    many = f"{faulty} hardware resources that may fail in {sections} sections are expected to have many"
    return f"{many} stable states"
