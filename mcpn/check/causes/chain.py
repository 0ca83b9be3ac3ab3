"""A section of a mission, or the whole mission taken as one, as a continuous-time Markov chain.

The model is that of :mod:`mcpn.check.causes.risk`. The chain begins in the state after its entry, which the
status of its hardware decides, and is absorbed at its exits. What a state is left to is decided by the chain
of jumps (Kemeny, Snell, *Finite Markov Chains*, 1960, chapter 3). The Laplace transform of the time until the
exit comes from the same linear system, with ``s`` added to the rate at which each state is left.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.sparse import csc_array, csr_array, identity
from scipy.sparse.linalg import splu

from mcpn.check.causes.prospects import Prospects
from mcpn.mission.flatten import ElementarySection
from mcpn.net.events import What
from mcpn.space.arrays import ArraySet, ArraySpace
from mcpn.space.markings.graph import Ints, Mask

Floats = npt.NDArray[np.float64]

CHUNK = 64
"""Right-hand sides of a sparse system that are solved at a time."""

MOST_DENSE = 100
"""States of a chain whose systems are dense, several solved at a time."""

DENSE_NUMBERS = 1 << 21
"""Numbers in dense systems that are solved at a time."""


@dataclass(frozen=True)
class Rates:
    """Numbers of the model, in the order of a chain's hardware and of its objectives.

    Args:
        failing: Failures per hour of each resource in service.
        repaired: Repairs per hour of each resource out of service.
        ending: Ends per hour of each objective while its success is possible.
        failure: The probability that such an end is a failure.
    """

    failing: tuple[float, ...]
    repaired: tuple[float, ...]
    ending: tuple[float, ...]
    failure: tuple[float, ...]

    @classmethod
    def of(
        cls, objectives: Iterable[ElementarySection], failing: Iterable[float], repaired: Iterable[float]
    ) -> Rates:
        """Those of some objectives and of the hardware; an objective without a duration never ends."""
        known = list(objectives)
        return cls(
            tuple(failing),
            tuple(repaired),
            tuple(0.0 if section.duration is None else 1.0 / section.duration for section in known),
            tuple(section.failure_probability for section in known),
        )


@dataclass(frozen=True, eq=False)
class _Runs:
    """One objective: states in which it runs, and in which its success is possible; edges that end it."""

    running: Mask
    won: Mask
    well: Mask
    badly: Mask


class Listed:
    """The states of a section, or of the whole mission, and what the model asks of them without numbers.

    Args:
        prospects: The section's local net, or the mission's, on its alternatives graph in arrays.
        hardware: Its hardware that can fail. A *status* is a number whose bits say which of it is out of
            service, the first resource in the highest bit.
    """

    def __init__(self, prospects: Prospects[ArraySet], hardware: Sequence[str]) -> None:
        assert isinstance(prospects.space, ArraySpace), "numbers are of listed states"
        self.prospects = prospects
        self.graph = graph = prospects.space.graph
        self.hardware = tuple(hardware)
        self.statuses = 1 << len(self.hardware)
        self.exits: Mapping[str, int] = {name: i for i, name in enumerate(prospects.mission_net.exits)}
        self.exit_of = np.full(graph.states, -1, np.int64)
        for name, place in prospects.mission_net.exits.items():
            self.exit_of[graph.marked(place)] = self.exits[name]
        self.ended: Mask = np.asarray(self.exit_of >= 0, np.bool_)
        self.failing = self._hardware_of(What.OUT_OF_SERVICE)
        self.repaired = self._hardware_of(What.REPAIRED)
        self.toggling: Mask = (self.failing >= 0) | (self.repaired >= 0)

    def _hardware_of(self, what: What) -> Ints:
        """The number of the resource that fails, or is repaired, at each edge; -1 for other edges."""
        number = np.full(len(self.graph.net.transitions), -1, np.int64)
        for i, name in enumerate(self.hardware):
            number[list(self.prospects.carrying(what, name))] = i
        return number[self.graph.labels]

    def _fired(self, transitions: Collection[int]) -> Mask:
        return np.isin(self.graph.labels, list(transitions))

    @cached_property
    def entering(self) -> Mask:
        """Edges with which it is entered."""
        return self._fired(self.prospects.carrying(What.START))

    @cached_property
    def inside(self) -> Mask:
        """Edges between its own states, or from these to its exits."""
        before = np.zeros(self.graph.states, np.bool_)
        before[self.graph.sources[self.entering]] = True
        return np.asarray(~(before | self.ended)[self.graph.sources], np.bool_)

    @cached_property
    def status(self) -> Ints:
        """The status of its hardware, by state; of use where it is idle."""
        found = np.zeros(self.graph.states, np.int64)
        for name in self.hardware:
            place = self.prospects.mission_net.by_role["oos", name][0]
            found = 2 * found + self.graph.marked(place)
        return found

    @cached_property
    def entries(self) -> Ints:
        """The first state, by the status with which it is entered; -1 where it is never entered so."""
        found = np.full(self.statuses, -1, np.int64)
        edges = np.flatnonzero(self.entering)
        found[self.status[self.graph.sources[edges]]] = self.graph.targets[edges]
        return found

    @cached_property
    def objectives(self) -> list[_Runs]:
        """Its elementary objectives, in its order."""
        prospects = self.prospects
        return [
            _Runs(
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
        if not places:
            return np.zeros((self.graph.states, 0), np.bool_)
        return np.stack([self.graph.marked(place) for place in places], axis=1)

    @cached_property
    def degraded(self) -> Mask:
        """States in which some activity runs in another alternative than its first."""
        found = self.prospects.mission_net
        first = {f"{a.name}.{a.alternatives[0].name}" for a in found.mission.activities}
        degraded = np.zeros(self.graph.states, np.bool_)
        for place, name in found.saying("active").items():
            if name not in first:
                degraded |= self.graph.marked(place)
        return degraded & ~self.ended


class Chain:
    """The chain under given rates.

    Args:
        listed: Its states.
        rates: The numbers.
        again: Exits after which it is entered again.
    """

    def __init__(self, listed: Listed, rates: Rates, again: frozenset[str] = frozenset()) -> None:
        self.listed = listed
        self.graph = graph = listed.graph
        self._again = np.isin(listed.exit_of, [listed.exits[name] for name in again])
        self.rates = np.zeros(graph.edges)
        for numbers, values in ((listed.failing, rates.failing), (listed.repaired, rates.repaired)):
            self.rates[numbers >= 0] = np.array(values)[numbers[numbers >= 0]]
        failed = self._run_objectives(rates)
        self.hasty = np.zeros(graph.states, np.bool_)
        """States that are left at once: an objective that runs cannot succeed any more."""
        self.hasty[graph.sources[failed]] = True
        self.rates[self.hasty[graph.sources]] = 0.0
        self.rates[failed] = 1.0
        self.moving: Mask = (self.rates > 0) & listed.inside
        """Edges that are taken with some probability."""
        self.rates[~self.moving] = 0.0

    def _run_objectives(self, rates: Rates) -> Mask:
        """Gives rates to edges that end objectives; those of objectives that fail at once are returned."""
        graph, sources, targets = self.graph, self.graph.sources, self.graph.targets
        possible = self.rates > 0
        failed = np.zeros(graph.edges, np.bool_)
        of = zip(self.listed.objectives, rates.ending, rates.failure, strict=True)
        for runs, rate, failure in of:
            if not runs.running.any():
                continue
            self.rates[runs.well] = rate * (1.0 - failure)
            self.rates[runs.badly & runs.won[sources]] = rate * failure
            going_on = runs.running[sources] & ~runs.well & ~runs.badly
            going_on &= ~self.listed.toggling | possible
            lost = runs.running & ~self._reaching(runs, going_on & runs.running[targets], going_on)
            failed |= runs.badly & lost[sources]
        return failed

    def _reaching(self, runs: _Runs, inside: Mask, going_on: Mask) -> Mask:
        """States from which an objective may still succeed in its present run."""
        found = self.graph.reaching(runs.won, inside)
        returning = np.flatnonzero(going_on & self._again[self.graph.targets])
        first = self.listed.entries[self.listed.status[self.graph.targets[returning]]]
        while len(returning):
            ways = returning[(first >= 0) & found[first] & runs.running[first]]
            more = found.copy()
            more[self.graph.sources[ways]] = True
            if (more == found).all():
                break
            found = self.graph.reaching(more, inside)
        return found

    # --- where it ends, and when ---

    @cached_property
    def _leaving(self) -> Floats:
        """The rate at which each state is left."""
        left = np.bincount(self.graph.sources, weights=self.rates, minlength=self.graph.states)
        return left.astype(np.float64)

    @cached_property
    def _jumps(self) -> csr_array:
        """Probabilities of the next state."""
        graph, moving = self.graph, self.moving
        sources, targets = graph.sources[moving], graph.targets[moving]
        values = self.rates[moving] / self._leaving[sources]
        return csr_array((values, (sources, targets)), shape=(graph.states, graph.states))

    @cached_property
    def _inner(self) -> Ints:
        """States, its exits aside, from which it comes to an exit with some probability."""
        return np.flatnonzero(self.graph.reaching(self.listed.ended, self.moving) & ~self.listed.ended)

    def expected(self, values: Floats) -> Floats:
        """The expected value at the exit, 0 if there never is one.

        Args:
            values: By state, of use at exits.

        Returns:
            By state.
        """
        found = np.where(self.listed.ended, values, 0.0)
        if len(self._inner):
            step = self._jumps[self._inner]
            found[self._inner] = _factors(step[:, self._inner])(step @ found)
        return found

    def kernels(self, decays: Floats) -> Floats:
        """Where it ends, discounted at several rates.

        Args:
            decays: Rates ``s``.

        Returns:
            By ``s``, status at the entry, and exit and status there, the expectation of ``exp(-s T)`` for the
            time ``T`` until the exit: shape (decays, statuses, exits * statuses).
        """
        listed, inner = self.listed, self._inner
        width = len(listed.exits) * listed.statuses
        found = np.zeros((len(decays), listed.statuses, width))
        number = np.full(self.graph.states, -1, np.int64)
        number[inner] = np.arange(len(inner))
        rows = number[listed.entries]
        met = np.flatnonzero((listed.entries >= 0) & (rows >= 0))
        if not len(inner) or not len(met):
            return found
        ends = np.flatnonzero(listed.ended)
        ones = csr_array((np.ones(len(ends)), (ends, self._column[ends])), shape=(self.graph.states, width))
        moving = self.moving
        ways = self.graph.sources[moving], self.graph.targets[moving]
        rates = csr_array((self.rates[moving], ways), shape=(self.graph.states,) * 2)[inner]
        out = csc_array(rates @ ones)
        wanted = np.flatnonzero(np.diff(out.indptr))
        leaving, waiting = self._leaving[inner], ~self.hasty[inner]
        if len(inner) <= MOST_DENSE:
            dense, right = rates[:, inner].toarray(), out[:, wanted].toarray()
            size = max(1, DENSE_NUMBERS // len(inner) ** 2)
            for begin in range(0, len(decays), size):
                left = leaving + np.multiply.outer(decays[begin : begin + size], waiting)
                systems = left[:, :, None] * np.eye(len(inner)) - dense
                solved = np.linalg.solve(systems, np.broadcast_to(right, (len(left), *right.shape)))
                found[begin : begin + size][:, met[:, None], wanted] = solved[:, rows[met]]
            return found
        for part, s in zip(found, decays.tolist(), strict=True):
            scale = 1.0 / (leaving + s * waiting)
            solve = _factors(csr_array(rates[:, inner].multiply(scale[:, None])))
            for begin in range(0, len(wanted), CHUNK):
                columns = wanted[begin : begin + CHUNK]
                right = out[:, columns].toarray() * scale[:, None]
                part[np.ix_(met, columns)] = solve(right)[rows[met]]
        return found

    @cached_property
    def _column(self) -> Ints:
        """Exit and status as one number, by state; of use at exits."""
        return self.listed.exit_of * self.listed.statuses + self.listed.status

    @cached_property
    def possible(self) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """By status at the entry, which exits and status there are possible: at once, and after some time."""
        listed, graph = self.listed, self.graph
        shape = listed.statuses, len(listed.exits) * listed.statuses
        at_once, later = np.zeros(shape, np.bool_), np.zeros(shape, np.bool_)
        quick = self.moving & self.hasty[graph.sources]
        for status, entry in enumerate(listed.entries.tolist()):
            if entry < 0:
                continue
            ends = graph.reached(quick, entry) & listed.ended
            at_once[status, self._column[ends]] = True
            slow = graph.reached(self.moving, entry) & ~self.hasty & ~listed.ended
            if slow.any():
                ends = graph.reached(self.moving, np.flatnonzero(slow)) & listed.ended
                later[status, self._column[ends]] = True
        return at_once, later

    @cached_property
    def stays(self) -> Mask:
        """By status at the entry, whether with some probability it comes to no exit."""
        ends = self.graph.reaching(self.listed.ended, self.moving)
        return self._at_entries(self.graph.reaching(~ends, self.moving))

    def _at_entries(self, states: Mask) -> Mask:
        entries = self.listed.entries
        return np.asarray((entries >= 0) & states[entries], np.bool_)

    # --- degraded modes ---

    @cached_property
    def into_degraded(self) -> Mask:
        """By status, whether its first state is of a degraded mode, and is not left at once."""
        return self._at_entries(self._counted_states)

    @property
    def _counted_states(self) -> Mask:
        return self.listed.degraded & ~self.hasty

    @cached_property
    def modes(self) -> tuple[Floats, Mask]:
        """The expected number of jumps into another, degraded mode, by state.

        The entry is not counted, unless it is entered again.

        Returns:
            The numbers, and the states from which the number is infinite.
        """
        graph, listed = self.graph, self.listed
        first = graph.targets.copy()
        again = self._again[first]
        first[again] = listed.entries[listed.status[first[again]]]
        changed = (listed.modes[graph.sources] != listed.modes[first]).any(axis=1)
        counted = self.moving & changed & self._counted_states[first] & (first >= 0)
        share = np.divide(self.rates, self._leaving[graph.sources], out=np.zeros(graph.edges), where=counted)
        gained = np.bincount(graph.sources, share, graph.states).astype(np.float64)
        gaining = graph.reaching(np.asarray(gained > 0, np.bool_), self.moving)
        # It goes on for ever where no state is reached after which nothing is gained.
        infinite = graph.reaching(~graph.reaching(~gaining, self.moving), self.moving)
        inner = np.flatnonzero(gaining & ~infinite)
        found = np.zeros(graph.states)
        if len(inner):
            found[inner] = _factors(self._jumps[inner][:, inner])(gained[inner])
        return found, infinite

    def modes_at_entries(self) -> tuple[Floats, Mask]:
        """The same by status at the entry."""
        numbers, infinite = self.modes
        met = self.listed.entries >= 0
        return np.where(met, numbers[self.listed.entries], 0.0), self._at_entries(infinite)


def _factors(step: csr_array) -> Callable[[Floats], Floats]:
    """Solves ``x = step x + b`` for given ``b``."""
    size = step.shape[0]
    solved: Callable[[Floats], Floats] = splu(csc_array(identity(size, format="csc") - step)).solve
    return solved
