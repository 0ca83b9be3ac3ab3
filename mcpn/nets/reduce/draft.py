"""A net that reductions change step by step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from mcpn.nets.petri import PetriNet

RunTree: TypeAlias = "int | tuple[RunTree, RunTree]"
"""The firings of the original net that one transition stands for, in their order."""

LONGEST = 100_000
"""Most firings that one transition may stand for."""


class Draft:
    """Places and transitions by number; reads are arcs in both directions.

    Args:
        net: The net to begin with, without priorities.
    """

    def __init__(self, net: PetriNet) -> None:
        self.initial = list(net.initial)
        self.places = set(range(len(net.places)))
        self.pre: dict[int, dict[int, int]] = {}
        self.post: dict[int, dict[int, int]] = {}
        self.runs: dict[int, RunTree] = {}
        self.lengths: dict[int, int] = {}
        self.users: list[set[int]] = [set() for _ in net.places]  # transitions that need a place
        self.feeders: list[set[int]] = [set() for _ in net.places]  # transitions that put tokens in it
        self.prefix: list[int] = []  # firings of the original net before any run
        self._next = 0
        for number, transition in enumerate(net.transitions):
            pre, post = dict(transition.consume), dict(transition.produce)
            for place, weight in transition.read:
                kept = max(weight - pre.get(place, 0), 0)
                if kept:
                    pre[place] = pre.get(place, 0) + kept
                    post[place] = post.get(place, 0) + kept
            self.add(pre, post, number, 1)

    def add(self, pre: Mapping[int, int], post: Mapping[int, int], run: RunTree, length: int) -> None:
        """Adds a transition."""
        number, self._next = self._next, self._next + 1
        self.pre[number], self.post[number] = dict(pre), dict(post)
        self.runs[number], self.lengths[number] = run, length
        for place in self.pre[number]:
            self.users[place].add(number)
        for place in self.post[number]:
            self.feeders[place].add(number)

    def drop(self, transition: int) -> None:
        """Takes a transition out."""
        for place in self.pre.pop(transition):
            self.users[place].discard(transition)
        for place in self.post.pop(transition):
            self.feeders[place].discard(transition)
        del self.runs[transition], self.lengths[transition]

    def unlink(self, place: int) -> None:
        """Takes all arcs of a place out."""
        for transition in self.users[place]:
            del self.pre[transition][place]
        for transition in self.feeders[place]:
            del self.post[transition][place]
        self.users[place].clear()
        self.feeders[place].clear()

    def drop_place(self, place: int) -> None:
        """Takes a place out, with its arcs."""
        self.unlink(place)
        self.places.discard(place)

    def change(self, transition: int, place: int) -> int:
        """The tokens that a firing adds to a place."""
        return self.post[transition].get(place, 0) - self.pre[transition].get(place, 0)

    def effect(self, transition: int) -> dict[int, int]:
        """The tokens that a firing adds, by place, without zeros."""
        pre, post = self.pre[transition], self.post[transition]
        return {p: by for p in pre.keys() | post.keys() if (by := post.get(p, 0) - pre.get(p, 0))}
