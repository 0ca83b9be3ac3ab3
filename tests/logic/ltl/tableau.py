"""Formulas on paths as people write them, and what satisfies them by tableaux of maximal consistent sets.

Reference: Lichtenstein, Pnueli, *Checking that finite state concurrent programs satisfy their linear
specification* (POPL 1985). It shares nothing with automata whose states are obligations.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import networkx as nx
from hypothesis import strategies as st

from mcpn.logic.formulas import OPERATORS
from mcpn.logic.ltl.formulas import Happens
from mcpn.logic.syntax import ON_PATH, parse
from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.goal import Formula
from tests.logic import formulas as on_states
from tests.logic.formulas import Edges, Written

OF_ONE, OF_TWO = ("X", "F", "G"), ("U", "R", "W")
"""Operators on one path that are judged here, by how many formulas they join."""
OF_PATHS = (*OF_ONE, *OF_TWO, "fires")


def formulas(
    places: list[str], transitions: list[str], *, leaves: int = 5, of_ctl: bool = True
) -> st.SearchStrategy[Written]:
    """Formulas on paths over a net's names; leaves are formulas on states, with ``of_ctl`` of CTL too."""
    atoms = on_states.formulas(places, transitions, leaves=2, of_paths=of_ctl)
    if transitions:
        atoms |= st.lists(st.sampled_from(transitions), min_size=1, max_size=2).map(lambda t: ("fires", *t))

    def wider(inside: st.SearchStrategy[Written]) -> st.SearchStrategy[Written]:
        return st.one_of(
            st.tuples(st.sampled_from(["!", *OF_ONE]), inside),
            st.tuples(st.sampled_from(["->", *OF_TWO]), inside, inside),
            st.tuples(st.sampled_from("&|"), inside, inside),
        )

    return st.recursive(atoms, wider, max_leaves=leaves)


def text(formula: Written) -> str:
    """The formula in the language that is checked, every operator in parentheses."""
    operator, *operands = formula
    if not speaks_of_paths(formula):
        return on_states.text(formula)
    if operator == "fires":
        return on_states.text(("enabled", *operands)).replace("enabled", "fires")
    inside = list(map(text, operands))
    return f"({operator} {inside[0]})" if len(inside) == 1 else f"({f' {operator} '.join(inside)})"


def speaks_of_paths(formula: Written) -> bool:
    """Whether a formula speaks of a path; else of one state."""
    operator, *operands = formula
    inside = [f for f in operands if isinstance(f, tuple)]
    return operator in OF_PATHS or (operator in ("!", "&", "|", "->") and any(map(speaks_of_paths, inside)))


def read(formula: Written, net: PetriNet) -> Formula:
    """The formula on paths, as its operators make it."""
    operator, *operands = formula
    if not speaks_of_paths(formula):
        return parse(on_states.text(formula), Names(net))
    if operator == "fires":
        return Happens(tuple(sorted({net.transition_index[name] for name in operands})))
    return {**OPERATORS, **ON_PATH}[operator](*(read(f, net) for f in operands))


def on_lasso(
    formula: Written, net: PetriNet, edges: Edges, run: Sequence[tuple[Marking, int | None]], cycle: int
) -> bool:
    """Whether one endless path satisfies a formula, by its definition.

    Args:
        formula: On paths.
        net: The net.
        edges: Its markings.
        run: The markings that it passes and what fires in each; the last one leads to that at ``cycle``.
        cycle: Where the part begins that is repeated.
    """
    after = [*range(1, len(run)), cycle]

    def least(now: list[bool], along: list[bool]) -> list[bool]:
        found = [False] * len(run)
        for _ in run:
            found = [n or (a and found[i]) for n, a, i in zip(now, along, after, strict=True)]
        return found

    def of(f: Written) -> list[bool]:
        if not speaks_of_paths(f):
            states = on_states.satisfying(f, net, edges)
            return [marking in states for marking, _ in run]
        operator, *operands = f
        if operator == "fires":
            return [t is not None and net.transitions[t].name in operands for _, t in run]
        (a, *more) = map(of, operands)
        b = more[0] if more else a
        neither = [not x and not y for x, y in zip(a, b, strict=True)]
        match operator:
            case "!":
                return [not x for x in a]
            case "X":
                return [a[i] for i in after]
            case "&":
                return [x and y for x, y in zip(a, b, strict=True)]
            case "|":
                return [x or y for x, y in zip(a, b, strict=True)]
            case "->":
                return [not x or y for x, y in zip(a, b, strict=True)]
            case "F":
                return least(a, [True] * len(run))
            case "G":
                return [not x for x in least([not x for x in a], [True] * len(run))]
            case "U":
                return least(b, a)
            case "R":
                return [not x for x in least([not y for y in b], [not x for x in a])]
        assert operator == "W"
        return [not x for x in least(neither, [not y for y in b])]

    return of(formula)[0]


