"""The token game of a page: every marking of a small net, with its firings, or one marking that is asked for.

A page fires nothing itself: it walks the graph that stands in it, or asks the server that it came from.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Any

from mcpn.errors import InputError
from mcpn.nets.petri import Arcs, Marking, PetriNet

MOST_MARKINGS = 500
"""Markings of a net up to which a page has its graph."""


def stored(net: PetriNet) -> dict[str, Any] | None:
    """The graph of a net's markings, the initial one first; ``None`` where it is too large for a page.

    Transitions are the rows of :func:`_row`; a position holds what is marked, and each transition that may
    fire, followed by the position to which it leads.
    """
    known, waiting = {net.initial: 0}, deque([net.initial])
    positions = list[tuple[str, list[int]]]()
    while waiting:
        marking, firings = waiting.popleft(), list[int]()
        for transition in net.enabled(marking):
            after = net.fire(marking, transition)
            if after not in known:
                if len(known) == MOST_MARKINGS:
                    return None
                known[after] = len(known)
                waiting.append(after)
            firings += (transition, known[after])
        positions.append((_told(net, marking), firings))
    return {"transitions": [_row(net, t) for t in range(len(net.transitions))], "positions": positions}


def position(net: PetriNet, marking: Marking) -> dict[str, Any]:
    """One marking as a page asks for it: its tokens by place, what is marked, what may fire."""
    return {
        "tokens": [[place, tokens] for place, tokens in enumerate(marking) if tokens],
        "marked": _told(net, marking),
        "enabled": [[transition, *_row(net, transition)] for transition in net.enabled(marking)],
    }


def fired(net: PetriNet, tokens: Sequence[Any], transition: int) -> dict[str, Any]:
    """The position after a firing.

    Args:
        net: The net.
        tokens: What is marked before it, as :func:`position` says it.
        transition: What fires.

    Raises:
        InputError: There is no such marking of the net, or the transition is not enabled in it.
    """
    marking = [0] * len(net.places)
    for pair in tokens:
        match pair:
            case [int(place), int(count)] if 0 <= place < len(marking) and count > 0:
                marking[place] = count
            case _:
                raise InputError.at(None, f"found {str(pair)[:50]}, expected a place and its tokens")
    if transition not in net.enabled(marking):
        raise InputError.at(None, f"transition {transition} is not enabled there")
    return position(net, net.fire(marking, transition))


def _row(net: PetriNet, number: int) -> list[str]:
    """A transition's name, the text of its event, and its arcs."""
    transition = net.transitions[number]
    read = f", reads {_arcs(net, transition.read)}" if transition.read else ""
    arcs = f"{_arcs(net, transition.consume)}{read} → {_arcs(net, transition.produce)}"
    return [transition.name, "" if transition.event is None else str(transition.event), arcs]


def _arcs(net: PetriNet, arcs: Arcs) -> str:
    return " + ".join(_tokens(net, place, weight) for place, weight in arcs)


def _told(net: PetriNet, marking: Marking) -> str:
    return ", ".join(_tokens(net, place, count) for place, count in enumerate(marking) if count)


def _tokens(net: PetriNet, place: int, count: int) -> str:
    return f"{count} " * (count > 1) + net.places[place].name
