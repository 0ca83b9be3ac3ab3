"""Numbers of risk by composition: a chain of sections over the status of the hardware.

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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import networkx as nx
import numpy as np
import numpy.typing as npt
from scipy.sparse.linalg import LinearOperator, gmres

from mcpn.check.causes.chain import Chain, Floats, Listed, Rates
from mcpn.check.causes.prospects import Prospects
from mcpn.errors import LimitError
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.space.arrays import ArraySpace
from mcpn.space.local.composite import CompositeSpace
from mcpn.space.local.section_type import SectionType
from mcpn.space.local.sections import Stage
from mcpn.space.local.sets import CompositeSet
from mcpn.space.markings.graph import Ints

Array: TypeAlias = npt.NDArray[Any]
Values: TypeAlias = dict[str, Array]
"""By section, values by the status of the hardware that it and later ones use; the last axis is free."""

MOST_HARDWARE = 16
"""Hardware resources whose status is remembered from one section to the next, at most."""

MOST_DENSE = 1024
"""Unknowns of a system that is solved directly; a larger one by iteration."""

PRODUCTS = 1024
"""Products of functions whose kernels are multiplied at a time."""

PRECISION = 1e-13
"""Of the iteration, relative to the values at the exits."""


class SectionChains:
    """The sections of a mission as chains.

    Args:
        prospects: The mission on its composite.
        max_states: How many states of a section may be listed.

    Raises:
        LimitError: Some section has more states, or too much hardware must be remembered.
    """

    def __init__(self, prospects: Prospects[CompositeSet], max_states: int) -> None:
        space = prospects.space
        assert isinstance(space, CompositeSpace), "only a composite has sections"
        self.entry = prospects.mission_net.graph.entry
        self.sections = {n: placed for n, placed in space.sections.items() if n in space.everything.parts}
        self.graph: nx.DiGraph[str] = nx.DiGraph()
        self.graph.add_nodes_from(self.sections)
        for name, placed in self.sections.items():
            self.graph.add_edges_from((name, r) for r in placed.routes.values() if r in self.sections)
        self.order = {name: number for number, name in enumerate(self.sections)}
        self.components = self._components()
        loop = {name: number for number, members in enumerate(self.components) for name in members}
        self.heads = {r for name, r in self.graph.edges if loop[name] == loop[r] and self.back(name, r)}
        self.used = self._used(space.layout.hardware)
        self.listed = self._listed(max_states)
        self.chains: dict[tuple[SectionType, Rates, frozenset[str]], Chain] = {}

    def _components(self) -> list[list[str]]:
        """Sections that lead to each other, later ones first; each in the mission's order."""
        condensed = nx.condensation(self.graph)
        later_first = reversed(list(nx.topological_sort(condensed)))
        return [sorted(condensed.nodes[c]["members"], key=self.order.__getitem__) for c in later_first]

    def back(self, name: str, route: str) -> bool:
        """Whether a section leads back to itself or one before it, in the mission's order."""
        return self.order[route] <= self.order[name]

    def _used(self, hardware: Sequence[str]) -> dict[str, tuple[str, ...]]:
        """By section, the hardware that it and later ones use, in the mission's order."""
        number = {name: i for i, name in enumerate(hardware)}
        found: dict[str, tuple[str, ...]] = {}
        for members in self.components:
            used = {h for name in members for h in self.sections[name].faulty}
            used |= {h for name in members for r in self.graph[name] for h in found.get(r, ())}
            if len(used) > MOST_HARDWARE:
                raise LimitError(
                    f"section {members[0]} and those after it use {len(used)} hardware resources that may "
                    f"fail: numbers of risk remember 2^{len(used)} states of them, the limit is "
                    f"2^{MOST_HARDWARE}"
                )
            found.update(dict.fromkeys(members, tuple(sorted(used, key=number.__getitem__))))
        return found

    def _listed(self, max_states: int) -> dict[SectionType, Listed]:
        found: dict[SectionType, Listed] = {}
        for name, placed in self.sections.items():
            kind = placed.type
            if kind not in found:
                space = ArraySpace(kind.listed(name, max_states, "numbers of risk list every state"))
                found[kind] = Listed(Prospects(kind.net, space), kind.faulty)
        return found

    def outlook(self, failing: Mapping[str, float], repaired: Mapping[str, float]) -> SectionsOutlook:
        """The mission under given failures and repairs per hour, by hardware."""
        known: dict[tuple[Chain, bytes], Floats] = {}
        steps = {name: self._step(name, failing, repaired, known) for name in self.sections}
        return SectionsOutlook(self, steps)

    def _step(
        self,
        name: str,
        failing: Mapping[str, float],
        repaired: Mapping[str, float],
        known: dict[tuple[Chain, bytes], Floats],
    ) -> Step:
        placed, used = self.sections[name], self.used[name]
        own = placed.faulty
        rates = Rates.of(placed.part.graph.walk(), [failing[h] for h in own], [repaired[h] for h in own])
        again = frozenset(exit_ for exit_, route in placed.routes.items() if route == name)
        key = placed.type, rates, again
        if key not in self.chains:
            self.chains[key] = Chain(self.listed[placed.type], rates, again)
        beside = [h for h in used if h not in own]
        return Step(
            placed,
            self.chains[key],
            used,
            tuple(used.index(h) for h in (*own, *beside)),
            tuple((failing[h], repaired[h]) for h in beside),
            known,
        )


