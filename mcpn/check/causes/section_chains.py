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
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import accumulate
from typing import Any

import networkx as nx
import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from mcpn.check.causes.chain import CHUNK, Chain, Floats, Listed, sums
from mcpn.errors import LimitError
from mcpn.mission.flatten import ElementarySection
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.space.markings.graph import Ints, Mask

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
    """The sections of a mission, whose entries are numbered.

    An *entry* is a section with a status of the hardware that it and later ones use, its own in the highest
    bits; the two ends of the mission are numbered last.

    Args:
        sections: The sections by name, in the mission's order.
        entry: The section where the mission begins.
        hardware: The mission's hardware that can fail.

    Attributes:
        used: By section and end of the mission, the hardware that it and later ones use, its own first.
        first: By section and end, the number of its first entry.
        entries: The number of all.
        loops: Sections that lead to each other, each time those that come last first, and the entries of
            those of them that are led back to; later ones first.

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
        components = [
            sorted(condensed.nodes[number]["members"], key=order.__getitem__, reverse=True)
            for number in reversed(list(nx.topological_sort(condensed)))
        ]
        known: dict[str, tuple[str, ...]] = {}
        for members in components:
            used = {h for n in members for h in sections[n].hardware}
            used |= {h for n in members for r in graph[n] for h in known.get(r, ())}
            if len(used) > MOST_HARDWARE and len(sections) > 1:
                raise LimitError(
                    f"section {members[-1]} and those after it use {len(used)} hardware resources that may "
                    f"fail: numbers of risk remember 2^{len(used)} states of them, the limit is "
                    f"2^{MOST_HARDWARE}"
                )
            for name in members:
                own = sections[name].hardware
                known[name] = (*own, *(h for h in hardware if h in used.difference(own)))
        self.used = {**{name: known[name] for name in sections}, SUCCEED: (), FAIL: ()}
        *firsts, self.entries = accumulate((1 << len(used) for used in self.used.values()), initial=0)
        self.first = dict(zip(self.used, firsts, strict=True))
        self.loops: list[tuple[list[str], Ints]] = []
        for members in components:
            back = {r for n in members for r in graph[n] if r in members and order[r] < order[n]}
            numbers = [np.arange(self.entries)[self.here(name)] for name in back]
            self.loops.append((members, np.concatenate([np.arange(0), *numbers])))
        self._projected = cache(_projected)

    def here(self, name: str) -> slice:
        """The entries of a section."""
        return slice(self.first[name], self.first[name] + (1 << len(self.used[name])))

    def after(self, name: str) -> Ints:
        """The entries behind a section: by exit and status there of its own hardware, and by other status."""
        section, used = self.sections[name], self.used[name]
        routes = [section.routes[exit_] for exit_ in section.listed.exits]
        found = [self.first[r] + self._projected(used, self.used[r]) for r in routes]
        return np.concatenate(found).reshape(section.listed.columns, -1)


def _projected(hardware: Sequence[str], of: Sequence[str]) -> Ints:
    """By status of some hardware, the status of some of it; bits of what is not among it are 0."""
    found = np.zeros(1, np.int64)
    for name in hardware:
        bit = 1 << (len(of) - 1 - of.index(name)) if name in of else 0
        found = np.add.outer(found, (0, bit)).reshape(-1)
    return found


class Outlook:
    """A mission under given rates.

    Args:
        model: Its sections.
        rates: Failures and repairs per hour, by hardware.
        like: The same mission under other rates, whose chains are taken where they are the same.
    """

    def __init__(
        self, model: Sections, rates: Mapping[str, tuple[float, float]], like: Outlook | None = None
    ) -> None:
        self.model = model
        self._chains: dict[Any, Chain] = dict(like._chains) if like else {}
        self._passages: dict[str, _Passage] = {}
        passage = cache(_Passage)
        for name, section in model.sections.items():
            of = [rates[h] for h in model.used[name]]
            own = len(section.hardware)
            ending = tuple(
                (1.0 / o.duration if o.duration else 0.0, o.failure_probability) for o in section.objectives
            )
            key = section.listed, tuple(of[:own]), ending
            if key not in self._chains:
                self._chains[key] = Chain(*key)
            self._passages[name] = passage(self._chains[key], tuple(of[own:]))

    def ends(self, lost: str | None = None) -> tuple[float, float]:
        """Probabilities of success and failure, if one resource is out of service at the start."""
        entry, used = self.model.entry, self.model.used[self.model.entry]
        status = 1 << (len(used) - 1 - used.index(lost)) if lost in used else 0
        success, failure = self._ends[self.model.first[entry] + status].tolist()
        return success, failure

    @cached_property
    def _ends(self) -> Floats:
        ends = np.zeros((self.model.entries, 2))
        ends[-2:] = np.eye(2)
        return self._solved(
            self._reaching(ends[:, 0] + ends[:, 1] > 0), np.zeros((self.model.entries, 1)), ends
        )

    def degraded_modes(self) -> float:
        """The expected number of jumps into another, degraded mode; infinite where it may go on for ever."""
        model = self.model
        entered = self._by_entry(lambda chain: chain.degraded)
        gained = self._by_entry(lambda chain: chain.modes)
        for name, passage in self._passages.items():
            gained[model.here(name)] += passage.back(entered[model.after(name), None])[:, 0]
        stays = self._by_entry(lambda chain: chain.stays)
        finite, endless = sums(gained, self._reaching, stays > 0)
        start = model.first[model.entry]
        if endless[start]:
            return math.inf
        values = self._solved(finite, gained[:, None], np.zeros((model.entries, 1)))
        return float(values[start, 0] + entered[start])

    def _by_entry(self, said: Callable[[Chain], Floats | Mask]) -> Floats:
        """What is said of the chains by status of a section's own hardware, by entry; 0 at the ends."""
        parts = [np.repeat(said(p.chain), 1 << len(p.beside)) for p in self._passages.values()]
        return np.concatenate([*parts, np.zeros(2)])

    def _reaching(self, goal: Mask) -> Mask:
        """The entries and ends from which some of given ones are reached with some probability."""
        found = goal.copy()
        for members, heads in self.model.loops:
            known = None
            while known is None or not np.array_equal(known, found[heads]):
                known = found[heads]
                for name in members:
                    coming = self._passages[name].may_come_to(found[self.model.after(name)])
                    found[self.model.here(name)] |= coming
        return found

    def _solved(self, inner: Mask, gained: Floats, ends: Floats) -> Floats:
        """What is gained and then expected, by entry, 0 outside ``inner``; at the ends as given."""
        values, nothing = ends.copy(), np.zeros(gained.shape)
        for members, heads in self.model.loops:
            self._sweep(members, inner, gained, values)
            if len(heads):

                def less(matrix: Floats, members: Sequence[str] = members, heads: Ints = heads) -> Floats:
                    found = np.zeros((len(values), matrix.shape[1]))
                    found[heads] = matrix
                    self._sweep(members, inner, nothing, found)
                    return matrix - found[heads]

                values[heads] = _linear(less, values[heads])
                self._sweep(members, inner, gained, values)
        return values

    def _sweep(self, members: Sequence[str], inner: Mask, gained: Floats, values: Floats) -> None:
        """Sets the values of sections from those of later ones, and of those they lead back to."""
        for name in members:
            # What leads back to this section came before it here, and has seen the value that was known.
            here = self.model.here(name)
            value = self._passages[name].back(values[self.model.after(name)]) + gained[here]
            values[here] = np.where(inner[here, None], value, 0.0)


