"""Generated formulas as people write them, and evaluation by the definitions on plain sets of markings.

A formula here is an operator and its operands: ``("AU", a, b)``, ``("enabled", "t", "u")``, or a relation
and two sums, each a constant and places: ``("<=", (1, "p"), (0, "q", "r"))``.
"""

from __future__ import annotations

import json
from typing import Any, TypeAlias

from hypothesis import strategies as st

from mcpn.answers.mission_names import MissionNames
from mcpn.drawing.compose import MissionNet
from mcpn.logic.syntax import parse
from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.goal import Formula

Edges = dict[Marking, list[tuple[int, Marking]]]
Written: TypeAlias = tuple[Any, ...]
RELATIONS = ("<", "<=", "=", "!=", ">=", ">")


def formulas(
    places: list[str], transitions: list[str], *, leaves: int = 6, of_paths: bool = True
) -> st.SearchStrategy[Written]:
    """Formulas over a net's names, all operators; without ``of_paths`` none that speaks of paths."""
    sums = st.builds(lambda constant, names: (constant, *names), st.integers(0, 3), _some(places, 0))
    atoms: st.SearchStrategy[Written] = st.one_of(
        st.sampled_from([("true",), ("false",), ("deadlock",), ("stable",)]),
        st.tuples(st.sampled_from(RELATIONS), sums, sums),
        st.tuples(st.just("place"), st.sampled_from(places)),
        # Holds of every marking, which no search is told: what hangs on its opposite is an edge of nothing.
        st.tuples(st.just("<="), st.just((0,)), st.sampled_from(places).map(lambda name: (0, name))),
    )
    if transitions:
        atoms |= _some(transitions, 1).map(lambda names: ("enabled", *names))

    def wider(inside: st.SearchStrategy[Written]) -> st.SearchStrategy[Written]:
        several = st.lists(inside, min_size=2, max_size=3)
        one, two = ["EX", "AX", "EF", "AF", "EG", "AG"], ["EU", "AU"]
        return st.one_of(
            st.tuples(st.sampled_from(["!", *(one if of_paths else ())]), inside),
            st.tuples(st.sampled_from(["->", "<->", *(two if of_paths else ())]), inside, inside),
            st.builds(lambda operator, operands: (operator, *operands), st.sampled_from("&|"), several),
        )

    return st.recursive(atoms, wider, max_leaves=leaves)


def _some(names: list[str], least: int) -> st.SearchStrategy[list[str]]:
    return st.lists(st.sampled_from(names), min_size=least, max_size=3)


def text(formula: Written) -> str:
    """The formula in the language that is checked, every operator in parentheses."""
    operator, *operands = formula
    if operator in ("true", "false", "deadlock", "stable"):
        return str(operator)
    if operator == "place":
        return _quoted(operands[0])
    if operator == "enabled":
        return f"enabled({', '.join(map(_quoted, operands))})"
    if operator in RELATIONS:
        left, right = (
            " + ".join([str(constant), *(f"tokens({_quoted(name)})" for name in names)])
            for constant, *names in operands
        )
        return f"({left} {operator} {right})"
    inside = list(map(text, operands))
    if operator in ("EU", "AU"):
        return f"{operator[0]}[{' U '.join(inside)}]"
    if len(inside) == 1:
        return f"({operator} {inside[0]})"
    return f"({f' {operator} '.join(inside)})"


def _quoted(name: str) -> str:
    return json.dumps(name, ensure_ascii=False)


def read(formula: Written, net: PetriNet, mission_net: MissionNet | None = None) -> Formula:
    """The formula as the program reads its text."""
    names = Names(net) if mission_net is None else MissionNames(mission_net, net=net)
    return parse(text(formula), names)


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


def satisfying(formula: Written, net: PetriNet, edges: Edges) -> set[Marking]:
    """The markings that satisfy a formula, by fixpoints over plain sets; paths are maximal."""
    everything = set(edges)

    def of(inside: Written) -> set[Marking]:
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
        case ("true",):
            return everything
        case ("false",):
            return set()
        case ("!", a):
            return everything - of(a)
        case ("&", *inside):
            return everything.intersection(*map(of, inside))
        case ("|", *inside):
            return set[Marking]().union(*map(of, inside))
        case ("->", a, b):
            return (everything - of(a)) | of(b)
        case ("<->", a, b):
            return everything - (of(a) ^ of(b))
        case ("EX", a):
            return some_next(of(a))
        case ("AX", a):
            return every_next(of(a))
        case ("EF", a):
            return least(of(a), everything, every=False)
        case ("AF", a):
            return least(of(a), everything, every=True)
        case ("EG", a):
            return everything - least(everything - of(a), everything, every=True)
        case ("AG", a):
            return everything - least(everything - of(a), everything, every=False)
        case ("EU", a, b):
            return least(of(b), of(a), every=False)
        case ("AU", a, b):
            return least(of(b), of(a), every=True)
        case ("place", name):
            return {m for m in everything if m[net.place_index[name]]}
        case ("enabled", *names):
            wanted = {net.transition_index[name] for name in names}
            return {m for m in everything if any(t in wanted for t, _ in edges[m])}
        case ("deadlock",):
            return {m for m in everything if not edges[m]}
        case ("stable",):
            return {m for m in everything if not net.priorities or not _internal(net, m)}
        case (relation, left, right):
            return {m for m in everything if _compares(net, m, left, relation, right)}
    raise TypeError(formula)


def _internal(net: PetriNet, marking: Marking) -> bool:
    return any(net.transitions[t].internal for t in net.enabled(marking))


def _compares(net: PetriNet, marking: Marking, left: Written, relation: str, right: Written) -> bool:
    a, b = (
        constant + sum(marking[net.place_index[name]] for name in names) for constant, *names in (left, right)
    )
    return bool({"<": a < b, "<=": a <= b, "=": a == b, "!=": a != b, ">=": a >= b, ">": a > b}[relation])
