"""Minimal cut sets: minimal sets of hardware that, lost for good, leave no way to succeed.

A set is lost for good where it is out of service and never repaired, while other hardware may fail and
recover as it likes. In the net whose hardware may die (:mod:`mcpn.net.mortal`) the sets that a goal survives
are the image, on the places *dead*, of the states from which a run without a further death reaches it. When
the hardware is lost is one of the moments of :class:`Moment`; the sets that are not survived are read off a
diagram, the minimal ones by their size, and no set is tried on its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Generic

from mcpn._kernel import Zdd
from mcpn.check.causes.prospects import Goal, Prospects
from mcpn.mission.flatten import Section
from mcpn.space.algebra import S
from mcpn.space.images import ImageStore

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


@dataclass(frozen=True)
class Nonmonotone:
    """A set that is lost while a larger one is not: only hardware that cannot always fail does so.

    Args:
        lost: A set of hardware that loses the goal at some moment.
        larger: The same and one resource more, which does not.
    """

    lost: CutSet
    larger: CutSet


class CutSets(Generic[S]):
    """The cut sets of a mission and its objectives.

    Args:
        mortal: The mission in a space of its net whose hardware may die.
    """

    def __init__(self, mortal: Prospects[S]) -> None:
        self.mortal = mortal
        self.space = mortal.space
        self.hardware = mortal.hardware
        self.images = ImageStore(len(self.hardware))
        self._minimal: dict[Zdd, list[CutSet]] = {}
        self._dead = mortal.places("dead", self.hardware)

    @cached_property
    def _from_start(self) -> S:
        """States to which runs lead along which nothing dies after the mission has begun."""
        before = self.space.marked([self.mortal.mission_net.beginning])
        return self.space.reached(before, transitions=self.mortal.everything)

    @cached_property
    def _at_worst(self) -> S:
        """States after runs without repairs and without avoidable failures, with all that is out dead."""
        mortal, space = self.mortal, self.space
        transitions = mortal.unrepaired | mortal.dying
        found = space.reached(space.initial, transitions=transitions, guards=mortal.forced)
        return (found & mortal.begun) - space.enabling(mortal.dying)

    def states(self, goal: Goal[S], moment: Moment, section: Section | None = None) -> S:
        """The states at a moment: those that have reached the goal for ``START``, else those that may."""
        if moment is Moment.START:
            return self._from_start & goal.won
        if moment is Moment.ENTRY:
            assert section is not None, "an entry is that of a section"
            return self.mortal.entered(section) & goal.running
        return goal.running & (self.mortal.begun if moment is Moment.WHENEVER else self._at_worst)

    def losing(self, goal: Goal[S], moment: Moment, section: Section | None = None) -> Zdd:
        """The sets of hardware whose loss loses a goal.

        Args:
            goal: The goal.
            moment: When they are lost.
            section: The section entered, for ``ENTRY``.

        Returns:
            A family that holds all larger sets too, but for ``SOMETIME`` (:meth:`nonmonotone`).
        """
        states = self.states(goal, moment, section)
        if moment is Moment.SOMETIME:
            return self.space.image(states - self.mortal.hopeful(goal), self._dead, self.images)
        if moment is not Moment.START:
            states = states & self.mortal.hopeful(goal)
        return self.images.everything - self.space.image(states, self._dead, self.images)

    def minimal(self, family: Zdd) -> list[CutSet]:
        """The minimal members of a family: of :meth:`losing`, the minimal cut sets.

        Returns:
            Smaller sets first, then in alphabetical order; the empty set alone where the goal can never be
            reached.

        Raises:
            LimitError: There are too many.
        """
        if family not in self._minimal:
            names = map(self._names, self.images.minimal(family))
            self._minimal[family] = sorted(names, key=lambda members: (len(members), members))
        return self._minimal[family]

    def _names(self, members: Iterable[int]) -> CutSet:
        return tuple(sorted(self.hardware[member] for member in members))

    def nonmonotone(self, lost: Zdd) -> Nonmonotone | None:
        """A loss at the worst moment that one failure more would undo, where there is one.

        The functions of the other moments are monotone as they stand. That of ``SOMETIME`` is where hardware
        in service can always fail, which the templates of the paper allow. Where it is not, the minimal cut
        sets are those of the least monotone function above it: their supersets may survive.

        Args:
            lost: What :meth:`losing` says of a goal ``SOMETIME``.
        """
        for number, name in enumerate(self.hardware):
            larger = (self.images.with_member(lost, number) - lost).pick()
            if larger is not None:
                names = self._names(larger)
                return Nonmonotone(tuple(n for n in names if n != name), names)
        return None
