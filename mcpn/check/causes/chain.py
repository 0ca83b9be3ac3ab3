"""A section of a mission, or the whole mission taken as one, as a continuous-time Markov chain.

The model is that of :mod:`mcpn.check.causes.risk`. The chain starts in the first state of the section, given
the status of the hardware at its entry, and is absorbed at the exits. Probabilities of absorption are those
of the embedded jump chain (Kemeny, Snell, *Finite Markov Chains*, 1960, chapter 3), from one linear system.
The Laplace transform of the time to absorption solves the same system with ``s`` added to the exit rate of
each state.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import chain, product
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from mcpn.check.causes.demands import entered_again, split_edges
from mcpn.check.causes.linear_systems import CHUNK, Floats, csc_array, csr_array, splu
from mcpn.check.causes.prospects import Goal, Prospects
from mcpn.net.events import What
from mcpn.net.sections import Element
from mcpn.net.templates import Role
from mcpn.space.arrays import ArraySet, ArraySpace
from mcpn.space.markings.graph import Ints, Mask, StateGraph

T = TypeVar("T", bound=np.generic)

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
        interrupting: By edge of a declared event or a detection its rate, 0 where the mission gives none; 0
            for other edges.
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
        for kind, name in carried:
            status = 2 * status + self._so(kind, name)
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
        self.interrupting: Floats = np.zeros(self.graph.edges)
        for event in prospects.mission_net.mission.events:
            self.interrupting[self.carrying(What.DECLARED, event.name)] = event.rate or 0.0
        for activity in prospects.mission_net.mission.activities:
            for hardware in activity.detects:
                self.interrupting[self.carrying(What.DETECTED, hardware)] = activity.detection_rate or 0.0
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

    def _so(self, kind: str, name: str) -> Mask:
        """States in which something carried is so: out of service, known to be, has happened, or is true."""
        net, marked = self.prospects.mission_net, self.graph.marked
        if kind == "fact":
            place, reverse = net.true_of_fact(name)
            return np.asarray(marked(place) != reverse, np.bool_)
        known: Role = ("known", name) if kind == "known" else ("happened", name)
        return marked(net.by_role[("oos", name) if kind == "hardware" else known][0])

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

    def carrying(self, what: What, element: str = "") -> Mask:
        """Edges of an event."""
        return self.of(self.prospects.carrying(what, element))

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
        first = {f"{a.name}.{a.alternatives[0].name}" for a in mission_net.mission.activities}
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


class Chain:
    """The chain under given rates.

    Args:
        listed: Its states.
        rates: Failures per hour in service and repairs per hour out of service, of each of its resources.
        ending: By objective, its ends per hour while its success is possible, and the probability that such
            an end is a failure.
        demands: By resource, how probable it is that it fails on demand.

    Attributes:
        rates: By edge.
        hasty: Vanishing states, left in no time: an objective that runs cannot succeed any more, or
            hardware may fail on demand at the entry.
        moving: Edges that are taken with some probability.
        leaving: The rate at which each state is left.
    """

    def __init__(
        self,
        listed: ListedChain,
        rates: Sequence[tuple[float, float]],
        ending: Sequence[tuple[float, float]],
        demands: Sequence[float] = (),
    ) -> None:
        self.listed = listed
        self._weights: Floats = np.ones(1) if listed.split is None else listed.split.weights(demands)
        self.graph = graph = listed.graph
        fails, back = np.array([*rates, (0.0, 0.0)]).T
        self.rates = fails[listed.failing] + back[listed.repaired] + listed.interrupting
        failed = self._run_objectives(ending)
        self.hasty = np.zeros(graph.states, np.bool_)
        self.hasty[graph.sources[failed]] = True
        self.rates[self.hasty[graph.sources]] = 0.0
        self.rates[failed | listed.starting] = 1.0
        self.hasty[graph.sources[listed.starting]] = True
        self.rates *= self._weights
        self.moving: Mask = (self.rates > 0) & listed.inside
        self.rates[~self.moving] = 0.0
        self.leaving: Floats = np.bincount(graph.sources, self.rates, graph.states).astype(np.float64)

    def _run_objectives(self, ending: Sequence[tuple[float, float]]) -> Mask:
        """Gives rates to edges that end objectives; those of objectives that fail at once are returned."""
        listed, sources, targets = self.listed, self.graph.sources, self.graph.targets
        may_happen = ((self.rates > 0) | listed.ending) & (self._weights > 0)
        failed = np.zeros(self.graph.edges, np.bool_)
        objectives = listed.prospects.objectives.items()
        for (name, goal), (rate, failure) in zip(objectives, ending, strict=True):
            if goal.running:
                well, badly = listed.carrying(What.SUCCESS, name), listed.carrying(What.FAILURE, name)
                running, won, misused = goal.running.mask, goal.won.mask, listed.misused[name]
                self.rates[well] = rate * (1.0 - failure)
                self.rates[badly & won[sources]] = rate * failure
                self.rates[badly & misused[sources]] = rate
                # What ends the present run may lead back into the objective: that is another run.
                going_on = running[sources] & running[targets] & may_happen & ~listed.ending_run(goal)
                hopeful = self.graph.reaching(won | misused, going_on)
                failed |= badly & (running & ~hopeful)[sources]
        return failed

    # --- what is possible ---

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

    # --- what is expected ---

    @cached_property
    def _matrix(self) -> csr_array:
        """Rates between states."""
        ways = self.graph.sources[self.moving], self.graph.targets[self.moving]
        return csr_array((self.rates[self.moving], ways), shape=(self.graph.states,) * 2)

    def _solver(self, states: Ints, decays: Floats) -> Callable[[Floats], Floats]:
        """Solves ``(leaving + s) x = rates x + b`` in some states for several ``s``, of given ``b``."""
        leaving = self.leaving[states] + np.multiply.outer(decays, ~self.hasty[states])
        scale, many = 1.0 / leaving.reshape(-1, 1), len(decays)
        step = self._matrix[states][:, states].tocoo()
        # One block-diagonal matrix holds all systems, since each call of scipy has a cost of its own.
        number, block = np.arange(len(scale)), np.repeat(np.arange(many) * len(states), step.nnz)
        rows, columns = (np.tile(indices, many) + block for indices in (step.row, step.col))
        values = np.concatenate([np.ones(len(scale)), -np.tile(step.data, many) * scale[rows, 0]])
        ends = np.concatenate([number, rows]), np.concatenate([number, columns])
        solve = splu(csc_array((values, ends), shape=(len(scale),) * 2)).solve
        return lambda right: solve(np.tile(right, (many, 1)) * scale).reshape(many, *right.shape)

    @cached_property
    def _inner(self) -> Ints:
        return np.flatnonzero(self._ending & ~self.listed.ended)

    @cached_property
    def _undecayed(self) -> Callable[[Floats], Floats]:
        return self._solver(self._inner, np.zeros(1))

    def expected(self, values: Floats) -> Floats:
        """The expected value at the exit, 0 if there never is one.

        Args:
            values: By exit and status there; the second axis is free.

        Returns:
            By status at the entry.
        """
        found = np.where(self.listed.ended[:, None], values[self.listed.column], 0.0)
        if len(self._inner):
            found[self._inner] = self._undecayed(self._matrix[self._inner] @ found)[0]
        return self.listed.at_entries(found)

    def kernels(self, decays: Floats) -> Floats:
        """Laplace transforms of the time to absorption, by the exit and status where the chain ends.

        Args:
            decays: Rates ``s``.

        Returns:
            By ``s``, status at the entry, and exit and status there, the expectation of ``exp(-s T)`` for the
            time ``T`` until the exit: shape (decays, statuses, columns).
        """
        listed, inner = self.listed, self._inner
        found = np.zeros((len(decays), listed.statuses, listed.columns))
        met = np.flatnonzero(np.isin(listed.entries, inner))
        rows, ends = np.searchsorted(inner, listed.entries[met]), np.flatnonzero(listed.ended)
        pairs = np.ones(len(ends)), (ends, listed.column[ends])
        out = csc_array(self._matrix[inner] @ csr_array(pairs, shape=(self.graph.states, listed.columns)))
        wanted = np.flatnonzero(np.diff(out.indptr))
        together = max(1, UNKNOWNS // max(1, len(inner)))
        for begin in range(0, len(decays) if len(met) else 0, together):
            some = slice(begin, begin + together)
            solve = self._solver(inner, decays[some])
            for first in range(0, len(wanted), CHUNK):
                columns = wanted[first : first + CHUNK]
                found[some][:, met[:, None], columns] = solve(out[:, columns].toarray())[:, rows]
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
            found[states] = self._solver(states, np.zeros(1))(gained[states, None])[0, :, 0]
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
    # Gains may never end where some run comes to a state from which no state without further gain is reached.
    endless = reaching(np.isinf(gained) | ~reaching(~gaining | resting))
    return np.where(endless, np.inf, solved(gaining & ~endless, gained))
