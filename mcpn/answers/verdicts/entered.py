"""Which objectives and alternatives run in some states of a mission."""

from __future__ import annotations

from collections.abc import Hashable, Iterator

from mcpn.drawing.compose import MissionNet
from mcpn.spaces.algebra import Piece, S, Space


def objectives_run(mission_net: MissionNet, space: Space[S], states: S) -> set[str]:
    """Objectives that run in some of these states.

    Args:
        mission_net: The mission's net.
        space: Its stable states, or its markings.
        states: Those that are asked.
    """
    return _names(mission_net, space, _alike(mission_net, space, states))


def selected_and_entered(mission_net: MissionNet, space: Space[S]) -> tuple[set[str], set[str]]:
    """Alternatives and objectives that run in some stable state."""
    active, selected = mission_net.saying("active"), set[str]()
    pieces = list(_alike(mission_net, space, space.stable))
    for piece, _, first in pieces:
        if first:
            left = ((place, name) for place, name in active.items() if name not in selected)
            selected |= {name for place, name in left if space.restricted(piece.states, [place], ())}
    return selected, _names(mission_net, space, iter(pieces))


def _alike(
    mission_net: MissionNet, space: Space[S], states: S
) -> Iterator[tuple[Piece[S], tuple[str, ...], bool]]:
    """Parts of some states, each with its objectives, and whether it is the first of those that are alike."""
    everywhere, known = tuple(mission_net.saying("objective").values()), set[Hashable]()
    for piece in space.pieces(states):
        yield piece, everywhere if piece.kind is None else piece.names, piece.kind not in known
        known.add(piece.kind)


def _names(
    mission_net: MissionNet, space: Space[S], pieces: Iterator[tuple[Piece[S], tuple[str, ...], bool]]
) -> set[str]:
    """Objectives that run in some pieces; pieces of one kind are asked once."""
    by_role, entered, known = mission_net.by_role, set[str](), dict[Hashable, list[int]]()
    for piece, names, first in pieces:
        if first:
            places = (by_role["objective", name] for name in names)
            known[piece.kind] = [
                number
                for number, own in enumerate(places)
                if any(space.restricted(piece.states, [place], ()) for place in own)
            ]
        entered.update(names[number] for number in known[piece.kind])
    return entered
