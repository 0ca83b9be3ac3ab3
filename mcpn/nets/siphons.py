"""Siphons and traps of a net, and Commoner's condition: what stays without tokens, and what keeps one.

Weights are not looked at: siphons and traps see which places stand where. A place that is read stands
before and after its transition (:mod:`mcpn.nets.surroundings`).

Reference: T. Murata, Petri nets: properties, analysis and applications, Proc. IEEE 77(4), 1989, section V.

>>> from mcpn.nets.petri import NetBuilder
>>> builder = NetBuilder("lamp")
>>> places = builder.place("off", initial=1), builder.place("on")
>>> builder.transition("press", consume=["off"], produce=["on"])
>>> builder.transition("again", consume=["on"], produce=["off"])
>>> net = builder.build()
>>> siphons(net), traps(net)
(((0, 1),), ((0, 1),))
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mcpn.errors import LimitError
from mcpn.nets.petri import PetriNet
from mcpn.nets.surroundings import Places, bits_of, members, surroundings

MAX_STEPS = 20_000
COMPARISONS_OF_A_STEP = 2_000
"""Comparisons of sets that each step stands for that a limit allows."""


def siphons(net: PetriNet, *, max_steps: int = MAX_STEPS) -> tuple[Places, ...]:
    """Every minimal siphon: places that, once without tokens, stay so.

    Args:
        net: The net.
        max_steps: How many sets the search may look at; there may be exponentially many siphons.

    Returns:
        The inclusion-minimal non-empty siphons, sorted.

    Raises:
        LimitError: The limit was hit.

    See Also:
        :func:`commoner`: whether each contains a marked trap.
        :func:`traps`: places that keep tokens.

    Examples:
        >>> from mcpn.testing.nets import philosophers
        >>> net = philosophers(2)
        >>> sorted(net.places[p].name for p in siphons(net)[3])
        ['eat0', 'eat1', 'fork0', 'fork1']
    """
    return _closed(surroundings(net), len(net.places), max_steps, "siphons")


def traps(net: PetriNet, *, max_steps: int = MAX_STEPS) -> tuple[Places, ...]:
    """Every minimal trap: places that, once they hold a token, always hold one.

    Args:
        net: The net.
        max_steps: How many sets the search may look at.

    Returns:
        The inclusion-minimal non-empty traps, sorted.

    Raises:
        LimitError: The limit was hit.
    """
    turned = [(after, before) for before, after in surroundings(net)]
    return _closed(turned, len(net.places), max_steps, "traps")


def _closed(around: Sequence[tuple[int, int]], places: int, max_steps: int, what: str) -> tuple[Places, ...]:
    """Minimal sets such that whatever puts into them also takes from them.

    Depth first: where some transition puts into the chosen set and takes nothing from it, one of the places
    that it takes from must be added; each of them is a branch of the search.
    """
    minimal: list[int] = []
    seen: set[int] = set()
    stack = [1 << p for p in range(places)]
    compared = 0
    while stack:
        chosen = stack.pop()
        if chosen in seen:
            continue
        compared += len(minimal)
        if compared > max_steps * COMPARISONS_OF_A_STEP:
            raise LimitError(
                f"more than {max_steps * COMPARISONS_OF_A_STEP} comparisons of sets:"
                f" the limit on the search for {what} was hit"
            )
        if any(known & chosen == known for known in minimal):
            continue
        seen.add(chosen)
        if len(seen) > max_steps:
            raise LimitError(
                f"more than {max_steps} sets looked at: the limit on the search for {what} was hit"
            )
        unfed = next((before for before, after in around if after & chosen and not before & chosen), None)
        if unfed is None:
            minimal = [known for known in minimal if known & chosen != chosen]
            minimal.append(chosen)
        else:
            stack.extend(chosen | 1 << p for p in members(unfed))
    return tuple(sorted(tuple(members(chosen)) for chosen in minimal))


def greatest_trap(net: PetriNet, places: Iterable[int]) -> Places:
    """The greatest trap inside a set of places."""
    inside = bits_of(places)
    around = surroundings(net)
    while True:
        lost = 0
        for before, after in around:
            if not after & inside:
                lost |= before & inside
        if not lost:
            return tuple(members(inside))
        inside &= ~lost


def commoner(net: PetriNet, *, max_steps: int = MAX_STEPS) -> Places | None:
    """A minimal siphon that contains no marked trap, or ``None`` where each contains one.

    An ordinary free choice net is live exactly where there is none (Commoner's theorem; Hack 1972); an
    asymmetric choice net is live if there is none.

    Raises:
        LimitError: The limit on the search for siphons was hit.

    Examples:
        >>> from mcpn.testing.nets import philosophers
        >>> net = philosophers(2)
        >>> [net.places[p].name for p in commoner(net) or ()]
        ['eat0', 'fork0', 'eat1', 'fork1']
    """
    touched = 0
    for before, after in surroundings(net):
        touched |= before | after
    for siphon in siphons(net, max_steps=max_steps):
        if not bits_of(siphon) & touched:
            continue  # a place without arcs hinders nothing
        if not any(net.initial[p] for p in greatest_trap(net, siphon)):
            return siphon
    return None
