"""Numbers of risk as a chain of sections over the status of the hardware; the whole mission may be one.

A section depends on its own hardware only; all other hardware fails and is repaired independently, while
the section takes a random time ``T``. What becomes of each other resource meanwhile is described by a clock
(:class:`mcpn.answers.causes.passages.Beside`), and the section's own chain is run against the clocks: how it
ends, and which of them have rung by then (:meth:`mcpn.answers.causes.chain.Chain.kernels`). This is exact,
all of it without a difference of probabilities, and the product of the section's states with the status of
other hardware is never built. Hardware that is detected late has two bits, one after the other: out of
service, and known to be.

The sections are worked backward from the mission's ends. The value at an entry is a function of the status of
the hardware that this section and later ones use; other hardware does not matter any more. A handler that
happens once has a status too: that of a resource that never fails nor is repaired beside a section. Where
sections lead back to earlier ones, the values at those entries are the unknowns of a linear system.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from mcpn.answers.causes.chain import Chain, ListedChain, totals
from mcpn.answers.causes.passages import Beside, LoopSection, SectionLoop, WayThrough
from mcpn.answers.causes.sparse import Floats
from mcpn.drawing.status import Element
from mcpn.errors import LimitError
from mcpn.mission.core.objectives_graph import ElementarySection
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.spaces.components import strongly_connected
from mcpn.spaces.markings.graph import Ints, Mask

ENDS = (SUCCEED, FAIL, ABORT)
"""The ends of a mission, in the order of their numbers."""

NEVER = "never"
"""That a mission does not end: as an end of its own, for it is computed as itself too."""

MOST_HARDWARE = 16
"""Hardware resources whose status is remembered from one section to the next, at most."""


@dataclass(frozen=True, eq=False)
class ChainSection:
    """A section of a mission, or the whole mission as one.

    Args:
        listed: Its states, which sections of one type share.
        carried: Its hardware that can fail and handlers that happen once, in the order of the states'.
        objectives: Its elementary objectives, in that order too.
        routes: By exit, the section that it leads to, or the mission's own exit.
    """

    listed: ListedChain
    carried: tuple[Element, ...]
    objectives: Sequence[ElementarySection]
    routes: Mapping[str, str]


class Sections:
    """The sections of a mission, whose entries are numbered.

    An *entry* is a section with a status of the hardware that it and later ones use, its own in the lowest
    bits; the ends of the mission are numbered first.

    Args:
        sections: The sections by name, in the mission's order.
        entry: The section where the mission begins.
        carried: The mission's hardware that can fail and handlers that happen once.
        out: Hardware that is out of service at the start.
        idle: What cannot fail beside a section: crashes happen only in sections that use what crashes.

    Attributes:
        sections: The sections, in the order of their entries: later ones first.
        used: By section and end of the mission, the hardware that it and later ones use, its own last.
        first: By section and end, the number of its first entry.
        entries: The number of all.
        loops: The strongly connected components of sections, in reverse topological order: the members, in
            reverse order of the mission, and the entries that members lead back to.

    Raises:
        LimitError: Too much hardware must be remembered.
    """

    def __init__(
        self,
        sections: Mapping[str, ChainSection],
        entry: str,
        carried: Sequence[Element],
        out: Collection[Element] = (),
        idle: Collection[Element] = (),
    ) -> None:
        self.entry = entry
        self.out, self.idle = frozenset(out), frozenset(idle)
        names, order = list(sections), {name: number for number, name in enumerate(sections)}
        graph = {n: dict.fromkeys(r for r in s.routes.values() if r in sections) for n, s in sections.items()}
        self.used: dict[str, tuple[Element, ...]] = dict.fromkeys(ENDS, ())
        self.first = {end: number for number, end in enumerate(ENDS)}
        self.entries = len(ENDS)
        self.loops: list[tuple[list[str], Ints]] = []
        for component in strongly_connected([[order[r] for r in graph[name]] for name in names]):
            members = [names[number] for number in reversed(component)]
            used = {h for n in members for h in sections[n].carried}
            used |= {h for n in members for r in graph[n] for h in self.used.get(r, ())}
            if len(used) > MOST_HARDWARE and len(sections) > 1:
                raise LimitError(
                    f"section {members[-1]} and those after it use {_counted(used)}: "
                    f"numbers of risk remember 2^{len(used)} states of them, the limit is 2^{MOST_HARDWARE}"
                )
            for name in members:
                own = sections[name].carried
                self.used[name] = (*(h for h in carried if h in used.difference(own)), *own)
                self.first[name] = self.entries
                self.entries += 1 << len(used)
            back = {r for n in members for r in graph[n] if r in members and order[r] < order[n]}
            heads = [self.first[name] + np.arange(1 << len(used)) for name in back]
            self.loops.append((members, np.concatenate([np.arange(0), *heads])))
        self.sections = {name: sections[name] for members, _ in self.loops for name in members}
        self._projected = cache(_projected)

    def here(self, name: str) -> slice:
        """The entries of a section."""
        return slice(self.first[name], self.first[name] + (1 << len(self.used[name])))

    def start(self, lost: Element | None = None, kept: Element | None = None) -> int:
        """The entry where the mission begins; one resource may be out of service there, or in service."""
        out = self.out.union(() if lost is None else (lost,))
        if kept is not None:
            out -= {kept, ("known", kept[1])}  # lost, what is detected late is not known to be
        return self.first[self.entry] + sum(_bit(element, self.used[self.entry]) for element in out)

    def after(self, name: str) -> Ints:
        """The entries behind a section: by status of other hardware, and exit and status of its own."""
        section, used = self.sections[name], self.used[name]
        # An exit to a section that the mission never enters is never taken: any end stands for it.
        routes = [route if (route := section.routes[e]) in self.first else FAIL for e in section.listed.exits]
        found = [self.first[r] + self._projected(used, self.used[r]) for r in routes]
        return np.concatenate([numbers.reshape(-1, section.listed.statuses) for numbers in found], axis=1)


def _projected(carried: Sequence[Element], used: Sequence[Element]) -> Ints:
    """By status of ``carried``, the status of ``of``, where elements that are not carried have bit 0."""
    found = np.zeros(1, np.int64)
    for element in carried:
        found = np.add.outer(found, (0, _bit(element, used))).reshape(-1)
    return found


def _bit(element: Element | None, elements: Sequence[Element]) -> int:
    """The status of some elements in which one is out of service, or has happened, if it is among them."""
    return 1 << len(elements) >> elements.index(element) + 1 if element in elements else 0


def _counted(elements: Collection[Element]) -> str:
    kinds = Counter(kind for kind, _ in elements)
    found = [f"{kinds['hardware']} hardware resources that may fail"]
    found += [f"{kinds['known']} of them that are detected late"] if kinds["known"] else []
    found += [f"{kinds['once']} handlers that happen once"] if kinds["once"] else []
    found += [f"{kinds['fact']} truth values of facts"] if kinds["fact"] else []
    return " and ".join(found)


class Outlook:
    """A mission under given rates.

    Args:
        model: Its sections.
        rates: Failures and repairs per hour, of hardware; of all else nothing changes beside a section.
        demands: How probable it is that hardware fails on demand.
        like: The same mission under other rates, whose chains are taken where they are the same.
    """

    def __init__(
        self,
        model: Sections,
        rates: Mapping[Element, tuple[float, float]],
        demands: Mapping[Element, float],
        like: Outlook | None = None,
    ) -> None:
        self.model, self._rates = model, rates
        self._chains: dict[Any, Chain] = dict(like._chains) if like else {}
        self._passages: dict[str, WayThrough] = {}
        passage = cache(WayThrough)
        for name, section in model.sections.items():
            own = tuple(rates.get(element, (0.0, 0.0)) for element in section.carried)
            others = model.used[name][: len(model.used[name]) - len(own)]
            beside = tuple(self._beside(element, others) for element in others if element[0] != "known")
            ending = tuple((1.0 / o.duration if o.duration else 0.0, *o.shares) for o in section.objectives)
            asked = (
                tuple(demands.get(element, 0.0) for element in section.carried)
                if section.listed.split
                else ()
            )
            key = section.listed, own, ending, asked
            if key not in self._chains:
                self._chains[key] = Chain(*key)
            self._passages[name] = passage(self._chains[key], beside)

    def _beside(self, element: Element, others: Collection[Element]) -> Beside:
        """What a resource does beside a section."""
        fails, back = self._rates.get(element, (0.0, 0.0))
        return Beside(0.0 if element in self.model.idle else fails, back, ("known", element[1]) in others)

    def passage(self, name: str) -> WayThrough:
        """The way through a section: one for all that are alike under the rates."""
        return self._passages[name]

    def ends(self, lost: Element | None = None, kept: Element | None = None) -> Mapping[str, float]:
        """Probabilities of the mission's ends, and that there is none, each computed as itself.

        One resource may be out of service at the start, or in service.
        """
        found = np.minimum(self._ends[self.model.start(lost, kept)], 1.0).tolist()  # but for rounding
        return dict(zip((*ENDS, NEVER), found, strict=True))

    @cached_property
    def _ends(self) -> Floats:
        ends = np.eye(self.model.entries, len(ENDS) + 1)
        ends[len(ENDS)] = 0.0
        ended = np.asarray(ends.any(axis=1), np.bool_)
        inner = self._reaching(ended)
        staying = np.concatenate([np.zeros(len(ENDS)), *(p.staying for p in self._passages.values())])
        ends[:, -1] = np.where(inner, staying, 1.0)
        return self._solved(inner, ends)

    def degraded_modes(self) -> float:
        """The expected number of jumps into another, degraded mode; infinite where it may go on for ever."""
        gained, stays = self._by_entry(lambda chain: chain.modes), self._by_entry(lambda chain: chain.stays)
        start = self.model.start()

        def solved(inner: Mask, gained: Floats) -> Floats:
            # A system is solved only if it decides what is gained from the start.
            return (
                self._solved(inner, np.where(inner, gained, 0.0))[:, 0]
                if inner[start]
                else np.zeros(len(gained))
            )

        return float(totals(gained, self._reaching, solved, stays > 0)[start])

    def _by_entry(self, said: Callable[[Chain], Floats | Mask]) -> Floats:
        """Values of chains, which are by status of a section's own hardware, by entry; 0 at the ends."""
        parts = [np.tile(said(p.chain), 1 << p.bits) for p in self._passages.values()]
        return np.concatenate([np.zeros(len(ENDS)), *parts])

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

    def _solved(self, inner: Mask, gained: Floats) -> Floats:
        """The expected total gain by entry, of gains there; at entries outside ``inner`` that gain alone."""
        gained = gained.reshape(len(gained), -1)
        values = np.zeros(gained.shape)
        values[: len(ENDS)] = gained[: len(ENDS)]
        systems: dict[Hashable, Callable[[Floats], Floats]] = {}
        for members, heads in self.model.loops:
            within = slice(self.model.here(members[0]).start, self.model.here(members[-1]).stop)
            steps = {name: self._passages[name].back(values[self.model.after(name)]) for name in members}
            known = gained[within] + np.concatenate(list(steps.values()))
            known[~inner[within]] = gained[within][~inner[within]]
            if len(heads):
                loop = self._loop(members, heads - within.start, inner[within])
                if loop.kind not in systems:
                    systems[loop.kind] = loop.system()
                known = systems[loop.kind](known)
            values[within] = known
        return values

    def _loop(self, members: Sequence[str], heads: Ints, inner: Mask) -> SectionLoop:
        model, begin, steps = self.model, self.model.here(members[0]).start, list[LoopSection]()
        for name in members:
            # What is not of the loop is known: here it counts as 0, the value at the last number.
            after, here = model.after(name) - begin, model.here(name)
            after[(after < 0) | (after >= len(inner))] = len(inner)
            at = slice(here.start - begin, here.stop - begin)
            steps.append(LoopSection(self._passages[name], after, at, inner[at]))
        return SectionLoop(steps, heads)
