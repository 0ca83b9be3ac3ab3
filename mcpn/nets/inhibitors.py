"""Inhibitor arcs as read arcs of complement places, of places with a proved bound.

A place ``p`` that never holds more than ``k`` tokens has a complement, which holds ``k`` less those of ``p``:
what puts tokens in one takes them from the other. ``p`` holds fewer than ``w`` tokens where its complement
holds ``k - w + 1``. The complement restricts nothing else, so that markings and firings are those of the net
with inhibitor arcs. Where no bound is proved there is no such place, and the net is refused: with inhibitor
arcs of unbounded places most questions have no algorithm.

Reference: Murata, Petri nets: properties, analysis and applications, Proc. of the IEEE 77(4), 1989.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import NamedTuple

from mcpn.errors import InputError, Source
from mcpn.nets.bounds import Inhibitions, coarse_bounds, listed_bounds, weighted_bound
from mcpn.nets.petri import Arcs, PetriNet, Place, Transition
from mcpn.nets.provenance import COMPLEMENT, Provenance
from mcpn.nets.structure import changes, place_bounds


class Inhibitor(NamedTuple):
    """An inhibitor arc.

    Args:
        place: Its place.
        transition: What is disabled,
        weight: where the place holds so many tokens.
        source: Where it is written.
    """

    place: str
    transition: str
    weight: int
    source: Source | None = None


def without_inhibitors(net: PetriNet, arcs: Sequence[Inhibitor]) -> PetriNet:
    """A net that reads complement places where it had inhibitor arcs; places of the net keep their indices.

    Args:
        net: The net without them.
        arcs: The inhibitor arcs.

    Raises:
        InputError: A place has no proved bound, with the line of its arc.

    Examples:
        >>> from mcpn.nets.petri import NetBuilder
        >>> builder = NetBuilder("door")
        >>> names = builder.place("open", initial=1), builder.place("light")
        >>> builder.transition("close", consume=["open"])
        >>> builder.transition("switch", produce=["light"])
        >>> dark = [Inhibitor("open", "switch", 1), Inhibitor("light", "switch", 1)]
        >>> net = without_inhibitors(builder.build(), dark)
        >>> net
        <net door: 4 places, 2 transitions>
        >>> [net.transitions[t].name for t in net.enabled(net.initial)]
        ['close']
    """
    blocked: dict[int, list[tuple[int, int]]] = {}
    for arc in arcs:
        pair = net.place_index[arc.place], arc.weight
        blocked.setdefault(net.transition_index[arc.transition], []).append(pair)
    waiting, made = {place for pairs in blocked.values() for place, _ in pairs}, net
    guarded, exact = _guarded(net, blocked), None
    while waiting:
        bounds = list(map(min, place_bounds(made), guarded))
        for place in waiting:
            bounds[place] = bounds[place] if bounds[place] < inf else weighted_bound(net, place)
        proved = {place: int(bounds[place]) for place in waiting if bounds[place] < inf}
        if exact is None and any(bound > 1 for bound in proved.values()):
            exact = listed_bounds(net, blocked) or bounds  # a bound that no marking reaches counts tokens
        proved = {place: int(min(bound, (exact or bounds)[place])) for place, bound in proved.items()}
        proved = proved or _listed(net, arcs, blocked, bounds, waiting)
        made = _complemented(made, proved, blocked)
        waiting -= proved.keys()
    return made


def _guarded(net: PetriNet, blocked: Inhibitions) -> list[float]:
    """Bounds of places that inhibit whatever puts tokens in them; of others infinity."""
    bounds: list[float] = list(net.initial)
    for number in range(len(net.transitions)):
        least = dict[int, int]()
        for place, tokens in blocked.get(number, ()):
            least[place] = min(tokens, least.get(place, tokens))
        for place, more in changes(net, number).items():
            if more > 0:
                held = least[place] - 1 if place in least else inf
                bounds[place] = max(bounds[place], held + more)
    return bounds


def _listed(
    net: PetriNet,
    arcs: Sequence[Inhibitor],
    blocked: Inhibitions,
    known: Sequence[float],
    waiting: set[int],
) -> dict[int, int]:
    """Bounds of some places that wait for them, by listing markings; else an error."""
    if exact := listed_bounds(net, blocked):
        return {place: int(exact[place]) for place in waiting}
    coarse = coarse_bounds(net, blocked, known, waiting) or known
    if proved := {place: int(coarse[place]) for place in waiting if coarse[place] < inf}:
        return proved
    arc = next(arc for arc in arcs if net.place_index[arc.place] in waiting)
    raise InputError.at(
        arc.source,
        f"found an inhibitor arc from {arc.place} to {arc.transition}, expected a bound of {arc.place}:"
        " neither weights of places nor the markings that were listed give one; such an arc is read where its"
        " place never holds more than some number of tokens",
    )


def _complemented(net: PetriNet, bounds: Mapping[int, int], blocked: Inhibitions) -> PetriNet:
    """The net with complements of some places, read by what these places inhibit."""
    needed = {p for pairs in blocked.values() for p, tokens in pairs if tokens <= bounds.get(p, -1)}
    own = {place: len(net.places) + number for number, place in enumerate(sorted(needed))}
    names = set(net.place_index)
    places = list(net.places)
    for place in own:
        name = f"complement of {net.places[place].name}"
        while name in names:
            name += "'"
        names.add(name)
        origin = Provenance(COMPLEMENT, net.places[place].name)
        places.append(Place(name, bounds[place] - net.initial[place], origin))
    transitions = [_reading(net, number, own, bounds, blocked) for number in range(len(net.transitions))]
    return replace(net, places=tuple(places), transitions=tuple(transitions))


def _reading(
    net: PetriNet, number: int, own: Mapping[int, int], bounds: Mapping[int, int], blocked: Inhibitions
) -> Transition:
    """A transition that keeps complements, and reads those of places that inhibit it."""
    old = net.transitions[number]
    changed = [(own[place], more) for place, more in changes(net, number).items() if place in own]
    reads: dict[int, int] = {}
    for place, tokens in blocked.get(number, ()):
        if tokens <= bounds.get(place, -1):
            reads[own[place]] = max(reads.get(own[place], 0), bounds[place] - tokens + 1)

    def with_more(arcs: Arcs, more: dict[int, int]) -> Arcs:
        return (*arcs, *sorted(more.items()))

    return replace(
        old,
        consume=with_more(old.consume, {place: more for place, more in changed if more > 0}),
        produce=with_more(old.produce, {place: -more for place, more in changed if more < 0}),
        read=with_more(old.read, reads),
    )
