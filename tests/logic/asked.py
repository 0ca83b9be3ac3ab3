"""Failure causes by one engine, asked by name: what the tests of causes share."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from mcpn.answers.causes.find import Causes, find_causes
from mcpn.answers.causes.minimal_cut_sets import CutSet, CutSets, Moment
from mcpn.answers.causes.prospects import Goal, Prospects
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import MissionNet
from mcpn.spaces.engine_names import SPACE_ENGINES, Engine

ENGINES = SPACE_ENGINES


class Asked:
    """The causes of one mission by one engine.

    Args:
        found: The mission's net.
        engine: The engine.
    """

    def __init__(self, found: MissionNet, engine: Engine = "explicit") -> None:
        self.found = found
        self.engine: Engine = engine
        self.prospects: Prospects[Any] = Prospects(found, spaces_of(found).space(engine, "alternatives"))
        self.sections = {section.name: section for section in found.graph.all_sections()}

    @cached_property
    def cuts(self) -> CutSets[Any]:
        return CutSets(self.found, spaces_of(self.found).space(self.engine, "alternatives", may_die=True))

    @cached_property
    def all(self) -> Causes:
        return find_causes(self.found, engine=self.engine)

    def goal(self, name: str | None = None) -> Goal[Any]:
        return self.prospects.mission if name is None else self.prospects.objectives[name]

    def dying(self, name: str | None = None) -> Goal[Any]:
        return self.cuts.mission if name is None else self.cuts.objectives[name]

    def cut_sets(self, name: str | None, moment: Moment, section: str | None = None) -> list[CutSet]:
        """Of the mission (``None``) or an objective; entered is the section, or the objective itself."""
        entered = self.sections.get(section or name or "")
        return self.cuts.minimal(self.cuts.defeating(self.dying(name), moment, entered))
