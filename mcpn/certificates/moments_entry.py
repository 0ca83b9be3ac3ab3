"""Claims on minimal cut sets at all moments but the mission's start, of the entry ``further.json``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from mcpn.answers.causes.find import Causes, GoalCauses
from mcpn.answers.causes.minimal_cut_sets import CutSet, Moment
from mcpn.answers.causes.prospects import Prospects
from mcpn.certificates import evidence
from mcpn.certificates.cut_set_evidence import Losing, can_fail, survived
from mcpn.certificates.entries import Claimed, Trusted, entry, supported
from mcpn.errors import LimitError
from mcpn.events import ENDING
from mcpn.mission.core.objectives_graph import ElementarySection, ParallelSection, Section
from mcpn.mission.static.handover import entries
from mcpn.spaces.arrays import ArraySet, ArraySpace
from mcpn.spaces.markings.graph import Mask
from mcpn.spaces.stable.alternatives import AlternativesGraph

CRASHES = "what crashes as it runs is lost at other moments only in a net that no certificate holds"
REENTERED = "a block that runs may be entered again by the event that ends it"
SENTENCES = {
    Moment.START: "All minimal cut sets: lost before the start, each leaves no way to {}.",
    Moment.ENTRY: "All minimal cut sets: lost as {} is entered, each leaves no way to {}.",
    Moment.WHENEVER: "All minimal cut sets: lost at whatever moment, each leaves no way to {}.",
    Moment.SOMETIME: "All minimal cut sets: lost at the worst moment, each leaves no way to {}.",
}
KINDS = {
    Moment.START: "cut_sets_at_start",
    Moment.ENTRY: "cut_sets_at_entry",
    Moment.WHENEVER: "cut_sets_whenever",
    Moment.SOMETIME: "cut_sets_at_worst",
}


class _Goal(NamedTuple):
    """A goal.

    Args:
        words: What it is called.
        said: How a statement says it.
        running: The states that a run to it passes.
        won: Those in which it is reached.
        edges: The edges that a run to it takes.
        open: The states in which it is not decided.
        refused: Why no statement says it; empty where one does.
        stopped: Transitions that end its run and may begin it again at once.
    """

    words: str
    said: dict[str, Any]
    running: Mask
    won: Mask
    edges: Mask
    open: Mask
    refused: str = ""
    stopped: Sequence[int] = ()


class MomentClaims:
    """The claims on cut sets of one mission.

    Args:
        causes: What makes it fail.
        graph: Its listed states.
    """

    def __init__(self, causes: Causes, graph: AlternativesGraph) -> None:
        self.causes, self.graph, self.net = causes, graph, causes.mission_net
        self.prospects: Prospects[ArraySet] = Prospects(self.net, ArraySpace(graph))
        self.hardware = can_fail(self.net)
        self.sections = {section.name: section for section in self.net.graph.sections}
        self.objectives = {name: self._objective(name) for name in self.prospects.objectives}

    def all(self) -> Iterator[Claimed | Trusted]:
        """Each as the certificate holds it, or why it is only trusted."""
        goals = [(self._ends("success"), self.causes.mission)]
        if self.causes.safety is not None and not self.causes.unsafe_aborts:
            goals.append((self._ends("success", "abort"), self.causes.safety))
        for goal, found in goals:
            yield from self._of(goal, found, Moment.WHENEVER, Moment.SOMETIME)
        for survival in self.causes.survival:
            every = (survival, survival.safety)
            for (goal, _), at_entry in zip(goals, every, strict=False):
                if survival.section is not None and at_entry is not None:
                    section = self.sections[survival.section]
                    yield self._claim(goal, Moment.ENTRY, at_entry.cut_sets, section)
        for name, found in self.causes.objectives.items():
            yield from self._of(self.objectives[name], found, *Moment)

    def _of(self, goal: _Goal, found: GoalCauses, *moments: Moment) -> Iterator[Claimed | Trusted]:
        """The claims on one goal at some moments."""
        for moment in moments:
            section = self.prospects.sections[found.name] if moment is Moment.ENTRY else None
            yield self._claim(goal, moment, found.moments[moment.value], section)

    def _claim(
        self, goal: _Goal, moment: Moment, cut_sets: Sequence[CutSet], section: Section | None
    ) -> Claimed | Trusted:
        at = [] if section is None else [section.name]
        sentence = SENTENCES[moment].format(*at, goal.words)
        key = ": ".join([KINDS[moment], goal.words, *at])
        cuts = sorted(sorted(names) for names in cut_sets)
        said: dict[str, Any] = {"goal": goal.said, "hardware": self.hardware, "cuts": cuts}
        # At the worst moment nothing fails that could succeed: that speaks of every objective.
        every = self.objectives.values() if moment is Moment.SOMETIME else (goal,)
        why = CRASHES if self.net.core.crashes else max((each.refused for each in every), default="")
        if section is not None and not why:
            said |= self._entering(section)
            why = self._entered_again(section)
        concerned = {goal.said["objective"], *at}
        said["stopped"] = self.stopped(self.objectives if moment is Moment.SOMETIME else sorted(concerned))
        if why:
            return Trusted(key, sentence, why)
        shown: dict[str, Any] = {}
        if moment is Moment.SOMETIME:
            blocks = self.net.graph.timed_blocks()
            own = [end for end in ("success", "abort") if end in goal.said["ends"]]
            # An end in failure is no safe end; a mission that has ended so loses no success any more.
            over = own if "abort" in own else ["success", "failure", "abort"]
            said |= {"over": over, "timed": [[block.name, *block.held] for block in blocks]}
        else:
            try:
                with supported(sentence):
                    losing = self._losing(goal, moment, section)
                    shown = {"survived": survived(self.graph, self.net, cuts, losing)}
            except LimitError as error:
                return Trusted(key, sentence, str(error))
        subject = (goal.words, *at)
        return entry(key, KINDS[moment], subject, True, sentence, said, shown)

    def stopped(self, names: Iterable[str]) -> list[dict[str, Any]]:
        """How a statement says what ends runs of some objectives and may begin them again at once."""
        goals = ((name, self.objectives[name]) for name in names if name in self.objectives)
        return [{"objective": name, "transitions": [*goal.stopped]} for name, goal in goals if goal.stopped]

    def _losing(self, goal: _Goal, moment: Moment, section: Section | None) -> Losing:
        """The moments, the goal and the edges of a claim that speaks of every moment of its kind."""
        if moment is Moment.START:
            start = evidence.marking(self.graph, [self.net.beginning])
            return Losing(start, goal.won, np.ones(self.graph.edges, np.bool_))
        if section is None:
            return Losing(goal.open, goal.won, goal.edges)
        return Losing(goal.running & self.prospects.entered(section).mask, goal.won, goal.edges)

    def _ends(self, *ends: str) -> _Goal:
        known = self.net.ends
        won = evidence.marking(self.graph, [known[end] for end in ends if end in known])
        said = {"ends": list(ends), "objective": ""}
        everything = np.ones(self.graph.states, np.bool_), np.ones(self.graph.edges, np.bool_)
        return _Goal(" or ".join(ends), said, everything[0], won, everything[1], ~won)

    def _objective(self, name: str) -> _Goal:
        graph, goal = self.graph, self.prospects.objectives[name]
        running = goal.running.mask
        edges = running[graph.sources] & running[graph.targets] & ~evidence.carrying(graph, goal.ends)
        within = self.net.by_role.get(("objective", name), ()), self.net.by_role.get(("pending", name), ())
        inside = evidence.marking(graph, [place for places in within for place in places])
        own = {t for what in ENDING for t in self.prospects.carrying(what, name)}
        stopping = evidence.carrying(graph, goal.ends - own)
        again = (stopping & inside[graph.sources] & inside[graph.targets]).any()
        said = {"ends": [], "objective": name}
        stopped = sorted(goal.ends - own) if again else []
        refused = REENTERED if goal.ends_from else ""
        return _Goal(f"success of {name}", said, running, goal.won.mask, edges, running, refused, stopped)

    def _entering(self, section: Section) -> dict[str, Any]:
        """How a statement says that a section is entered."""
        by_role, names = self.net.by_role, [inner.name for inner in section.walk()]
        kinds, again = ["objective", "pending"], [section.name]
        if isinstance(section, ParallelSection):
            names += [branch.name for branch in section.branches]
            kinds, again = [*kinds, "done"], []
        first = list(dict.fromkeys(inner.name for inner in entries(section)))
        inside = [[kind, name] for kind in kinds for name in dict.fromkeys(names) if (kind, name) in by_role]
        return {"entered": first, "inside": inside, "again": again}

    def _entered_again(self, section: Section) -> str:
        """Why a statement cannot say when a section is entered; empty where it can."""
        if isinstance(section, ElementarySection):
            return self.objectives[section.name].refused
        assert isinstance(section, ParallelSection), "there are two kinds"
        said = self._entering(section)["inside"]
        places = [place for kind, name in said for place in self.net.by_role[kind, name]]
        running = ArraySet(evidence.marking(self.graph, places))
        return REENTERED if self.prospects.reentry.entered(section, running) else ""
