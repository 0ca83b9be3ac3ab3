"""A section of a mission, or the whole mission, as a continuous-time Markov chain with a rate for each edge.

What solves the chain takes floats, what writes it exact fractions.

The model is that of :mod:`mcpn.answers.causes.risk`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import chain, product
from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from mcpn.answers.causes.demands import entered_again, split_edges
from mcpn.answers.causes.linear_systems import Layers, StepSystem
from mcpn.answers.causes.prospects import Goal, Prospects
from mcpn.answers.causes.sparse import Floats, SparseMatrix
from mcpn.drawing.status import Element
from mcpn.events import What
from mcpn.spaces.arrays import ArraySet, ArraySpace
from mcpn.spaces.markings.graph import Ints, Mask, StateGraph

Number: TypeAlias = float | Fraction


def decimal(value: float) -> Fraction:
    """The number that a file says: the decimal text of a float, not the binary fraction next to it.

    Examples:
        >>> decimal(0.1)
        Fraction(1, 10)
    """
    return Fraction(repr(float(value)))


class EdgeRates:
    """The rates of a chain's edges.

    Args:
        listed: The states and edges.
        rates: Failures per hour in service and repairs per hour out of service, of each of its resources.
        ending: By objective, its ends per hour while its success is possible, and the probabilities that
            such an end is a failure: for no reason, then for each of its reasons.
        demands: By resource, how probable it is that it fails on demand.
        number: Makes a number of the kind that the arguments are: :func:`decimal`, else it makes floats.

    Attributes:
        rates: By edge, 0 where it is never taken; of a state that is left in no time its weight.
        hasty: Vanishing states, left in no time: an objective that runs cannot succeed any more, or
            hardware may fail on demand at the entry.
        moving: Edges that are taken with some probability.
    """

    def __init__(
        self,
        listed: ListedChain,
        rates: Sequence[tuple[Number, Number]],
        ending: Sequence[tuple[Number, ...]],
        demands: Sequence[Number] = (),
        number: Callable[[float], Number] = float,
    ) -> None:
        self._listed, self._graph = listed, listed.graph
        kind = np.object_ if number is decimal else np.float64
        split = listed.split
        one: npt.NDArray[Any] = np.ones(1, kind)
        self._weights = one if split is None else split.weights(demands, kind)
        fails, back = np.array([*rates, (number(0.0), number(0.0))], kind).T
        events: npt.NDArray[Any] = np.array([number(rate) for rate in listed.occurring], kind)
        self.rates: npt.NDArray[Any] = (
            fails[listed.failing] + back[listed.repaired] + events[listed.interrupting]
        )
        failed = self._run_objectives(ending)
        sources = self._graph.sources
        self.hasty: Mask = np.zeros(self._graph.states, np.bool_)
        self.hasty[sources[failed]] = True
        self.rates[self.hasty[sources]] = number(0.0)
        self.rates[failed | listed.starting] = number(1.0)
        self.hasty[sources[listed.starting]] = True
        self.rates = self.rates * self._weights
        # An event after which all is as it was takes no part in the jumps.
        changing = listed.inside & (sources != self._graph.targets)
        self.moving: Mask = np.asarray(self.rates > 0, np.bool_) & changing
        self.rates[~self.moving] = number(0.0)

    def _run_objectives(self, ending: Sequence[tuple[Number, ...]]) -> Mask:
        """Gives rates to edges that end objectives; those of objectives that fail at once are returned."""
        listed, sources, targets = self._listed, self._graph.sources, self._graph.targets
        may_happen = ((self.rates > 0) | listed.ending) & (self._weights > 0)
        failed = np.zeros(self._graph.edges, np.bool_)
        objectives = listed.prospects.objectives.items()
        for (name, goal), (rate, *failures) in zip(objectives, ending, strict=True):
            if goal.running:
                well, badly = listed.carrying(What.SUCCESS, name), listed.carrying(What.FAILURE, name, "")
                running, won, misused = goal.running.mask, goal.won.mask, listed.misused[name]
                self.rates[well] = rate * (1 - sum(failures))
                reasons = ("", *(reason for reason, _ in listed.prospects.sections[name].reasons))
                for reason, failure in zip(reasons, failures, strict=True):
                    self.rates[listed.carrying(What.FAILURE, name, reason) & won[sources]] = rate * failure
                self.rates[badly & misused[sources]] = rate
                # What ends the present run may lead back into the objective: that is another run.
                going_on = running[sources] & running[targets] & may_happen & ~listed.ending_run(goal)
                hopeful = self._graph.reaching(won | misused, np.asarray(going_on, np.bool_))
                failed |= badly & (running & ~hopeful)[sources]
        return failed


# The chain starts in the first state of the section,
# given the status of the hardware at its entry, and is absorbed at the exits. Probabilities of absorption are
# those of the embedded jump chain (Kemeny, Snell, *Finite Markov Chains*, 1960, chapter 3), from one linear
# system. What happens beside a section before it ends is a race of the chain with clocks: the same system
# with the rates of the clocks added to the exit rate of each state.

T = TypeVar("T", bound=np.generic)

Phases: TypeAlias = Sequence[Sequence[tuple[float, int]]]
"""By phase of a clock, the rates at which it is left, each with the later phase that it leads to."""

UNKNOWNS = 1 << 12
"""Unknowns of systems that are solved together, unless one alone has more."""


class ListedChain:
    """The states and edges of a section's chain, or of the whole mission's, before rates are given.

    Args:
        prospects: The section's local net, or the mission's, on its alternatives graph in arrays.
        carried: Its hardware that can fail, handlers that happen once, and facts. A *status* is a number
            whose bits say what is out of service, what has happened and what facts are, the first in the
            highest bit.
        again: Exits after which it is entered again at once: edges to them lead to its first states.
        demanded: The numbers of those of its hardware that may fail on demand.

    Attributes:
        graph: Its states and edges.
        exits: Its exits, by name.
        columns: The number of pairs of an exit and a status there.
        column: By state at an exit, the number of its pair; meaningless elsewhere.
        ended: States at exits.
        entries: The first state, by the status with which it is entered; -1 where it is never entered so.
            Where hardware may fail on demand, the state before it, which is left at once.
        split: The edges, split by what fails on demand; ``None`` where nothing does.
        starting: The edges from states before the entry that are left at once.
        misused: By objective, states in which it would succeed but for hardware that is lost unnoticed.
        failing: By edge, the number of the resource that fails; -1 for other edges.
        repaired: The same of one that is repaired.
        occurring: The rates of declared events and detections, 0 where the mission gives none; before them 0.
        interrupting: By edge of a declared event or a detection the number of its rate; 0 for other edges.
        ending: Edges with which some objective ends.
        inside: Edges between its own states, or from these to its exits.
        returning: Edges that leave it and enter it again.
    """

    def __init__(
        self,
        prospects: Prospects[ArraySet],
        carried: Sequence[Element],
        again: Collection[str] = (),
        demanded: Sequence[int] = (),
    ) -> None:
        assert isinstance(prospects.space, ArraySpace), "numbers are of listed states"
        self.prospects = prospects
        self.graph: StateGraph = prospects.space.graph
        self.statuses = 1 << len(carried)
        self.exits = tuple(prospects.mission_net.exits)
        states = self.graph.states
        exit_of, status = np.full(states, -1, np.int64), np.zeros(states, np.int64)
        for number, place in enumerate(prospects.mission_net.exits.values()):
            exit_of[self.graph.marked(place)] = number
        for flag in carried:
            status = 2 * status + self._so(flag)
        self.columns = len(self.exits) * self.statuses
        self.column = exit_of * self.statuses + status
        self.ended: Mask = np.asarray(exit_of >= 0, np.bool_)
        self.split = split_edges(self.graph, prospects.mission_net, carried, demanded) if demanded else None
        if self.split is not None:
            self.graph = self.split.graph
        self.returning: Mask = np.zeros(self.graph.edges, np.bool_)
        if self.split is not None and again:
            back = np.isin(exit_of, [self.exits.index(name) for name in again])[self.graph.targets]
            back &= ~self.ended[self.graph.sources]
            starts = self.carrying(What.START)
            self.split, self.returning = entered_again(self.split, back, status, starts)
            self.graph, again = self.split.graph, ()
        sources, targets = self.graph.sources, self.graph.targets
        self.failing = self._hardware_of(What.OUT_OF_SERVICE, carried)
        self.repaired = self._hardware_of(What.REPAIRED, carried)
        self.occurring, self.interrupting = [0.0], np.zeros(self.graph.edges, np.int64)
        mission = prospects.mission_net.core
        rated = [(What.DECLARED, event.name, event.rate) for event in mission.events]
        rated += [(What.DETECTED, k, a.detection_rate) for a in mission.activities for k in a.detects]
        for what, name, rate in rated:
            self.interrupting[self.carrying(what, name)] = len(self.occurring)
            self.occurring.append(rate or 0.0)
        self.misused = {name: self.misusing(name) for name in prospects.objectives}
        ends = product((What.SUCCESS, What.FAILURE), prospects.sections)
        self.ending = self.of(chain.from_iterable(prospects.carrying(*end) for end in ends))
        entering = self.carrying(What.START)
        outside = self.ended.copy()
        outside[sources[entering]] = True
        self.inside: Mask = np.asarray(~outside[sources], np.bool_)
        self.entries: Ints = np.full(self.statuses, -1, np.int64)
        self.entries[status[sources[entering]]] = (targets if self.split is None else sources)[entering]
        self.starting: Mask = entering & (self.split is not None)
        self.inside |= self.starting
        if again:
            returning = np.isin(exit_of[targets], [self.exits.index(name) for name in again])
            first = self.entries[status[targets]]
            returning &= self.inside & (first >= 0)
            self.returning = np.asarray(returning, np.bool_)
            self.graph = replace(self.graph, targets=np.where(returning, first, targets))

    def _so(self, flag: Element) -> Mask:
        """States in which something carried is so: out of service, known to be, has happened, or is true."""
        place, reverse = self.prospects.mission_net.flag_bits[flag]
        return np.asarray(self.graph.marked(place) != reverse, np.bool_)

    def misusing(self, objective: str) -> Mask:
        """States in which an objective would succeed but that somebody uses hardware which is lost.

        The robot does not know it: the objective goes on, and what ends it then is a failure.
        """
        net, found = self.prospects.mission_net, np.zeros(self.graph.states, np.bool_)
        fine = net.saying("fine")
        for t in self.prospects.carrying(What.SUCCESS, objective) if fine else ():
            transition, apart = self.graph.net.transitions[t], np.ones(self.graph.states, np.bool_)
            needed = [place for place, _ in (*transition.consume, *transition.read)]
            for place in needed:
                apart &= place in fine or self.graph.marked(place)
            for place in needed:
                found |= apart & ~self.graph.marked(place)
        return found

    def _hardware_of(self, what: What, carried: Sequence[Element]) -> Ints:
        number = np.full(len(self.graph.net.transitions), -1, np.int64)
        for i, (kind, name) in enumerate(carried):
            if kind == "hardware":
                number[list(self.prospects.carrying(what, name))] = i
        return number[self.graph.labels]

    def carrying(self, what: What, element: str = "", reason: str | None = None) -> Mask:
        """Edges of an event; of a failure for any reason or none, unless one is said."""
        return self.of(self.prospects.carrying(what, element, reason))

    def of(self, transitions: Iterable[int]) -> Mask:
        """Edges of some transitions."""
        wanted = np.zeros(len(self.graph.net.transitions), np.bool_)
        wanted[list(transitions)] = True
        return np.asarray(wanted[self.graph.labels], np.bool_)

    def ending_run(self, goal: Goal[ArraySet]) -> Mask:
        """Edges that end the present run of an objective."""
        found = self.of(goal.ends) | self.returning
        for t, states in goal.ends_from.items():
            found |= self.of([t]) & states.mask[self.graph.sources]
        return found

    def at_entries(self, states: npt.NDArray[T]) -> npt.NDArray[T]:
        """Values by state, taken at the first state of each status; zero where it is never entered so."""
        values = states[self.entries]
        values[self.entries < 0] = 0
        return values

    @cached_property
    def degraded(self) -> Mask:
        """States in which some activity runs in another alternative than its first."""
        mission_net = self.prospects.mission_net
        first = {f"{a.name}.{a.alternatives[0].name}" for a in mission_net.core.activities}
        others = [place for place, name in mission_net.saying("active").items() if name not in first]
        return self.prospects.space.marked(others).mask & ~self.ended

    @cached_property
    def changing(self) -> Mask:
        """Edges into another functioning mode: other objectives run, or other alternatives."""
        mission_net, graph = self.prospects.mission_net, self.graph
        changed = np.zeros(graph.edges, np.bool_)
        for place in (*mission_net.saying("active"), *mission_net.saying("objective")):
            marked = graph.marked(place)
            changed |= marked[graph.sources] != marked[graph.targets]
        return changed


class Clocks:
    """Clocks that run beside a chain, independent of it and of each other.

    A clock goes through phases, each later than those that lead to it. The phases of all clocks together are
    numbered, those of the first clock first.

    Args:
        clocks: By clock, its phases: the rates at which it passes to later ones.

    Attributes:
        decays: By phase of all, the rate at which it is left.
        levels: The phases in the order of how many steps lead there.
    """

    def __init__(self, clocks: Sequence[Phases]) -> None:
        self.decays, steps = np.zeros(1), np.zeros(1, np.int64)
        self._clocks, stride = list[tuple[int, Phases]](), 1
        for phases in reversed(clocks):
            self._clocks.append((stride, phases))
            stride *= len(phases)
            depth = [0] * len(phases)
            for phase, each in enumerate(phases):
                for _, after in each:
                    depth[after] = depth[phase] + 1
            leaving = [sum(rate for rate, _ in each) for each in phases]
            self.decays = np.add.outer(leaving, self.decays).reshape(-1)
            steps = np.add.outer(depth, steps).reshape(-1)
        self.levels = [np.flatnonzero(steps == level).tolist() for level in range(int(steps.max()) + 1)]

    def ringing(self, phase: int) -> Iterator[tuple[float, int]]:
        """The rates at which a phase of all is left, each with the phase after it."""
        for stride, phases in self._clocks:
            own = phase // stride % len(phases)
            for rate, after in phases[own]:
                yield rate, phase + (after - own) * stride


class Chain:
    """The chain under given rates.

    Args:
        listed: Its states.
        rates: Failures per hour in service and repairs per hour out of service, of each of its resources.
        ending: By objective, its ends per hour while its success is possible, and the probabilities that
            such an end is a failure: for no reason, then for each of its reasons.
        demands: By resource, how probable it is that it fails on demand.

    Attributes:
        rates: By edge, as :class:`mcpn.answers.causes.chain.EdgeRates` has them.
        hasty: Its vanishing states.
        moving: Its edges that are taken with some probability.
    """

    def __init__(
        self,
        listed: ListedChain,
        rates: Sequence[tuple[float, float]],
        ending: Sequence[tuple[float, ...]],
        demands: Sequence[float] = (),
    ) -> None:
        self.listed, self.graph = listed, listed.graph
        found = EdgeRates(listed, rates, ending, demands)
        self.rates, self.hasty, self.moving = found.rates, found.hasty, found.moving

    def may_come_to(self, flags: Mask) -> Mask:
        """By status at the entry, whether some exits, flagged by exit and status, are possible."""
        goal = self.listed.ended & flags[self.listed.column]
        return self.listed.at_entries(self.graph.reaching(goal, self.moving))

    @cached_property
    def possible(self) -> tuple[Mask, Mask]:
        """By status at the entry, which exits and status there are possible: at once, and after some time."""
        listed, graph = self.listed, self.graph
        at_once, later = np.zeros((2, listed.statuses, listed.columns), np.bool_)
        quick = self.moving & self.hasty[graph.sources]
        for status, entry in enumerate(listed.entries.tolist()):
            if entry >= 0:
                at_once[status, listed.column[graph.reached(quick, entry) & listed.ended]] = True
                slow = graph.reached(self.moving, entry) & ~self.hasty & ~listed.ended
                ends = graph.reached(self.moving, np.flatnonzero(slow)) & listed.ended
                later[status, listed.column[ends]] = True
        return at_once, later

    @cached_property
    def _ending(self) -> Mask:
        """States from which the chain reaches an exit with some probability."""
        return self.graph.reaching(self.listed.ended, self.moving)

    @cached_property
    def stays(self) -> Mask:
        """By status at the entry, whether with some probability the chain never reaches an exit."""
        return self.listed.at_entries(self.graph.reaching(~self._ending, self.moving))

    @cached_property
    def _matrix(self) -> SparseMatrix:
        """Rates between states."""
        moving, states = self.moving, self.graph.states
        rates, sources, targets = self.rates[moving], self.graph.sources[moving], self.graph.targets[moving]
        return SparseMatrix(rates, sources, targets.astype(np.intp), (states, states))

    def _out(self, states: Ints) -> SparseMatrix:
        """Rates from some states to the others."""
        others = np.ones(self.graph.states, np.bool_)
        others[states] = False
        matrix = self._matrix
        kept = ~others[matrix.rows] & others[matrix.columns]
        rows = np.searchsorted(states, matrix.rows[kept])
        return SparseMatrix(matrix.values[kept], rows, matrix.columns[kept], (len(states), self.graph.states))

    @cached_property
    def _inner(self) -> Ints:
        return np.flatnonzero(self._ending & ~self.listed.ended)

    @cached_property
    def _outer(self) -> SparseMatrix:
        return self._out(self._inner)

    @cached_property
    def _layers(self) -> Layers:
        return Layers(self._matrix.within(self._inner))

    def _steps(self, decays: Floats) -> StepSystem:
        """The system of the inner states, for several decays; what takes no time does not decay."""
        return StepSystem(self._layers, self._outer.sums, np.multiply.outer(decays, ~self.hasty[self._inner]))

    @cached_property
    def _undecayed(self) -> StepSystem:
        return self._steps(np.zeros(1))

    def _found(self, values: Floats) -> Floats:
        """By status at the entry, what is expected of given values at all states but those in between."""
        right = self._outer @ values
        if right.any():
            values[self._inner] = self._undecayed.solved(right[None])[0]
        return self.listed.at_entries(values)

    def expected(self, values: Floats) -> Floats:
        """The expected value at the exit, 0 if there never is one.

        Args:
            values: By exit and status there; the second axis is free.

        Returns:
            By status at the entry.
        """
        return self._found(np.where(self.listed.ended[:, None], values[self.listed.column], 0.0))

    @cached_property
    def staying(self) -> Floats:
        """By status at the entry, how probable it is that the chain never reaches an exit."""
        return self._found(np.where(self._ending, 0.0, 1.0)[:, None])[:, 0]

    def kernels(self, race: Clocks) -> Floats:
        """How the chain ends, and which of some clocks have rung by then.

        Args:
            race: The clocks that run beside it.

        Returns:
            By phase of the clocks, status at the entry, and exit and status there, how probable it is that
            the chain ends so in that phase: shape (phases, statuses, columns).
        """
        listed, inner = self.listed, self._inner
        found = np.zeros((len(race.decays), listed.statuses, listed.columns))
        met = np.flatnonzero(np.isin(listed.entries, inner))
        if not len(met):
            return found
        outer = self._outer
        to_end = listed.ended[outer.columns]
        columns = listed.column[outer.columns[to_end]]
        out = SparseMatrix(outer.values[to_end], columns, outer.rows[to_end], (listed.columns, len(inner)))
        begun = np.zeros((len(inner), len(met)))
        begun[np.searchsorted(inner, listed.entries[met]), np.arange(len(met))] = 1.0
        together, slow = max(1, UNKNOWNS // len(inner)), ~self.hasty[inner, None]
        decays, kind = np.unique(race.decays, return_inverse=True)
        at_once = self._steps(decays) if len(decays) <= together else None
        # What comes to each phase: the beginning, or what rings the last clock of those that have rung.
        coming = {0: begun}
        for level in race.levels:
            met_phases = [phase for phase in level if phase in coming]
            for begin in range(0, len(met_phases), together):
                some = met_phases[begin : begin + together]
                right = np.stack([coming.pop(phase) for phase in some])
                system = self._steps(race.decays[some]) if at_once is None else at_once.of(kind[some])
                spent = system.solved(right, forward=True)
                for phase, times in zip(some, spent, strict=True):
                    found[phase, met] = (out @ times).T
                    for rate, after in race.ringing(phase):
                        coming[after] = coming.get(after, 0.0) + rate * slow * times
        return found

    @cached_property
    def modes(self) -> Floats:
        """The expected number of jumps into another, degraded mode, by status at the entry; may be infinite.

        A degraded first state counts as a jump; vanishing states do not count.
        """
        graph, listed = self.graph, self.listed
        degraded = listed.degraded & ~self.hasty
        changed = np.where(listed.changing & degraded[graph.targets], self.rates, 0.0)
        gained = np.bincount(graph.sources, changed, graph.states).astype(float)
        after = totals(gained, lambda goal: graph.reaching(goal, self.moving), self._solved)
        return listed.at_entries(degraded + after)

    def _solved(self, inner: Mask, gained: Floats) -> Floats:
        """The expected total gain from each of some states; 0 from all others."""
        found, states = np.zeros(self.graph.states), np.flatnonzero(inner)
        if len(states):
            system = StepSystem(
                Layers(self._matrix.within(states)), self._out(states).sums, np.zeros((1, len(states)))
            )
            found[states] = system.solved(gained[states, None][None])[0, :, 0]
        return found


def totals(
    gained: Floats,
    reaching: Callable[[Mask], Mask],
    solved: Callable[[Mask, Floats], Floats],
    resting: Mask | bool = False,
) -> Floats:
    """The expected total gain (reward) until absorption, by state; infinite where gains may never end.

    Args:
        gained: The expected gain in a state, or by the jump out of it.
        reaching: Finds the states from which some of given states are reached with some probability.
        solved: Solves the linear system of the states whose total gain is positive and finite.
        resting: States that may turn out to be the last.
    """
    gaining = reaching(np.asarray(gained > 0, np.bool_))
    # Gains may never end where some run reaches a state from which no state without further gain is reached.
    endless = reaching(np.isinf(gained) | ~reaching(~gaining | resting))
    return np.where(endless, np.inf, solved(gaining & ~endless, gained))
