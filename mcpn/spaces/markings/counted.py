"""Markings with several tokens in a place, explored one at a time, breadth first, priorities respected.

The native kernel does the work: a marking is a row of words, each place a field of bits in it. Where a
firing does not fit into a field, places are made wider and exploration begins anew
(:mod:`mcpn.spaces.markings.widths`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from mcpn._kernel import CountedNet, Exploration, MemoryLimit, StateLimit
from mcpn.errors import LimitError, UnsafeError
from mcpn.nets.petri import PetriNet
from mcpn.nets.structure import changes, needs
from mcpn.records import record
from mcpn.spaces.markings.explicit import DEFAULT_MAX_MEMORY, MAX_MARKINGS, Counts, count, explore
from mcpn.steps import telling

if TYPE_CHECKING:
    from mcpn.spaces.markings.graph import Field, StateGraph
from mcpn.spaces.markings.widths import Widths

FIRST_BITS = 4
"""Width of a place of which no bound is known."""
MOST_BITS = 40
"""Sums of tokens stay within 64 bits."""
MOST_WEIGHT = 2**62
WORD = 64


@record(frozen=True)
class TokenCounts(Counts):
    """Sizes of a markings graph whose places hold several tokens.

    Args:
        bounds: Most tokens by place.
    """

    bounds: tuple[int, ...]


def explore_markings(net: PetriNet, *, max_states: int = MAX_MARKINGS) -> StateGraph:
    """Builds the markings graph of a net, 1-safe or not.

    Args:
        net: The net; with priorities it must be 1-safe.
        max_states: How many states it may have.

    Raises:
        UnsafeError: The net has priorities and is not 1-safe.
        UnboundedError: The net is unbounded.
        LimitError: A limit was hit.
    """
    try:
        return explore(net, max_states=max_states)
    except UnsafeError:
        if net.priorities:
            raise
        return explore_tokens(net, max_states=max_states)


def count_markings(net: PetriNet, *, max_states: int = MAX_MARKINGS) -> Counts:
    """Counts what :func:`explore_markings` builds, without keeping the edges."""
    try:
        return count(net, max_states=max_states)
    except UnsafeError:
        if net.priorities:
            raise
        return count_tokens(net, max_states=max_states)


def explore_tokens(
    net: PetriNet,
    *,
    max_states: int = MAX_MARKINGS,
    max_memory: int = DEFAULT_MAX_MEMORY,
) -> StateGraph:
    """Builds the markings graph of a net with as many tokens as there are, priorities respected.

    Args:
        net: The net.
        max_states: How many states it may have.
        max_memory: Bytes that the kernel's tables may take; the graph's own arrays come on top.

    Raises:
        UnboundedError: The net has no priorities and is unbounded.
        LimitError: A limit was hit.
    """
    from mcpn.spaces.markings.graph import StateGraph

    exploration, fields = _explored(net, True, max_states, max_memory)
    offsets, targets = exploration.take_offsets().astype("int64"), exploration.take_targets().astype("int64")
    labels = exploration.take_labels().astype("int64")
    return StateGraph(net, exploration.take_markings(), offsets, targets, labels, fields=tuple(fields))


def count_tokens(
    net: PetriNet,
    *,
    max_states: int = MAX_MARKINGS,
    max_memory: int = DEFAULT_MAX_MEMORY,
) -> TokenCounts:
    """Counts what :func:`explore_tokens` builds, without keeping the edges."""
    exploration, _ = _explored(net, False, max_states, max_memory)
    sizes = (
        exploration.states,
        exploration.edges,
        exploration.dead,
        exploration.stable,
        exploration.most_tokens,
    )
    return TokenCounts(*sizes, tuple(exploration.bounds))


def layout(widths: Sequence[int]) -> list[Field]:
    """Fields of some widths in words, none across two of them."""
    fields: list[Field] = []
    word, shift = 0, 0
    for width in widths:
        if shift + width > WORD:
            word, shift = word + 1, 0
        fields.append((word, shift, width))
        shift += width
    return fields


def _explored(
    net: PetriNet, edges: bool, max_states: int, max_memory: int
) -> tuple[Exploration, list[Field]]:
    widths = Widths(net, first=FIRST_BITS, most=MOST_BITS, asking=True)
    encoded = []
    for t, transition in enumerate(net.transitions):
        need, change = needs(net, t), changes(net, t)
        if max((*need.values(), *change.values()), default=0) > MOST_WEIGHT:
            raise LimitError(f"{transition.name} has a weight of more than {MOST_WEIGHT}: the limit was hit")
        encoded.append((list(need.items()), list(change.items()), net.ranks[t]))
    while True:
        fields = layout(widths.bits)
        kernel = CountedNet(fields, encoded, net.priorities)
        try:
            exploration = kernel.explore(net.initial, edges, max_states, max_memory, telling())
        except (StateLimit, MemoryLimit) as error:
            raise LimitError(str(error)) from error
        if exploration.trouble is None:
            return exploration, fields
        state, beyond, _ = exploration.trouble
        marking = net.initial
        for t in (*exploration.run(state), *beyond):
            marking = net.fire(marking, t)
        widths.widen([p for p, (_, _, width) in enumerate(fields) if marking[p] >> width])
