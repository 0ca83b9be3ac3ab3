"""What is known of formulas at a net's initial state without its space, and the runs that show it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING

from mcpn.logic.formulas import EG, EU, says_eventually
from mcpn.logic.initial_state import at_first
from mcpn.logic.ltl.formulas import Release, SomePath, Until
from mcpn.logic.simplify import simplified, takes_away, where_paths_end
from mcpn.logic.witness import Explanation, NoRun, Witness
from mcpn.nets.petri import EVENTS, Marking, PetriNet
from mcpn.records import record
from mcpn.spaces.algebra import Edge
from mcpn.spaces.formula_names import Names
from mcpn.spaces.run import Completion
from mcpn.spaces.search.goal import (
    DEADLOCK,
    FALSE,
    TRUE,
    And,
    Deadlock,
    Formula,
    Goal,
    Not,
    Or,
    as_goal,
    holds,
    none_more_urgent,
)

if TYPE_CHECKING:
    from mcpn.logic.ltl.path_search import FoundPath
    from mcpn.spaces.search.facts import Facts
    from mcpn.spaces.search.home import Home

SOME_DEADLOCK = EU(TRUE, DEADLOCK)


@record(frozen=True)
class Fired:
    """A net whose states are its markings, fired one after the other.

    Args:
        net: The net.
    """

    net: PetriNet

    def marking(self, state: Marking) -> Marking:
        """The state itself."""
        return state


class Known:
    """Values of formulas at the initial state of a graph whose states are not listed.

    Args:
        net: The net.
        settled: Whether the states are the stable markings alone.

    Attributes:
        values: By part of a simplified formula its value at the initial state.
        runs: By part that begins with ``EF`` and holds the transitions of a run to where its operand holds.
        paths: By part that asks for some path and holds such a path.
        home: A marking that every reachable one leads to, where one is known.
        all_ends: Whether nothing can go on for ever, as far as is known.
        bounds: Most tokens of each place, as far as is known.
    """

    def __init__(self, net: PetriNet, *, settled: bool) -> None:
        self.net, self.settled = net, settled
        self.values: dict[Formula, bool] = {}
        self.runs: dict[Formula, tuple[int, ...]] = {}
        self.paths: dict[Formula, FoundPath] = {}
        self.home: Home | None = None
        self.all_ends = not net.priorities and takes_away(net)
        self.bounds: Sequence[float] = [inf] * len(net.places)
        self._facts: Facts | None = None
        self._simple: dict[Formula, Formula] = {}
        self._goals: dict[Formula, Goal | None] = {}

    def believe(self, facts: Facts) -> None:
        """Puts in what is true of the net as a whole: formulas are simplified anew."""
        self._facts = facts
        self.forget()

    def forget(self) -> None:
        """Simplifies formulas anew, since more is known."""
        self._simple.clear()

    @cached_property
    def initial(self) -> Marking:
        """The initial state."""
        marking = list(self.net.initial)
        if self.settled:
            for _ in Completion(self.net).settle(marking):
                pass
        return tuple(marking)

    def simple(self, formula: Formula) -> Formula:
        """A smaller formula with the same value in every state."""
        if formula == SOME_DEADLOCK:  # no bound makes it smaller
            return formula
        if formula not in self._simple:
            self._simple[formula] = simplified(
                formula,
                self.net,
                self.bounds,
                self._always if self._facts else where_paths_end if self.all_ends else lambda _: None,
                spelled=self._facts is not None and not self.net.priorities,
            )
        return self._simple[formula]

    def _always(self, part: Formula) -> bool | None:
        """The value of a part where it is the same in every reachable marking; ``None`` where not known.

        Every reachable marking leads to a home marking, so that what holds there may always hold again. What
        can be reached from the initial marking can be from all, if it is one. If every run ends in a home
        marking, what fails there does not hold all along.
        """
        assert self._facts is not None
        if self.all_ends and (value := where_paths_end(part)) is not None:
            return value
        home = self.home
        match part:
            case Deadlock():
                never = self.values.get(SOME_DEADLOCK) is False or (home and self.net.enabled(home.marking))
                return False if never else None
            case EU((And(()), operand)) if home:
                goal = self.as_goal(operand)
                if goal is not None and holds(goal, self.net, home.marking):
                    return True
                return self.values.get(part) if self.reversible else None
            case Until((And(()), operand)) if home and home.ends:
                goal = self.as_goal(operand)
                return True if goal is not None and holds(goal, self.net, home.marking) else None
            case EG((operand,)) | Release((Or(()), operand)) if home and home.ends:
                goal = self.as_goal(operand)
                return None if goal is None or holds(goal, self.net, home.marking) else False
        return self._facts.always(part)

    @property
    def reversible(self) -> bool:
        """Whether every reachable marking is known to lead back to the initial one."""
        return self.home is not None and self.home.marking == self.net.initial

    def nested(self, formula: Formula) -> Iterator[Formula]:
        """Parts inside operators that have one value in all markings, since the net is reversible."""
        for part in self.simple(formula).walk() if self.reversible else ():
            for inside in part.operands if not isinstance(part, Not | And | Or) else ():
                for below in inside.walk():
                    if says_eventually(below) and not any(map(says_eventually, below.operands[1].walk())):
                        yield below

    def rest(self, formula: Formula, marking: Marking | None = None) -> Formula:
        """What is left to ask of a formula in a state: a constant where what is known decides it.

        Args:
            formula: The formula.
            marking: The state; by default the initial one, of which more is known than its marking.
        """

        def value(part: Formula) -> bool | None:
            if marking is None and part in self.values:
                return self.values[part]
            goal = self.as_goal(part)
            return None if goal is None else holds(goal, self.net, marking or self.initial)

        return at_first(self.simple(formula), value)

    def as_goal(self, formula: Formula) -> Goal | None:
        """What :func:`mcpn.spaces.search.goal.as_goal` makes of a formula, once."""
        if formula not in self._goals:
            self._goals[formula] = as_goal(formula, self.net)
        return self._goals[formula]

    def goal(self, part: Formula) -> Goal | None:
        """The markings that a search looks for where a part is ``EF f`` and needs no more; else ``None``."""
        match part:
            case EU((And(()), inside)):
                goal = self.as_goal(inside)
                # A dead marking is stable; of other goals only the stable markings count.
                unrestricted = goal is None or goal == DEADLOCK or not self.settled
                return goal if unrestricted else self.as_goal(And(inside, none_more_urgent(self.net, EVENTS)))
        return None

    def beginning(self, names: Names) -> Witness:
        """A run that has not left the initial state."""
        return Witness(Fired(self.net), self.initial, names, self.settled and self.net.priorities)

    def explain(self, formula: Formula, value: bool, names: Names) -> Witness:
        """Shows by a run why a formula has a value in the initial state.

        Raises:
            NoRun: No run is known that shows it.
        """
        witness = self.beginning(names)
        _ByRuns(self, witness).explain(formula, value)
        return witness


class _ByRuns(Explanation):
    """Explains by the runs that searches have found."""

    def __init__(self, known: Known, witness: Witness) -> None:
        super().__init__(witness)
        self.known = known

    def _rest(self, formula: Formula) -> Formula:
        return self.known.rest(formula, self.witness.end if self.witness.steps else None)

    def value(self, formula: Formula) -> bool | None:
        return {TRUE: True, FALSE: False}.get(self._rest(formula))

    def reach(self, left: Formula, right: Formula) -> None:
        if self.value(right):
            return
        run = None if self.witness.steps else self.known.runs.get(self.known.simple(EU(left, right)))
        if run is None:
            raise NoRun
        self._fire(run)

    def _fire(self, run: Sequence[int]) -> None:
        """Appends the edges of a run: firings, or events each with the internal firings behind it.

        Of its markings the last is kept alone, where the explanation goes on: a run may be as long as the net
        has places.
        """
        from mcpn.spaces.search.searches import replay

        net = self.known.net
        events: list[list[int]] = []
        for t in run:
            if not self.witness.settles or not net.transitions[t].internal:
                events.append([t])
            elif events:
                events[-1].append(t)
        if events:
            ends = (*(None for _ in events[1:]), replay(net, run))
            self.witness.steps += (
                Edge(t, end, tuple(rest)) for (t, *rest), end in zip(events, ends, strict=True)
            )

    def step(self, operand: Formula) -> None:
        net, here = self.known.net, self.witness.end
        completion = Completion(net) if self.witness.settles else None
        for t in net.enabled(here):
            internal, after = completion.after(here, t) if completion else ((), net.fire(here, t))
            if self.known.rest(operand, after) == TRUE:
                self.witness.steps.append(Edge(t, after, internal))
                return
        raise NoRun

    def stay(self, operand: Formula) -> None:
        raise NoRun

    def show_path(self, formula: SomePath) -> None:
        raise NoRun

    def explain(self, formula: Formula, holds: bool) -> None:
        path = self.known.paths.get(self.known.simple(formula)) if holds else None
        if path is None or self.witness.steps:
            super().explain(formula, holds)
            return
        self.note("along this run", formula)
        self._fire(path.run)
        self.show_rest(path.cycle, decided=bool(self.known.net.enabled(self.witness.end)))
