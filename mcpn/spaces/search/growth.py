"""Sums of tokens without a bound: a run that may be fired again and again, and adds to the sum each time.

A linear program finds numbers of firings that lower no place and raise the sum. They are put in an order that
needs few tokens beforehand, and a search looks for a marking that holds these: from there on the run may be
fired for ever. R. M. Karp, R. E. Miller, *Parallel program schemata*, JCSS 3, 1969.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from math import ceil, inf
from typing import NamedTuple

from mcpn.nets.petri import PetriNet
from mcpn.nets.programs import minimise
from mcpn.nets.repeatable import LARGEST, SCALES
from mcpn.nets.structure import changes, incidence, needs
from mcpn.spaces.search.goal import And, Goal, holds, marked
from mcpn.spaces.search.home import descent_of
from mcpn.spaces.search.searches import Run, Searches
from mcpn.turns import Pausing

STATES = 20_000
"""Of a search for where a run may be fired."""
TRIES, DEARER = 4, 20.0
"""Proposals of the program; transitions of one that no search comes to are dearer in the next."""
LONGEST = 10_000
"""Firings of a run that is repeated, at most."""
ROUNDING = 1e-6
ORDERS = 5_000
"""Firings that are tried for an order that needs few tokens."""


class Growth(NamedTuple):
    """How a sum of tokens grows.

    Args:
        run: Transitions from the initial marking on.
        cycle: What may then be fired again and again.
    """

    run: Run
    cycle: Run


def growing(
    searches: Searches, weights: Mapping[int, int], dead: Collection[int] = ()
) -> Pausing[Growth | None]:
    """How a weighted sum of tokens of a net without priorities grows for ever, with pauses.

    Args:
        searches: Searches on the net.
        weights: By place.
        dead: Transitions that never fire.

    Returns:
        What makes it grow; ``None`` where nothing is found, which says nothing.
    """
    net = searches.net
    costs = [1.0] * len(net.transitions)
    for _ in range(TRIES if searches.fits and net.largest <= LARGEST else 0):
        counts = _repeatable(net, weights, costs, dead)
        yield
        if not counts:
            return None
        cycle = _circling(net, counts) or _ordered(net, counts)
        goal: Goal = And(*(marked(p, tokens=n) for p, n in descent_of(net, cycle).needs.items()))
        if holds(goal, net, net.initial):
            return Growth((), cycle)
        found = yield from searches.planning(goal).searching(STATES)
        yield
        if found.outcome == "reached":
            return Growth(found.run, cycle)
        for t in counts:
            costs[t] *= DEARER
    return None


def _repeatable(
    net: PetriNet, weights: Mapping[int, int], costs: Sequence[float], dead: Collection[int]
) -> dict[int, int]:
    """Numbers of firings that lower no place and raise a sum, by transition; none where none are proposed."""
    rows = [(row, 0.0, inf) for row in incidence(net) if row]
    effects = [changes(net, t) for t in range(len(net.transitions))]
    sums = (sum(weights.get(place, 0) * by for place, by in effect.items()) for effect in effects)
    raises = {t: by for t, by in enumerate(sums) if by}
    if not any(by > 0 for by in raises.values()):
        return {}
    upper = [0.0 if t in dead else inf for t in range(len(effects))]
    solved = minimise(costs, [*rows, (raises, 1.0, inf)], [0.0] * len(effects), upper)
    for scale in SCALES if solved.kind == "solved" else ():
        counts = {t: n for t, value in enumerate(solved.values) if (n := ceil(value * scale - ROUNDING)) > 0}
        total: dict[int, int] = {}
        for t, n in counts.items():
            for place, by in effects[t].items():
                total[place] = total.get(place, 0) + n * by
        adds = sum(weights.get(place, 0) * by for place, by in total.items())
        if adds > 0 and min(total.values()) >= 0 and sum(counts.values()) <= LONGEST:
            return counts
    return {}


def _circling(net: PetriNet, counts: Mapping[int, int]) -> Run:
    """An order of firings that needs what its first one does, and no more; empty where none is found soon."""
    looks = ORDERS
    for first in counts:
        # What is fired and, by each firing, what is left to try in its place.
        marking = [0] * len(net.places)
        for place, weight in needs(net, first).items():
            marking[place] = weight
        left, run, choices = dict(counts), list[int](), [[first]]
        seen: set[tuple[int, ...]] = set()
        while choices and looks > 0:
            looks -= 1
            if not choices[-1]:
                choices.pop()
                if run:
                    net.undo_in_place(marking, run[-1])
                    left[run.pop()] += 1
                continue
            t = choices[-1].pop()
            net.fire_in_place(marking, t)
            left[t] -= 1
            run.append(t)
            if not any(left.values()):
                return tuple(run)
            key = tuple(left.values())
            fits = [] if key in seen else [u for u, n in left.items() if n and net.covers(marking, u)]
            seen.add(key)
            choices.append(fits)
    return ()


def _ordered(net: PetriNet, counts: Mapping[int, int]) -> Run:
    """An order of firings that needs few tokens beyond those of the initial marking."""
    marking, left, run = list(net.initial), dict(counts), list[int]()
    while left:
        t = min(left, key=lambda t: (sum(max(w - marking[p], 0) for p, w in needs(net, t).items()), t))
        for place, weight in needs(net, t).items():
            marking[place] = max(marking[place], weight)  # as if they were there
        net.fire_in_place(marking, t)
        run.append(t)
        left[t] -= 1
        if not left[t]:
            del left[t]
    return tuple(run)
