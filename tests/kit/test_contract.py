"""The contract of templates: ours keep it, no more is declared than they do, and who breaks it is told."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.drawing.templates import Canvas, PaperTemplates
from mcpn.drawing.templates.canvas import RoleName
from mcpn.drawing.templates.interface import HAPPENING, MEETINGS, SAYING
from mcpn.errors import LimitError
from mcpn.events import Event, What
from mcpn.mission.language.forms import form_of, language
from mcpn.mission.model import Approximation, Mission, Translated
from mcpn.mission.requirement import Requirement
from mcpn.mission.robot import Activity, Described, Hardware
from mcpn.mission.xml import read_mission
from mcpn.testing.elements import LATE, LATE_APART
from mcpn.testing.elements import MISSIONS as MISSIONS_OF_ANY_KIND
from mcpn.testing.kit.contract import WORDS, contract_of_arcs, drawer, touches
from mcpn.testing.kit.corpus import MISSIONS
from mcpn.testing.kit.subject import Subject, Violation
from tests.conftest import ULYSSE
from tests.draws import fewer
from tests.kit.test_kit import OURS
from tests.shares import returns_early


@fewer(0.3)
@given(st.one_of(MISSIONS_OF_ANY_KIND, LATE, LATE_APART))
def test_the_contract_accepts_our_templates_whatever_a_mission_says(mission: Mission) -> None:
    """Every element of the language, contended or not: what touches what follows from the templates alone."""
    for templates in OURS:
        try:
            contract_of_arcs(Subject(mission, templates))
        except LimitError as error:
            returns_early(type(error).__name__)


Row = tuple[str, str, str, str]
"""Kind, part, side, letter."""


def rows_touched(missions: Iterable[Mission]) -> set[Row]:
    """What the paper's templates do, of what is declared of their places."""
    found = set()
    for mission in missions:
        for touch in touches(Subject(mission)):
            if touch.row is not None:
                found.add((*touch.row, touch.side, touch.letter))
    return found


def test_no_more_is_declared_than_the_templates_do() -> None:
    allowed = {
        (kind, part, side, letter)
        for kind, parts in MEETINGS.items()
        for part, meeting in parts.items()
        for side, letters in meeting.allowed.items()
        for letter in letters
    }
    assert allowed - rows_touched((*MISSIONS.values(), read_mission(ULYSSE))) == RARE


