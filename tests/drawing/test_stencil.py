"""Copies of sections are what drawing each of them gives."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import pytest
from hypothesis import given

from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.templates import Canvas, PaperTemplates
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.drawing.templates.stencil import Stencil
from mcpn.errors import LimitError, Source
from mcpn.mission.flatten import Section
from mcpn.mission.model import FAIL, SUCCEED, Mission, Objective
from mcpn.mission.xml import read_mission
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
        assert origins(copied) == origins(each)


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


def test_of_equal_sections_one_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that lead to other sections are equal; what fails elsewhere than it succeeds is another kind."""
    copied, copy = list[str](), Stencil.copy

    def noted(stencil: Stencil, canvas: Canvas, section: Section, led: Sequence[Collection[str]]) -> None:
        copied.append(section.name)
        copy(stencil, canvas, section, led)

    monkeypatch.setattr(Stencil, "copy", noted)
    routes = {"a": ("b", "b"), "b": ("c", "c"), "c": ("d", FAIL), "d": ("e", "e"), "e": (SUCCEED, "a")}
    blocks = [
        Objective(name=name, activities=("look",), success=success, failure=failure)
        for name, (success, failure) in routes.items()
    ]
    compose(small(robot(hw("eye"), activity("look", ("eye",))), *blocks))
    assert copied == ["a", "b", "c", "d", "e"]
