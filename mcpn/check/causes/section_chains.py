"""Numbers of risk as a chain of sections over the status of the hardware; the whole mission may be one.

What a section does depends on its own hardware alone, and all other hardware fails and is repaired beside it
in continuous time. Both are independent but for the time ``T`` after which the section ends. Each resource
beside it is a chain of two states, whose functions are spanned by two that decay as ``exp(-s t)``: the
constant with ``s = 0``, and one with ``s`` its failures and repairs per hour together. Of a product of such
functions the rates ``s`` add up. So the expected value at the exit of a section is, for each product, the
transform ``E[exp(-s T)]`` of the section's own chain (:meth:`mcpn.check.causes.chain.Chain.kernels`): exact,
and without the product of the section's states with the status of the other hardware.

The sections are worked backward from the mission's ends. The value at an entry is a function of the status of
the hardware that this section and later ones use; other hardware does not matter any more. Where sections
lead back to earlier ones, the values at those entries are the unknowns of a linear system.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias
from weakref import WeakValueDictionary

import networkx as nx
import numpy as np
import numpy.typing as npt
from scipy.sparse.linalg import LinearOperator, gmres

from mcpn.check.causes.chain import Chain, Floats, Listed
from mcpn.errors import LimitError
from mcpn.mission.flatten import ElementarySection
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.space.markings.graph import Ints

Array: TypeAlias = npt.NDArray[Any]
Values: TypeAlias = Mapping[str, Array]
"""By section, values by the status of the hardware that it and later ones use; the last axis is free."""

MOST_HARDWARE = 16
"""Hardware resources whose status is remembered from one section to the next, at most."""

MOST_DENSE = 1024
"""Unknowns of a system that is solved directly; a larger one by iteration."""

PRODUCTS = 1024
"""Products of functions whose kernels are multiplied at a time."""

PRECISION = 1e-13
"""Of the iteration, relative to the values at the exits."""


@dataclass(frozen=True, eq=False)
class Section:
    """A section of a mission, or the whole mission as one.

    Args:
        listed: Its states, which sections of one type share.
        hardware: Its hardware that can fail, in the order of the states'.
        objectives: Its elementary objectives, in that order too.
        routes: By exit, the section that it leads to, or the mission's own exit.
    """

    listed: Listed
    hardware: tuple[str, ...]
    objectives: Sequence[ElementarySection]
    routes: Mapping[str, str]


class Sections:
    """The sections of a mission.

    Args:
        sections: The sections by name, in the mission's order.
        entry: The section where the mission begins.
        hardware: The mission's hardware that can fail.

    Raises:
        LimitError: Too much hardware must be remembered.
    """

    def __init__(self, sections: Mapping[str, Section], entry: str, hardware: Sequence[str]) -> None:
        self.sections = sections
        self.entry = entry
        graph: nx.DiGraph[str] = nx.DiGraph()
        graph.add_nodes_from(sections)
        graph.add_edges_from((n, r) for n, s in sections.items() for r in s.routes.values() if r in sections)
        order = {name: number for number, name in enumerate(sections)}
        condensed = nx.condensation(graph)
        self.loops: list[tuple[list[str], list[str]]] = []
        """Sections that lead to each other, and those of them that are led back to; later ones first."""
        self.used: dict[str, tuple[str, ...]] = {}
        """By section, the hardware that it and later ones use, in the mission's order."""
        for number in reversed(list(nx.topological_sort(condensed))):
            members = sorted(condensed.nodes[number]["members"], key=order.__getitem__)
            back = {r for n in members for r in graph[n] if r in members and order[r] <= order[n]}
            self.loops.append((members, sorted(back, key=order.__getitem__)))
            used = {h for name in members for h in sections[name].hardware}
            used |= {h for name in members for r in graph[name] for h in self.used.get(r, ())}
            if len(used) > MOST_HARDWARE and len(sections) > 1:
                raise LimitError(
                    f"section {members[0]} and those after it use {len(used)} hardware resources that may "
                    f"fail: numbers of risk remember 2^{len(used)} states of them, the limit is "
                    f"2^{MOST_HARDWARE}"
                )
            self.used.update(dict.fromkeys(members, tuple(h for h in hardware if h in used)))
        self.chains: WeakValueDictionary[Any, Chain] = WeakValueDictionary()
        """Chains that some outlook still uses, by all that makes them."""


