"""A section of a mission, or the whole mission taken as one, as a continuous-time Markov chain.

The model is that of :mod:`mcpn.check.causes.risk`. The chain begins in the state after its entry, which the
status of its hardware decides, and is absorbed at its exits. What a state is left to is decided by the chain
of jumps (Kemeny, Snell, *Finite Markov Chains*, 1960, chapter 3). The Laplace transform of the time until the
exit comes from the same linear system, with ``s`` added to the rate at which each state is left.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import cached_property
from typing import TypeVar

import numpy as np
import numpy.typing as npt
from scipy.sparse import csc_array, csr_array, identity
from scipy.sparse.linalg import splu

from mcpn.check.causes.prospects import Prospects
from mcpn.net.events import What
from mcpn.space.arrays import ArraySet, ArraySpace
from mcpn.space.markings.graph import Ints, Mask

Floats = npt.NDArray[np.float64]
T = TypeVar("T", bound=np.generic)

CHUNK = 64
"""Right-hand sides of a sparse system that are solved at a time."""

MOST_DENSE = 100
"""States of a chain whose systems are dense, several solved at a time."""

DENSE_NUMBERS = 1 << 21
"""Numbers in dense systems that are solved at a time."""


class Listed:
    """The states of a section, or of the whole mission, and what the model asks of them without numbers.

    Args:
        prospects: The section's local net, or the mission's, on its alternatives graph in arrays.
        hardware: Its hardware that can fail. A *status* is a number whose bits say which of it is out of
            service, the first resource in the highest bit.

    Attributes:
        exits: Its exits, by name.
        columns: The number of pairs of an exit and a status there.
        column: By state, such a pair as a number; of use at exits.
        ended: States at exits.
        entries: The first state, by the status with which it is entered; -1 where it is never entered so.
        failing: By edge, the number of the resource that fails; -1 for other edges.
        repaired: The same of one that is repaired.
        entering: Edges with which it is entered.
        inside: Edges between its own states, or from these to its exits.
    """

    def __init__(self, prospects: Prospects[ArraySet], hardware: Sequence[str]) -> None:
        assert isinstance(prospects.space, ArraySpace), "numbers are of listed states"
        self.prospects = prospects
        self.graph = graph = prospects.space.graph
        self.hardware = tuple(hardware)
        self.statuses = 1 << len(self.hardware)
        self.exits = tuple(prospects.mission_net.exits)
        exit_of = np.full(graph.states, -1, np.int64)
        for number, place in enumerate(prospects.mission_net.exits.values()):
            exit_of[graph.marked(place)] = number
        status = np.zeros(graph.states, np.int64)
        for name in self.hardware:
            status = 2 * status + graph.marked(prospects.mission_net.by_role["oos", name][0])
        self.columns = len(self.exits) * self.statuses
        self.column = exit_of * self.statuses + status
        self.ended: Mask = np.asarray(exit_of >= 0, np.bool_)
        self.failing = self._hardware_of(What.OUT_OF_SERVICE)
        self.repaired = self._hardware_of(What.REPAIRED)
        entering = np.flatnonzero(self._fired(prospects.carrying(What.START)))
        outside = self.ended.copy()
        outside[graph.sources[entering]] = True
        self.inside: Mask = np.asarray(~outside[graph.sources], np.bool_)
        self.entries: Ints = np.full(self.statuses, -1, np.int64)
        self.entries[status[graph.sources[entering]]] = graph.targets[entering]

    def _hardware_of(self, what: What) -> Ints:
        number = np.full(len(self.graph.net.transitions), -1, np.int64)
        for i, name in enumerate(self.hardware):
            number[list(self.prospects.carrying(what, name))] = i
        return number[self.graph.labels]

    def _fired(self, transitions: Collection[int]) -> Mask:
        return np.isin(self.graph.labels, list(transitions))

    def at_entries(self, states: npt.NDArray[T]) -> npt.NDArray[T]:
        """What is said of states, of the first one by status; zero where it is never entered so."""
        found = states[self.entries]
        found[self.entries < 0] = 0
        return found

    @cached_property
    def objectives(self) -> list[tuple[Mask, Mask, Mask, Mask]]:
        """By objective: states in which it runs, and may succeed at once; edges of success and of failure."""
        prospects = self.prospects
        return [
            (
                goal.running.mask,
                goal.won.mask,
                self._fired(prospects.carrying(What.SUCCESS, name)),
                self._fired(prospects.carrying(What.FAILURE, name)),
            )
            for name, goal in prospects.objectives.items()
        ]

    @cached_property
    def modes(self) -> npt.NDArray[np.bool_]:
        """Which objectives run, and which alternatives, by state: equal rows are one functioning mode."""
        found = self.prospects.mission_net
        places = sorted((*found.saying("active"), *found.saying("objective")))
        marked = [self.graph.marked(place) for place in places]
        return np.stack(marked, axis=1) if marked else np.zeros((self.graph.states, 0), np.bool_)

    @cached_property
    def degraded(self) -> Mask:
        """States in which some activity runs in another alternative than its first."""
        found = self.prospects.mission_net
        first = {f"{a.name}.{a.alternatives[0].name}" for a in found.mission.activities}
        others = [place for place, name in found.saying("active").items() if name not in first]
        return self.prospects.space.marked(others).mask & ~self.ended


class Chain:
    """The chain under given rates.

    Args:
        listed: Its states.
        failing: Failures per hour of each of its resources in service.
        repaired: Repairs per hour of each out of service.
        ending: By objective, its ends per hour while its success is possible, and the probability that such
            an end is a failure.
        again: Exits after which it is entered again.
    """

    def __init__(
        self,
        listed: Listed,
        failing: Sequence[float],
        repaired: Sequence[float],
        ending: Sequence[tuple[float, float]],
        again: Collection[str] = (),
    ) -> None:
        self.listed = listed
        self.graph = graph = listed.graph
        exits = [listed.exits.index(name) for name in again]
        self._again = np.isin(listed.column // listed.statuses, exits) & listed.ended
        self.rates = np.append(failing, 0.0)[listed.failing] + np.append(repaired, 0.0)[listed.repaired]
        failed = self._run_objectives(ending)
        self.hasty = np.zeros(graph.states, np.bool_)
        """States that are left at once: an objective that runs cannot succeed any more."""
        self.hasty[graph.sources[failed]] = True
        self.rates[self.hasty[graph.sources]] = 0.0
        self.rates[failed] = 1.0
        self.moving: Mask = (self.rates > 0) & listed.inside
        """Edges that are taken with some probability."""
        self.rates[~self.moving] = 0.0
        self.leaving: Floats = np.bincount(graph.sources, self.rates, graph.states).astype(np.float64)
        """The rate at which each state is left."""

    def _run_objectives(self, ending: Sequence[tuple[float, float]]) -> Mask:
        """Gives rates to edges that end objectives; those of objectives that fail at once are returned."""
        listed, sources, targets = self.listed, self.graph.sources, self.graph.targets
        may_happen = (self.rates > 0) | ((listed.failing < 0) & (listed.repaired < 0))
        failed = np.zeros(self.graph.edges, np.bool_)
        for (running, won, well, badly), (rate, failure) in zip(listed.objectives, ending, strict=True):
            if not running.any():
                continue
            self.rates[well] = rate * (1.0 - failure)
            self.rates[badly & won[sources]] = rate * failure
            going_on = running[sources] & ~well & ~badly & may_happen
            hopeful = self.graph.reaching(won, going_on & running[targets])
            returning = np.flatnonzero(going_on & self._again[targets])
            first = self._after(returning)
            while len(returning):  # its run may go on after an exit that leads back to the entry
                ways = returning[(first >= 0) & hopeful[first] & running[first]]
                if hopeful[sources[ways]].all():
                    break
                hopeful[sources[ways]] = True
                hopeful = self.graph.reaching(hopeful, going_on & running[targets])
            failed |= badly & (running & ~hopeful)[sources]
        return failed

    def _after(self, edges: Ints) -> Ints:
        """The states after some edges; the first one where it is entered again."""
        targets = self.graph.targets[edges]
        again = self.listed.entries[self.listed.column[targets] % self.listed.statuses]
        return np.where(self._again[targets], again, targets)

    # --- where it ends, and when ---

    @cached_property
    def _jumps(self) -> csr_array:
        """Probabilities of the next state."""
        graph, moving = self.graph, self.moving
        sources, targets = graph.sources[moving], graph.targets[moving]
        values = self.rates[moving] / self.leaving[sources]
        return csr_array((values, (sources, targets)), shape=(graph.states, graph.states))

    @cached_property
    def _ending(self) -> Mask:
        """States from which it comes to an exit with some probability."""
        return self.graph.reaching(self.listed.ended, self.moving)

    @cached_property
    def _inner(self) -> Ints:
        return np.flatnonzero(self._ending & ~self.listed.ended)

    @cached_property
    def _solve(self) -> Callable[[Floats], Floats]:
        return _factors(self._jumps[self._inner][:, self._inner])

    def expected(self, values: Floats) -> Floats:
        """The expected value at the exit, 0 if there never is one.

        Args:
            values: By exit and status there; the second axis is free.

        Returns:
            By status at the entry.
        """
        found = np.where(self.listed.ended[:, None], values[self.listed.column], 0.0)
        if len(self._inner):
            found[self._inner] = self._solve(self._jumps[self._inner] @ found)
        return self.listed.at_entries(found)

    def kernels(self, decays: Floats) -> Floats:
        """Where it ends, discounted at several rates.

        Args:
            decays: Rates ``s``.

        Returns:
            By ``s``, status at the entry, and exit and status there, the expectation of ``exp(-s T)`` for the
            time ``T`` until the exit: shape (decays, statuses, columns).
        """
        listed, inner = self.listed, self._inner
        found = np.zeros((len(decays), listed.statuses, listed.columns))
        number = np.full(self.graph.states, -1, np.int64)
        number[inner] = np.arange(len(inner))
        met = np.flatnonzero((listed.entries >= 0) & (number[listed.entries] >= 0))
        if not len(met):
            return found
        rows = number[listed.entries[met]]
        ways = self.graph.sources[self.moving], self.graph.targets[self.moving]
        rates = csr_array((self.rates[self.moving], ways), shape=(self.graph.states,) * 2)[inner]
        ends = np.flatnonzero(listed.ended)
        pairs = csr_array(
            (np.ones(len(ends)), (ends, listed.column[ends])), shape=(self.graph.states, listed.columns)
        )
        out = csc_array(rates @ pairs)
        wanted = np.flatnonzero(np.diff(out.indptr))
        leaving, waiting = self.leaving[inner], ~self.hasty[inner]
        if len(inner) <= MOST_DENSE:
            dense, right = rates[:, inner].toarray(), out[:, wanted].toarray()
            size = max(1, DENSE_NUMBERS // len(inner) ** 2)
            for begin in range(0, len(decays), size):
                left = leaving + np.multiply.outer(decays[begin : begin + size], waiting)
                systems = left[:, :, None] * np.eye(len(inner)) - dense
                solved = np.linalg.solve(systems, np.broadcast_to(right, (len(left), *right.shape)))
                found[begin : begin + size][:, met[:, None], wanted] = solved[:, rows]
            return found
        for part, s in zip(found, decays.tolist(), strict=True):
            scale = 1.0 / (leaving + s * waiting)
            solve = _factors(csr_array(rates[:, inner].multiply(scale[:, None])))
            for begin in range(0, len(wanted), CHUNK):
                columns = wanted[begin : begin + CHUNK]
                right = out[:, columns].toarray() * scale[:, None]
                part[np.ix_(met, columns)] = solve(right)[rows]
        return found

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
    def stays(self) -> Mask:
        """By status at the entry, whether with some probability it comes to no exit."""
        return self.listed.at_entries(self.graph.reaching(~self._ending, self.moving))

    # --- degraded modes ---

    @cached_property
    def _degraded(self) -> Mask:
        """States of a degraded mode that are not left at once."""
        return self.listed.degraded & ~self.hasty

    @cached_property
    def into_degraded(self) -> Mask:
        """By status, whether the first state is of a degraded mode, and is not left at once."""
        return self.listed.at_entries(self._degraded)

    @cached_property
    def modes(self) -> tuple[Floats, Mask]:
        """The expected number of jumps into another, degraded mode, by status at the entry.

        The entry is not counted, unless it is entered again.

        Returns:
            The numbers, and whether they are infinite.
        """
        graph, listed = self.graph, self.listed
        after = self._after(np.arange(graph.edges))
        changed = (listed.modes[graph.sources] != listed.modes[after]).any(axis=1)
        counted = self.moving & changed & self._degraded[after] & (after >= 0)
        share = np.divide(self.rates, self.leaving[graph.sources], out=np.zeros(graph.edges), where=counted)
        gained = np.bincount(graph.sources, share, graph.states).astype(np.float64)
        gaining = graph.reaching(np.asarray(gained > 0, np.bool_), self.moving)
        # It goes on for ever where no state is reached after which nothing is gained.
        infinite = graph.reaching(~graph.reaching(~gaining, self.moving), self.moving)
        inner = np.flatnonzero(gaining & ~infinite)
        found = np.zeros(graph.states)
        if len(inner):
            found[inner] = _factors(self._jumps[inner][:, inner])(gained[inner])
        return listed.at_entries(found), listed.at_entries(infinite)


def _factors(step: csr_array) -> Callable[[Floats], Floats]:
    """Solves ``x = step x + b`` for given ``b``."""
    size = step.shape[0]
    solved: Callable[[Floats], Floats] = splu(csc_array(identity(size, format="csc") - step)).solve
    return solved
