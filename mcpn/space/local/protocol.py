"""What the local state space of a section is, whether its states are listed or a diagram.

Its stable states are those before the entry (one for each state of the section's hardware), those inside, and
those after, by the section's outcome. Composition needs no more of them than is here.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from functools import wraps
from typing import Any, Literal, NamedTuple, Protocol, Self, TypeAlias, TypeVar, cast

from mcpn.errors import SemanticsError
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event
from mcpn.net.sections import LocalPart
from mcpn.space.local.interface import Frame, HardwareStates

Outcome: TypeAlias = Literal["success", "failure"]
OUTCOMES: tuple[Outcome, Outcome] = ("success", "failure")


class PremiseError(SemanticsError):
    """A section hands on more than the state of its hardware, so that local graphs do not tell the mission's.

    Args:
        section: The section's name.
        place: A place that differs at the section's exit from what it was at its entry.
        runs: One that shows it, in the local net.
    """

    kind = "premise"

    def __init__(self, section: str, place: str, runs: list[list[str]]) -> None:
        self.section = section
        self.place = place
        super().__init__(
            f"section {section} does not leave the place {place} as it was at its entry, so local graphs do "
            "not tell the mission's: use --engine explicit or symbolic",
            runs,
        )


class States(Protocol):
    """A set of stable states of one local space."""

    def __and__(self, other: Self, /) -> Self: ...
    def __or__(self, other: Self, /) -> Self: ...
    def __sub__(self, other: Self, /) -> Self: ...
    def __bool__(self) -> bool: ...
    def count(self) -> int:
        """How many states there are."""


class TornHere(NamedTuple):
    """An event of a local space whose outcome is not one stable state, or is not known to be.

    Attributes:
        states: The state before it, as a set of one.
        event: The event; ``MISSION_EV_START`` for the section's entry, ``None`` where it is not known.
        error: What is wrong, with the runs that show it in the local net.
    """

    states: Any
    event: Event | None
    error: SemanticsError


class LocalSpace(Protocol):
    """The stable states of one type of sections, from every state of its hardware."""

    @property
    def part(self) -> LocalPart:
        """The section that stands for its type."""

    @property
    def net(self) -> MissionNet:
        """Its local net."""

    @property
    def size(self) -> int:
        """How many stable states there are."""

    @property
    def before(self) -> Any:
        """States before the entry."""

    @property
    def inside(self) -> Any:
        """States of the section itself."""

    @property
    def ended(self) -> Mapping[Outcome, Any]:
        """States after the section, by its outcome."""

    @property
    def dead(self) -> Any:
        """States without an event."""

    def hardware(self, states: Any, frame: Frame) -> HardwareStates:
        """Which hardware is out of service in some states, by the names of a section of the type."""

    def with_hardware(self, states: Any, hardware: HardwareStates) -> Any:
        """Those of some states whose hardware is in one of some states."""

    def begin(self, before: Any) -> Any:
        """First states inside after the start from states before."""

    def beginnings(self, inside: Any) -> Any:
        """States before whose start leads into some states inside."""

    def reached(self, inside: Any) -> Any:
        """States inside to which runs inside lead from some, those included."""

    def reaching(self, goal: Any) -> Any:
        """States inside from which some run through the inside leads to a goal, inside or after."""

    def after(self, inside: Any) -> Any:
        """States, inside or after the section, one event after states inside."""

    def step_into(self, goal: Any, among: Any) -> tuple[int, Any, Any] | None:
        """One step from one of some states inside to a goal: a transition, and one state at each end.

        Of several it is the same each time; ``None`` where there is no such step.
        """

    def pick(self, states: Any) -> Any:
        """A set of one of the states, the same each time."""

    def edges(self, inside: Any) -> int:
        """Number of events, state by state."""

    def fired(self, inside: Any) -> frozenset[int]:
        """Transitions that carry an event in some of the states."""

    def marks(self, place: int, states: Any) -> bool:
        """Whether some of the states mark a place."""

    def among(self, states: Any, marking: Sequence[int]) -> Any:
        """A marking, given as tokens by place, as a set of one if it is among some states, else empty."""

    def check_premise(self, section: str) -> None:
        """Compares each state after the section with the one before it of the same hardware.

        Args:
            section: The section's name, for the error.

        Raises:
            PremiseError: Some place differs.
        """

    def torn(self, inside: Any, before: Any) -> Iterator[TornHere]:
        """Events whose outcome is not one stable state, in states inside and before."""


Known: TypeAlias = dict[tuple[str, tuple[Hashable, ...]], Any]
"""Results of methods, by their names and arguments."""

Method = TypeVar("Method", bound=Callable[..., Any])


def once(method: Method) -> Method:
    """A method that remembers its results: sections of one type ask their local space the same again."""

    @wraps(method)
    def remembering(self: Any, *arguments: Hashable) -> Any:
        key = method.__name__, arguments
        if key not in self._known:
            self._known[key] = method(self, *arguments)
        return self._known[key]

    return cast(Method, remembering)