class Outlook:
    """A mission under given rates.

    Args:
        model: Its sections.
        failing: Failures per hour, by hardware.
        repaired: Repairs per hour, by hardware.
    """

    def __init__(self, model: Sections, failing: Mapping[str, float], repaired: Mapping[str, float]) -> None:
        self.model = model
        kernels: dict[tuple[Chain, bytes], Floats] = {}
        self.steps = {name: _Step(name, model, failing, repaired, kernels) for name in model.sections}

    def ends(self, lost: str | None = None) -> tuple[float, float]:
        """Probabilities of success and failure, if one resource is out of service at the start."""
        status = tuple(int(name == lost) for name in self.model.used[self.model.entry])
        success, failure = self._ends[self.model.entry][status].tolist()
        return success, failure

    @cached_property
    def _ends(self) -> Values:
        sure = np.ones(1, np.bool_)
        ending = self._coming_to({SUCCEED: sure, FAIL: sure})
        nothing = dict.fromkeys(self.steps, np.zeros(2))
        return self._solved(ending, nothing, {SUCCEED: np.array([1.0, 0.0]), FAIL: np.array([0.0, 1.0])})

    def degraded_modes(self) -> float:
        """The expected number of jumps into another, degraded mode; infinite where it may go on for ever."""
        steps, sure = self.steps, np.ones(1, np.bool_)
        entered = {name: step.spread(step.chain.into_degraded) for name, step in steps.items()}
        gained: dict[str, Array] = {}
        for name, step in steps.items():
            # A section that is entered again from itself counts that inside, where it knows the mode before.
            others = {route: found for route, found in entered.items() if route != name}
            gained[name] = step.back(self._at_exits(step, others)) + step.spread(step.chain.modes[0])
        gaining = self._coming_to({name: found > 0 for name, found in gained.items()})
        # It goes on for ever where no state is reached after which nothing is gained.
        resting = {name: step.spread(step.chain.stays) | ~gaining[name] for name, step in steps.items()}
        resting = self._coming_to({**resting, SUCCEED: sure, FAIL: sure})
        infinite = {name: step.spread(step.chain.modes[1]) | ~resting[name] for name, step in steps.items()}
        infinite = self._coming_to(infinite)
        start = *(0 for _ in self.model.used[self.model.entry]), 0
        if infinite[self.model.entry][start]:
            return math.inf
        finite = {name: gaining[name] & ~infinite[name] for name in steps}
        values = self._solved(finite, gained, {})
        return float(values[self.model.entry][start] + entered[self.model.entry][start])

    def _at_exits(self, step: _Step, values: Values) -> list[Array]:
        """Values after each exit of a section, with the section's axes; 0 where none are given."""
        routes = [step.section.routes[exit_] for exit_ in step.chain.listed.exits]
        found = [values.get(route, np.zeros(1, np.bool_)) for route in routes]
        width = max(value.shape[-1] for value in found)
        for i, (route, value) in enumerate(zip(routes, found, strict=True)):
            later = self.model.used[route] if value.ndim > 1 else ()
            value = value.reshape(*(2 if h in later else 1 for h in step.used), value.shape[-1])
            found[i] = np.broadcast_to(value, (2,) * len(step.used) + (width,))
        return found

    def _coming_to(self, flagged: Values) -> dict[str, Array]:
        """The entries from which flagged entries or ends are reached with some probability."""
        found = dict(flagged)
        for members, heads in self.model.loops:
            grown = True
            while grown:
                before = {name: found.get(name) for name in heads}
                for name in reversed(members):
                    coming = self.steps[name].may_come_to(self._at_exits(self.steps[name], found))
                    found[name] = found.get(name, False) | coming
                grown = any(not np.array_equal(found[name], known) for name, known in before.items())  # type: ignore[arg-type]
        return found

    def _solved(self, inner: Values, gained: Values, ends: Values) -> Values:
        """The values at entries: what is gained, and what is expected at the exits; 0 outside ``inner``."""
        found = dict(ends)
        for members, heads in self.model.loops:
            if heads:
                found |= self._heads(members, heads, inner, gained, found)
            found |= self._sweep(members, inner, gained, found)
        return found

    def _sweep(
        self, members: Sequence[str], inner: Values, gained: Values, known: Values
    ) -> dict[str, Array]:
        """The values at the entries of sections from those of later ones, and of those they lead back to."""
        values = dict(known)
        for name in reversed(members):
            # What leads back to this section came before it here, and has seen the value that was known.
            step = self.steps[name]
            value = step.back(self._at_exits(step, values)) + gained[name]
            values[name] = np.where(inner[name], value, 0.0)
        return values

    def _heads(
        self, members: Sequence[str], heads: Sequence[str], inner: Values, gained: Values, later: Values
    ) -> Values:
        """The values at the entries that sections of a loop lead back to, by a linear system."""
        shape = (2,) * len(self.model.used[heads[0]])

        def split(matrix: Array) -> Values:
            parts = (part.reshape(*shape, -1) for part in np.split(matrix, len(heads)))
            return dict(zip(heads, parts, strict=True))

        def onward(matrix: Array, gained: Values, later: Values) -> Floats:
            found = self._sweep(members, inner, gained, {**later, **split(matrix)})
            return np.concatenate([found[name].reshape(-1, found[name].shape[-1]) for name in heads])

        size, width = len(heads) << len(shape), gained[heads[0]].shape[-1]
        right = onward(np.zeros((size, width)), gained, later)
        if size <= MOST_DENSE:
            nothing = dict.fromkeys(members, np.zeros(size))
            return split(np.linalg.solve(np.eye(size) - onward(np.eye(size), nothing, {}), right))

        def less(vector: Floats) -> Floats:
            nothing = dict.fromkeys(members, np.zeros(1))
            return vector - onward(vector.reshape(-1, 1), nothing, {}).reshape(-1)

        system = LinearOperator((size, size), matvec=less, dtype=np.float64)
        columns = []
        for column in right.T:
            solved, failed = gmres(system, column, rtol=PRECISION, atol=0.0, restart=100, maxiter=20)
            if failed:
                raise LimitError(f"the values at {size} entries of sections in loops did not settle")
            columns.append(solved)
        return split(np.stack(columns, axis=1))


