"""A firing of a net that puts a second token in a place, found among the markings that were reached."""

from __future__ import annotations

from mcpn._kernel import Zdd
from mcpn.errors import UnsafeError
from mcpn.space.diagrams.encoding import Encoding
from mcpn.space.diagrams.symbolic import SymbolicSpace


def refuse_unsafe(space: SymbolicSpace) -> None:
    """Looks for a reachable marking in which a transition that fires puts a second token in a place.

    Markings beyond an unsafe firing are not followed, so the first unsafe firing of any run is seen.
    """
    suspects = _suspects(space.encoding)
    if any(markings.first([c for _, _, c in of]) >= 0 for markings, of in _divided(space, suspects)):
        raise _unsafe(space, suspects)


Suspect = tuple[int, int, int]
"""A transition, a place that it produces into, and the condition under which that is one token too many."""


def _suspects(encoding: Encoding) -> list[Suspect]:
    found = []
    for t in encoding.transitions:
        safe = encoding.net.safe_transitions[t]
        for place in dict.fromkeys((*safe.produce, *safe.overflow)):
            before = (*safe.consume, *safe.read, *(() if place in safe.overflow else (place,)))
            condition = encoding.condition(before)
            if condition is not None:
                found.append((t, place, condition))
    return found


def _divided(space: SymbolicSpace, suspects: list[Suspect]) -> list[tuple[Zdd, list[Suspect]]]:
    """Suspects beside the markings in which priorities let them fire."""
    if space.stable is None:
        return [(space.reachable, suspects)]
    net = space.encoding.net
    return [
        (space.reachable, [s for s in suspects if net.transitions[s[0]].internal]),
        (space.stable, [s for s in suspects if not net.transitions[s[0]].internal]),
    ]


def _unsafe(space: SymbolicSpace, suspects: list[Suspect]) -> UnsafeError:
    """The error for the nearest unsafe firing: layers of a breadth-first search, then back through them."""
    encoding, net = space.encoding, space.encoding.net
    seen = layer = encoding.initial()
    layers = [layer]
    while True:
        for t, place, condition in suspects:
            if layer.first([condition]) < 0:
                continue
            conflict = layer & (
                space.reachable if net.transitions[t].internal or space.stable is None else space.stable
            )
            before = conflict.subset(*_sides(encoding, t, place))
            marking = before.pick()
            if marking is None:
                continue
            run = _back(space, layers, marking)
            names = net.marked(encoding.marking(marking))
            return UnsafeError(net.places[place].name, net.transitions[t].name, names, run)
        layer = _step(space, layer) - seen
        seen |= layer
        layers.append(layer)


def _sides(encoding: Encoding, transition: int, place: int) -> tuple[list[int], list[int]]:
    safe = encoding.net.safe_transitions[transition]
    marked = {*safe.consume, *safe.read, *(() if place in safe.overflow else (place,))}
    return sorted(encoding.levels(marked)), sorted(set(encoding.partners(marked)))


def _step(space: SymbolicSpace, layer: Zdd) -> Zdd:
    net, events = space.encoding.net, space.encoding.events
    if space.stable is None:
        return layer.images(list(events.values()))
    internal = layer.images([e for t, e in events.items() if net.transitions[t].internal])
    return internal | (layer & space.stable).images(
        [e for t, e in events.items() if not net.transitions[t].internal]
    )


def _back(space: SymbolicSpace, layers: list[Zdd], marking: list[int]) -> list[str]:
    """A run through the layers to a marking of the last one."""
    encoding, net = space.encoding, space.encoding.net
    run: list[str] = []
    goal = encoding.store.singleton(marking)
    for layer in reversed(layers[:-1]):
        for t, event in encoding.events.items():
            usable = layer
            if space.stable is not None and not net.transitions[t].internal:
                usable = layer & space.stable
            if usable.images([event]) & goal:
                earlier = (goal.images([encoding.undoing[t]]) & usable).pick()
                assert earlier is not None
                goal = encoding.store.singleton(earlier)
                run.append(net.transitions[t].name)
                break
    return run[::-1]
