"""Fills in templates of claims on losses at one moment: at the entry of a section, at the worst moments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Generic

from mcpn.answers.causes.prospects import Goal
from mcpn.answers.claims.late import open_run
from mcpn.answers.claims.parts import MOST_NAMED, FormulaParts, some
from mcpn.answers.kinds.by_name import KINDS
from mcpn.events import Event, What
from mcpn.mission.core.objectives_graph import ElementarySection, ParallelSection, Section
from mcpn.mission.static.handover import entries
from mcpn.spaces.algebra import S


class Moments(Generic[S]):
    """The formulas on one mission; empty where no formula says it.

    Args:
        parts: The parts of its formulas.
    """

    def __init__(self, parts: FormulaParts[S]) -> None:
        self.parts, self.prospects, self.net, self.space = parts, parts.prospects, parts.net, parts.space
        self.sections = {section.name: section for section in self.net.graph.sections}

    def lost_at_entry(self, kind: str, section: str, lost: Sequence[str] = ()) -> str:
        """That no run leads from the entry of a section to a goal after some losses at once, not repaired.

        Args:
            kind: The kind of the claim.
            section: The name of the section.
            lost: Hardware; none for what the entry alone leaves.
        """
        goal = self._goal(kind)
        reaches = self.parts.reaches(goal, self._repairs(lost))
        before, inside = self._entering(self.sections[section])
        if not reaches or not before or not self._plain:
            return ""
        out = "".join(f"oos({name}) & " for name in lost)
        fails = " | ".join(f"happens({name}_EV_OOS)" for name in self.prospects.hardware) or "false"
        # Hardware may fail at once as the section is entered.
        then = f"E(({fails}) U ({out}{reaches}))" if lost else reaches
        return KINDS[kind].formula.format(before=before, inside=inside, then=then)

    def _goal(self, kind: str) -> Goal[S]:
        """The goal of the mission of which a kind speaks."""
        of_safety = kind.endswith(("endangers", "endanger", "to_safety"))
        found = self.prospects.safety if of_safety else self.prospects.mission
        assert found is not None, "it can abort"
        return found

    def _entering(self, section: Section) -> tuple[str, str]:
        """What is so before the edges with which a section is entered, and what is so behind them."""
        names = [objective.name for objective in section.walk()]
        if not self.parts.mean_one(names):
            return "", ""
        inside = self._runs([first.name for first in entries(section)])
        if isinstance(section, ElementarySection):
            ends = [f"happens({Event(What.SUCCESS, section.name)})", *self.parts.failures_of(section.name)]
        else:
            assert isinstance(section, ParallelSection), "there are two kinds"
            if section.pause_graphs:
                return "", ""  # none of it runs meanwhile
            ends = []
        places = self.prospects.places
        running = self.space.marked([*places("objective", names), *places("pending", names)])
        # Where another event ends it and begins it again, no word tells the two runs apart.
        if self.prospects.reentry.entered(section, running):
            return "", ""
        return " | ".join([f"!({self._runs(names)})", *ends]), inside

    def _runs(self, names: Sequence[str]) -> str:
        """That one of some objectives runs, or is about to."""
        pending = [name for name in names if ("pending", name) in self.net.by_role]
        return " | ".join([some("objective", names), *(f"pending({name})" for name in pending)])

    def lost_at_worst(self, kind: str, lost: Sequence[str]) -> str:
        """That some losses, each at some moment, leave no way to a goal, if objectives fail only when forced.

        Args:
            kind: The kind of the claim.
            lost: Hardware.
        """
        goal = self._goal(kind)
        steps, reaches = self._forced, self.parts.reaches(goal, self._repairs(lost))
        if goal.ends_from or not steps or not reaches or not self._plain:
            return ""
        sound = [name for name in self.prospects.hardware if name not in lost]
        out = " & ".join([*(f"oos({name})" for name in lost), *(f"!oos({name})" for name in sound)]) or "true"
        # An end in failure is no safe end; a mission that has ended so loses no success any more.
        ended = "success | abort" if goal is self.prospects.safety else self.parts.ends
        return KINDS[kind].formula.format(steps=steps, out=out, ended=ended, reaches=reaches)

    def _repairs(self, lost: Sequence[str]) -> list[str]:
        return [f"{name}_EV_RD" for name in lost if self.prospects.carrying(What.REPAIRED, name)]

    @cached_property
    def _plain(self) -> bool:
        """Whether each loss is one of a resource of its own, which may come at any moment."""
        mission = self.net.core
        return (
            len(self.prospects.hardware) <= MOST_NAMED and not mission.common_causes and not mission.crashes
        )

    @cached_property
    def _forced(self) -> str:
        """That nothing is repaired now, and nothing fails that could succeed in its present run."""
        objectives = self.prospects.objectives
        if not self.parts.mean_one(list(objectives)):
            return ""
        open_ = dict[str, str]()
        for name, goal in objectives.items():
            open_[name] = open_run(self.parts, name) if goal.won else "false"
        if not all(open_.values()):
            return ""
        said = [*(f"!happens({event})" for event in self.parts.repairs), *self._excused(open_)]
        return " & ".join(said) or "true"

    def _excused(self, open_: dict[str, str]) -> Iterator[str]:
        """That what fails now could not succeed; as the time of a block is over, something in it."""
        for name, could in open_.items():
            for what in (What.FAILURE, What.TIMEOUT):
                for event in self.parts.events(self.prospects.carrying(what, name)):
                    yield f"(!happens({event}) | !{could})"
        for block in self.net.graph.timed_blocks():
            if events := self.parts.events(self.prospects.carrying(What.TIMEOUT, block.name)):
                could_not = " | ".join(f"(objective({n}) & !{open_[n]})" for n in block.held if n in open_)
                yield f"(!happens({events[0]}) | {could_not or 'false'})"
