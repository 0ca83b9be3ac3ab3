"""Minimal cut sets: minimal sets of hardware that, lost for good, leave no way to succeed.

A set is lost for good where it is out of service and never repaired, while other hardware may fail and
recover as it likes. In the net whose hardware may die (:mod:`mcpn.drawing.permanent_loss`) the sets that a
goal survives are the image, on the places *dead*, of the states from which a run without a further death
reaches it. The hardware is lost at one of the moments of :class:`Moment`; the sets that are not survived are
read off a diagram, the minimal ones by their size, and no set is tried on its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum
from functools import cached_property, reduce
from operator import or_
from typing import NamedTuple

from mcpn._kernel import Zdd
from mcpn.answers.causes.prospects import Goal, Prospects
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.permanent_loss import mortal
from mcpn.events import HELPING, Event, What
from mcpn.mission.core.objectives_graph import Section
from mcpn.spaces.algebra import Alike, S, Space
from mcpn.spaces.memoized import memoized
from mcpn.spaces.projections import ImageStore

CutSet = tuple[str, ...]
"""Names of hardware, in alphabetical order."""


class Moment(Enum):
    """When a set of hardware is lost, for it to be a cut set.

    ``START``, ``ENTRY`` and ``WHENEVER`` ask that *every* state with the set out of service loses the goal;
    ``SOMETIME`` that *one* does.
    """

    START = "start"
    """Before the mission begins."""
    ENTRY = "entry"
    """At the entry of a section, or at once after it."""
    WHENEVER = "whenever"
    """In every state in which the goal is still open: the set loses it at whatever moment it is lost."""
    SOMETIME = "sometime"
    """In some state with just this hardware out, after a run without repairs in which objectives failed only
    where they could not succeed any more: at the worst moment."""


class Nonmonotone(NamedTuple):
    """A set whose loss loses a goal, and a set with one resource more, whose loss does not."""

    lost: CutSet
    larger: CutSet


class Found(NamedTuple):
    """What the loss of hardware means for a goal.

    Args:
        minimal: Minimal cut sets by moment.
        nonmonotone: A pair of sets for which one failure more would undo a loss; ``None`` without one.
    """

    minimal: Mapping[Moment, list[CutSet]]
    nonmonotone: Nonmonotone | None


def help_in_words(event: Event) -> str:
    """An event that helps, as a sentence names it."""
    return event.element if event.what is What.DECLARED else f"the end of the time of {event.element}"


class Unaided(NamedTuple):
    """What the loss of hardware before the start means where nothing helps.

    Args:
        cut_sets: Minimal cut sets.
        helpers: What makes up for those of them that are none where it happens.
    """

    cut_sets: list[CutSet]
    helpers: tuple[str, ...]


class CutSets(Prospects[S]):
    """The prospects of a mission whose hardware may die, and the cut sets that follow from them.

    Args:
        mission_net: The mission's net.
        space: The alternatives graph of :func:`mcpn.drawing.permanent_loss.mortal` of it.
    """

    def __init__(self, mission_net: MissionNet, space: Space[S]) -> None:
        super().__init__(mortal(mission_net), space)
        self.images = ImageStore(len(self.hardware))
        self._found: Alike[Found] = Alike()

    @cached_property
    def _from_start(self) -> S:
        """States to which runs lead along which nothing dies after the mission has begun."""
        before = self.space.marked([self.mission_net.beginning])
        return self.space.reached(before, transitions=self.everything)

    @cached_property
    def _at_worst(self) -> S:
        """States after runs without repairs and without avoidable failures, with all that is out dead."""
        space, transitions = self.space, self.unrepaired | self.dying
        found = space.reached(space.initial, transitions=transitions, guards=self.forced)
        return found - space.enabling(self.dying)

    def found(self, goal: Goal[S], section: Section | None = None) -> Found:
        """What makes a goal fail at each moment, for an objective also at the entry of its section.

        It is found once for objectives that are alike.
        """
        wanted = [moment for moment in Moment if section is not None or moment is not Moment.ENTRY]

        def compute() -> Found:
            losing = {moment: self.defeating(goal, moment, section) for moment in wanted}
            minimal = {moment: self.minimal(lost) for moment, lost in losing.items()}
            return Found(minimal, self.nonmonotone(losing[Moment.SOMETIME]))

        times = [self._at_worst, self._from_start]
        times += [] if section is None else [self.entered(section)]
        known = self.alike(goal, *(goal.running & states for states in times))
        return compute() if known is None else self._found.known(*known, compute)[0]

    def defeating(self, goal: Goal[S], moment: Moment, section: Section | None = None) -> Zdd:
        """The sets of hardware whose loss at a moment, for ``ENTRY`` that of a section, loses a goal.

        The family holds all larger sets too, but for ``SOMETIME`` (:meth:`nonmonotone`).
        """
        hopeful = self.hopeful(goal, repairs=True)
        if moment is Moment.SOMETIME:
            return self._dead((goal.running & self._at_worst) - hopeful - self._failed(goal))
        if moment is Moment.START:
            survived = self._from_start & goal.won
        elif moment is Moment.ENTRY:
            assert section is not None, "an entry is that of a section"
            survived = self.entered(section) & goal.running & hopeful
        else:
            survived = goal.running & hopeful
        return self.images.everything - self._dead(survived)

    def unaided(self, goal: Goal[S]) -> Unaided:
        """What defeats a goal of the mission, lost before the start, where nothing helps.

        Neither do declared events happen nor is a time over, before the start nor after it.
        """
        space, net = self.space, self.mission_net
        helping = frozenset(self.events.carrying(*HELPING))
        steps = self.everything - helping
        before = space.marked([net.beginning]) & space.reached(space.initial, transitions=steps | self.dying)
        won = goal.won
        if goal.ends_from:
            well = (states for t, states in goal.ends_from.items() if t not in helping)
            won = reduce(or_, well, self.mission.won)
        survived = space.reached(before, transitions=steps) & won
        minimal, helpers = self.minimal(self.images.everything - self._dead(survived)), dict[str, None]()
        aided = set(self.minimal(self.defeating(goal, Moment.START)))
        for lost in (lost for lost in minimal if lost not in aided):
            alive = [name for name in self.hardware if name not in lost]
            there = space.restricted(before, self.places("dead", lost), self.places("dead", alive))
            run = space.run(there.pick(), goal.won, transitions=self.everything) if there else None
            events = (net.net.transitions[edge.transition].event for edge in run or ())
            helpers |= dict.fromkeys(map(help_in_words, (e for e in events if e and e.what in HELPING)))
        return Unaided(minimal, tuple(helpers))

    def _failed(self, goal: Goal[S]) -> S:
        """States in which the mission has ended without success, and can lose it no more.

        An end in failure is no safe end. So it counts where that is asked.
        """
        if goal is self.safety:
            return self.space.nothing
        return self.space.marked(self.mission_net.ends.values()) - goal.won

    def _dead(self, states: S) -> Zdd:
        """The sets of hardware that is dead in some states."""
        return self.space.image(states, self.places("dead", self.hardware), self.images)

    @memoized
    def minimal(self, family: Zdd) -> list[CutSet]:
        """The minimal members of a family, by size, then in alphabetical order: minimal cut sets.

        It is the empty set alone where the goal can never be reached.

        Raises:
            LimitError: There are too many.
        """
        names = map(self._names, self.images.minimal(family))
        return sorted(names, key=lambda members: (len(members), members))

    def _names(self, members: Iterable[int]) -> CutSet:
        return tuple(sorted(self.hardware[member] for member in members))

    def nonmonotone(self, lost: Zdd) -> Nonmonotone | None:
        """A loss at the worst moment (``SOMETIME``) that one failure more would undo, where there is one.

        There is none where hardware in service can always fail, as the templates of the paper have it. Where
        there is one, the minimal cut sets are those of the least monotone function above.
        """
        for number, name in enumerate(self.hardware):
            larger = (self.images.with_member(lost, number) - lost).pick()
            if larger is not None:
                names = self._names(larger)
                return Nonmonotone(tuple(n for n in names if n != name), names)
        return None
