"""Generated formulas, and evaluation by the definitions on plain sets of markings."""

from __future__ import annotations

from hypothesis import strategies as st

from mcpn.check.logic.formulas import (
    EG,
    EU,
    EX,
    RELATIONS,
    And,
    Compare,
    Const,
    Deadlock,
    Derived,
    Enabled,
    Formula,
    Not,
    Or,
    Stable,
    Sum,
    temporal,
)
from mcpn.net.petri import Marking, PetriNet

Edges = dict[Marking, list[tuple[int, Marking]]]


def formulas(places: list[str], transitions: list[str], *, leaves: int = 6) -> st.SearchStrategy[Formula]:
    """Formulas over a net's names, all operators."""
    sums = st.builds(Sum, st.integers(0, 3), st.lists(st.sampled_from(places), max_size=3).map(tuple))
    atoms: st.SearchStrategy[Formula] = st.one_of(
        st.sampled_from([Const(True), Const(False), Deadlock(), Stable()]),
        st.builds(Compare, sums, st.sampled_from(RELATIONS), sums),
        st.builds(lambda p: Compare(Sum(0, (p,)), ">=", Sum(1)), st.sampled_from(places)),
    )
    if transitions:
        some = st.lists(st.sampled_from(transitions), min_size=1, max_size=3).map(tuple)
        atoms |= st.builds(Enabled, some)

    def wider(inside: st.SearchStrategy[Formula]) -> st.SearchStrategy[Formula]:
        several = st.lists(inside, min_size=2, max_size=3).map(tuple)
        return st.one_of(
            *(st.builds(unary, inside) for unary in (Not, EX, EG)),
            *(st.builds(temporal, st.just(operator), inside) for operator in ("AX", "EF", "AF", "AG")),
            *(st.builds(temporal, st.just(o), inside, inside) for o in ("->", "<->", "EU", "AU")),
            st.builds(And, several),
            st.builds(Or, several),
        )

    return st.recursive(atoms, wider, max_leaves=leaves)


def edges_of(net: PetriNet) -> Edges:
    """Every reachable marking with its firings, by the net's own rule."""
    found: Edges = {}
    stack = [net.initial]
    while stack:
        marking = stack.pop()
        if marking not in found:
            found[marking] = [(t, net.fire(marking, t)) for t in net.enabled(marking)]
            stack.extend(after for _, after in found[marking])
    return found


def satisfying(formula: Formula, net: PetriNet, edges: Edges) -> set[Marking]:
    """The markings that satisfy a formula, by fixpoints over plain sets; paths are maximal."""
    everything = set(edges)

    def of(inside: Formula) -> set[Marking]:
        return satisfying(inside, net, edges)

    def some_next(goal: set[Marking]) -> set[Marking]:
        return {m for m in everything if any(after in goal for _, after in edges[m])}

    def every_next(goal: set[Marking]) -> set[Marking]:
        return {m for m in everything if all(after in goal for _, after in edges[m])}

    def least(goal: set[Marking], along: set[Marking], *, every: bool) -> set[Marking]:
        found = set(goal)
        while True:
            # All paths reach the goal only from where there is a next state.
            step = {m for m in every_next(found) if edges[m]} if every else some_next(found)
            wider = found | step & along
            if wider == found:
                return found
            found = wider

    match formula:
        case Const(value):
            return everything if value else set()
        case Not(a):
            return everything - of(a)
        case And(inside):
            return everything.intersection(*map(of, inside))
        case Or(inside):
            return set[Marking]().union(*map(of, inside))
        case Derived("->", (a, b)):
            return (everything - of(a)) | of(b)
        case Derived("<->", (a, b)):
            return everything - (of(a) ^ of(b))
        case EX(a):
            return some_next(of(a))
        case Derived("AX", (a,)):
            return every_next(of(a))
        case Derived("EF", (a,)):
            return least(of(a), everything, every=False)
        case Derived("AF", (a,)):
            return least(of(a), everything, every=True)
        case EG(a):
            return everything - least(everything - of(a), everything, every=True)
        case Derived("AG", (a,)):
            return everything - least(everything - of(a), everything, every=False)
        case EU(a, b):
            return least(of(b), of(a), every=False)
        case Derived("AU", (a, b)):
            return least(of(b), of(a), every=True)
        case Compare(left, relation, right):
            return {m for m in everything if _compares(net, m, left, relation, right)}
        case Enabled(names):
            wanted = {net.transition_index[name] for name in names}
            return {m for m in everything if any(t in wanted for t, _ in edges[m])}
        case Deadlock():
            return {m for m in everything if not edges[m]}
        case Stable():
            return {m for m in everything if not net.priorities or not _internal(net, m)}
    raise TypeError(formula)


def _internal(net: PetriNet, marking: Marking) -> bool:
    return any(net.transitions[t].internal for t in net.enabled(marking))


def _compares(net: PetriNet, marking: Marking, left: Sum, relation: str, right: Sum) -> bool:
    a, b = (
        side.constant + sum(marking[net.place_index[name]] for name in side.places) for side in (left, right)
    )
    return {"<": a < b, "<=": a <= b, "=": a == b, "!=": a != b, ">=": a >= b, ">": a > b}[relation]
