"""The markings graph, explored one marking at a time, breadth first, priorities respected.

The native kernel does the work: markings as bit sets in one array, found by hash. 1-safety is not assumed:
each firing is checked, and the first one that would put a second token in a place ends the exploration with
that firing and a shortest run to it.
"""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

from mcpn._kernel import Exploration, MemoryLimit, SafeNet, StateLimit
from mcpn.errors import LimitError, UnsafeError
from mcpn.nets.petri import PetriNet
from mcpn.records import record
from mcpn.steps import telling

if TYPE_CHECKING:
    from mcpn.spaces.markings.graph import Ints, StateGraph, Words
from mcpn.spaces.markings.masked import unsafe_after, unsafe_at_start

"""Called about once a second with the states found and the edges fired so far."""

MAX_MARKINGS = 100_000_000
DEFAULT_MAX_MEMORY = 16 << 30


class KernelNet:
    """A net as the kernel explores it: transitions that no safe marking covers are left out.

    Args:
        net: The net.
        events: Whether events may happen; else there is internal evolution alone.

    Raises:
        UnsafeError: The initial marking holds two tokens in a place.
    """

    def __init__(self, net: PetriNet, *, events: bool = True) -> None:
        self.net = net
        if error := unsafe_at_start(net):
            raise error
        self.initial = [p for p, tokens in enumerate(net.initial) if tokens]
        self.transitions = [
            i
            for i, t in enumerate(net.safe_transitions)
            if not t.blocked and (events or net.transitions[i].internal)
        ]
        if net.priorities:  # the kernel takes them by rank
            self.transitions.sort(key=net.ranks.__getitem__)

    @cached_property
    def kernel(self) -> SafeNet:
        """The net in the kernel, which numbers transitions without those that are left out."""
        encoded = []
        for i in self.transitions:
            t = self.net.safe_transitions[i]
            rank = self.net.ranks[i]
            need = sorted({*t.consume, *t.read})
            encoded.append((need, list(t.consume), list(t.produce), rank, bool(t.overflow)))
        return SafeNet(len(self.net.places), encoded, self.net.priorities)

    def unsafe(self, exploration: Exploration) -> UnsafeError:
        """The error for an exploration that ended at an unsafe firing."""
        assert exploration.trouble is not None, "asked for explorations that ended in trouble"
        state, last, _ = exploration.trouble
        return unsafe_after(self.net, [self.transitions[t] for t in (*exploration.run(state), *last)])

    def lists(self, exploration: Exploration) -> tuple[list[int], list[list[tuple[int, int]]]]:
        """Markings of a settled exploration, a bit for each place, and by state its edges.

        Each edge is a transition, as the net numbers them, and the state that it leads to.
        """
        words, offsets, targets, labels = exploration.lists()
        width = len(words) // exploration.states
        markings = [
            sum(word << 64 * i for i, word in enumerate(words[at : at + width]))
            for at in range(0, len(words), width)
        ]
        edges = [(self.transitions[t], target) for t, target in zip(labels, targets, strict=True)]
        return markings, [edges[first:last] for first, last in pairwise(offsets)]

    def arrays(self, exploration: Exploration) -> tuple[Words, Ints, Ints, Ints]:
        """Markings, offsets, targets and labels of a settled exploration, labels as the net numbers them."""
        import numpy as np

        numbers = np.array(self.transitions, np.int64)
        markings: Words = exploration.take_markings()
        offsets, targets = (
            exploration.take_offsets().astype(np.int64),
            exploration.take_targets().astype(np.int64),
        )
        return markings, offsets, targets, numbers[exploration.take_labels()]

    def graph(self, exploration: Exploration) -> StateGraph:
        """The graph of an exploration that has kept its edges."""
        import numpy as np

        from mcpn.spaces.markings.graph import StateGraph

        def labels(markings: Words) -> Ints:
            return np.array(self.transitions, np.int64)[self.kernel.labels(markings)]

        offsets = exploration.take_offsets().view(np.int64)
        return StateGraph(self.net, exploration.take_markings(), offsets, exploration.take_targets(), labels)


@record(frozen=True)
class Counts:
    """Sizes of a markings graph.

    Args:
        states: Reachable markings.
        edges: Firings between them.
        dead: Markings that enable nothing.
        stable: Markings that enable no internal transition, of nets with priorities.
        max_tokens: Most tokens in a marking.
    """

    states: int
    edges: int
    dead: int
    stable: int
    max_tokens: int


def explore(
    net: PetriNet,
    *,
    max_states: int = MAX_MARKINGS,
    max_memory: int = DEFAULT_MAX_MEMORY,
) -> StateGraph:
    """Builds the markings graph of a 1-safe net.

    Args:
        net: The net.
        max_states: How many states it may have.
        max_memory: Bytes that the kernel's tables may take; the graph's own arrays come on top.

    Returns:
        The reachable markings in breadth-first order, and every firing between them.

    Raises:
        UnsafeError: The net is not 1-safe; a shortest run to the unsafe firing is given.
        LimitError: A limit was hit.

    See Also:
        :func:`mcpn.spaces.diagrams.symbolic.reach`: the same markings as a diagram.
        :func:`mcpn.spaces.stable.alternatives.direct`: stable states alone, without the markings between.
    """
    prepared = KernelNet(net)
    return prepared.graph(_explored(prepared, True, max_states, max_memory))


def count(
    net: PetriNet,
    *,
    max_states: int = MAX_MARKINGS,
    max_memory: int = DEFAULT_MAX_MEMORY,
) -> Counts:
    """Counts what :func:`explore` builds, without keeping the edges.

    Args:
        net: The net.
        max_states: How many states it may have.
        max_memory: Bytes that the kernel's tables may take.

    Returns:
        The sizes.

    Raises:
        UnsafeError: The net is not 1-safe; a shortest run to the unsafe firing is given.
        LimitError: A limit was hit.
    """
    exploration = _explored(KernelNet(net), False, max_states, max_memory)
    return Counts(
        exploration.states, exploration.edges, exploration.dead, exploration.stable, exploration.most_tokens
    )


def _explored(prepared: KernelNet, edges: bool, max_states: int, max_memory: int) -> Exploration:
    try:
        exploration = prepared.kernel.explore(prepared.initial, edges, max_states, max_memory, telling())
    except (StateLimit, MemoryLimit) as error:
        raise LimitError(str(error)) from error
    if exploration.trouble is not None:
        raise prepared.unsafe(exploration)
    return exploration
