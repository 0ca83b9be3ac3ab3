"""Local graphs, their states listed: the alternatives graph of a section from all states of its hardware."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from mcpn.net.compose import MissionNet
from mcpn.net.sections import LocalPart
from mcpn.space.alternatives import AlternativesGraph
from mcpn.space.graph import Ints, Mask, pack, rows
from mcpn.space.local.interface import Frame, HardwareStates
from mcpn.space.local.protocol import OUTCOMES, Known, Outcome, PremiseError, TornHere, once


@dataclass(frozen=True, eq=False)
class Listed:
    """A set of states of a local graph.

    Args:
        mask: Shape (states,).
    """

    mask: Mask

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Listed) and np.array_equal(self.mask, other.mask)

    def __hash__(self) -> int:
        return hash(self.mask.tobytes())

    def __and__(self, other: Listed) -> Listed:
        return Listed(self.mask & other.mask)

    def __or__(self, other: Listed) -> Listed:
        return Listed(self.mask | other.mask)

    def __sub__(self, other: Listed) -> Listed:
        return Listed(self.mask & ~other.mask)

    def __bool__(self) -> bool:
        return bool(self.mask.any())

    def count(self) -> int:
        """How many states there are."""
        return int(self.mask.sum())


@dataclass(frozen=True, eq=False)
class LocalGraph:
    """The alternatives graph of one type of sections.

    Its states are those before the entry (one for each interface state), those inside, and those after.

    Args:
        part: The section that stands for its type.
        net: Its local net.
        graph: The graph.
    """

    part: LocalPart
    net: MissionNet
    graph: AlternativesGraph
    _known: Known = field(default_factory=dict)

    @cached_property
    def faulty(self) -> tuple[str, ...]:
        """Hardware that can fail, by its bit in masks."""
        return self.part.faulty

    @cached_property
    def out_of_service(self) -> Ints:
        """By state, the mask of the hardware out of service, shape (states,)."""
        masks = np.zeros(self.graph.states, np.int64)
        for bit, name in enumerate(self.faulty):
            (place,) = self.net.by_role["oos", name]
            masks |= self.graph.marked(place).astype(np.int64) << bit
        return masks

    @property
    def size(self) -> int:
        """How many states there are."""
        return self.graph.states

    @cached_property
    def ended(self) -> Mapping[Outcome, Listed]:
        """States after the section, by its outcome."""
        return {
            "success": Listed(self.graph.marked(self.net.success)),
            "failure": Listed(self.graph.marked(self.net.failure)),
        }

    @cached_property
    def before(self) -> Listed:
        """States before the entry."""
        return Listed(self.graph.marked(self.net.beginning))

    @cached_property
    def inside(self) -> Listed:
        """States of the section itself."""
        everything = Listed(np.ones(self.graph.states, np.bool_))
        return everything - self.before - self.ended["success"] - self.ended["failure"]

    @cached_property
    def dead(self) -> Listed:
        """States without an event."""
        return Listed(self.graph.dead)

    @cached_property
    def entry(self) -> Ints:
        """By mask of hardware out of service at the entry, the first state inside, shape (masks,).

        It is -1 where the start from there has no one outcome.
        """
        graph = self.graph
        starts = self.before.mask[graph.sources] & ~self.before.mask[graph.targets]
        found = np.full(1 << len(self.faulty), -1, np.int64)
        found[self.out_of_service[graph.sources[starts]]] = graph.targets[starts]
        return found

    @cached_property
    def leaving(self) -> Mapping[Outcome, Ints]:
        """Edges that leave the section, by its outcome."""
        inside = self.inside.mask[self.graph.sources]
        return {o: np.flatnonzero(inside & self.ended[o].mask[self.graph.targets]) for o in OUTCOMES}

    @cached_property
    def edges_inside(self) -> Mask:
        """Edges between states inside, shape (edges,)."""
        return self.inside.mask[self.graph.sources] & self.inside.mask[self.graph.targets]

    @cached_property
    def edges_from_inside(self) -> Mask:
        """Edges from states inside, shape (edges,)."""
        return self.inside.mask[self.graph.sources]

    # --- as composition needs it ---

    def hardware(self, states: Listed, frame: Frame) -> HardwareStates:
        """Which hardware is out of service in some states, by the names of a section of the type."""
        masks = np.zeros(1 << len(self.faulty), np.bool_)
        masks[self.out_of_service[states.mask]] = True
        return frame.from_masks(masks)

    def with_hardware(self, states: Listed, hardware: HardwareStates) -> Listed:
        """Those of some states whose hardware is in one of some states."""
        return Listed(states.mask & hardware.masks()[self.out_of_service])

    def begin(self, before: Listed) -> Listed:
        """First states inside after the start from states before."""
        entries = self.entry[self.out_of_service[before.mask]]
        return self._of(entries[entries >= 0])

    def beginnings(self, inside: Listed) -> Listed:
        """States before whose start leads into some states inside."""
        masks = np.flatnonzero((self.entry >= 0) & inside.mask[self.entry])
        return Listed(self.before.mask & np.isin(self.out_of_service, masks))

    def _of(self, states: Ints) -> Listed:
        mask = np.zeros(self.graph.states, np.bool_)
        mask[states] = True
        return Listed(mask)

    @once
    def reached(self, inside: Listed) -> Listed:
        """States inside to which runs inside lead from some, those included."""
        return Listed(self.graph.reached(self.edges_inside, np.flatnonzero(inside.mask)))

    def reaching(self, goal: Listed) -> Listed:
        """States inside from which some run through the inside leads to a goal, inside or after."""
        return Listed(self.graph.reaching(goal.mask, self.edges_from_inside)) & self.inside

    def after(self, inside: Listed) -> Listed:
        """States, inside or after the section, one event after states inside."""
        return self._of(self.graph.targets[rows(self.graph.offsets, np.flatnonzero(inside.mask))])

    def step_into(self, goal: Listed, among: Listed) -> tuple[int, Listed, Listed] | None:
        """One step from one of some states inside to a goal: a transition, and one state at each end."""
        graph = self.graph
        offsets, order = graph.incoming
        edges = order[rows(offsets, np.flatnonzero(goal.mask))]
        edges = edges[among.mask[graph.sources[edges]]]
        if not len(edges):
            return None
        edge = int(edges.min())
        return int(graph.labels[edge]), self._of(graph.sources[[edge]]), self._of(graph.targets[[edge]])

    def pick(self, states: Listed) -> Listed:
        """A set of one of the states, the same each time."""
        return self._of(np.flatnonzero(states.mask)[:1])

    def edges(self, inside: Listed) -> int:
        """Number of events, state by state."""
        return int(np.diff(self.graph.offsets)[inside.mask].sum())

    def fired(self, inside: Listed) -> frozenset[int]:
        """Transitions that carry an event in some of the states."""
        return frozenset(np.unique(self.graph.labels[inside.mask[self.graph.sources]]).tolist())

    def marks(self, place: int, states: Listed) -> bool:
        """Whether some of the states mark a place."""
        return bool((self.graph.marked(place) & states.mask).any())

    def among(self, states: Listed, marking: Sequence[int]) -> Listed:
        """A marking, given as tokens by place, as a set of one if it is among some states, else empty."""
        row = pack([sum(1 << p for p, tokens in enumerate(marking) if tokens)], len(marking))
        return Listed(states.mask & (self.graph.markings == row).all(axis=1))

    def torn(self, inside: Listed, before: Listed) -> Iterator[TornHere]:
        """Events whose outcome is not one stable state, in states inside and before."""
        concerned = (inside | before).mask
        for state, transition, error in self.graph.torn:
            if concerned[state]:
                event = self.net.net.transitions[transition].event
                yield TornHere(self._of(np.array([state])), event, error)

    def check_premise(self, section: str) -> None:
        """Compares each state after the section with the one before it of the same hardware.

        Raises:
            PremiseError: Some place differs.
        """
        graph, net = self.graph, self.net
        aside = np.zeros_like(graph.markings[0])
        for place in (net.beginning, net.success, net.failure):
            aside[place // 64] |= np.uint64(1) << np.uint64(place % 64)
        markings = graph.markings & ~aside
        idle = np.zeros((1 << len(self.faulty), markings.shape[1]), np.uint64)
        before = self.before.mask
        idle[self.out_of_service[before]] = markings[before]
        after = np.flatnonzero((self.ended["success"] | self.ended["failure"]).mask)
        different = markings[after] != idle[self.out_of_service[after]]
        if different.any():
            state = int(after[np.flatnonzero(different.any(axis=1))[0]])
            changed = markings[state] ^ idle[self.out_of_service[state]]
            place = next(p for p in range(len(net.net.places)) if int(changed[p // 64]) >> p % 64 & 1)
            run = graph.run_to(np.arange(graph.states) == state) or []
            raise PremiseError(
                section, net.net.places[place].name, [[str(event) for event in graph.events(run)]]
            )
