"""Events in, actions out: an action with its parameters, the first event, an event that is refused."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, field

START = "MISSION_EV_START"


class Refused(Exception):
    """An event that the controller cannot take now.

    Attributes:
        event: The event's text.
        known: Whether the controller knows the event at all.
        possible: The events that it can take now.
    """

    def __init__(self, event: object, known: bool, possible: tuple[str, ...]) -> None:
        self.event = event
        self.known = known
        self.possible = possible
        what = "is not possible now" if known else "is no event of this mission"
        super().__init__(f"{str(event)[:200]!r} {what}; possible: {', '.join(possible) or 'none'}")


def spelled(event: str, known: Container[str]) -> str:
    """The text of an event; that of a declared one once was its name with ``_EV`` behind it."""
    plain = event.removesuffix("_EV")
    return plain if event not in known and plain in known else event


@dataclass(frozen=True, slots=True)
class ParameterValue:
    """A value for the control laws, as the mission says it.

    Args:
        name: Its name.
        value: The text as written.
        unit: The unit as written, if any.
    """

    name: str
    value: str
    unit: str | None = None


@dataclass(frozen=True, slots=True)
class Action:
    """One order to the robot.

    Args:
        verb: ``stop`` or ``start`` an activity, ``select`` one of its alternatives, ``release`` hardware,
            ``arm`` or ``disarm`` the timer of an objective, which the controller does by itself.
        activity: The activity, of the first three.
        alternative: The alternative, for ``select``.
        hardware: The hardware resource, for ``release``.
        objective: The running objective that names the activity, for ``select`` and ``start``; a timer's own.
        parameters: For ``select``: of the activity, the alternative and the objective, one of each name: the
            objective's, else the alternative's, else the activity's; empty for other verbs.
        seconds: For ``arm``: how long the objective may run.
    """

    verb: str
    activity: str | None = None
    alternative: str | None = None
    hardware: str | None = None
    objective: str | None = None
    parameters: tuple[ParameterValue, ...] = field(default=(), compare=False)
    seconds: float | None = None

    def __str__(self) -> str:
        parts = (self.verb, self.activity or self.hardware or self.objective, self.alternative)
        return " ".join(part for part in parts if part)
