"""Bounds of places, proved by weights of places or by listing markings, exact ones or coarser ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from math import inf
from operator import mul

from mcpn.nets.petri import Marking, PetriNet
from mcpn.nets.programs import minimise
from mcpn.nets.repeatable import LARGEST, SCALES
from mcpn.nets.structure import changes, place_bounds

MAX_LISTED = 50_000
"""Markings that are listed to prove a bound."""
MAX_CELLS = 5_000_000
"""Numbers of tokens in them all."""
BEYOND = 16
"""Tokens beyond all weights at which a place whose bound is asked for is no longer counted."""

Inhibitions = Mapping[int, Sequence[tuple[int, int]]]
"""By transition pairs (place, tokens): it is disabled where the place holds so many."""


def listed_bounds(
    net: PetriNet, inhibitions: Inhibitions | None = None, counted: Sequence[float] = ()
) -> list[float] | None:
    """The most tokens of each place in the reachable markings; ``None`` where these are too many to list.

    Args:
        net: The net; its priorities are left out, which reaches more.
        inhibitions: What disables transitions beside their arcs.
        counted: By place how far its tokens are counted: so many stand for as many or more. It is at least
            the largest weight of the place. Empty: as far as they go. What is reached then is reached in the
            net, and may be more: a place that does not come so far is bounded by what it comes to.
    """
    plain, blocked = PetriNet(net.name, net.places, net.transitions), inhibitions or {}
    limit = min(MAX_LISTED, MAX_CELLS // max(len(net.places), 1))
    most = [inf] * len(net.places) if not counted else list(counted)
    first = tuple(int(min(pair)) for pair in zip(net.initial, most, strict=True))
    reached = list(first)
    seen, todo = {first}, [first]
    while todo:
        marking = todo.pop()
        for t in plain.enabled(marking):
            if any(marking[place] >= tokens for place, tokens in blocked.get(t, ())):
                continue
            for after in _fired(plain, marking, t, most):
                if after not in seen:
                    if len(seen) >= limit:
                        return None
                    seen.add(after)
                    todo.append(after)
                    reached = list(map(max, reached, after))
    return [tokens if tokens < far else inf for tokens, far in zip(reached, most, strict=True)]


def _fired(net: PetriNet, marking: Marking, transition: int, most: Sequence[float]) -> Iterator[Marking]:
    """What a firing may lead to: tokens that are counted no further may be as many, or not, after some go."""
    after = net.fire(marking, transition)
    vague = [p for p, _ in net.transitions[transition].consume if marking[p] == most[p] > after[p]]
    if not vague and all(tokens <= far for tokens, far in zip(after, most, strict=True)):
        yield after
        return
    shortened = [int(min(pair)) for pair in zip(after, most, strict=True)]
    for choice in product(*(range(shortened[p], int(most[p]) + 1) for p in vague)):
        for place, tokens in zip(vague, choice, strict=True):
            shortened[place] = tokens
        yield tuple(shortened)


def coarse_bounds(
    net: PetriNet, inhibitions: Inhibitions, known: Sequence[float], places: set[int]
) -> list[float] | None:
    """Bounds of some places, where other tokens are counted as far as arcs tell their numbers apart.

    Args:
        net: The net.
        inhibitions: What disables transitions beside their arcs.
        known: By place a bound that is proved already, or infinity: so far it is counted.
        places: Those whose bounds are asked for.
    """
    far = [float(max(1, tokens)) for tokens in net.initial]
    for number, t in enumerate(net.transitions):
        for place, weight in (*t.consume, *t.read, *inhibitions.get(number, ())):
            far[place] = max(far[place], weight)
    for place, bound in enumerate(known):
        if bound < far[place] + BEYOND:
            far[place] = max(far[place], bound + 1)
        elif place in places:
            far[place] += BEYOND
    return listed_bounds(net, inhibitions, far)


def weighted_bound(net: PetriNet, place: int) -> float:
    """The most tokens of a place, by weights of places whose sum no firing raises; else infinity.

    Weights that are rounded to whole numbers are checked in whole numbers: what the solver says is not
    believed. They need not leave the sum as it is, as invariants do, so that tokens may vanish.
    """
    moved = [change for t in range(len(net.transitions)) if (change := changes(net, t))]
    if net.largest > LARGEST:
        return inf
    lower = [1.0 if p == place else 0.0 for p in range(len(net.places))]
    rows = [({p: float(by) for p, by in change.items()}, -inf, 0.0) for change in moved]
    solution = minimise(list(map(float, net.initial)), rows, lower, [inf] * len(lower))
    for scale in SCALES if solution.kind == "solved" else ():
        whole = [round(weight * scale) for weight in solution.values[: len(lower)]]
        if whole[place] > 0 and all(sum(whole[p] * by for p, by in change.items()) <= 0 for change in moved):
            total: int = sum(map(mul, whole, net.initial))
            return total // whole[place]
    return inf


def proved_bounds(net: PetriNet) -> list[float]:
    """The most tokens of each place, by invariants; where they leave one out, by all markings if few."""
    bounds = place_bounds(net)
    if inf in bounds and (listed := listed_bounds(net)) is not None:
        return listed
    return [weighted_bound(net, p) if bound == inf else bound for p, bound in enumerate(bounds)]
