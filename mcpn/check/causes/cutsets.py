"""Minimal cut sets: minimal sets of hardware that, lost for good, leave no way to succeed; as a formula, too.

A set is lost for good where it is out of service and never repaired, while other hardware may fail and
recover as it likes. In the net whose hardware may die (:mod:`mcpn.net.mortal`) the sets that a goal survives
are the image, on the places *dead*, of the states from which a run without a further death reaches it. When
the hardware is lost is one of the moments of :class:`Moment`; the sets that are not survived are read off a
diagram, the minimal ones by their size, and no set is tried on its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import Enum
from functools import cached_property
from typing import Generic, NamedTuple

from mcpn._kernel import Zdd
from mcpn.check.causes.prospects import Goal, Prospects
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.flatten import Section
from mcpn.space.algebra import S
from mcpn.space.images import ImageStore
from mcpn.space.local.layout import remembered

MAX_TERMS = 2000
"""The most products of which a minimal formula is looked for."""

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
    """A set whose loss loses a goal at some moment, and the same with one resource more, which does not."""

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
        self._places = mortal.places("dead", self.hardware)

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

    def losing(self, goal: Goal[S], moment: Moment, section: Section | None = None) -> Zdd:
        """The sets of hardware whose loss loses a goal.

        Args:
            goal: The goal.
            moment: When they are lost.
            section: The section entered, for ``ENTRY``.

        Returns:
            A family that holds all larger sets too, but for ``SOMETIME`` (:meth:`nonmonotone`).
        """
        mortal, hopeful = self.mortal, self.mortal.hopeful(goal, repairs=True)
        if moment is Moment.SOMETIME:
            return self._dead((goal.running & self._at_worst) - hopeful)
        if moment is Moment.START:
            survived = self._from_start & goal.won
        elif moment is Moment.ENTRY:
            assert section is not None, "an entry is that of a section"
            survived = mortal.entered(section) & goal.running & hopeful
        else:
            survived = goal.running & mortal.begun & hopeful
        return self.images.everything - self._dead(survived)

    def _dead(self, states: S) -> Zdd:
        """The sets of hardware that is dead in some states."""
        return self.space.image(states, self._places, self.images)

    @remembered
    def minimal(self, family: Zdd) -> list[CutSet]:
        """The minimal members of a family: of :meth:`losing`, the minimal cut sets.

        Returns:
            Smaller sets first, then in alphabetical order; the empty set alone where the goal can never be
            reached.

        Raises:
            LimitError: There are too many.
        """
        names = map(self._names, self.images.minimal(family))
        return sorted(names, key=lambda members: (len(members), members))

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


def minimal_formula(losing: Sequence[CutSet]) -> str:
    """The minimal sum of products of a function, found by espresso and proved equivalent to it by a solver.

    A monotone function has just one, the sum of its minimal solutions.

    Args:
        losing: Products whose sum is the function, each of names of hardware; they need not be minimal.

    Returns:
        For example ``thruster_actuator | GPS_sensor & IMU_sensor``, smaller products first, then in
        alphabetical order; ``0`` never, ``1`` always.

    Raises:
        LimitError: pyeda is not installed, or the function has more than :data:`MAX_TERMS` products.
        SemanticsError: The solver finds the formula and the function to differ.
    """
    if not losing or () in losing:
        return "1" if losing else "0"
    if len(losing) > MAX_TERMS:
        raise LimitError(f"{len(losing)} products: more than {MAX_TERMS}, the limit on products of a formula")
    try:
        from pyeda.boolalg.expr import And, Or, Xor, exprvar
        from pyeda.boolalg.minimization import espresso_exprs
    except ImportError as error:
        raise LimitError('minimal formulas need pyeda: pip install "mcpn[pyeda]"') from error
    names = sorted({name for product in losing for name in product})
    variables = {name: exprvar("hardware", number) for number, name in enumerate(names)}
    function = Or(*(And(*(variables[name] for name in product)) for product in losing))
    (minimised,) = espresso_exprs(function.to_dnf())
    if Xor(function, minimised).satisfy_one() is not None:
        raise SemanticsError("espresso's formula differs from the function that it minimises")
    products = [sorted(names[variable.indices[0]] for variable in cube) for cube in minimised.cover]
    return " | ".join(" & ".join(product) for product in sorted(products, key=lambda p: (len(p), p)))