class _Node(tuple[Marking, int | None, frozenset[Written]]):
    """A marking, what fires next (None where nothing can), and the promises that the rest keeps."""


def satisfying(
    formula: Written,
    net: PetriNet,
    edges: Edges,
    fair: Sequence[tuple[set[Marking], set[int]]] = (),
) -> set[Marking]:
    """The markings from which some path satisfies a formula.

    Args:
        formula: On paths.
        net: The net.
        edges: Its markings.
        fair: Markings and transitions, of which endless paths pass some again and again to count.
    """
    states = {f: on_states.satisfying(f, net, edges) for f in _leaves(formula)}
    made = list(dict.fromkeys(promises(formula)))

    def value(f: Written, node: _Node) -> bool:
        marking, fired, kept = node
        match f:
            case _ if f in states:
                return marking in states[f]
            case ("fires", *names):
                return fired is not None and net.transitions[fired].name in names
            case ("!", a):
                return not value(a, node)
            case ("&", a, b):
                return value(a, node) and value(b, node)
            case ("|", a, b):
                return value(a, node) or value(b, node)
            case ("->", a, b):
                return not value(a, node) or value(b, node)
            case ("X", _):
                return f in kept
            case ("F", a):
                return value(a, node) or f in kept
            case ("G", a):
                return value(a, node) and f in kept
            case ("U", a, b):
                return value(b, node) or (value(a, node) and f in kept)
            case ("W", a, b):
                return value(b, node) or (value(a, node) and f in kept)
            case ("R", a, b):
                return value(b, node) and (value(a, node) or f in kept)
        raise AssertionError(f)

    all_bits = product((False, True), repeat=len(made))
    kept = [frozenset(p for p, there in zip(made, bits, strict=True) if there) for bits in all_bits]
    firings: dict[Marking, list[int | None]] = {m: [t for t, _ in of] or [None] for m, of in edges.items()}
    nodes = [_Node((m, t, k)) for m, of in firings.items() for t in of for k in kept]
    by_marking: dict[Marking, dict[frozenset[Written], list[_Node]]] = {m: {} for m in edges}
    for node in nodes:
        due = frozenset(p for p in made if value(p[1] if p[0] == "X" else p, node))
        by_marking[node[0]].setdefault(due, []).append(node)
    graph: nx.DiGraph[_Node] = nx.DiGraph()
    graph.add_nodes_from(nodes)
    for node in nodes:
        marking, fired, due = node
        after = marking if fired is None else dict(edges[marking])[fired]
        graph.add_edges_from((node, other) for other in by_marking[after].get(due, ()))

    def fulfils(component: set[_Node]) -> bool:
        if len(component) == 1 and not graph.has_edge(*(2 * tuple(component))):
            return False
        # What is promised comes to pass somewhere, and so does what ends a promise that is not given.
        comes = {
            "F": lambda p, n: not value(p, n) or value(p[1], n),
            "U": lambda p, n: not value(p, n) or value(p[2], n),
            "G": lambda p, n: value(p, n) or not value(p[1], n),
            "R": lambda p, n: value(p, n) or not value(p[2], n),
            "W": lambda p, n: value(p, n) or not (value(p[1], n) or value(p[2], n)),
        }
        for p in made:
            if p[0] in comes and not any(comes[p[0]](p, n) for n in component):
                return False
        return all(any(n[1] is None or n[0] in m or n[1] in t for n in component) for m, t in fair)

    good = {n for c in nx.strongly_connected_components(graph) if fulfils(c) for n in c}
    seen = set(good)
    queue = list(good)
    while queue:
        for before in graph.predecessors(queue.pop()):
            if before not in seen:
                seen.add(before)
                queue.append(before)
    return {node[0] for node in seen if value(formula, node)}


def _leaves(formula: Written) -> list[Written]:
    if not speaks_of_paths(formula):
        return [formula]
    return [leaf for f in formula[1:] if isinstance(f, tuple) for leaf in _leaves(f)]


def promises(formula: Written) -> list[Written]:
    """What is said of the rest of a path: operators, each as often as it stands there."""
    if not speaks_of_paths(formula):
        return []
    inside = [p for f in formula[1:] if isinstance(f, tuple) for p in promises(f)]
    return [*inside, *([formula] if formula[0] in "XFGURW" else [])]