@dataclass(frozen=True, eq=False)
class Step:
    """The way through one section, from values at its exits to values at its entry.

    Values are arrays with an axis for each resource that the section and later ones use, in service and out
    of service, and a last axis for several values at once.

    Args:
        placed: The section.
        chain: Its chain.
        used: The hardware of the axes.
        axes: The axes, those of its own hardware first.
        beside: Failures and repairs per hour of the rest.
        known: Kernels of this outlook's chains, by the decays of what is beside.
    """

    placed: Stage
    chain: Chain
    used: tuple[str, ...]
    axes: tuple[int, ...]
    beside: tuple[tuple[float, float], ...]
    known: dict[tuple[Chain, bytes], Floats]

    @property
    def routes(self) -> Mapping[str, str]:
        """By exit, where it leads."""
        return self.placed.routes

    @cached_property
    def _decay(self) -> Floats:
        """By product of functions of the hardware beside the section, its rate of decay."""
        found = np.zeros(1)
        for fails, back in self.beside:
            found = np.add.outer(found, (0.0, fails + back)).reshape(-1)
        return found

    @cached_property
    def _kernels(self) -> tuple[Ints, Floats]:
        """By product, the number of its kernel; and the kernels, which sections of one chain share."""
        decays, numbers = np.unique(self._decay, return_inverse=True)
        key = self.chain, decays.tobytes()
        if key not in self.known:
            self.known[key] = self.chain.kernels(decays)
        return numbers, self.known[key]

    def _matrix(self, values: Sequence[Array]) -> Array:
        """Values at the exits with own status, status beside and values as axes; exits one after another."""
        own = self.chain.listed.statuses
        last = len(self.used)
        found = [v.transpose(*self.axes, last).reshape(own, -1, v.shape[-1]) for v in values]
        return np.concatenate(found)

    def _array(self, matrix: Array) -> Array:
        """The same back, for values at the entry."""
        found = matrix.reshape((2,) * len(self.used) + matrix.shape[-1:])
        return found.transpose(*np.argsort(self.axes), len(self.used))

    def back(self, values: Sequence[Floats]) -> Floats:
        """Expected values, from values at each of the chain's exits."""
        matrix = np.asarray(self._matrix(values), np.float64)
        shape = matrix.shape
        by_resource = matrix.reshape(shape[0], *(2,) * len(self.beside), shape[-1])
        for axis, (fails, back) in enumerate(self.beside, 1):
            working, out = np.take(by_resource, 0, axis), np.take(by_resource, 1, axis)
            if fails + back:
                mean = (back * working + fails * out) / (fails + back)
                working, out = mean, working - out
            by_resource = np.stack([working, out], axis)
        matrix = by_resource.reshape(shape)
        found = np.empty((self.chain.listed.statuses, *shape[1:]))
        decays, kernels = self._kernels
        for begin in range(0, len(decays), PRODUCTS):
            chosen = slice(begin, begin + PRODUCTS)
            products = kernels[decays[chosen]] @ matrix[:, chosen].transpose(1, 0, 2)
            found[:, chosen] = products.transpose(1, 0, 2)
        by_resource = found.reshape(found.shape[0], *(2,) * len(self.beside), shape[-1])
        for axis, (fails, back) in enumerate(self.beside, 1):
            if fails + back:
                mean, difference = np.take(by_resource, 0, axis), np.take(by_resource, 1, axis)
                working = mean + difference * (fails / (fails + back))
                out = mean - difference * (back / (fails + back))
                by_resource = np.stack([working, out], axis)
        return np.asarray(self._array(by_resource), np.float64)

    def may_come_to(self, flags: Sequence[Array]) -> Array:
        """Whether some of the flagged states at the chain's exits are reached with some probability."""
        matrix = self._matrix(flags)
        at_once, later = self.chain.possible
        after = matrix.reshape(matrix.shape[0], *(2,) * len(self.beside), matrix.shape[-1]).copy()
        for axis, (fails, back) in enumerate(self.beside, 1):
            working, out = np.moveaxis(after, axis, 0)
            if fails:
                working |= out
            if back:
                out |= working
        counts = np.tensordot(at_once.astype(np.int64), matrix.astype(np.int64), axes=1)
        counts += np.tensordot(later.astype(np.int64), after.reshape(matrix.shape).astype(np.int64), axes=1)
        return np.asarray(self._array(counts > 0), np.bool_)

    def spread(self, by_status: Array) -> Array:
        """Values by own status as an array of the section's shape."""
        own = self.chain.listed.statuses
        whole = np.broadcast_to(by_status.reshape(own, 1, 1), (own, len(self._decay), 1))
        return self._array(whole)


