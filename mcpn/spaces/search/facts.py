"""What is true of a net as a whole, by the state equation, by walks and by its arcs: no space is built.

What takes long is work that pauses (:mod:`mcpn.turns`): ended early, it has found out less and nothing wrong.

The state equation says how many tokens there may be and which transitions never fire; walks meet these bounds
and fire the others. Each answer is exact: a bound counts once a marking has reached it, and a transition is
dead or has fired, or nothing is said.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from math import inf
from typing import TypeAlias

from mcpn.errors import LimitError
from mcpn.nets.petri import Marking, PetriNet
from mcpn.nets.repeatable import repeatable
from mcpn.nets.siphons import commoner
from mcpn.nets.structural_classes import classes
from mcpn.nets.structure import incidence, needs
from mcpn.spaces.search import HEURISTIC, HOME, INITIAL_STATE, RANDOM_WALK, STATE_EQUATION, STRUCTURE, TRAPS
from mcpn.spaces.search.equation import Ceiling, StateEquation
from mcpn.spaces.search.goal import AtMost, Fires, Formula, Goal, as_goal, asks_dead, fireable, holds, marked
from mcpn.spaces.search.growth import Growth, growing
from mcpn.spaces.search.home import Home, proving_home
from mcpn.spaces.search.portfolio import FIRINGS, MOST_COUNTED, ROUNDS, Portfolio
from mcpn.spaces.search.searches import Search, Searches, replay
from mcpn.turns import Pausing

STEPS = 20_000
"""Firings of walks for each sum; as many for all transitions together, and some for each."""
STEPS_OF_TRANSITION = 50
PLANNED = (500_000, 5_000_000, 25_000_000, 100_000_000)
"""Of greedy searches for one goal, one after the other: markings times transitions that are looked at."""
FEWEST_PLANNED = 20
CASES = 4
"""Of the branch and bound, for each condition that is joined of several."""
SIPHON_STEPS = 500
WALKS = 6
"""Walks, each twice as long as the one before, after which it is looked whether a transition is dead."""

Ways: TypeAlias = tuple[str, ...]
Examined: TypeAlias = tuple[bool | None, Ways]
"""The answer to an examination, ``None`` where it is not decided, and how it is known."""


class Facts:
    """Bounds, dead transitions, safety and liveness of a net without priorities.

    Args:
        net: The net.
        bounds: Most tokens of each place, as far as is known already.
        searches: Walks on the net, where there are some already.

    Attributes:
        fires: Transitions that are known to fire in some reachable marking.
        dead: Transitions that are known never to fire.
        grows: How sums of tokens grow for ever, of those that are known to.
        home: A marking that every reachable one leads to, once :meth:`going_home` has proved one.
    """

    def __init__(self, net: PetriNet, bounds: Sequence[float] = (), searches: Searches | None = None) -> None:
        assert not net.priorities, "with priorities, less fires than the arcs say"
        self.net = net
        self.equation = StateEquation(net, bounds)
        self.searches = searches or Searches(net)
        self.fires: set[int] = set()
        self.dead: set[int] = set()
        self._traps = False
        self._bounds = list(bounds) or [inf] * len(net.places)
        self._constant: dict[Formula, bool | None] = {}
        self._asked: set[int] = set()  # transitions that the equation has been asked about
        self._transitions_walked = False
        self._round = 0
        self._walks = self.searches.ends(steps=STEPS + len(net.transitions), walks=WALKS)
        self._came: list[list[int]] = []
        self.grows: dict[tuple[int, ...], Growth] = {}
        self.home: Home | None = None
        self._home_sought = False

    def sums(self, asked: Iterable[tuple[int, ...]]) -> Iterator[tuple[tuple[int, ...], float, Ways] | None]:
        """The most tokens that places hold together, where a bound is met, or none is there.

        Args:
            asked: Places of each sum; one that stands twice counts twice.

        Yields:
            A sum, its bound, and how it was had; ``None`` for a pause.
        """
        left: list[tuple[tuple[int, ...], int, Ceiling, Goal]] = []
        unbounded: list[tuple[int, ...]] = []
        for places in asked:
            found = yield from self.equation.bounding(Counter(places))
            if found.bound is None:
                unbounded.append(places)
                continue
            goal = exceeding(places, found.bound - 1)
            if holds(goal, self.net, self.net.initial):
                yield places, found.bound, (INITIAL_STATE, *_proved(found.traps))
            elif (yield from self._met([goal], STEPS)):
                yield places, found.bound, (*_proved(found.traps), RANDOM_WALK)
            else:
                left.append((places, found.bound, found, goal))
        reached = yield from self._met([goal for *_, goal in left], STEPS * len(left))
        for number in reached:
            places, bound, found, _ = left[number]
            yield places, bound, (*_proved(found.traps), RANDOM_WALK)
        left = [each for number, each in enumerate(left) if number not in reached]
        grows = self._growing(unbounded)
        held = {places: self._held(places, self.net.initial) for places, *_ in left}
        portfolio = Portfolio(self.net, self.searches)
        ways: Ways
        for effort, budget in enumerate(ROUNDS[: len(PLANNED)]):
            waiting, left = left, []
            for each in waiting:
                places, bound, found, goal = each
                if self._counted(goal, found.counts, effort):
                    yield places, bound, (*_proved(found.traps), RANDOM_WALK)
                    continue
                more, ways = exceeding(places, held[places]), ()
                for told in portfolio.going_on([more], budget, effort):
                    yield None
                    if told:
                        ways = told[1].techniques
                        if not told[1].reachable:
                            bound = held[places]
                        elif told[1].run is not None:
                            held[places] = self._held(places, replay(self.net, told[1].run))
                if held[places] < bound:
                    ways = (HEURISTIC,)
                    held[places] = max(held[places], (yield from self._raised(places, bound, effort)))
                if held[places] == bound:
                    yield places, bound, (*_proved(found.traps), *ways)
                else:
                    left.append(each)
                yield None
            yield from grows

    def _held(self, places: Iterable[int], marking: Sequence[int]) -> int:
        """How many tokens some places hold together."""
        return sum(marking[place] for place in places)

    def _raised(self, places: tuple[int, ...], bound: int, effort: int) -> Pausing[int]:
        """How far a sum comes to a bound by searches that each begin where the last one ended, one more."""
        marking = list(self.net.initial)
        while (held := self._held(places, marking)) < bound:
            found = yield from self._planning(exceeding(places, held), effort, marking)
            if found.outcome != "reached":
                break
            for t in found.run:
                self.net.fire_in_place(marking, t)
            yield
        return held

    def _growing(
        self, asked: Iterable[tuple[int, ...]]
    ) -> Iterator[tuple[tuple[int, ...], float, Ways] | None]:
        """Sums that grow for ever, of those that no bound is proved for."""
        for places in asked:
            if growth := (yield from growing(self.searches, Counter(places), self.dead)):
                self.grows[places] = growth
                yield places, inf, (STATE_EQUATION, HEURISTIC)

    def bounded_by(self, bounds: Sequence[float]) -> None:
        """Takes over most tokens of each place."""
        self._bounds = list(map(min, self._bounds, bounds))

    def knowing_transitions(self) -> Pausing[None]:
        """Finds out, once, which transitions fire and which are dead, as far as that is told."""
        if not self._transitions_walked:
            self._transitions_walked = True
            self.dead |= set(range(len(self.net.transitions))) - possible(self.net, self.net.initial)
            yield from self._fire(STEPS)
        for t in self.unknown:
            if t in self._asked or t in self.fires or t in self.dead:
                continue
            self._asked.add(t)
            goal = fireable(self.net, t)
            if (yield from self._planned(goal, 0)):
                self.fires.add(t)
                continue
            solution = yield from self.equation.solving(goal)
            if solution.kind == "unreachable":
                self.dead.add(t)
                self._traps = self._traps or bool(solution.traps)
            elif solution.kind == "possible" and (
                self._counted(goal, solution.counts) or (yield from self._planned(goal, 1))
            ):
                self.fires.add(t)

    @property
    def unknown(self) -> list[int]:
        """Transitions of which neither is known."""
        return [t for t in range(len(self.net.transitions)) if t not in self.fires and t not in self.dead]

    @property
    def ways(self) -> Ways:
        """How it was found out which transitions fire."""
        return (RANDOM_WALK, *(_proved(self._traps) if self.dead else ()))

    def _fire(self, steps: int) -> Pausing[None]:
        open_ones = self.unknown
        goals = [fireable(self.net, t) for t in open_ones]
        found = yield from self._met(goals, steps + STEPS_OF_TRANSITION * len(goals))
        self.fires.update(open_ones[goal] for goal in found)

    @property
    def examinations(self) -> dict[str, Callable[[], Pausing[Examined]]]:
        """By names of the contest: what decides each, cheap ones first."""
        return {
            "OneSafe": self.safe,
            "QuasiLiveness": self.quasi_live,
            "StableMarking": self.stable_place,
            "Liveness": self.live,
        }

    def quasi_live(self) -> Pausing[Examined]:
        """Whether every transition fires somewhere, and how it is known."""
        for _ in self.knowing_transitions():
            if self.dead:
                break
            yield
        return (False if self.dead else None if self.unknown else True), self.ways

    def stable_place(self) -> Pausing[Examined]:
        """Whether the tokens of some place never change, and how it is known."""
        changing = incidence(self.net)
        if not all(changing):
            return True, (STRUCTURE,)
        yield from self.knowing_transitions()
        if any(self.dead.issuperset(row) for row in changing):
            return True, self.ways
        return (None if any(self.fires.isdisjoint(row) for row in changing) else False), self.ways

    def safe(self) -> Pausing[Examined]:
        """Whether no place ever holds two tokens, as far as the equation and walks tell, and how."""
        crowded = yield from self._crowded(1)
        if (yield from self._met([marked(p, tokens=2) for p in crowded], STEPS * len(crowded))):
            return False, (RANDOM_WALK,)
        for effort in range(len(PLANNED)):
            for place in crowded:
                yield
                if (yield from self._planned(marked(place, tokens=2), effort)):
                    return False, (HEURISTIC,)
        return (None, ()) if crowded else (True, _proved(self._traps))

    def _crowded(self, most: float) -> Pausing[list[int]]:
        """Places that are not proved to hold so few tokens."""
        known = self._bounds
        for place in range(len(self.net.places)):
            if known[place] <= most and known[place] < inf:
                continue
            found = yield from self.equation.bounding({place: 1})
            self._traps = self._traps or bool(found.traps)
            known = self._bounds
            for other, bound in self.equation.shared(found).items():
                known[other] = min(bound, known[other])
            if found.bound is not None:
                known[place] = min(found.bound, known[place])
        return [place for place, bound in enumerate(known) if bound > most or bound == inf]

    def knowing(self, conditions: Iterable[Formula]) -> Pausing[None]:
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
        met = yield from self._met(goals, STEPS * len(goals))
        left = [condition for index, condition in enumerate(changed) if index not in met]
        # Those that are joined of several take a program of their own.
        for condition in sorted(left, key=lambda condition: not isinstance(changed[condition], AtMost)):
            if (yield from self._refuting(changed[condition])):
                goal = as_goal(condition, self.net)
                assert goal is not None, "it was one before"
                self._constant[condition] = holds(goal, self.net, self.net.initial)

    @property
    def constants(self) -> int:
        """How many conditions are known to have one value in all markings."""
        return sum(value is not None for value in self._constant.values())

    def _refuting(self, goal: Goal) -> Pausing[bool]:
        """Whether the equation shows that no marking of a goal is reachable."""
        if isinstance(goal, AtMost):
            found = yield from self.equation.bounding({place: -weight for place, weight in goal.weights})
            return found.bound is not None and found.bound < -goal.bound
        return (yield from self.equation.solving(goal, CASES)).kind == "unreachable"

    def always(self, condition: Formula) -> bool | None:
        """The value of a condition that is the same in every reachable marking; ``None`` where not known."""
        if isinstance(condition, Fires) and self.dead.issuperset(condition.transitions):
            return False
        return self._constant.get(condition)

    def going_home(self) -> Pausing[Home | None]:
        """A marking that every reachable one leads to, if one is proved: the initial one, or a dead one."""
        if not self._home_sought:
            self._home_sought = True
            self.home = yield from self._home()
        return self.home

    def _home(self) -> Pausing[Home | None]:
        if not (self.searches.fits and self.equation.fits) or (yield from self._crowded(inf)):
            return None
        here: Marking | None = self.net.initial
        first, dead = possible(self.net, self.net.initial), set[Marking]()
        for end in self._ends():
            yield
            if not self.net.enabled(end):
                dead.add(tuple(end))
                if len(dead) > 1:
                    return None
            elif not first <= possible(self.net, end):
                here = None  # from there nothing leads back
        if dead:
            (here,) = dead
        if here is None:
            return None
        return (yield from proving_home(StateEquation(self.net, self._bounds), self.searches, here))

    def _ends(self) -> Iterator[list[int]]:
        """Where some walks have come to, each made when it is first asked for."""
        yield from self._came
        for end in self._walks:
            self._came.append(end)
            yield end

    def live(self) -> Pausing[Examined]:
        """Whether every transition can always fire again, as far as arcs and the equation tell, and how."""
        every = range(len(self.net.transitions))
        if self.equation.fits and not (yield from self._crowded(inf)) and self._lowers_for_good(every):
            return False, (STATE_EQUATION,)
        yield
        if self._chooses_freely and {"ordinary", "free choice"} <= classes(self.net):
            try:
                return commoner(self.net, max_steps=SIPHON_STEPS) is None, (STRUCTURE,)
            except LimitError:
                pass
        for end in self._ends():
            yield
            if len(possible(self.net, end)) < len(every):
                return False, (RANDOM_WALK, STRUCTURE)  # a siphon has emptied
        home = yield from self.going_home()
        if home and home.marking == self.net.initial:
            fires, ways = yield from self.quasi_live()
            return fires, (*ways, HOME, STATE_EQUATION)
        return None, ()

    @property
    def _chooses_freely(self) -> bool:
        """Whether transitions that share a place need no other; quicker than to ask for all classes."""
        inputs = [needs(self.net, t).keys() for t in range(len(self.net.transitions))]
        users = Counter(place for places in inputs for place in places)
        return all(len(places) == 1 or all(users[place] == 1 for place in places) for places in inputs)

    def _lowers_for_good(self, every: Sequence[int]) -> bool:
        """Whether some transition lowers a bounded sum of tokens that nothing raises."""
        return len(repeatable(self.net, every)) < len(every)

    def _met(self, goals: Sequence[Goal], steps: int) -> Pausing[set[int]]:
        """The goals that walks have met, by index; there is no further walk after one that has met none."""
        met: set[int] = set()
        if self.searches.fits:
            self._round, before = self._round + 1, -1
            for walked in self.searches.walking(goals, steps, seed=self._round):
                if walked is not None:
                    met.add(walked[0])
                    continue
                yield
                if len(met) == before:
                    break
                before = len(met)
        return met

    def _counted(self, goal: Goal, counts: Sequence[int], effort: int = 0) -> bool:
        """Whether a walk by proposed numbers of firings meets a goal."""
        firings = sum(counts)
        if not self.searches.fits or FIRINGS * firings > MOST_COUNTED:
            return False
        steps = min((STEPS + FIRINGS * firings) << 2 * effort, max(MOST_COUNTED, STEPS))
        return bool(self.searches.met([goal], steps=steps, seed=effort, counts=counts))

    def _planned(self, goal: Goal, effort: int) -> Pausing[bool]:
        """Whether a greedy search comes to a goal; what fires on its way is known to fire."""
        return self.searches.fits and (yield from self._planning(goal, effort)).outcome == "reached"

    def _planning(self, goal: Goal, effort: int, start: Sequence[int] | None = None) -> Pausing[Search]:
        most = max(PLANNED[effort] // (len(self.net.transitions) + 1), FEWEST_PLANNED)
        found = yield from self.searches.planning(goal, seed=effort, start=start).searching(most)
        self.fires.update(found.run)
        return found


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
