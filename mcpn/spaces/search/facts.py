"""What is true of a net as a whole, by the state equation, by walks and by its arcs: no space is built.

The state equation says how many tokens there may be and which transitions never fire; walks meet these bounds
and fire the others. Each answer is exact: a bound counts once a marking has reached it, and a transition is
dead or has fired, or nothing is said.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from itertools import islice
from math import inf
from typing import TypeAlias, TypeVar

from mcpn.errors import LimitError
from mcpn.nets.petri import Marking, PetriNet
from mcpn.nets.repeatable import repeatable
from mcpn.nets.siphons import classes, commoner
from mcpn.nets.structure import incidence, needs
from mcpn.spaces.search import HOME, INITIAL_STATE, RANDOM_WALK, STATE_EQUATION, STRUCTURE, TRAPS
from mcpn.spaces.search.equation import Ceiling, StateEquation
from mcpn.spaces.search.goal import AtMost, Fires, Formula, Goal, as_goal, asks_dead, fireable, holds, marked
from mcpn.spaces.search.home import Home, proved_home
from mcpn.spaces.search.portfolio import FIRINGS, MOST_COUNTED
from mcpn.spaces.search.searches import Searches

STEPS = 20_000
"""Firings of walks for each sum; as many for all transitions together, and some for each."""
STEPS_OF_TRANSITION = 50
MOST_WORK, WORK_OF_CALL = 2_000_000, 500
"""How much work the equation is asked for of all transitions, of all places and of all atoms: calls times
arcs, as if each net had some more."""
MOST_TOGETHER = 20
"""Sums whose walks have their full number of firings."""
MOST_JOINED, FEW_CASES = 40, 4
"""Conditions that are joined of several, each of which takes a program of its own, and cases of each."""
SIPHON_STEPS = 500
WALKS = 6
"""Walks, each twice as long as the one before, after which it is looked whether a transition is dead."""
MOST_ARCS = 5_000
"""Where a net has more, neither its siphons nor a home marking are looked for."""

Ways: TypeAlias = tuple[str, ...]
Asked = TypeVar("Asked")


class Facts:
    """Bounds, dead transitions, safety and liveness of a net without priorities.

    Args:
        net: The net.
        bounds: Most tokens of each place, as far as is known already.
        searches: Walks on the net, where there are some already.

    Attributes:
        fires: Transitions that are known to fire in some reachable marking.
        dead: Transitions that are known never to fire.
    """

    def __init__(self, net: PetriNet, bounds: Sequence[float] = (), searches: Searches | None = None) -> None:
        assert not net.priorities, "with priorities, less fires than the arcs say"
        self.net = net
        self.equation = StateEquation(net, bounds)
        self.searches = searches or Searches(net)
        self.fires: set[int] = set()
        self.dead: set[int] = set()
        self._traps = False
        self._bounds = dict(enumerate(bounds))
        self._constant: dict[Formula, bool | None] = {}
        self._round = 0
        self._walks = self.searches.ends(steps=STEPS + len(net.transitions), walks=WALKS)
        self._came: list[list[int]] = []

    # --- bounds ---

    def sums(self, asked: Iterable[tuple[int, ...]]) -> Iterator[tuple[tuple[int, ...], int, Ways]]:
        """The most tokens that places hold together, of sums whose bound by the equation is met.

        Args:
            asked: Places of each sum; one that stands twice counts twice.

        Yields:
            A sum, its bound, and how it was had.
        """
        left: list[tuple[tuple[int, ...], int, Ceiling, Goal]] = []
        for places in asked:
            found = self.equation.most(Counter(places))
            if found.bound is None:
                continue
            goal = exceeding(places, found.bound - 1)
            if holds(goal, self.net, self.net.initial):
                yield places, found.bound, (INITIAL_STATE, *_proved(found.traps))
            else:
                left.append((places, found.bound, found, goal))
        reached = self._met([goal for *_, goal in left], STEPS * min(len(left), MOST_TOGETHER))
        for number, (places, bound, found, goal) in enumerate(left):
            if number in reached or self._counted(goal, found.counts):
                yield places, bound, (*_proved(found.traps), RANDOM_WALK)

    # --- transitions ---

    def know_transitions(self) -> None:
        """Finds out, once, which transitions fire and which are dead, as far as that is told."""
        if self.fires or self.dead:
            return
        self.dead |= set(range(len(self.net.transitions))) - possible(self.net, self.net.initial)
        self._fire(STEPS)
        for t in self._affordable(self.unknown):
            solution = self.equation.solve(fireable(self.net, t))
            if solution.kind == "unreachable":
                self.dead.add(t)
                self._traps = self._traps or bool(solution.traps)
            elif solution.kind == "possible" and self._counted(fireable(self.net, t), solution.counts):
                self.fires.add(t)

    @property
    def unknown(self) -> list[int]:
        """Transitions of which neither is known."""
        return [t for t in range(len(self.net.transitions)) if t not in self.fires and t not in self.dead]

    @property
    def ways(self) -> Ways:
        """How it was found out which transitions fire."""
        return (RANDOM_WALK, *(_proved(self._traps) if self.dead else ()))

    def _fire(self, steps: int) -> None:
        open_ones = self.unknown
        goals = [fireable(self.net, t) for t in open_ones]
        found = self._met(goals, steps + STEPS_OF_TRANSITION * len(goals))
        self.fires.update(open_ones[goal] for goal in found)

    # --- examinations ---

    @property
    def examinations(self) -> dict[str, Callable[[], tuple[bool | None, Ways]]]:
        """By names of the contest: what decides each, cheap ones first; ``None`` where it is not decided."""
        return {
            "OneSafe": self.safe,
            "QuasiLiveness": self.quasi_live,
            "StableMarking": self.stable_place,
            "Liveness": self.live,
        }

    def quasi_live(self) -> tuple[bool | None, Ways]:
        """Whether every transition fires somewhere, and how it is known."""
        self.know_transitions()
        return (False if self.dead else None if self.unknown else True), self.ways

    def stable_place(self) -> tuple[bool | None, Ways]:
        """Whether the tokens of some place never change, and how it is known."""
        changing = incidence(self.net)
        if not all(changing):
            return True, (STRUCTURE,)
        self.know_transitions()
        if any(self.dead.issuperset(row) for row in changing):
            return True, self.ways
        return (None if any(self.fires.isdisjoint(row) for row in changing) else False), self.ways

    def safe(self) -> tuple[bool | None, Ways]:
        """Whether no place ever holds two tokens, as far as the equation and walks tell, and how."""
        crowded, whole = self._crowded(1)
        if self._met([marked(p, tokens=2) for p in crowded], STEPS * min(len(crowded), MOST_TOGETHER)):
            return False, (RANDOM_WALK,)
        return (None, ()) if crowded or not whole else (True, _proved(self._traps))

    @cached_property
    def bounded(self) -> bool:
        """Whether the equation bounds every place."""
        return self._crowded(inf) == ([], True)

    def _crowded(self, most: float) -> tuple[list[int], bool]:
        """Places not proved to hold so few tokens, and whether the others are proved to."""
        crowded: list[int] = []
        known = self._bounds
        every = range(len(self.net.places))
        for place in self._affordable(p for p in every if known.get(p, inf) == inf or known[p] > most):
            found = self.equation.most({place: 1})
            self._traps = self._traps or bool(found.traps)
            for other, bound in self.equation.shared(found).items():
                known[other] = min(bound, known.get(other, inf))
            if found.bound is not None:
                known[place] = min(found.bound, known.get(place, inf))
            if known.get(place, inf) > most or place not in known:
                crowded.append(place)
        return crowded, all(p in crowded or (p in known and known[p] <= most) for p in every)

    def _affordable(self, asked: Iterable[Asked]) -> Iterator[Asked]:
        """Those of which the equation is asked one by one: fewer, the larger the net is."""
        return islice(asked, MOST_WORK // self._size)

    @cached_property
    def _size(self) -> int:
        return WORK_OF_CALL + sum(len(t.consume) + len(t.produce) for t in self.net.transitions)

    def know(self, conditions: Iterable[Formula]) -> None:
        """Finds out which conditions have one value in all markings, as far as walks and the equation tell.

        Args:
            conditions: Those that :meth:`always` will be asked about.
        """
        changed: dict[Formula, Goal] = {}
        for condition in dict.fromkeys(conditions):
            goal = as_goal(condition, self.net)
            if goal is None or asks_dead(goal) or condition in self._constant:
                continue
            if holds(goal, self.net, self.net.initial):
                goal = as_goal(condition, self.net, wanted=False)
            assert goal is not None, "its negation speaks of tokens, too"
            changed[condition], self._constant[condition] = goal, None
        goals = list(changed.values())
        met = self._met(goals, STEPS * min(len(goals), MOST_TOGETHER))
        left = [condition for index, condition in enumerate(changed) if index not in met]
        sums = [condition for condition in left if isinstance(changed[condition], AtMost)]
        joined = (condition for condition in left if not isinstance(changed[condition], AtMost))
        for condition in self._affordable([*sums, *islice(joined, MOST_JOINED)]):
            if self._refuted(changed[condition]):
                goal = as_goal(condition, self.net)
                assert goal is not None, "it was one before"
                self._constant[condition] = holds(goal, self.net, self.net.initial)

    def _refuted(self, goal: Goal) -> bool:
        """Whether the equation shows that no marking of a goal is reachable."""
        if isinstance(goal, AtMost):
            most = self.equation.most({place: -weight for place, weight in goal.weights}).bound
            return most is not None and most < -goal.bound
        return self.equation.solve(goal, FEW_CASES).kind == "unreachable"

    def always(self, condition: Formula) -> bool | None:
        """The value of a condition that is the same in every reachable marking; ``None`` where not known."""
        if isinstance(condition, Fires) and self.dead.issuperset(condition.transitions):
            return False
        return self._constant.get(condition)

    @cached_property
    def home(self) -> Home | None:
        """A marking that every reachable one leads to, if one is proved: the initial one, or a dead one."""
        small = self._size - WORK_OF_CALL <= MOST_ARCS and self.searches.fits and self.equation.fits
        if not small or not self.bounded:
            return None
        here: Marking | None = self.net.initial
        first, dead = possible(self.net, self.net.initial), set[Marking]()
        for end in self._ends():
            if not self.net.enabled(end):
                dead.add(tuple(end))
                if len(dead) > 1:
                    return None
            elif not first <= possible(self.net, end):
                here = None  # from there nothing leads back
        if dead:
            (here,) = dead
        bounds = [self._bounds[place] for place in range(len(self.net.places))]
        return proved_home(StateEquation(self.net, bounds), self.searches, here) if here else None

    def _ends(self) -> Iterator[list[int]]:
        """Where some walks have come to, each made when it is first asked for."""
        yield from self._came
        for end in self._walks:
            self._came.append(end)
            yield end

    def live(self) -> tuple[bool | None, Ways]:
        """Whether every transition can always fire again, as far as arcs and the equation tell, and how."""
        every = range(len(self.net.transitions))
        if self.equation.fits and self.bounded and len(repeatable(self.net, every)) < len(every):
            return False, (STATE_EQUATION,)  # what lowers a bounded sum that nothing raises ends
        if sum(len(t.consume) for t in self.net.transitions) <= MOST_ARCS:
            try:
                if {"ordinary", "free choice"} <= classes(self.net):
                    return commoner(self.net, max_steps=SIPHON_STEPS) is None, (STRUCTURE,)
            except LimitError:
                pass
        if any(len(possible(self.net, end)) < len(every) for end in self._ends()):
            return False, (RANDOM_WALK, STRUCTURE)  # a siphon has emptied
        if self.home and self.home.marking == self.net.initial:
            fires, ways = self.quasi_live()
            return fires, (*ways, HOME, STATE_EQUATION)
        return None, ()

    # --- walks ---

    def _met(self, goals: Sequence[Goal], steps: int) -> set[int]:
        """The goals that a walk has met, by index."""
        if not goals or not self.searches.fits:
            return set()
        self._round += 1
        return self.searches.met(goals, steps=steps, seed=self._round)

    def _counted(self, goal: Goal, counts: Sequence[int]) -> bool:
        """Whether a walk by proposed numbers of firings meets a goal."""
        firings = sum(counts)
        if not self.searches.fits or FIRINGS * firings > MOST_COUNTED:
            return False
        return bool(self.searches.met([goal], steps=STEPS + FIRINGS * firings, counts=counts))


def exceeding(places: Sequence[int], bound: int) -> Goal:
    """The markings where places hold together more tokens; one that stands twice counts twice."""
    return AtMost(tuple((place, -times) for place, times in sorted(Counter(places).items())), -bound - 1)


def _proved(traps: int) -> Ways:
    return (STATE_EQUATION, TRAPS) if traps else (STATE_EQUATION,)


def possible(net: PetriNet, marking: Sequence[int]) -> set[int]:
    """Transitions whose places can be marked one after the other: all others need an empty siphon.

    Args:
        net: The net.
        marking: Where they begin.
    """
    marked_ones = {p for p, tokens in enumerate(marking) if tokens}
    waiting: dict[int, list[int]] = {}
    missing = []
    ready = []
    for t in range(len(net.transitions)):
        wanted = needs(net, t).keys() - marked_ones
        missing.append(len(wanted))
        for place in wanted:
            waiting.setdefault(place, []).append(t)
        if not wanted:
            ready.append(t)
    found = set(ready)
    while ready:
        for place, _ in net.transitions[ready.pop()].produce:
            for t in waiting.pop(place, ()):
                missing[t] -= 1
                if not missing[t]:
                    found.add(t)
                    ready.append(t)
    return found
