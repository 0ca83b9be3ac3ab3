"""Minimal cut sets: minimal sets of hardware that, out of service and not repaired, leave no way to succeed.

For a goal and a set ``D`` of hardware, a state *holds out* where some run without a repair of ``D`` reaches
the goal; other hardware may fail and recover as it likes. ``loss[s]`` is the function that is true of those
``D`` with which ``s`` does not hold out. It is monotone: more hardware that stays out leaves fewer runs. All
the functions of a graph are one greatest fixpoint,

    loss[s] = never, where the goal is reached; else
    loss[s] = for all edges s -> t: loss[t], or, where the edge repairs h, (loss[t] or h in D),

worked out on diagrams of minimal solutions (:mod:`mcpn.check.families`), so that the 2^n sets are never gone
through one by one. When ``D`` is lost is one of the moments of :class:`Moment`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from mcpn.check.families import ALWAYS, NEVER, Families, Family
from mcpn.check.losing import Goal, Outlook
from mcpn.space.graph import Mask

CutSet = tuple[str, ...]
"""Names of hardware, in alphabetical order."""


class Moment(Enum):
    """When a set of hardware is out of service, for it to be a cut set.

    ``START`` and ``ENTRY`` and ``WHENEVER`` ask that *every* such state loses; ``SOMETIME`` that *one* does.
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


