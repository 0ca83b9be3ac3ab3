"""A firing of a net that puts a second token in a place, found among the markings that were reached."""

from __future__ import annotations

from itertools import groupby

from mcpn._kernel import Zdd
from mcpn.errors import UnsafeError
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.diagrams.spaces import DiagramMarkings


def refuse_unsafe(space: SymbolicSpace) -> None:
    """Looks for a reachable marking in which a transition that fires puts a second token in a place.

    Markings beyond an unsafe firing are not followed, so the first unsafe firing of any run is seen.
    """
    markings = DiagramMarkings(space)
    suspects = sorted(_suspects(space.encoding), key=lambda suspect: space.encoding.net.ranks[suspect[0]])
    for where, together in groupby(suspects, lambda suspect: markings.where[suspect[0]]):
        if where.first([condition for _, _, condition in together]) >= 0:
            raise _unsafe(markings, suspects)


Suspect = tuple[int, int, int]
"""A transition, a place that it produces into, and the condition under which that is one token too many."""


def _suspects(encoding: Encoding) -> list[Suspect]:
    suspects = []
    for t in encoding.transitions:
        safe = encoding.net.safe_transitions[t]
        for place in dict.fromkeys((*safe.produce, *safe.overflow)):
            before = (*safe.consume, *safe.read, *(() if place in safe.overflow else (place,)))
            condition = encoding.condition(before)
            if condition is not None:
                suspects.append((t, place, condition))
    return suspects


def _unsafe(markings: DiagramMarkings, suspects: list[Suspect]) -> UnsafeError:
    """The error for the nearest unsafe firing: layers of a breadth-first search, then back through them."""
    net = markings.net
    seen = layer = markings.initial
    layers = [layer]
    while True:
        for t, place, condition in suspects:
            firing = layer & markings.where[t]
            levels = (firing - firing.without([condition])).pick()
            if levels is not None:
                names = net.marked(markings.marking(levels))
                run = _back(markings, layers, levels)
                return UnsafeError(net.places[place].name, net.transitions[t].name, names, run)
        layer = markings.after(layer) - seen
        seen |= layer
        layers.append(layer)


def _back(markings: DiagramMarkings, layers: list[Zdd], marking: list[int]) -> list[str]:
    """A run through the layers to a marking of the last one."""
    run: list[str] = []
    for layer in reversed(layers[:-1]):
        t, before = next(markings.crossing(layer, markings.single(marking)))
        marking = before.pick() or []
        run.append(markings.net.transitions[t].name)
    return run[::-1]
