"""Places and transitions that a question does not need.

Each rule says whether it has changed something. ``kept`` are the places that the question speaks of: what
they hold stays what it was in every marking that answers it.
"""

from __future__ import annotations

from collections.abc import Mapping, Set

from mcpn.nets.reduce.draft import Draft
from mcpn.nets.relaxed import relaxed

MOST_COMPARED = 40
"""Transitions of one effect that are compared with each other."""


def drop_never_marked(draft: Draft) -> bool:
    """Transitions that need a place of an unmarked siphon: no run ever marks it."""
    marked = (place for place in draft.places if draft.initial[place])
    needs = {t: len(places) for t, places in draft.pre.items()}
    _, dead = relaxed(marked, needs, draft.users, draft.post.__getitem__)
    for t in sorted(dead):
        draft.drop(t)
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
