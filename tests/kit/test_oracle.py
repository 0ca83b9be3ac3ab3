"""Templates against the interpreter of missions that draws no net: an oracle that shares none of them.

The kit's ``behaves_as`` holds templates to the paper's set, ``as_the_language_says`` to the interpreter. Here
the paper's set is held to it by every engine and controller.
"""

from __future__ import annotations

import pytest

from experiments.faults.template_faults import FAULTS, Faulty
from mcpn.drawing.compose import compose
from mcpn.drawing.templates import Canvas, PaperTemplates
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.mission.robot import Activity
from mcpn.testing.kit import language
from mcpn.testing.kit.corpus import MISSIONS
from mcpn.testing.kit.language import as_the_language_says
from mcpn.testing.kit.properties import PROPERTIES
from mcpn.testing.kit.running import first_broken, of_the_corpus
from tests.judge.lockstep import Judge
from tests.judge.players import OfGraph

MOST_STATES = 20_000
"""Stable states of an engine's graph."""

SHOWN_BY = {
    "an event that changes facts never happens": "facts",
    "it goes on though what it requires is no more": "facts",
    "an objective succeeds and changes nothing": "facts",
    "an objective begins and changes nothing": "facts",
    "its loss is seen though nobody looks": "found late",
    "its loss is never seen": "found late",
    "it is repaired and gone still": "found late",
    "what is lost never returns": "crashes",
    "its time is never over": "its time is over",
    "what happens once happens again": "interrupted",
    "a block that needs one branch awaits all": "ends before all",
}
"""Faults that keep every promise of the contract, each with a mission whose behaviour tells."""


@pytest.mark.parametrize("name", MISSIONS)
def test_our_templates_do_what_the_language_says(name: str) -> None:
    """By every engine and controller for the paper's; without composition, which draws these, for others."""
    mission = MISSIONS[name]
    if name != "four data":  # too many stable states for all players
        assert Judge(mission).judge().kind == "agree"
    compact = compose(mission, CompactTemplates(at_once=0, combined=0))
    judge = Judge(mission)
    assert judge.explore()
    for engine in ("explicit", "symbolic"):
        assert judge.lockstep(engine, OfGraph(compact, engine, MOST_STATES))


@pytest.mark.parametrize("name", SHOWN_BY)
def test_what_only_behaviour_tells_is_told_by_the_interpreter_too(name: str) -> None:
    mission, templates = MISSIONS[SHOWN_BY[name]], Faulty(*FAULTS[name])
    found = first_broken(mission, templates, {"said": as_the_language_says})
    assert found is not None
    assert found.violation.runs or "start may happen" in found.violation.message
    assert next(of_the_corpus(templates, PROPERTIES), None) is None


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("its loss is never seen", "h detected may happen by the language alone"),
        ("it is repaired and gone still", "hardware out of service: expected none beside these, found h"),
        ("a block that needs one branch awaits all", "objectives that run: expected m, n, o, found v"),
        ("an objective succeeds and changes nothing", "facts: expected way: right, found way: left"),
    ],
)
def test_what_differs_is_told_in_words(name: str, said: str) -> None:
    found = first_broken(MISSIONS[SHOWN_BY[name]], Faulty(*FAULTS[name]), {"said": as_the_language_says})
    assert found is not None
    assert found.violation.message == said


def test_an_outcome_that_the_language_does_not_leave_open_is_told() -> None:
    """In a mission whose activities contend, where ``confluent`` does not ask."""
    mission = MISSIONS["contends"]
    assert compose(mission).usage.contentions
    found = first_broken(mission, Racing(), {"said": as_the_language_says})
    assert found is not None
    assert "the language gives each event one outcome here: " in found.violation.message


class Racing(PaperTemplates):
    """An activity that may be refused at once, beside being started."""

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        super().activity(canvas, activity)
        if activity.name == "a":
            pen = canvas.of("activity", "a", None)
            start, refused = (canvas.place_of("activity", "a", part) for part in ("Start", "error"))
            pen.transition("give_up", [start], [refused])


def test_larger_missions_are_passed_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    templates = Faulty(*FAULTS["its time is never over"])
    mission = MISSIONS["its time is over"]
    monkeypatch.setattr(language, "MOST_STATES", 1)
    assert first_broken(mission, templates, {"said": as_the_language_says}) is None
