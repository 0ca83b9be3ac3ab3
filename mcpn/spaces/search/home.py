"""Home markings: those that every reachable marking leads to, proved without the space.

A *rule* is a run that may be fired wherever its tokens are there. Some rules, and weights of places such that
each rule lowers the weighted sum of tokens: then firing rules ends, whatever the order. If the
state equation shows that no reachable marking but one stops all rules, every reachable marking leads to it.

Rules are found by counterexamples. At first they are single transitions, as many as some weights allow; for
a marking that stops them and that the equation lets pass, a search looks for a run home, and the shortest
beginning of it that some weights allow becomes a rule. The weights are checked in whole numbers, and the
equation's refutations as :mod:`mcpn.spaces.search.equation` does.

>>> from mcpn.testing.nets import kanban
>>> net = kanban(30)
>>> equation = StateEquation(net, bounds=[30] * len(net.places))
>>> home = proved_home(equation, Searches(net), net.initial)
>>> home is not None and home.marking == net.initial
True
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from math import inf

from mcpn.nets.petri import Marking, PetriNet
from mcpn.nets.programs import minimise
from mcpn.nets.repeatable import SCALES
from mcpn.nets.structure import Sparse, changes, needs
from mcpn.records import record
from mcpn.spaces.search.equation import Proof, StateEquation
from mcpn.spaces.search.goal import And, AtMost, Goal, Or, marked
from mcpn.spaces.search.searches import Searches
from mcpn.turns import Pausing, finished

ROUNDS, MOST_WORK = 24, 25_000
"""How often rules are sought; less often where that times the arcs is more."""
MARKINGS = 3_000
"""Of a search for a run home."""
LONGEST = 40
"""Firings of a rule at most."""
CASES = 200
"""Of the branch and bound, for each marking that is sought."""
UNSETTLED = 10
"""Places whose tokens the marking's empty places do not settle, at most."""
HEAVIEST = 10_000.0
"""The greatest weight of a place."""
LIGHT = 0.001
"""What a weight costs beside a transition that is no rule,"""
LIKED = 8.0
"""and one that is none though it is called as one that had to be."""


@record(frozen=True)
class Descent:
    """A run that lowers a weighted sum of tokens, and what it takes.

    Args:
        run: Transitions.
        needs: Tokens by place with which it may be fired.
        effect: What it changes, by place.
    """

    run: tuple[int, ...]
    needs: Sparse
    effect: Sparse

    def applies(self, marking: Sequence[int]) -> bool:
        """Whether it may be fired in a marking."""
        return all(marking[place] >= tokens for place, tokens in self.needs.items())


@record(frozen=True)
class Home:
    """A home marking, with what proves it.

    Args:
        marking: The marking.
        rules: No other reachable marking stops all of them.
        weights: By place; each rule lowers the weighted sum of tokens.
        ends: Whether each transition alone is a rule: then every run ends there.
        proofs: That the equation lets no other marking stop all rules.
    """

    marking: Marking
    rules: tuple[Descent, ...]
    weights: tuple[int, ...]
    ends: bool
    proofs: tuple[Proof, ...]


def descent_of(net: PetriNet, run: Sequence[int]) -> Descent:
    """The rule of a run."""
    wanted: dict[int, int] = {}
    effect: dict[int, int] = {}
    for t in reversed(run):
        for place, change in changes(net, t).items():
            wanted[place] = max(wanted.get(place, 0) - change, 0)
            effect[place] = effect.get(place, 0) + change
        for place, tokens in needs(net, t).items():
            wanted[place] = max(wanted.get(place, 0), tokens)
    return Descent(tuple(run), *({p: n for p, n in side.items() if n} for side in (wanted, effect)))


def proved_home(equation: StateEquation, searches: Searches, marking: Marking) -> Home | None:
    """A proof that every reachable marking of a net without priorities leads to a marking.

    Args:
        equation: The state equation of the net.
        searches: Searches on it.
        marking: The marking.

    Returns:
        The proof; ``None`` where none is found.
    """
    return finished(proving_home(equation, searches, marking))


