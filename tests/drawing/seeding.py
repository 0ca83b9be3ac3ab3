"""Faults seeded in the net of a mission: one arc, one rank or one transition is not as templates draw it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from mcpn.nets.petri import Arcs, PetriNet, Transition

Fault = Callable[[PetriNet], PetriNet]
"""What a fault makes of a net."""


@dataclass(frozen=True)
class Seed:
    """A fault of one transition.

    Args:
        kind: One of :data:`KINDS`.
        transition: Its name.
        place: The place of the arc that is changed; empty where none is.
        other: The place that it goes to instead, or the transition whose rank it gets.
    """

    kind: str
    transition: str
    place: str = ""
    other: str = ""

    def __str__(self) -> str:
        """The fault as a sentence."""
        return " ".join(part for part in (self.transition, self.kind, self.place, self.other) if part)

    def __call__(self, net: PetriNet) -> PetriNet:
        """The net with the fault.

        Raises:
            AssertionError: The net has no such transition, or arc.
        """
        at = net.transition_index[self.transition]
        before = net.transitions[at]
        if self.kind == "fires with":
            other = net.transitions[net.transition_index[self.other]].rank
        else:
            other = net.place_index[self.other] if self.other else -1
        after = KINDS[self.kind](before, net.place_index[self.place] if self.place else -1, other)
        assert after != before, f"{self} changes nothing"
        rest = list(net.transitions)
        rest[at : at + 1] = [] if after is None else [after]
        return replace(net, transitions=tuple(rest))


def without(arcs: Arcs, place: int) -> Arcs:
    """Arcs but the one of a place, which there must be."""
    assert place in dict(arcs), "the arc is there"
    return tuple(arc for arc in arcs if arc[0] != place)


def having(arcs: Arcs, place: int) -> Arcs:
    """Arcs, and one of a place."""
    assert place not in dict(arcs), "the arc is new"
    return tuple(sorted([*arcs, (place, 1)]))


KINDS: dict[str, Callable[[Transition, int, int], Transition | None]] = {
    "keeps": lambda t, p, _: replace(t, consume=without(t.consume, p), read=having(t.read, p)),
    "ignores": lambda t, p, _: replace(t, consume=without(t.consume, p)),
    "does not read": lambda t, p, _: replace(t, read=without(t.read, p)),
    "takes": lambda t, p, _: replace(t, read=without(t.read, p), consume=having(t.consume, p)),
    "does not put": lambda t, p, _: replace(t, produce=without(t.produce, p)),
    "misputs": lambda t, p, q: replace(t, produce=having(without(t.produce, p), q)),
    "fires with": lambda t, _, rank: replace(t, rank=rank),
    "is missing": lambda t, *_: None,
}
"""What a fault does to a transition, with the place of its arc and the other one, or the rank."""


def single(net: PetriNet) -> Iterator[Seed]:
    """Every fault of one arc that is there, and every transition that is missing, event or internal."""
    names = [place.name for place in net.places]
    for t in net.transitions:
        yield Seed("is missing", t.name)
        for kind, arcs in (
            ("keeps", t.consume),
            ("ignores", t.consume),
            ("does not read", t.read),
            ("takes", t.read),
            ("does not put", t.produce),
        ):
            for p, _ in arcs:
                yield Seed(kind, t.name, names[p])
        if t.internal:
            for first in {
                u.rank: u.name for u in reversed(net.transitions) if u.internal and u.rank != t.rank
            }.values():
                yield Seed("fires with", t.name, "", first)