@pytest.mark.parametrize("kind", MEETINGS)
def test_an_element_that_declares_no_places_is_told(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """So a new element cannot be forgotten: none may touch its places until they are declared."""
    monkeypatch.delitem(MEETINGS, kind)
    told = []
    for mission in MISSIONS.values():
        try:
            contract_of_arcs(Subject(mission))
        except Violation as violation:
            told.append(violation.message)
    assert told
    assert all(re.search(rf"which the .* of {kind} \S+ may not$", message) for message in told)


def test_what_places_say_is_declared_or_private() -> None:
    """By role, so that a new one is thought of: who may touch a place that says so?"""
    private = {
        *("wait", "want", "known", "ready", "presumed"),  # of who draws it; others learn of it otherwise
        *(
            "objective",
            "pending",
            "done",
            "success",
            "failure",
            "abort",
            "exit",
            "open",
            "happened",
        ),  # control
        *("alive", "dead"),  # never drawn by templates: made of the net of a mission later
        "fine",  # has the name that is declared
    }
    assert {*get_args(RoleName)} == {*SAYING} | private
    assert not {*SAYING} & private
    assert all(part in MEETINGS[kind] for kind, part in SAYING.values())


def test_every_event_is_of_some_kind_of_element() -> None:
    """By what it says; no set draws losses for good and what was before a part, and a set may name others."""
    assert {*What} - {*HAPPENING} == {What.LOST, What.EARLIER}
    drawn = {
        (transition.event.what, drawer(transition.provenance)[0])
        for mission in MISSIONS.values()
        for transition in Subject(mission).net.transitions
        if transition.event is not None and transition.provenance is not None
    }
    assert all(kind in HAPPENING[what] for what, kind in drawn)
    assert {*HAPPENING} == {what for what, _ in drawn}


def test_events_of_other_elements_break_the_contract() -> None:
    class Meddling(PaperTemplates):
        """An activity during which hardware may fail, without the hardware's template."""

        def activity(self, canvas: Canvas, activity: Activity) -> None:
            super().activity(canvas, activity)
            running = canvas.place_of("activity", activity.name, "active1")
            fails = Event(What.OUT_OF_SERVICE, "h")
            canvas.of("activity", activity.name, None).transition("worn", [running], [running], event=fails)

    told = "a_worn, of activity a, fires with h_EV_OOS, an event of another element"
    with pytest.raises(Violation, match=told):
        contract_of_arcs(Subject(MISSIONS["retried"], Meddling()))


class Noticing(PaperTemplates):
    """An activity that looks at a place of its hardware that this set alone has."""

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        super().hardware(canvas, resource)
        pen = canvas.of("hardware", resource.name, resource.source)
        self.declared(canvas, canvas.place(f"hours of {resource.name}", provenance=pen.provenance))

    def declared(self, canvas: Canvas, place: str) -> None:
        """It is not declared that others look at it."""

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        super().activity(canvas, activity)
        read = [f"hours of {name}" for way in activity.alternatives for name in way.consumes]
        canvas.of("activity", activity.name, None).transition("look", [], [], read=read)


def test_a_set_declares_places_of_its_own_at_which_templates_meet() -> None:
    told = "a_look, of activity a, reads hours of h, which the other side of hardware h may not"
    with pytest.raises(Violation, match=told):
        contract_of_arcs(Subject(MISSIONS["retried"], Noticing()))

    class Declaring(Noticing):
        letters = "r"

        def declared(self, canvas: Canvas, place: str) -> None:
            canvas.meet(place, "it has run for long", consumer=self.letters)

    contract_of_arcs(Subject(MISSIONS["retried"], Declaring()))

    class Other(Declaring):
        letters = "t"

    told = "a_look, of activity a, reads hours of h, which the consumer of hardware h may not"
    with pytest.raises(Violation, match=told):
        contract_of_arcs(Subject(MISSIONS["retried"], Other()))


NOT_DRAWN: Mapping[str, set[str]] = {
    "it is text": {"Described.description", "Described.source", "Parameter.value", "Parameter.unit"}
    | {f"{of}.parameters" for of in ("Activity", "Alternative", "Objective", "Protocol", "Recursive", "Use")},
    "it is a number": {
        f"{of}.{number}"
        for of, numbers in {
            **dict.fromkeys(
                ("Hardware", "Fault", "Activity", "Alternative"), ("failure_rate", "repair_rate")
            ),
            "Objective": ("duration", "failure_probability"),
            "DeclaredEvent": ("rate",),
        }.items()
        for number in numbers
    }
    | {"Activity.detection_rate", "Hardware.demand_probability"},
    "it is asked of the net": {"BlockElement.nominal", "DeclaredEvent.required", "Mission.requirements"}
    | {"Protocol.requirements"},
    "it is of files": {"Import.href", "Protocols.name", "Protocols.protocols", "Mission.translated"},
}
"""What the language has and no net shows, by the reason."""


def test_every_element_of_the_language_is_in_the_corpus() -> None:
    """With each attribute that a net may show, not at its default: so a new one is thought of."""
    missed = {
        f"{field.owner.__name__}.{field.name}"
        for tag in language().values()
        for form in tag.forms
        if not issubclass(form, (Requirement, Translated, Approximation)) and form.__module__ in DRAWN
        for field in form_of(form).fields
        if field not in form_of(form).core
    }
    for mission in MISSIONS.values():
        missed -= {*said(mission)}
    assert missed == set().union(*NOT_DRAWN.values())


DRAWN = ("mcpn.mission.model", "mcpn.mission.robot")
"""Modules that declare elements; patterns of requirements have one of their own."""


def said(element: Described) -> Iterator[str]:
    """The attributes and contents of an element that are not the default, and of those inside."""
    for field in form_of(type(element)).fields:
        value = getattr(element, field.name)
        if value not in (field.default, None, ()):
            yield f"{field.owner.__name__}.{field.name}"
        for inner in value if isinstance(value, tuple) else ():
            if isinstance(inner, Described):
                yield from said(inner)


RARE = {
    # A request is given up of a producer that waits; those of the corpus that do so serve.
    ("software", "free", "consumer", "p"),
    # Errors of hardware are noted one by one beside more than three data.
    ("hardware", "answer", "consumer", "p"),
    ("hardware", "error", "consumer", "r"),
    # An activity returns for hardware that only its supplier uses.
    ("hardware", "service", "watcher", "r"),
    # An event that changes several facts does so by transitions of one of them, and reads what is so already.
    ("fact", "value", "owner", "r"),
    *(("fact", "value", "event", letter) for letter in "tpr"),
}


def test_who_touches_what_is_private_breaks_the_contract() -> None:
    class Meddling(PaperTemplates):
        """An activity that looks into the hardware that it uses."""

        def hardware(self, canvas: Canvas, resource: Hardware) -> None:
            super().hardware(canvas, resource)
            pen = canvas.of("activity", "a", None)
            pen.transition(("peek", resource.name), [], [], read=[canvas.resource(resource.name, "busy")])

    with pytest.raises(
        Violation, match=r"a_peek_h, of activity a, reads h_busy, which the other side of hardware h may not"
    ):
        contract_of_arcs(Subject(MISSIONS["retried"], Meddling()))
    assert WORDS.keys() == {"t", "p", "r"}
