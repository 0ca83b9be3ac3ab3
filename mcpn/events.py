"""Events: what happens, and to which element of a mission; the one home of their text.

>>> str(Event(What.OUT_OF_SERVICE, "GPS_sensor"))
'GPS_sensor_EV_OOS'
>>> Event.parse("OBJ_diving_EV_OK")
Event(what=<What.SUCCESS: 'success'>, element='diving', reason='')
>>> Event.parse("OBJ_diving_EV_FAIL_too_deep").reason
'too_deep'
>>> str(Event(What.DECLARED, "battery_low"))
'battery_low'
"""

from __future__ import annotations

import re
from enum import StrEnum
from functools import total_ordering

from mcpn.records import record


class What(StrEnum):
    """What an event says that happens."""

    START = "start"
    """The mission starts; in the net of a section, the section is entered."""
    SUCCESS = "success"
    """An objective ends in success."""
    FAILURE = "failure"
    """An objective ends in failure."""
    TIMEOUT = "timeout"
    """The time of an objective is over."""
    OUT_OF_SERVICE = "out of service"
    """A hardware resource fails."""
    REPAIRED = "repaired"
    """A hardware resource is ready again."""
    LOST = "lost"
    """A hardware resource that is out of service is lost for good (:mod:`mcpn.drawing.permanent_loss`)."""
    EARLIER = "earlier"
    """A handler that happens once has happened before this part of the mission; in nets of parts alone."""
    DETECTED = "detected"
    """The robot learns that a hardware resource is out of service which is detected late."""
    DECLARED = "declared"
    """An event that the mission, a net from a file, or a template of a user's own calls by a name."""


ENDING = (What.SUCCESS, What.FAILURE, What.TIMEOUT)
"""How an objective ends by itself."""

HELPING = (What.DECLARED, What.TIMEOUT)
"""What may help, and need not happen."""

_FORMS = {
    What.SUCCESS: ("OBJ_", "_EV_OK"),
    What.FAILURE: ("OBJ_", "_EV_FAIL"),
    What.TIMEOUT: ("OBJ_", "_EV_TIMEOUT"),
    What.OUT_OF_SERVICE: ("", "_EV_OOS"),
    What.REPAIRED: ("", "_EV_RD"),
    What.LOST: ("", "_EV_DEATH"),
    What.EARLIER: ("", "_EARLIER"),
    What.DETECTED: ("", "_EV_DETECTED"),
}
"""Text before and after the element; no text ends like two of them. That of a declared event is its name."""

_DECLARED = "_EV"
"""Behind a declared name that else would be read as another event."""
_START = "MISSION_EV_START"
_REASON = re.compile(r"OBJ_(.+)_EV_FAIL_([A-Za-z_][A-Za-z0-9_]*)", re.ASCII)
"""A failure with its reason, in which no other form of an event may occur."""


@total_ordering
@record(frozen=True, slots=True)
class Event:
    """An event of a net. Two events are equal if and only if their texts are.

    Args:
        what: What happens.
        element: To which element: an objective, hardware, the declared name; of the start nothing.
        reason: Of a failure for which the mission has a name, that name; else nothing.

    Raises:
        ValueError: The text of these would be read as another event.
    """

    what: What
    element: str = ""
    reason: str = ""

    def __post_init__(self) -> None:
        if self.reason and (self.what is not What.FAILURE or not self.element):
            raise ValueError(f"{self.what.name} of {self.element!r} has a reason: only a failure has one")
        if (self.what is What.START) != (not self.element) and self.what is not What.DECLARED:
            raise ValueError(f"{self.what.name} of {self.element!r}: only the start is of no element")

    def __str__(self) -> str:
        if self.what is What.DECLARED:
            return self.element + _DECLARED * _reads_otherwise(self.element)
        if self.what is What.START:
            return _START
        before, after = _FORMS[self.what]
        return f"{before}{self.element}{after}{'_' * bool(self.reason)}{self.reason}"

    def __lt__(self, other: Event) -> bool:
        return str(self) < str(other)

    @staticmethod
    def parse(text: str) -> Event:
        """The event that a text from a file or from people says."""
        return Event(*_parse(text))

    def of(self, element: str) -> Event:
        """The same of another element."""
        return Event(self.what, element, self.reason)


def _parse(text: str) -> tuple[What, str, str]:
    """What happens, to which element and for what reason."""
    if text == _START:
        return What.START, "", ""
    for what, (before, after) in _FORMS.items():
        if text.startswith(before) and text.endswith(after) and len(text) > len(before) + len(after):
            return what, text[len(before) : -len(after)], ""
    if text.endswith(_DECLARED) and _reads_otherwise(name := text.removesuffix(_DECLARED)):
        return What.DECLARED, name, ""
    named = _REASON.fullmatch(text)
    return (What.DECLARED, text, "") if named is None else (What.FAILURE, named[1], named[2])


def _reads_otherwise(name: str) -> bool:
    """Whether a declared name is the text of another event, or of another declared one."""
    return _parse(name) != (What.DECLARED, name, "")


START = Event(What.START)
"""The event with which a mission begins, and each section in its own net."""
