"""The closure of a net on the levels of one order: saturation, and chaining where there are priorities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import chain
from typing import TypeAlias

from mcpn._kernel import Zdd
from mcpn.nets.petri import PetriNet
from mcpn.nets.provenance import Provenance
from mcpn.spaces.diagrams.encoding import Encoding, distinct
from mcpn.spaces.diagrams.internal_evolution import Clock, behind
from mcpn.spaces.diagrams.order import Order
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace

Encode: TypeAlias = Callable[[PetriNet, Order, int], Encoding]
"""Puts a net on the levels of a store, given an order of places and the bytes that the store may take."""


def close(encoding: Encoding, name: str, order: Order, budget: int = 0) -> SymbolicSpace:
    """Reaches every marking in so many steps, or any number for 0."""
    net, store = encoding.net, encoding.store
    if not net.priorities:
        everything = encoding.initial().saturate(distinct(encoding.events.values()), max_steps=budget)
        return SymbolicSpace(encoding, everything, None, name, order, store.peak_nodes)
    clock, peak = Clock(budget), 0

    def step(settled: Zdd, events: list[int]) -> Zdd:
        nonlocal peak
        fired = settled.images(events)
        clock.spent += store.steps
        ends = behind(encoding, fired, clock)[1]
        peak = max(peak, store.peak_nodes)
        return ends

    # Transient markings stay out of the sets that grow; those behind all events are put together at the end.
    by_element = [distinct(encoding.events[t] for t in own) for own in elements(encoding)]
    begun, first = behind(encoding, encoding.initial(), clock)
    stable = chained(first, [partial(step, events=events) for events in by_element])
    every = stable.images(distinct(chain.from_iterable(by_element)))
    reachable = begun | behind(encoding, every, clock)[0]
    return SymbolicSpace(encoding, reachable, stable, name, order, max(peak, store.peak_nodes))


def elements(encoding: Encoding) -> list[list[int]]:
    """The event transitions of a net with priorities, by the element that they are of.

    Resources come last: sets in which one fails already are larger on the way than those without.
    """
    groups: dict[Provenance | None, list[int]] = {}
    for t in encoding.events:
        transition = encoding.net.transitions[t]
        if not transition.internal:
            groups.setdefault(transition.provenance, []).append(t)
    last = sorted(groups, key=lambda element: element is not None and element.part == "resource")
    return [groups[element] for element in last]


def chained(begin: Zdd, steps: Sequence[Callable[[Zdd], Zdd]]) -> Zdd:
    """The least fixpoint of a union of steps above a set; each step is closed before the next is taken.

    This is *chaining* (Roig, Cortadella, Pastor, ICATPN 1995). Breadth-first layers, all states so many steps
    away, have large diagrams on the way to a small one; closing under the events of one element at a time
    avoids them.

    Args:
        begin: The set that the fixpoint contains.
        steps: Each maps a set to its image, and distributes over unions.
    """
    reached = begin
    taken = [begin - begin] * len(steps)  # by step, the states that it has been applied to
    changed = True
    while changed:
        changed = False
        for number, step in enumerate(steps):
            while new := reached - taken[number]:
                taken[number] = reached
                after = step(new)
                if (reached | after) == reached:
                    break
                reached |= after
                changed = True
    return reached