def _linear(system: Callable[[Floats], Floats], right: Floats) -> Floats:
    """Solves a linear system that is given as what it makes of the columns of a matrix."""
    size = len(right)
    if size <= MOST_DENSE:
        parts = np.array_split(np.eye(size), -(-size // CHUNK), axis=1)
        return np.linalg.solve(np.hstack([system(part) for part in parts]), right).astype(np.float64)
    operator = LinearOperator((size, size), lambda x: system(x.reshape(-1, 1))[:, 0], dtype=np.float64)
    found = np.empty(right.shape)
    for i, column in enumerate(right.T):
        found[:, i], failed = gmres(operator, column, rtol=PRECISION, atol=0.0, restart=100, maxiter=20)
        if failed:
            raise LimitError(f"the values at {size} entries of sections in loops did not settle")
    return found


class _Passage:
    """The way through one section, from values at its exits to values at its entry.

    Args:
        chain: The section's.
        beside: Failures and repairs per hour of other hardware that it or later ones use.
    """

    def __init__(self, chain: Chain, beside: Sequence[tuple[float, float]]) -> None:
        self.chain = chain
        self.beside = beside

    def _each_beside(self, matrix: Floats, maps: Iterable[Sequence[Sequence[float]]]) -> Floats:
        """Values after a map of two states to two for each resource beside the section."""
        found = matrix
        for number, of in enumerate(maps):
            found = np.asarray(of) @ found.reshape(len(matrix) << number, 2, -1)
        return found.reshape(matrix.shape)

    @cached_property
    def _kernels(self) -> tuple[Floats, Ints]:
        """The chain's kernels at the rates at which products of functions of the hardware beside decay.

        Returns:
            The kernels, and by product the number of its kernel.
        """
        found = np.zeros(1)
        for fails, back in self.beside:
            found = np.add.outer(found, (0.0, fails + back)).reshape(-1)
        decays, numbers = np.unique(found, return_inverse=True)
        return self.chain.kernels(decays), numbers

    def back(self, values: Floats) -> Floats:
        """Expected values.

        Args:
            values: By exit and status there, status beside, and a free axis.

        Returns:
            By entry, and the free axis.
        """
        if not self.beside:
            return self.chain.expected(values[:, 0])
        kernels, numbers = self._kernels
        # The share of time out of service, and the difference that the status makes, or the status as it is.
        shares = [(fails / (fails + back) if fails + back else None) for fails, back in self.beside]
        as_it_is = (1.0, 0.0), (0.0, 1.0)
        values = self._each_beside(
            values, (as_it_is if out is None else ((1.0 - out, out), (1.0, -1.0)) for out in shares)
        )
        found = np.empty((self.chain.listed.statuses, *values.shape[1:]))
        for begin in range(0, len(numbers), PRODUCTS):
            chosen = slice(begin, begin + PRODUCTS)
            products = kernels[numbers[chosen]] @ values[:, chosen].transpose(1, 0, 2)
            found[:, chosen] = products.transpose(1, 0, 2)
        found = self._each_beside(
            found, (as_it_is if out is None else ((1.0, out), (1.0, out - 1.0)) for out in shares)
        )
        return found.reshape(-1, values.shape[-1])

    def may_come_to(self, flags: Mask) -> Mask:
        """By entry, whether what is flagged, by exit and status there, and status beside, is possible."""
        if not self.beside:
            return self.chain.may_come_to(flags[:, 0])
        before = flags.astype(np.float64)
        after = self._each_beside(before, (((1, fails > 0), (back > 0, 1)) for fails, back in self.beside))
        at_once, later = (pairs.astype(np.float64) for pairs in self.chain.possible)
        return np.asarray(at_once @ before + later @ after > 0, np.bool_).reshape(-1)
