"""Reduces a net for one question, and lifts the runs of the smaller net.

>>> from mcpn.nets.petri import NetBuilder
>>> builder = NetBuilder("line")
>>> for place in "abcd":
...     _ = builder.place(place, initial=int(place == "a"))
>>> for source, target in ("ab", "bc", "cd"):
...     builder.transition(source + target, consume=[source], produce=[target])
>>> net = builder.build()
>>> reduced = reduce_for_goal(net, {3: {1}})
>>> [place.name for place in reduced.net.places], len(reduced.net.transitions)
(['a', 'd'], 1)
>>> reduced.lift([0])
(0, 1, 2)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import cached_property

from mcpn.nets.petri import PetriNet, Transition
from mcpn.nets.reduce.agglomeration import agglomerate, flat
from mcpn.nets.reduce.draft import Draft
from mcpn.nets.reduce.redundant import (
    drop_equal_places,
    drop_irrelevant,
    drop_never_marked,
    drop_places,
    drop_transitions,
)

MORE_TRANSITIONS = (0, 4, 16)
"""How many more transitions an agglomeration may cost than it takes away, step by step."""
MOST_NAMED = 3


@dataclass(frozen=True)
class Reduction:
    """A smaller net with the same answer.

    Args:
        net: The smaller net.
        places: For each of its places, the one of the original net that it is.
        runs: For each of its transitions, the firings of the original net that it stands for.
        prefix: Firings of the original net before its runs.
    """

    net: PetriNet
    places: tuple[int, ...]
    runs: tuple[tuple[int, ...], ...]
    prefix: tuple[int, ...]

    @cached_property
    def place_index(self) -> Mapping[int, int]:
        """Where each place of the original net that is left stands in the smaller one."""
        return {place: index for index, place in enumerate(self.places)}

    def lift(self, run: Sequence[int]) -> tuple[int, ...]:
        """The run of the original net that a run of the smaller one stands for."""
        return (*self.prefix, *(t for number in run for t in self.runs[number]))


def reduce_for_deadlock(net: PetriNet) -> Reduction:
    """A smaller net that has a reachable dead marking exactly if the given net has one.

    Args:
        net: A net without priorities.

    Returns:
        The smaller net. A lifted run to its deadlock need not end in a deadlock of the given net, but each
        way to go on from there soon does: all that may fire are first halves of agglomerated sequences.

    Examples:
        >>> from mcpn.testing.nets import kanban
        >>> kanban(3), reduce_for_deadlock(kanban(3)).net
        (<net kanban-3: 16 places, 16 transitions>, <net kanban-3, reduced: 10 places, 14 transitions>)
    """
    draft = Draft(net)
    _reduce(draft, frozenset(), None)
    return _reduction(draft, net)


def reduce_for_goal(net: PetriNet, wanted: Mapping[int, Set[int]]) -> Reduction:
    """A net that reaches the same combinations of tokens in some places, as far as a goal may ask for them.

    Args:
        net: A net without priorities.
        wanted: The places that the goal speaks of: whether it may help to raise (1) or to lower (-1) each.

    Returns:
        The smaller net, with those places; a lifted run ends in a marking that holds the same there.
    """
    draft = Draft(net)
    _reduce(draft, wanted.keys(), wanted)
    return _reduction(draft, net)


def reduce_for_paths(net: PetriNet, kept: Set[int]) -> Reduction:
    """A smaller net whose maximal paths are stutter-equivalent on some places to those of the given net.

    So both satisfy the same stutter-insensitive formulas on paths that speak of these places alone. The rules
    are those of Haddad and Pradat-Peyre (2006). The first transition of a pre-agglomeration may be postponed
    for ever, since no other transition needs the tokens that it takes.

    Args:
        net: A net without priorities.
        kept: The places that a formula speaks of.

    Returns:
        The smaller net, with those places. Where a path of it ends, what is left to fire after the lifted run
        are first halves of sequences, which change none of them.
    """
    draft = Draft(net)
    _reduce(draft, kept, None, paths=True)
    return _reduction(draft, net)


def reduce_for_branching(net: PetriNet, kept: Set[int]) -> Reduction:
    """A smaller net that is branching bisimilar on some places to the given one, divergence respected.

    So both satisfy the same formulas of CTL* without "next" that speak of these places alone. A transition
    that nothing disables, once it is enabled, and that changes none of them is fired with the one before it:
    R. De Nicola, F. Vaandrager, *Three logics for branching bisimulation*, Journal of the ACM 42, 1995; J. F.
    Groote, J. van de Pol, *State space reduction using partial tau-confluence*, MFCS 2000.

    Args:
        net: A net without priorities.
        kept: The places that formulas speak of.

    Returns:
        The smaller net, with those places.
    """
    draft = Draft(net)
    _reduce(draft, kept, None, branching=True)
    return _reduction(draft, net)


def _reduce(
    draft: Draft,
    kept: Set[int],
    wanted: Mapping[int, Set[int]] | None,
    *,
    paths: bool = False,
    branching: bool = False,
) -> None:
    most = len(draft.pre)
    for growth in MORE_TRANSITIONS:
        changed = True
        while changed and len(draft.pre) <= most:
            changed = drop_never_marked(draft)
            changed |= drop_places(draft, kept)
            changed |= drop_equal_places(draft, kept)
            changed |= drop_transitions(draft, deadlock=wanted is None)
            if wanted is not None:
                changed |= drop_irrelevant(draft, wanted)
            changed |= agglomerate(draft, kept, growth=growth, paths=paths, branching=branching)


def _reduction(draft: Draft, net: PetriNet) -> Reduction:
    places = tuple(sorted(draft.places))
    index = {place: number for number, place in enumerate(places)}
    transitions, runs = [], []
    for number in draft.pre:
        run = tuple(flat(draft, number))
        name = f"{number}: {', '.join(net.transitions[t].name for t in run[:MOST_NAMED])}"
        if len(run) > MOST_NAMED:
            name += f" and {len(run) - MOST_NAMED} more"
        consume, produce = (
            tuple(sorted((index[p], w) for p, w in side.items()))
            for side in (draft.pre[number], draft.post[number])
        )
        transitions.append(Transition(name, consume, produce))
        runs.append(run)
    kept = tuple(replace(net.places[p], initial=draft.initial[p]) for p in places)
    smaller = PetriNet(f"{net.name}, reduced", kept, tuple(transitions))
    return Reduction(smaller, places, tuple(runs), tuple(draft.prefix))
