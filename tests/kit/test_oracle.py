"""Templates against the interpreter of missions that draws no net: an oracle that shares none of them.

The kit's ``behaves_as`` holds templates to the paper's set; here that set, and what the kit finds by it
alone, are held to what the page on the language says.
"""

from __future__ import annotations

import pytest

from experiments.template_faults import FAULTS, Faulty
from mcpn.drawing.compose import compose
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.testing.kit.corpus import MISSIONS
from mcpn.testing.kit.properties import PROPERTIES
from mcpn.testing.kit.running import of_the_corpus
from tests.judge.lockstep import Disagreement, Judge
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
    judge = Judge(mission)
    assert judge.explore()
    with pytest.raises(Disagreement):
        judge.lockstep("explicit", OfGraph(compose(mission, templates), "explicit", MOST_STATES))
    assert next(of_the_corpus(templates, PROPERTIES), None) is None
