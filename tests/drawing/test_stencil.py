"""Copies of sections are what drawing each of them gives."""

from __future__ import annotations

import pickle
from dataclasses import replace

import pytest
from hypothesis import given

from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.templates import PaperTemplates, TemplateSet
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.drawing.templates.copied import CopiedNet
from mcpn.errors import LimitError, Source
from mcpn.mission.model import FAIL, SUCCEED, Mission, Objective
from mcpn.mission.xml import read_mission
from mcpn.nets.numbering import Nodes
from mcpn.nets.petri import PetriNet, Place, Transition
from mcpn.nets.provenance import Provenance
from mcpn.testing import missions
from tests.conftest import ROOT
from tests.draws import fewer
from tests.shares import returns_early
from tests.small import activity, hw, robot
from tests.small import mission as small

WORKED = sorted(path.parent.name for path in (ROOT / "experiments").glob("*/mission.xml"))


class PaperOfAnother(PaperTemplates):
    """A caller's own set, of which nothing is known: each section is drawn by itself."""


class CompactOfAnother(CompactTemplates):
    """The same of the compact set."""


SETS = ((PaperTemplates(), PaperOfAnother()), (CompactTemplates(), CompactOfAnother()))


def confirm(mission: Mission) -> None:
    for by_type, one_by_one in SETS:
        copied, each = compose(mission, by_type), compose(mission, one_by_one)
        assert (copied.net, copied.roles, copied.meetings) == (each.net, each.roles, each.meetings)
        asked_before_it_is_drawn(mission, by_type, each.net)
        assert origins(copied) == origins(each)


def asked_before_it_is_drawn(mission: Mission, templates: TemplateSet, drawn: PetriNet) -> None:
    """What is known of copies without drawing them is what is found in all that is drawn."""
    net = compose(mission, templates).net
    assert (len(net.places), len(net.transitions)) == (len(drawn.places), len(drawn.transitions))
    assert (net.initial, net.ranks, net.internal_ranks) == (drawn.initial, drawn.ranks, drawn.internal_ranks)
    assert (net.events.pairs, net.events.internal) == (drawn.events.pairs, drawn.events.internal)
    assert {p: [*users] for p, users in net.internal_users.items()} == drawn.internal_users
    assert {p: dict(crowd) for p, crowd in net.crowds(2).items()} == drawn.crowds(2)
    outside = [p for p, by in enumerate(drawn.places) if by.provenance and by.provenance.kind == "hardware"]
    assert net.consuming(outside) == drawn.consuming(outside)
    some = [*range(0, len(net.transitions), 7)]
    assert [(net.event(t), net.arcs(t)) for t in some] == [(drawn.event(t), drawn.arcs(t)) for t in some]
    assert [sorted(net.needs(t)) for t in some] == [sorted(drawn.needs(t)) for t in some]
    assert [*map(net.origin, range(len(net.places)))] == [place.provenance for place in drawn.places]
    assert [net.transitions[t] for t in some] == [drawn.transitions[t] for t in some]
    assert [net.places[p] for p in range(0, len(net.places), 5)] == [*drawn.places[::5]]
    if isinstance(net, CopiedNet):
        assert isinstance(net.places, Nodes)
        assert not net.places.drawn
        assert pickle.loads(pickle.dumps(net)) == drawn
        changed = {0: replace(drawn.transitions[0], name="other")}
        assert replace(net, priorities=False) == replace(drawn, priorities=False)
        more = changed, [Place("one more")], [Transition("then")], [(0, 1)]
        assert net.extended(*more) == drawn.extended(*more)


def origins(mission_net: MissionNet) -> list[tuple[Provenance | None, Source | None]]:
    """What has made each place and transition, and its line, which equal nets need not share."""
    places = [place.provenance for place in mission_net.net.places]
    made = [*places, *(transition.provenance for transition in mission_net.net.transitions)]
    return [(origin, origin.source if origin else None) for origin in made]


@fewer(0.5)
@given(missions())
def test_drawn_missions(mission: Mission) -> None:
    try:
        confirm(mission)
    except LimitError:
        returns_early("LimitError")


@pytest.mark.parametrize("name", WORKED)
def test_worked_missions(name: str) -> None:
    confirm(read_mission(ROOT / "experiments" / name / "mission.xml"))


def test_of_equal_sections_one_is_drawn() -> None:
    """Those that lead to other sections are equal; what fails elsewhere than it succeeds is another kind."""
    routes = {"a": ("b", "b"), "b": ("c", "c"), "c": ("d", FAIL), "d": ("e", "e"), "e": (SUCCEED, "a")}
    net = compose(small(robot(hw("eye"), activity("look", ("eye",))), *led(routes))).net
    assert isinstance(net, CopiedNet)
    assert [copy.section.name for copy in net.copies.every] == ["a", "b", "c", "d", "e"]
    assert len({id(copy.stencil) for copy in net.copies.every}) == 2


def led(routes: dict[str, tuple[str, str]]) -> list[Objective]:
    return [
        Objective(name=name, activities=("look",), success=success, failure=failure)
        for name, (success, failure) in routes.items()
    ]
