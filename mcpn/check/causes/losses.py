"""When the loss of objectives loses the mission, from the mission's text alone: the top of a fault tree.

It is a monotone function of the objectives that cannot succeed: a greatest fixpoint on the objectives graph,
section by section. No state is explored; the cost is that of the diagrams, which keep shared parts shared.

With the functions of objectives it holds where nothing contends: then an activity whose resources can all be
had runs, whatever else does. The state spaces are the truth, and the tests hold this against them.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, reduce
from operator import and_, or_

from mcpn._kernel import Zdd
from mcpn.mission.flatten import Branch, ElementarySection, ObjectivesGraph, Section
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.space.images import ImageStore


class Losses:
    """Sets of elementary objectives, with all sets that contain them, whose loss loses the mission.

    Args:
        graph: The mission's objectives graph.
    """

    def __init__(self, graph: ObjectivesGraph) -> None:
        self.graph = graph
        self.objectives = [section.name for section in graph.walk()]
        self.images = images = ImageStore(len(self.objectives))
        self.never, self.always = images.nothing, images.everything
        single = map(images.store.singleton, ([number] for number in range(images.levels)))
        self._lost = dict(zip(self.objectives, map(images.upward, single), strict=True))

    def mission_from(self, entry: str) -> list[tuple[str, ...]]:
        """The minimal losses after which no run from the entry of a section of the graph succeeds.

        Raises:
            LimitError: There are too many.
        """
        minimal = sorted(self.images.minimal(self._mission[entry]), key=lambda lost: (len(lost), lost))
        return [tuple(self.objectives[number] for number in lost) for lost in minimal]

    @cached_property
    def _mission(self) -> Mapping[str, Zdd]:
        return self._sections(self.graph, SUCCEED)

    def _sections(self, graph: ObjectivesGraph, *wanted: str) -> Mapping[str, Zdd]:
        """When no run from the entry of each section of a graph leads to an exit that is wanted.

        It is the greatest solution of *lost here = (success is impossible, or lost behind it) and (failure is
        impossible, or lost behind it)*.
        """
        ways = {s.name: (self._succeeding(s), self._failing(s)) for s in graph.sections}
        lost = dict.fromkeys((*ways, SUCCEED, FAIL), self.always) | dict.fromkeys(wanted, self.never)
        changed = True
        while changed:
            changed = False
            for section in reversed(graph.sections):
                well, badly = ways[section.name]
                now = (well | lost[section.success]) & (badly | lost[section.failure])
                changed |= now != lost[section.name]
                lost[section.name] = now
        return lost

    def _succeeding(self, section: Section) -> Zdd:
        """When a section cannot be left by its success."""
        if isinstance(section, ElementarySection):
            return self._lost[section.name]
        ways = ((SUCCEED,) if branch.mandatory else (SUCCEED, FAIL) for branch in section.branches)
        return reduce(or_, map(self._ending, section.branches, ways), self.never)

    def _failing(self, section: Section) -> Zdd:
        """When a section cannot be left by its failure; an elementary objective always can."""
        if isinstance(section, ElementarySection):
            return self.never
        unended = reduce(or_, (self._ending(b, (SUCCEED, FAIL)) for b in section.branches), self.never)
        failing = (self._ending(b, (FAIL,)) for b in section.branches if b.mandatory)
        return unended | reduce(and_, failing, self.always)

    def _ending(self, branch: Branch, wanted: tuple[str, ...]) -> Zdd:
        """When a branch cannot end as wanted."""
        return self._sections(branch.graph, *wanted)[branch.graph.entry]
