"""Generated goals on generated nets, and every marking of a small net by the net's own rule."""

from __future__ import annotations

from collections import deque

from hypothesis import strategies as st

from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.search.goal import DEADLOCK, And, AtMost, Goal, Not, Or, as_goal


def goals(net: PetriNet, *, dead: bool = True, depth: int = 2) -> st.SearchStrategy[Goal]:
    """Conditions on the markings of a net."""
    places = st.integers(0, len(net.places) - 1)
    weights = st.dictionaries(places, st.sampled_from([-2, -1, 1, 2]), min_size=1, max_size=3)
    atom: st.SearchStrategy[Goal] = st.builds(
        lambda w, bound: AtMost(tuple(sorted(w.items())), bound), weights, st.integers(-4, 3)
    )
    if dead:
        atom |= st.sampled_from([DEADLOCK, Not(DEADLOCK)])
    return st.recursive(
        atom,
        lambda inside: (
            st.lists(inside, max_size=3).map(lambda goals: And(*goals))
            | st.lists(inside, max_size=3).map(lambda goals: Or(*goals))
        ),
        max_leaves=2**depth,
    )


def all_markings(net: PetriNet, limit: int = 2000) -> set[Marking] | None:
    """Every reachable marking, or ``None`` where there are more than the limit."""
    found = {net.initial}
    queue = deque(found)
    while queue:
        marking = queue.popleft()
        for transition in net.enabled(marking):
            after = net.fire(marking, transition)
            if after not in found:
                found.add(after)
                queue.append(after)
        if len(found) > limit:
            return None
    return found


def is_goal(goal: Goal, net: PetriNet, marking: Marking) -> bool:
    """Whether a marking satisfies a goal, spelled out again."""
    match goal:
        case AtMost(weights, bound):
            return sum(w * marking[p] for p, w in weights) <= bound
        case And(inside):
            return all(is_goal(g, net, marking) for g in inside)
        case Or(inside):
            return any(is_goal(g, net, marking) for g in inside)
    return (net.enabled(marking) == []) == (goal == DEADLOCK)


def negated(goal: Goal, net: PetriNet) -> Goal:
    """The markings that a goal leaves out."""
    found = as_goal(goal, net, wanted=False)
    assert found is not None
    return found