class SectionsOutlook:
    """The mission under given rates.

    Args:
        model: Its sections.
        steps: The way through each, under the rates.
    """

    def __init__(self, model: SectionChains, steps: Mapping[str, Step]) -> None:
        self.model = model
        self.steps = steps

    def ends(self, lost: str | None = None) -> tuple[float, float]:
        """Probabilities of success and failure, if one resource is out of service at the start."""
        used = self.model.used[self.model.entry]
        status = tuple(int(name == lost) for name in used)
        success, failure = self._ends[self.model.entry][status].tolist()
        return success, failure

    @cached_property
    def _ends(self) -> Values:
        ending = self._coming_to({}, {SUCCEED: np.ones(1, np.bool_), FAIL: np.ones(1, np.bool_)})
        return self._solved(ending, {}, {SUCCEED: np.array([1.0, 0.0]), FAIL: np.array([0.0, 1.0])}, 2)

    def degraded_modes(self) -> float:
        """The expected number of jumps into another, degraded mode."""
        steps = self.steps
        inside = {name: step.chain.modes_at_entries() for name, step in steps.items()}
        entered = {name: step.spread(step.chain.into_degraded) for name, step in steps.items()}
        gained: Values = {}
        for name, step in steps.items():
            # A section that is entered again from itself counts that inside, where it knows the mode before.
            others = {route: found for route, found in entered.items() if route != name}
            gained[name] = step.back(self._at_exits(step, others, np.zeros(1))) + step.spread(inside[name][0])
        gaining = self._coming_to({name: found > 0 for name, found in gained.items()}, {})
        # It goes on for ever where no state is reached after which nothing is gained.
        resting = {name: step.spread(step.chain.stays) | ~gaining[name] for name, step in steps.items()}
        resting = self._coming_to(resting, {SUCCEED: np.ones(1, np.bool_), FAIL: np.ones(1, np.bool_)})
        infinite = {name: step.spread(inside[name][1]) | ~resting[name] for name, step in steps.items()}
        infinite = self._coming_to(infinite, {})
        start = *(0 for _ in self.model.used[self.model.entry]), 0
        if infinite[self.model.entry][start]:
            return math.inf
        finite = {name: gaining[name] & ~infinite[name] for name in steps}
        values = self._solved(finite, gained, {}, 1)
        return float(values[self.model.entry][start] + entered[self.model.entry][start])

    def _at_exits(self, step: Step, values: Values, nothing: Array) -> list[Array]:
        """Values after each exit of a section, with the section's axes."""
        found = []
        for exit_ in step.chain.listed.exits:
            route = step.routes[exit_]
            value = values.get(route, nothing)
            later = self.model.used.get(route, ()) if value.ndim > 1 else ()
            value = value.reshape(*(2 if h in later else 1 for h in step.used), value.shape[-1])
            found.append(np.broadcast_to(value, (2,) * len(step.used) + value.shape[-1:]))
        return found

    def _coming_to(self, flagged: Values, ends: Values) -> Values:
        """The entries from which flagged entries or ends are reached with some probability."""
        found = {**flagged, **ends}
        nothing = np.zeros(1, np.bool_)
        for members in self.model.components:
            grown = True
            while grown:
                grown = False
                for name in reversed(members):
                    step, before = self.steps[name], found.get(name)
                    after = step.may_come_to(self._at_exits(step, found, nothing))
                    found[name] = after if before is None else after | before
                    if name in self.model.heads:
                        grown |= bool((found[name] if before is None else found[name] > before).any())
        return found

    def _solved(self, inner: Values, gained: Values, ends: Values, width: int) -> Values:
        """The values at entries: what is gained, and what is expected at the exits; 0 outside ``inner``."""
        found = dict(ends)
        for members in self.model.components:
            heads = [name for name in members if name in self.model.heads]
            known = {name: np.zeros((2,) * len(self.model.used[name]) + (width,)) for name in heads}
            if heads:
                known = self._fixed(members, known, inner, gained, found)
            found |= self._sweep(members, known, inner, gained, found, width)
        return found

    def _sweep(
        self,
        members: Sequence[str],
        known: Values,
        inner: Values,
        gained: Values,
        later: Values,
        width: int,
    ) -> Values:
        """The values at the entries of sections from those of later ones, and of those they lead back to."""
        found: Values = {}
        for name in reversed(members):
            step = self.steps[name]
            forward = {route: value for route, value in found.items() if not self.model.back(name, route)}
            value = step.back(self._at_exits(step, {**later, **known, **forward}, np.zeros(width)))
            found[name] = np.where(inner[name], value + gained.get(name, 0.0), 0.0)
        return found

    def _fixed(
        self, members: Sequence[str], known: Values, inner: Values, gained: Values, later: Values
    ) -> Values:
        """The values at the entries that sections of a loop lead back to, by a linear system."""
        shapes = {name: value.shape for name, value in known.items()}

        def onward(values: Values, gained: Values, later: Values) -> Floats:
            width = next(iter(values.values())).shape[-1]
            found = self._sweep(members, values, inner, gained, later, width)
            return np.concatenate([found[name].reshape(-1, found[name].shape[-1]) for name in shapes])

        def split(matrix: Array) -> Values:
            parts = np.split(matrix, len(shapes))
            return {
                name: part.reshape(*shape[:-1], part.shape[-1])
                for (name, shape), part in zip(shapes.items(), parts, strict=True)
            }

        right = onward(known, gained, later)
        size = len(right)
        if size <= MOST_DENSE:
            matrix = onward(split(np.eye(size)), {}, {})
            return split(np.linalg.solve(np.eye(size) - matrix, right))

        def less(vector: Floats) -> Floats:
            return vector - onward(split(vector.reshape(-1, 1)), {}, {}).reshape(-1)

        system = LinearOperator((size, size), matvec=less, dtype=np.float64)
        columns = []
        for column in right.T:
            solved, failed = gmres(system, column, rtol=PRECISION, atol=0.0, restart=100, maxiter=20)
            if failed:
                raise LimitError(f"the values at {size} entries of sections in loops did not settle")
            columns.append(solved)
        return split(np.stack(columns, axis=1))