class Losses:
    """The loss functions of a mission and its objectives on one graph.

    Args:
        outlook: The mission on its alternatives graph (or markings graph).
        families: Where to make the functions, and what its elements are, where the graph is one of several
            that share them; by default the elements are the graph's faulty hardware.
        hardware: Names of the elements.
    """

    def __init__(
        self,
        outlook: Outlook,
        families: Families | None = None,
        hardware: Sequence[str] | None = None,
    ) -> None:
        self.outlook = outlook
        self.hardware = tuple(outlook.hardware if hardware is None else hardware)
        self.families = families or Families(len(self.hardware))
        self.elements = [self.hardware.index(name) for name in outlook.hardware]
        self._functions: dict[tuple[str, str], list[Family]] = {}

    def functions(self, goal: Goal) -> list[Family]:
        """The loss function of each state for a goal; those of states where it is not open mean nothing.

        Args:
            goal: The goal.

        Returns:
            By state. Each function only ever shrinks, so the number of rounds is bounded by the height of
            the lattice of functions; in practice each state changes a few times.
        """
        key = goal.kind, goal.name
        if key not in self._functions:
            self._functions[key] = self._fixpoint(goal, [(goal.won, NEVER)])
        return self._functions[key]

    def lead_on(self, goal: Goal, ends: Sequence[tuple[Mask, Family]]) -> None:
        """Says what is lost behind the ends of a graph that is part of a larger whole.

        Args:
            goal: A goal beyond the graph.
            ends: States in which the graph is left, shape (states,), with the loss function there.
        """
        self._functions[goal.kind, goal.name] = self._fixpoint(goal, ends)

    def _fixpoint(self, goal: Goal, ends: Sequence[tuple[Mask, Family]]) -> list[Family]:
        graph, families = self.outlook.graph, self.families
        loss = [ALWAYS] * graph.states
        queued = [False] * graph.states
        queue: deque[int] = deque()
        for states, behind in ends:
            for state in np.flatnonzero(states).tolist():
                loss[state] = behind
                queued[state] = True
                queue.append(state)
        offsets, incoming = graph.incoming
        sources, along = graph.sources.tolist(), goal.along.tolist()
        repaired = self.outlook.repaired.tolist()
        guards = [families.single(element) for element in self.elements]
        bounds, order = offsets.tolist(), incoming.tolist()
        while queue:
            state = queue.popleft()
            queued[state] = False
            for edge in order[bounds[state] : bounds[state + 1]]:
                before = sources[edge]
                if not along[edge] or loss[before] == NEVER:
                    continue
                after = loss[state]
                if repaired[edge] >= 0:
                    after = families.either(after, guards[repaired[edge]])
                less = families.both(loss[before], after)
                if less != loss[before]:
                    loss[before] = less
                    if not queued[before]:
                        queued[before] = True
                        queue.append(before)
        return loss

    # --- moments ---------------------------------------------------------------------------------------

    def in_every(self, goal: Goal, states: Mask) -> Family:
        """Sets that lose the goal from every one of some states in which they are out of service.

        Args:
            goal: The goal.
            states: Shape (states,).

        Returns:
            The monotone function as its minimal solutions: for each state, ``D`` is not all out of service
            there, or is lost there.
        """
        families, found = self.families, ALWAYS
        for out, loss in self._distinct(goal, states):
            elsewhere = families.any_of(h for h in self.elements if h not in out)
            found = families.both(found, families.either(elsewhere, loss))
        return found

    def in_some(self, goal: Goal, states: Mask) -> Family:
        """Minimal sets that lose the goal from some of the states in which just they are out of service.

        Hardware that the graph does not know may be out of service besides in any of its states.
        """
        families, found, here = self.families, NEVER, frozenset(self.elements)
        others = frozenset(range(families.elements)) - here
        for out, loss in self._distinct(goal, states):
            besides = families.assuming(families.inside(loss, out | others), out)
            found = families.either(found, families.both(families.all_of(out), besides))
        return found

    def _distinct(self, goal: Goal, states: Mask) -> list[tuple[frozenset[int], Family]]:
        functions, out = self.functions(goal), self.outlook.out
        pairs = {(out[s].tobytes(), functions[s]): s for s in np.flatnonzero(states).tolist()}
        return [(self.out(s), loss) for (_, loss), s in pairs.items()]

    def out(self, state: int) -> frozenset[int]:
        """The elements that are out of service in a state."""
        return frozenset(self.elements[h] for h in np.flatnonzero(self.outlook.out[state]).tolist())

    def cut_sets(self, goal: Goal, moment: Moment, section: str | None = None) -> Family:
        """The minimal cut sets of a goal.

        Args:
            goal: The goal.
            moment: When they are lost.
            section: The section entered, for ``ENTRY``: any elementary objective or parallel block.

        Returns:
            Minimal solutions; the empty set alone where the goal can never be reached.
        """
        outlook = self.outlook
        if moment is Moment.START:
            return self.in_every(goal if goal.kind == "mission" else self.ever(goal), ~outlook.begun)
        if moment is Moment.ENTRY:
            assert section is not None, "an entry is that of a section"
            return self.in_every(goal, self.entry(section) & goal.running)
        if moment is Moment.WHENEVER:
            return self.in_every(goal, goal.running & outlook.begun)
        return self.in_some(goal, self._at_worst(goal))

    def _at_worst(self, goal: Goal) -> Mask:
        return np.asarray(goal.running & self.outlook.begun & self.after_forced(0), np.bool_)

    def after_forced(self, state: int) -> Mask:
        """States that runs without repairs and without avoidable failures lead to from one."""
        return self.outlook.graph.reached(self.outlook.forced, state)

    def ever(self, goal: Goal) -> Goal:
        """The same for an objective whenever it may run: it succeeds at least once in the mission."""
        anywhere = np.ones(self.outlook.graph.states, np.bool_)
        return Goal(goal.kind, f"{goal.name}, ever", anywhere, goal.won, self.outlook.allowed(True))

    def entry(self, section: str) -> Mask:
        """States at the entry of a section of this name."""
        return self._entries[section]

    @cached_property
    def _entries(self) -> Mapping[str, Mask]:
        return {s.name: self.outlook.entered(s) for s in self.outlook.mission_net.graph.all_sections()}

    # --- premise ---------------------------------------------------------------------------------------

    def nonmonotone(self, goal: Goal) -> Nonmonotone | None:
        """A loss at the worst moment that one failure more would undo, where there is one.

        The functions of :meth:`in_every` are monotone as they stand. That of :meth:`in_some` is monotone
        where hardware in service can always fail, which the templates of the paper allow; it is decided on
        the sets themselves. Where it is not, the minimal cut sets are those of the least monotone function
        above it: their supersets may survive.
        """
        lost = {
            out for out, loss in self._distinct(goal, self._at_worst(goal)) if self.families.holds(loss, out)
        }
        for out in sorted(lost, key=lambda members: (len(members), sorted(members))):
            for h in range(self.families.elements):
                if out | {h} not in lost:
                    return Nonmonotone(self.names(out), self.names(out | {h}))
        return None

    # --- words -----------------------------------------------------------------------------------------

    def names(self, members: tuple[int, ...] | frozenset[int]) -> CutSet:
        """Names of hardware, sorted."""
        return tuple(sorted(self.hardware[h] for h in members))

    def listed(self, family: Family) -> list[CutSet]:
        """A family by names, smaller sets first, then in alphabetical order."""
        found = [self.names(members) for members in self.families.members(family)]
        return sorted(found, key=lambda names: (len(names), names))
