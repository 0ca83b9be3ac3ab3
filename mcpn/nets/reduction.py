"""A net that reductions change step by step.

Reduces a net for one question, and lifts the runs of the smaller net.

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
from typing import TypeAlias

from mcpn.nets.petri import PetriNet, Transition

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


# --- Agglomeration: two transitions in sequence become one, and the place between them goes ---------------
#
# References: G. Berthelot, *Transformations and decompositions of nets*, LNCS 254, 1987; S. Haddad, J.-F.
# Pradat-Peyre, *New efficient Petri nets reductions for parallel programs verification*, 2006; Y.
# Thierry-Mieg, *Structural reductions revisited*, Petri Nets 2020.

MOST_FIRED_AT_FIRST = 1000


def agglomerate(
    draft: Draft, kept: Set[int], *, growth: int, paths: bool = False, branching: bool = False
) -> bool:
    """Agglomerates around every place that allows it.

    Args:
        draft: The net.
        kept: Places that the question speaks of; empty for deadlocks.
        growth: How many more transitions a place may cost than it takes away.
        paths: Whether the question speaks of what those places hold along whole paths.
        branching: Whether it speaks of the paths from any marking on the way. Then the transition behind a
            place must be the only one: nothing disables it, so that it makes no difference when it fires.

    Returns:
        Whether something has changed.
    """
    changed = False
    for place in sorted(draft.places):
        if place in kept:
            continue
        before, after = draft.feeders[place], draft.users[place]
        if not (before or branching) or not after or before & after:
            continue
        if len(before) * len(after) > len(before) + len(after) + growth:
            continue
        if branching:
            allowed = len(after) == 1 and _post_allowed(draft, place, kept, paths=True)
        else:
            allowed = _post_allowed(draft, place, kept, paths) or _pre_allowed(draft, place, kept)
        if allowed:
            changed |= _fuse(draft, place)
    return changed


def _post_allowed(draft: Draft, place: int, kept: Set[int], paths: bool) -> bool:
    """Whether post-agglomeration is allowed: each output transition of the place needs this place alone.

    A marking with tokens here is no deadlock. For a goal, some output transition must leave the kept places
    as they are, so that it can empty this place without changing the answer. For a formula on paths all of
    them must: then it makes no difference when they fire. Initial tokens are removed by firing the output
    transition beforehand, where there is one alone.
    """
    after = draft.users[place]
    weights = {draft.post[t][place] for t in draft.feeders[place]} | {draft.pre[t][place] for t in after}
    if len(weights) > 1 or any(len(draft.pre[t]) > 1 for t in after):
        return False
    seen = [bool(draft.post[t].keys() & kept) for t in after]
    if any(seen) if paths else all(seen):
        return False
    count = draft.initial[place] // weights.pop()  # a rest that is no whole firing is never used
    if count == 0:
        return True
    only, *others = after
    if others or count * draft.lengths[only] > MOST_FIRED_AT_FIRST:
        return False
    for produced, more in draft.post[only].items():
        draft.initial[produced] += more * count
    draft.initial[place] = 0
    draft.prefix += flat(draft, only) * count
    return True


def _pre_allowed(draft: Draft, place: int, kept: Set[int]) -> bool:
    """Whether pre-agglomeration is allowed: input transitions mark this place alone, and share no input."""
    if draft.initial[place]:
        return False
    for t in draft.feeders[place]:
        if draft.post[t] != {place: 1} or not draft.pre[t]:
            return False
        if any(input_ in kept or draft.users[input_] != {t} for input_ in draft.pre[t]):
            return False
    return all(draft.pre[t][place] == 1 for t in draft.users[place])


def _fuse(draft: Draft, place: int) -> bool:
    """Replaces the transitions around a place by their sequences, and takes the place out.

    The place is the only output of the input transitions, or the only input of the output transitions, so
    that no other place is between them.
    """
    before, after = sorted(draft.feeders[place]), sorted(draft.users[place])
    if max((draft.lengths[t] for t in before), default=0) + max(draft.lengths[t] for t in after) > LONGEST:
        return False
    for first in before:
        for second in after:
            pre, post = dict(draft.pre[first]), dict(draft.post[second])
            for side, more in ((pre, draft.pre[second]), (post, draft.post[first])):
                for other, weight in more.items():
                    if other != place:
                        side[other] = side.get(other, 0) + weight
            run = (draft.runs[first], draft.runs[second])
            draft.add(pre, post, run, draft.lengths[first] + draft.lengths[second])
    for transition in (*before, *after):
        draft.drop(transition)
    draft.drop_place(place)
    return True


def flat(draft: Draft, transition: int) -> list[int]:
    """The firings of the original net that a transition stands for."""
    members: list[int] = []
    stack = [draft.runs[transition]]
    while stack:
        run = stack.pop()
        if isinstance(run, int):
            members.append(run)
        else:
            stack += run[::-1]
    return members


# --- Places and transitions that a question does not need -------------------------------------------------
#
# Each rule says whether it has changed something. ``kept`` are the places that the question speaks of: what
# they hold stays what it was in every marking that answers it.

MOST_COMPARED = 40
"""Transitions of one effect that are compared with each other."""


def drop_never_marked(draft: Draft) -> bool:
    """Transitions that need a place of an unmarked siphon: no run ever marks it."""
    siphon = {place for place in draft.places if draft.initial[place] == 0}
    queue = list(siphon)
    while queue:
        place = queue.pop()
        if place not in siphon or all(draft.pre[t].keys() & siphon for t in draft.feeders[place]):
            continue
        siphon.discard(place)
        for transition in draft.users[place]:
            queue.extend(after for after in draft.post[transition] if after in siphon)
    dead = {t for place in siphon for t in draft.users[place]}
    for transition in dead:
        draft.drop(transition)
    return bool(dead)


def drop_places(draft: Draft, kept: Set[int]) -> bool:
    """Places that never hinder a firing: constant ones, those that only grow or that nothing needs."""
    changed = False
    for place in list(draft.places):
        raised = any(draft.change(t, place) > 0 for t in draft.feeders[place])
        if not raised:
            for t in [t for t in draft.users[place] if draft.pre[t][place] > draft.initial[place]]:
                draft.drop(t)
                changed = True
        lowered = any(draft.change(t, place) < 0 for t in draft.users[place])
        need = max((draft.pre[t][place] for t in draft.users[place]), default=0)
        if place in kept:
            if not raised and not lowered and (draft.users[place] or draft.feeders[place]):
                draft.unlink(place)
                changed = True
        elif not draft.users[place] or (not lowered and need <= draft.initial[place]):
            draft.drop_place(place)
            changed = True
    return changed


def drop_equal_places(draft: Draft, kept: Set[int]) -> bool:
    """Places with the arcs of another that holds no more tokens than they do."""
    groups: dict[frozenset[tuple[int, int, int]], list[int]] = {}
    for place in draft.places:
        touching = draft.users[place] | draft.feeders[place]
        arcs = frozenset((t, draft.pre[t].get(place, 0), draft.post[t].get(place, 0)) for t in touching)
        groups.setdefault(arcs, []).append(place)
    changed = False
    for places in groups.values():
        least = min(places, key=lambda place: (draft.initial[place], place not in kept))
        for place in places:
            if place != least and place not in kept:
                draft.drop_place(place)
                changed = True
    return changed


def drop_transitions(draft: Draft, *, deadlock: bool) -> bool:
    """Transitions of the effect of another that needs no more; without deadlocks also those of no effect."""
    groups: dict[frozenset[tuple[int, int]], list[int]] = {}
    for transition in draft.pre:
        groups.setdefault(frozenset(draft.effect(transition).items()), []).append(transition)
    changed = False
    for effect, transitions in groups.items():
        if not effect and not deadlock:
            for transition in transitions:
                draft.drop(transition)
            changed = True
            continue
        if len(transitions) == 1:
            continue
        transitions.sort(key=lambda t: (sum(draft.pre[t].values()), draft.lengths[t], t))
        kept_needs: list[tuple[frozenset[int], dict[int, int]]] = []  # places, and tokens by place
        for transition in transitions:
            needs = draft.pre[transition]
            places = frozenset(needs)
            if any(own <= places and all(w <= needs[p] for p, w in less.items()) for own, less in kept_needs):
                draft.drop(transition)
                changed = True
            elif len(kept_needs) < MOST_COMPARED:
                kept_needs.append((places, needs))
    return changed


def drop_irrelevant(draft: Draft, wanted: Mapping[int, Set[int]]) -> bool:
    """Transitions that cannot help to reach a goal, and the places that nothing else needs.

    A transition helps if it changes a wanted place the wanted way, or adds tokens to a place that a
    transition that helps needs. A run without the others has no fewer tokens where they are needed.

    Args:
        draft: The net.
        wanted: The places of the goal: whether it may help to raise (1) or to lower (-1) each.
    """
    needed: set[int] = set()
    helping: set[int] = set()
    queue: list[int] = []
    for place, ways in wanted.items():
        for transition in draft.users[place] | draft.feeders[place]:
            change = draft.change(transition, place)
            if (change > 0 and 1 in ways) or (change < 0 and -1 in ways):
                queue.append(transition)
    while queue:
        transition = queue.pop()
        if transition in helping:
            continue
        helping.add(transition)
        for place in draft.pre[transition]:
            if place not in needed:
                needed.add(place)
                queue.extend(t for t in draft.feeders[place] if draft.change(t, place) > 0)
    useless = [t for t in draft.pre if t not in helping]
    for transition in useless:
        draft.drop(transition)
    for place in [place for place in draft.places if place not in needed and place not in wanted]:
        draft.drop_place(place)
    return bool(useless)


# --- Reduces a net for one question, and lifts the runs of the smaller net --------------------------------

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
