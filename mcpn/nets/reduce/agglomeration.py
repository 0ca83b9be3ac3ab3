"""Agglomeration: two transitions in sequence become one, and the place between them goes.

References: G. Berthelot, *Transformations and decompositions of nets*, LNCS 254, 1987; S. Haddad, J.-F.
Pradat-Peyre, *New efficient Petri nets reductions for parallel programs verification*, 2006; Y.
Thierry-Mieg, *Structural reductions revisited*, Petri Nets 2020.
"""

from __future__ import annotations

from collections.abc import Set

from mcpn.nets.reduce.draft import LONGEST, Draft

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