def proving_home(equation: StateEquation, searches: Searches, marking: Marking) -> Pausing[Home | None]:
    """:func:`proved_home`, with pauses."""
    net = equation.net
    every = range(len(net.transitions))
    singles = [descent_of(net, (t,)) for t in every if changes(net, t) and not net.covers(marking, t)]
    empty = [place for place, tokens in enumerate(marking) if not tokens]
    others: list[Goal] | None = None  # where the marking differs though the same places are empty
    chosen: list[Descent] = []
    arcs = sum(len(t.consume) + len(t.produce) for t in net.transitions)
    for _ in range(max(2, min(ROUNDS, MOST_WORK // max(arcs, 1)))):
        ranked = _ranked(net, chosen, singles)
        if ranked is None:
            return None
        rules, weights = ranked
        stops = [_stops(rule) for rule in rules]
        proofs: list[Proof] = []
        found = (yield from equation.solving(And(marked(*empty), *stops), CASES)) if empty else None
        if found is None or found.kind == "unreachable":
            proofs += found.proofs if found else ()
            others = (yield from _left_open(equation, marking, empty)) if others is None else others
            if len(others) > UNSETTLED:
                return None
            for other in others:
                found = yield from equation.solving(And(other, *stops), CASES)
                if found.kind != "unreachable":
                    break
                proofs += found.proofs
            else:
                ends = {(t,) for t in every} <= {rule.run for rule in rules}
                return Home(marking, rules, weights, ends, tuple(proofs))
        if found.kind == "unknown":
            return None
        more = yield from _another(searches, found.marking, marking, chosen, singles)
        if more is None:
            return None
        chosen.append(more)
    return None


def _stops(rule: Descent) -> Goal:
    return Or(*(AtMost(((place, 1),), tokens - 1) for place, tokens in rule.needs.items()))


def _left_open(equation: StateEquation, marking: Marking, empty: Sequence[int]) -> Pausing[list[Goal]]:
    """How another marking could differ although it has no tokens where this one has none."""
    goals: list[Goal] = []
    for place, tokens in enumerate(marking):
        for sign in (1, -1) if tokens else ():
            if (yield from equation.bounding({place: sign}, empty)).bound != sign * tokens:
                goals.append(AtMost(((place, -sign),), -sign * tokens - 1))
    return goals


def _another(
    searches: Searches, stuck: Marking, home: Marking, chosen: list[Descent], singles: list[Descent]
) -> Pausing[Descent | None]:
    """A rule that may be fired in a marking where those chosen so far may not."""
    net = searches.net
    exactly = And(
        *chain.from_iterable(
            (AtMost(((place, 1),), tokens), AtMost(((place, -1),), -tokens))
            for place, tokens in enumerate(home)
        )
    )
    found = yield from searches.seeking(exactly, start=stuck).searching(MARKINGS)
    for length in range(1, min(len(found.run), LONGEST) + 1):
        rule = descent_of(net, found.run[:length])
        if not rule.applies(home) and _ranked(net, [*chosen, rule], singles):
            return rule
    return None


def _stem(net: PetriNet, rule: Descent) -> str:
    """The name of the first transition without its number: components that are alike have it in common."""
    return net.transitions[rule.run[0]].name.rstrip("0123456789")


def _ranked(
    net: PetriNet, chosen: Sequence[Descent], singles: Sequence[Descent]
) -> tuple[tuple[Descent, ...], tuple[int, ...]] | None:
    """Rules that some weights allow: all that are chosen, and as many others as may be; and the weights."""
    places = len(net.places)
    rules = [*chosen, *singles]
    rows = [
        ({**rule.effect, **({} if number < len(chosen) else {places + number - len(chosen): -1})}, -inf, -1.0)
        for number, rule in enumerate(rules)
    ]
    liked = {_stem(net, rule) for rule in chosen if len(rule.run) == 1}
    solved = minimise(
        [LIGHT] * places + [LIKED if _stem(net, rule) in liked else 1.0 for rule in singles],
        rows,
        [0.0] * (places + len(singles)),
        [HEAVIEST] * places + [inf] * len(singles),
    )
    best: tuple[tuple[Descent, ...], tuple[int, ...]] | None = None
    for scale in SCALES if solved.kind == "solved" else ():
        weights = tuple(round(weight * scale) for weight in solved.values[:places])
        lowers = [sum(weights[p] * change for p, change in rule.effect.items()) < 0 for rule in rules]
        kept = tuple(rule for rule, low in zip(rules, lowers, strict=True) if low)
        if all(lowers[: len(chosen)]) and (best is None or len(kept) > len(best[0])):
            best = kept, weights
    return best
