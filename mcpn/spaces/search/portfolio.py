"""Is some marking of a goal reachable? Asked of cheap ways first, in rounds of so many firings and markings.

The ways are a look at the initial marking, walks, structural reductions with searches of what is left, greedy
and with stubborn sets, and the state equation. Nothing here builds the whole space, and nothing is sure to
end with an answer.

Budgets are counts of firings and markings, never seconds, so that the same question has the same answer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property

from mcpn.nets.petri import PetriNet
from mcpn.nets.reduce.reduction import Reduction, reduce_for_deadlock, reduce_for_goal
from mcpn.records import record
from mcpn.spaces.search import (
    EXPLICIT,
    HEURISTIC,
    INITIAL_STATE,
    RANDOM_WALK,
    REDUCTION,
    STATE_EQUATION,
    STUBBORN_SETS,
    TRAPS,
)
from mcpn.spaces.search.goal import DEADLOCK, Goal, asks_dead, holds, renamed, wanted
from mcpn.spaces.search.searches import MAX_BYTES, Run, Searches, Seeking, leads_to, replay, shortened
from mcpn.turns import Pausing

MOST_LEFT = 100_000
"""Firings after a lifted run before its end must be dead."""


@record(frozen=True)
class SearchResult:
    """Whether a goal is reachable, and how that was found.

    Args:
        reachable: The answer.
        run: Transitions of the net from its initial marking to the goal, where it is reachable.
        techniques: The ways that led to the answer, in words of the Model Checking Contest.
    """

    reachable: bool
    run: Run | None
    techniques: tuple[str, ...]


@record(frozen=True)
class Round:
    """Budgets of one round, for each goal.

    Args:
        steps: Firings of a walk; where it is 0, neither walks nor a greedy search, whose runs are long.
        states: Markings of a search.
        equation: Whether the state equation is asked as well.
    """

    steps: int
    states: int
    equation: bool = False


MOST_REDUCED = 200_000
"""Arcs of nets that are reduced for one goal each, in all; the goals beyond share one reduction."""
ALONE = 3
"""How many times as many markings a lone goal has before the equation, whose solver takes as long to load."""
STEPS_OF_TRANSITION = 20
"""Firings of a walk beyond those of its round, for each transition of the net."""
CASES_OF_DEADLOCK = 400
"""Of the branch and bound: there is one such goal, of conditions on many places."""
FIRINGS, MOST_COUNTED = 4, 4_000_000
"""Firings tried for each that the state equation proposes, and in all."""
SHORT = Round(0, 20_000)
"""A search alone, whose runs are shorter than those of walks."""
ROUNDS = (
    Round(20_000, 2_000),
    Round(60_000, 20_000, equation=True),
    Round(200_000, 200_000),
    Round(600_000, 2_000_000),
    Round(2_000_000, 20_000_000),
)


class Portfolio:
    """Decides goals on one net.

    Args:
        net: Any net. One with priorities is neither reduced nor searched by stubborn sets; the state equation
            speaks of it too, since priorities only forbid.
        searches: Walks and searches on it, where there are some already.
    """

    def __init__(self, net: PetriNet, searches: Searches | None = None) -> None:
        self.net, self.searches = net, searches or Searches(net)
        self._tasks: dict[Goal, _Task] = {}
        self._arcs = 0

    def decide(
        self, goals: Sequence[Goal], rounds: Sequence[Round] = ROUNDS
    ) -> Iterator[tuple[int, SearchResult]]:
        """What :meth:`deciding` finds, at once."""
        return (told for told in self.deciding(goals, rounds) if told is not None)

    def deciding(
        self, goals: Sequence[Goal], rounds: Sequence[Round] = ROUNDS
    ) -> Iterator[tuple[int, SearchResult] | None]:
        """Decides goals, the easy ones first.

        Args:
            goals: What may be reachable.
            rounds: Budgets, growing.

        Yields:
            The index of a goal and what was found, as it comes; goals that no way decides are left out.
            ``None`` for a pause.
        """
        left = []
        for index, goal in enumerate(goals):
            if holds(goal, self.net, self.net.initial):
                yield index, SearchResult(True, (), (INITIAL_STATE,))
            else:
                left.append(index)
        for number, budget in enumerate(rounds):
            waiting = left
            for told in self.going_on([goals[index] for index in waiting], budget, number):
                if told is not None:
                    told = waiting[told[0]], told[1]
                    left = [index for index in left if index != told[0]]
                yield told

    def going_on(
        self,
        goals: Sequence[Goal],
        budget: Round,
        number: int,
        asked: Callable[[int], bool] = lambda _: True,
    ) -> Iterator[tuple[int, SearchResult] | None]:
        """One round of some goals; those that had one before go on from there.

        Args:
            goals: What may be reachable, and does not hold at first.
            budget: Of the round.
            number: How many rounds these goals have had.
            asked: Whether the goal of an index is still asked for.

        Yields:
            As :meth:`deciding`.
        """
        if not self.searches.fits:
            return
        waiting = list(range(len(goals)))
        beyond = STEPS_OF_TRANSITION * len(self.net.transitions) if budget.steps else 0
        steps = (budget.steps + beyond) * len(waiting)
        met = set[int]()
        for walked in self.searches.walking([goals[index] for index in waiting], steps, seed=number):
            if walked is None:
                yield None
                continue
            index = waiting[walked[0]]
            met.add(index)
            run = shortened(self.net, walked[1])
            yield index, SearchResult(True, _direct(self.net, run, goals[index]), (RANDOM_WALK,))
        waiting = [index for index in waiting if index not in met]
        yield None
        new = [goals[index] for index in waiting if goals[index] not in self._tasks]
        shared = _shared(self.net, new) if len(new) > 1 else None
        for index in filter(asked, waiting):
            goal = goals[index]
            task = self._tasks.get(goal)
            if task is None:
                task = self._tasks[goal] = _Task(self.net, goal, shared, alone=self._arcs <= MOST_REDUCED)
                self._arcs += task.arcs
            finding = yield from task.searching(
                budget, number, MAX_BYTES // len(waiting), alone=len(goals) == 1
            )
            if finding is not None:
                del self._tasks[goal]
                yield index, finding
            yield None

    def keep(self, goals: Iterable[Goal]) -> None:
        """Forgets what was searched for other goals."""
        self._tasks = {goal: task for goal in goals if (task := self._tasks.get(goal))}


class _Task:
    """One goal, on the net reduced for it.

    Args:
        net: The net.
        goal: What is looked for.
        shared: The net reduced for several goals, where there is such.
        alone: Whether it may be reduced for this one alone as well.

    Attributes:
        arcs: Of the net that has been reduced for this goal alone.
    """

    def __init__(self, net: PetriNet, goal: Goal, shared: Reduction | None, *, alone: bool) -> None:
        self.net, self.goal = net, goal
        self.inner, smaller = goal, net
        self.reductions: list[Reduction] = []
        self.arcs = 0
        if shared and not asks_dead(goal):
            smaller = self._put(shared)
        if alone and (own := _reduced(smaller, self.inner)):
            self.arcs = sum(len(t.consume) + len(t.produce) for t in smaller.transitions)
            smaller = self._put(own)
        self.searches = Searches(smaller)
        self.techniques = (REDUCTION,) if self.reductions else ()
        self.ways = (EXPLICIT,) if net.priorities else (EXPLICIT, STUBBORN_SETS)

    def _put(self, reduction: Reduction) -> PetriNet:
        self.reductions.append(reduction)
        if self.inner != DEADLOCK:
            self.inner = renamed(self.inner, reduction.place_index.__getitem__)
        return reduction.net

    @cached_property
    def _seeking(self) -> Seeking:
        """A search for all that is reachable, which each round goes on with."""
        return self.searches.seeking(self.inner)

    def searching(
        self, budget: Round, seed: int, max_bytes: int, *, alone: bool
    ) -> Pausing[SearchResult | None]:
        """Walks and searches, within a budget; nothing where neither decides."""
        if self.reductions:
            if not self.searches.fits:
                return None
            walked = self.searches.walk([self.inner], steps=budget.steps, seed=seed)
            if walked:
                return self._reached(walked[0], RANDOM_WALK)
            yield
        more = ALONE if alone and budget.equation else 1
        run = yield from self._seeking.searching(budget.states * more, max_bytes)
        if run.outcome == "reached":
            return self._reached(run.run, *self.ways)
        if run.outcome == "unreachable":
            return SearchResult(False, None, (*self.techniques, *self.ways))
        yield
        if budget.steps:  # each marking takes longer
            run = yield from self.searches.planning(self.inner, seed=seed).searching(budget.states)
            if run.outcome == "reached":
                return self._reached(run.run, HEURISTIC)
            yield
        # That nothing is dead the equation, with traps, often proves in less than a search takes.
        proves = (seed == 0 and budget.steps > 0) if self.goal == DEADLOCK else budget.equation
        return (yield from self._by_equation(budget, seed)) if proves else None

    def _by_equation(self, budget: Round, seed: int) -> Pausing[SearchResult | None]:
        from mcpn.spaces.search.equation import NODES, StateEquation

        cases = CASES_OF_DEADLOCK if self.goal == DEADLOCK else NODES
        solution = yield from StateEquation(self.searches.net).solving(self.inner, cases)
        if solution.kind == "unreachable":
            traps = (TRAPS,) if solution.traps else ()
            return SearchResult(False, None, (*self.techniques, STATE_EQUATION, *traps))
        if solution.kind == "possible":
            steps = max(budget.steps, min(FIRINGS * sum(solution.counts), MOST_COUNTED))
            walked = self.searches.walk([self.inner], steps=steps, seed=seed, counts=solution.counts)
            if walked:
                return self._reached(walked[0], STATE_EQUATION, RANDOM_WALK)
        return None

    def _reached(self, run: Run, *ways: str) -> SearchResult:
        if self.reductions:
            for reduction in reversed(self.reductions):
                run = reduction.lift(run)
            run = shortened(self.net, run)
            if self.goal == DEADLOCK:
                run = shortened(self.net, _gone_on(self.net, run))
        run = _direct(self.net, run, self.goal)
        assert leads_to(self.net, run, self.goal), "a run to a goal replays"
        return SearchResult(True, run, (*self.techniques, *ways))


def _shared(net: PetriNet, goals: Sequence[Goal]) -> Reduction | None:
    """The net reduced for all of some goals; ``None`` where that is not smaller."""
    ways: dict[int, set[int]] = {}
    for goal in goals:
        for place, signs in () if asks_dead(goal) else wanted(goal).items():
            ways.setdefault(place, set()).update(signs)
    if net.priorities or not ways:
        return None
    reduction = reduce_for_goal(net, ways)
    smaller = reduction.net
    sizes = len(smaller.places) < len(net.places), len(smaller.transitions) < len(net.transitions)
    return reduction if any(sizes) else None


def _reduced(net: PetriNet, goal: Goal) -> Reduction | None:
    if net.priorities:
        return None
    if goal == DEADLOCK:
        return reduce_for_deadlock(net)
    return None if asks_dead(goal) else reduce_for_goal(net, wanted(goal))


def _direct(net: PetriNet, run: Run, goal: Goal) -> Run:
    """A run to a goal without the events of a mission that it can do without."""
    if not net.priorities:
        return run
    from mcpn.spaces.run import without_detours

    return without_detours(net, run, lambda marking: holds(goal, net, marking))


def _gone_on(net: PetriNet, run: Run) -> Run:
    """A run that goes on until nothing may fire."""
    fired = list(run)
    marking = replay(net, run)
    while (enabled := net.enabled(marking)) and len(fired) < len(run) + MOST_LEFT:
        fired.append(enabled[0])
        marking = net.fire(marking, enabled[0])
    return tuple(fired)
