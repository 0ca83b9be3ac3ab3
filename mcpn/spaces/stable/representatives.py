"""Internal evolution marking by marking, where markings that evolve alike are explored once.

What may fire behind a marking depends on few of its places: those of the transitions that have their tokens
there or may get them, whoever takes them before; and for each other transition one place without which it
can never fire. Markings that agree on these places evolve alike, whatever the rest of the net is doing. So
a set of markings as large as a diagram can hold is decided by exploring one marking of each pattern.
"""

from __future__ import annotations

from collections.abc import Iterator

from mcpn._kernel import Zdd
from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.markings.explicit import KernelNet
from mcpn.spaces.stable.run_to_completion import MOST_ENDS, settled


def without_one_end(encoding: Encoding, begun: Zdd) -> Marking | None:
    """Looks among markings for one from which internal evolution has not one stable end.

    Args:
        encoding: A net with priorities on the levels of a store.
        begun: Markings in which internal evolution begins.

    Returns:
        A marking from which there are several stable ends, a run without end, or an unsafe firing; ``None``
        where each has one end. Takes one exploration for each pattern.

    Raises:
        LimitError: There is too much to explore behind one marking.
    """
    patterns, internal = _Patterns(encoding.net), KernelNet(encoding.net, events=False)
    left = begun
    while (levels := left.pick()) is not None:
        marking = encoding.marking(levels)
        if settled(internal, marking, orders="every", max_states=MOST_ENDS).trouble is not None:
            return marking
        left -= encoding.restricted(left, *patterns.of(marking))
    return None


class _Patterns:
    """What internal evolution depends on, marking by marking.

    Args:
        net: A 1-safe net with priorities.
    """

    def __init__(self, net: PetriNet) -> None:
        self.net = net
        internal = (t for t, made in enumerate(net.transitions) if made.internal)
        safe = net.safe_transitions
        self.internal = [t for t in internal if not safe[t].blocked]
        needs = {t: (*safe[t].consume, *safe[t].read) for t in self.internal}
        self.users: dict[int, list[int]] = {}
        for t, places in needs.items():
            for p in places:
                self.users.setdefault(p, []).append(t)
        self.counts = {t: len(places) for t, places in needs.items()}
        # Those first that most transitions need: one of them, unmarked, keeps many from firing.
        self.needs = {
            t: sorted(places, key=lambda p: (len(self.users[p]), p), reverse=True)
            for t, places in needs.items()
        }

    def of(self, marking: Marking) -> tuple[list[int], list[int]]:
        """Places that are marked, and that are not, in all markings that evolve as this one does."""
        within, firing = self._may_be_marked(marking)
        relevant = {p for t in firing for p in self.needs[t]}
        # One unmarked place for each transition that can never fire: none that needs this place can.
        for t, places in self.needs.items():
            if t not in firing:
                relevant.add(next(p for p in places if p not in within))
        return [p for p in sorted(relevant) if marking[p]], [p for p in sorted(relevant) if not marking[p]]

    def _may_be_marked(self, marking: Marking) -> tuple[set[int], set[int]]:
        """Places that may get tokens, and transitions that may fire, if firings took none: both supersets."""
        within = {p for p, tokens in enumerate(marking) if tokens}
        missing = dict(self.counts)
        for p in within:
            for user in self.users.get(p, ()):
                missing[user] -= 1
        firing, queue = set[int](), [t for t, count in missing.items() if not count]
        for t in queue:  # grows while it is walked
            firing.add(t)
            for p in self._new(t, within):
                within.add(p)
                for user in self.users.get(p, ()):
                    missing[user] -= 1
                    if not missing[user]:
                        queue.append(user)
        return within, firing

    def _new(self, transition: int, within: set[int]) -> Iterator[int]:
        return (p for p in self.net.safe_transitions[transition].produce if p not in within)