class _Step:
    """The way through one section, from values at its exits to values at its entry.

    Values are arrays with an axis for each resource that the section and later ones use, in service and out
    of service, and a last axis for several values at once.
    """

    def __init__(
        self,
        name: str,
        model: Sections,
        failing: Mapping[str, float],
        repaired: Mapping[str, float],
        kernels: dict[tuple[Chain, bytes], Floats],
    ) -> None:
        self.section = section = model.sections[name]
        self.used = model.used[name]
        own = section.hardware
        ending = tuple(
            (1.0 / o.duration if o.duration else 0.0, o.failure_probability) for o in section.objectives
        )
        again = tuple(exit_ for exit_, route in section.routes.items() if route == name)
        rates = tuple(failing[h] for h in own), tuple(repaired[h] for h in own), ending, again
        chain = model.chains.get((section.listed, *rates))
        if chain is None:
            chain = model.chains[section.listed, *rates] = Chain(section.listed, *rates)
        self.chain = chain
        beside = [h for h in self.used if h not in own]
        self.beside = [(failing[h], repaired[h]) for h in beside]
        self._axes = [self.used.index(h) for h in (*own, *beside)]
        self._known = kernels
        """Kernels of this outlook's chains, by the decays of what is beside."""

    def _matrix(self, values: Sequence[Array]) -> Array:
        """Values at the exits with own status, status beside and values as axes; exits one after another."""
        own, last = self.chain.listed.statuses, len(self.used)
        return np.concatenate([v.transpose(*self._axes, last).reshape(own, -1, v.shape[-1]) for v in values])

    def _array(self, matrix: Array) -> Array:
        """The same back, for values at the entry."""
        found = matrix.reshape((2,) * len(self.used) + matrix.shape[-1:])
        return found.transpose(*np.argsort(self._axes), len(self.used))

    def _each_beside(self, matrix: Array, maps: Iterable[Sequence[Sequence[float]]]) -> Array:
        """Values after a map of two states to two for each resource beside the section."""
        found = matrix
        for number, of in enumerate(maps):
            found = np.asarray(of) @ found.reshape(len(matrix) << number, 2, -1)
        return found.reshape(matrix.shape)

    @cached_property
    def _decays(self) -> tuple[Floats, Ints]:
        """The rates at which products of functions of the hardware beside decay; by product, its rate."""
        found = np.zeros(1)
        for fails, back in self.beside:
            found = np.add.outer(found, (0.0, fails + back)).reshape(-1)
        return np.unique(found, return_inverse=True)

    def back(self, values: Sequence[Array]) -> Floats:
        """Expected values, from values at each of the chain's exits."""
        matrix = self._matrix(values).astype(np.float64)
        if not self.beside:
            return self._array(self.chain.expected(matrix[:, 0]))
        decays, numbers = self._decays
        key = self.chain, decays.tobytes()
        if key not in self._known:
            self._known[key] = self.chain.kernels(decays)
        kernels = self._known[key]
        # The share of time out of service, and the difference that the status makes, or the status as it is.
        shares = [(fails / (fails + back) if fails + back else None) for fails, back in self.beside]
        as_it_is = (1.0, 0.0), (0.0, 1.0)
        matrix = self._each_beside(
            matrix, (as_it_is if out is None else ((1.0 - out, out), (1.0, -1.0)) for out in shares)
        )
        found = np.empty((self.chain.listed.statuses, *matrix.shape[1:]))
        for begin in range(0, len(numbers), PRODUCTS):
            chosen = slice(begin, begin + PRODUCTS)
            products = kernels[numbers[chosen]] @ matrix[:, chosen].transpose(1, 0, 2)
            found[:, chosen] = products.transpose(1, 0, 2)
        return self._array(
            self._each_beside(
                found, (as_it_is if out is None else ((1.0, out), (1.0, out - 1.0)) for out in shares)
            )
        )

    def may_come_to(self, flags: Sequence[Array]) -> Array:
        """Whether some of the flagged states at the chain's exits are reached with some probability."""
        matrix = self._matrix(flags)
        if not self.beside:
            return self._array(self.chain.may_come_to(matrix[:, 0, 0])[:, None])
        matrix = matrix.astype(np.int64)
        after = self._each_beside(matrix, (((1, fails > 0), (back > 0, 1)) for fails, back in self.beside))
        at_once, later = (pairs.astype(np.int64) for pairs in self.chain.possible)
        counts = np.tensordot(at_once, matrix, axes=1) + np.tensordot(later, after, axes=1)
        return self._array(counts > 0)

    def spread(self, by_status: Array) -> Array:
        """Values by own status as an array of the section's shape."""
        own = self.chain.listed.statuses
        return self._array(np.broadcast_to(by_status.reshape(own, 1, 1), (own, 1 << len(self.beside), 1)))
