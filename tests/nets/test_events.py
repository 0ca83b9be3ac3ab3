from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.events import START, Event, What
from tests.nets.nets import events

PIECES = [
    "OBJ_",
    "_EV",
    "_OK",
    "_FAIL",
    "_OOS",
    "_RD",
    "MISSION_EV_START",
    "MISSION",
    "_START",
    "a",
    ".",
    "x_ok",
]
TEXTS = st.lists(st.sampled_from(PIECES), max_size=6).map("".join) | st.text(max_size=6)


@pytest.mark.parametrize(
    ("event", "text"),
    [
        (START, "MISSION_EV_START"),
        (Event(What.SUCCESS, "transect.diving"), "OBJ_transect.diving_EV_OK"),
        (Event(What.FAILURE, "diving"), "OBJ_diving_EV_FAIL"),
        (Event(What.TIMEOUT, "diving"), "OBJ_diving_EV_TIMEOUT"),
        (Event(What.OUT_OF_SERVICE, "GPS_sensor"), "GPS_sensor_EV_OOS"),
        (Event(What.OUT_OF_SERVICE, "OBJ_x"), "OBJ_x_EV_OOS"),
        (Event(What.REPAIRED, "GPS_sensor"), "GPS_sensor_EV_RD"),
        (Event(What.DECLARED, "leak"), "leak"),
        (Event(What.DECLARED, "leak_EV"), "leak_EV"),
        (Event(What.DECLARED, "OBJ_x_EV_OK"), "OBJ_x_EV_OK_EV"),
        (Event(What.DECLARED, "OBJ_x_EV_OK_EV"), "OBJ_x_EV_OK_EV_EV"),
        (Event(What.DECLARED, "OBJ__EV_OK"), "OBJ__EV_OK"),
        (Event(What.DECLARED, ""), ""),
    ],
)
def test_each_event_has_its_text(event: Event, text: str) -> None:
    assert str(event) == text
    assert Event.parse(text) == event


@given(TEXTS)
def test_every_text_is_of_one_event(text: str) -> None:
    assert str(Event.parse(text)) == text


@given(events(TEXTS), events(TEXTS))
def test_events_are_told_apart_and_ordered_by_their_texts(one: Event, other: Event) -> None:
    assert Event.parse(str(one)) == one
    assert (one == other) == (str(one) == str(other))
    assert (one < other) == (str(one) < str(other))
    assert one != other or hash(one) == hash(other)


@pytest.mark.parametrize(
    ("what", "element"),
    [(What.START, "m"), (What.SUCCESS, "")],
)
def test_no_event_has_the_text_of_another(what: What, element: str) -> None:
    with pytest.raises(ValueError, match="no element"):
        Event(what, element)
