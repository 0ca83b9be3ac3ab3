"""A mission that is read again after an edit is the one that is read of the whole, errors and lines too."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.errors import InputError
from mcpn.mission.language import incremental_reader as drafts
from mcpn.mission.language.forms import form_of
from mcpn.mission.language.incremental_reader import MissionDraft
from mcpn.mission.model import Mission
from mcpn.mission.robot import Described
from mcpn.mission.writer import write_mission
from mcpn.mission.xml import read_mission
from mcpn.testing import missions
from tests.conftest import ULYSSE
from tests.mission.test_broken import BROKEN

FILE = Path("/nowhere/mission.xml")
LINES = (
    "",
    "<hardware name='more'/>",
    "<objective name='more' activities='a0'/>",
    "</objective>",
    "<objective name='group'>",
    "<parallel name='pair'><objective name='left' activities='a0'/></parallel>",
    "<requirement name='must' formula='EF success'/>",
    "<use name='there' protocol='p0'/>",
    "</robot><robot name='second'>",
    "<!-- a comment -->",
    "some text",
)
CHANGES = (
    (r'name="\w+"', 'name="other"'),
    (r"activities", "activites"),
    (r'="\w', '="x'),
    ("/>", ">"),
    (" ", "\n"),
)


def placed(element: Any) -> list[Any]:
    """An element of a mission and those in it, with their lines."""
    found: list[Any] = [(type(element), element.source)]
    for field in form_of(type(element)).contents:
        found += [placed(member) for member in getattr(element, field.name) if isinstance(member, Described)]
    return found


def read(text: str, draft: MissionDraft | None) -> tuple[object, ...]:
    """The mission of a text with the lines of its elements, or what is wrong."""
    try:
        mission = read_mission(FILE, unsaved={FILE: text}, draft=draft)
    except InputError as error:
        return error.problems
    return mission, placed(mission)


@given(mission=missions(), data=st.data())
def test_an_edit_is_read_as_the_whole_is(mission: Mission, data: st.DataObject) -> None:
    lines, draft = write_mission(mission).decode().split("\n"), MissionDraft()
    read("\n".join(lines), draft)
    for _ in range(data.draw(st.integers(1, 6))):
        edited = list(lines)
        at = data.draw(st.integers(0, len(lines) - 1))
        match data.draw(st.sampled_from(("insert", "delete", "copy", "change"))):
            case "insert":
                edited.insert(at, data.draw(st.sampled_from(LINES)))
            case "delete":
                del edited[at : at + data.draw(st.integers(1, 4))]
            case "copy":
                edited[at:at] = edited[at : at + data.draw(st.integers(1, 4))]
            case "change":
                edited[at] = re.sub(*data.draw(st.sampled_from(CHANGES)), edited[at], count=1)
        text = "\n".join(edited)
        expected = read(text, None)
        assert read(text, draft) == expected
        fits = isinstance(expected[0], Mission)
        event("valid" if fits else "not valid")
        lines = edited if fits or data.draw(st.booleans()) else lines


HEAD = (
    '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="h"/>'
    '<activity name="a" consumes="h"/></robot>'
)
PARAMETERS = tuple(f"<parameter name='p{i}' value='1'/>" for i in range(8))
INSIDE = (*PARAMETERS[:3], "<objective name='b' activities='a'/>", *PARAMETERS[3:])


@pytest.mark.parametrize(
    ("old", "new"),
    [("p6", "p66"), ("name='g'", "name='g' activities='a'"), ("<parameter name='p7'", "<sets fact='f'")],
)
def test_what_an_excerpt_leaves_out_counts(old: str, new: str) -> None:
    inside = "\n".join(("<objective name='g'>", *INSIDE, "</objective>"))
    text, draft = f"{HEAD}\n{inside}\n</mission>", MissionDraft()
    assert isinstance(read(text, draft)[0], Mission)
    assert read(text.replace(old, new), draft) == read(text.replace(old, new), None)


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_mission_is_as_broken_after_a_right_one(name: str) -> None:
    draft = MissionDraft()
    text = BROKEN[name][0]
    for typed in (text, text.replace(">", ">\n"), text):  # each from what was kept of the others
        assert read(typed, draft) == read(typed, None)


def test_what_has_not_changed_is_not_read_again(monkeypatch: pytest.MonkeyPatch) -> None:
    path, draft = ULYSSE.parent / "protocols.xml", MissionDraft()
    text = path.read_text()
    before = read_mission(ULYSSE, unsaved={path: text}, draft=draft)
    edited = text.replace("\n", "\n\n", 1).replace('timeout="', 'timeout="1', 1)
    after = read_mission(ULYSSE, unsaved={path: edited}, draft=draft)
    assert after.robots[0].activities[0] is before.robots[0].activities[0]
    monkeypatch.setattr(drafts, "MAX_LINES", 1)
    whole = read_mission(ULYSSE, unsaved={path: edited}, draft=draft)
    assert whole.robots[0].activities[0] is not before.robots[0].activities[0]
    assert (whole, placed(whole)) == (after, placed(after))
