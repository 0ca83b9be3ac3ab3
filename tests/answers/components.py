"""CTL on explicit graphs, sharing nothing with the evaluation that it judges but the core of formulas.

``EG`` goes by strongly connected components, under fairness too (Clarke, Emerson, Sistla, *Automatic
verification of finite-state concurrent systems*, TOPLAS 1986), each operator in time linear in the graph.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from mcpn.logic.formulas import EG, EU, EX, Justice
from mcpn.spaces.markings.graph import Mask, StateGraph
from mcpn.spaces.search.goal import And, AtMost, Deadlock, Fires, Formula, Not, Or, Stable
from mcpn.spaces.stable.alternatives import AlternativesGraph


class ByComponents:
    """Evaluates formulas on a markings graph or an alternatives graph.

    Args:
        graph: The graph.
        fair: Justice constraints: infinite paths that meet one of them only finitely often do not count.
    """

    def __init__(self, graph: StateGraph, fair: Sequence[Justice] = ()) -> None:
        self.graph = graph
        self.fair = tuple(fair)
        self._known: dict[Formula, Mask] = {}
        self._plain = ByComponents(graph) if fair else self  # constraints speak of all paths

    def holds(self, formula: Formula) -> bool:
        """Whether the initial state satisfies a formula."""
        return bool(self.states(formula)[0])

    def states(self, formula: Formula) -> Mask:
        """Which states satisfy a formula, shape (states,)."""
        if formula not in self._known:
            self._known[formula] = self._evaluate(formula)
        return self._known[formula]

    def _evaluate(self, formula: Formula) -> Mask:
        graph = self.graph
        match formula:
            case Not((operand,)):
                return ~self.states(operand)
            case And(operands):
                return _every([self._all, *map(self.states, operands)])
            case Or(operands):
                return ~_every([self._all, *(~self.states(operand) for operand in operands)])
            case AtMost(weights, bound):
                total = np.zeros(graph.states, np.int64)
                for place, weight in weights:
                    total += weight * graph.marked(place)
                return np.asarray(total <= bound, np.bool_)
            case Fires(transitions):
                return self._sources(np.isin(graph.labels, transitions))
            case Deadlock():
                return graph.dead
            case Stable():
                if isinstance(graph, AlternativesGraph) or not graph.net.priorities:
                    return self._all
                internal = [i for i, t in enumerate(graph.net.transitions) if t.internal]
                return ~self.states(Fires(tuple(internal)))
            case EX((operand,)):
                goal = self.states(operand) & self.fair_states
                return self._sources(goal[graph.targets])
            case EU((left, right)):
                along = self.states(left)[graph.sources]
                return graph.reaching(self.states(right) & self.fair_states, along)
            case EG((operand,)):
                return self._always(self.states(operand))
        raise TypeError(f"no formula of the core: {formula!r}")

    @cached_property
    def _all(self) -> Mask:
        return np.ones(self.graph.states, np.bool_)

    def _sources(self, edges: Mask) -> Mask:
        found = np.zeros(self.graph.states, np.bool_)
        found[self.graph.sources[edges]] = True
        return found

    @cached_property
    def fair_states(self) -> Mask:
        """From which states some fair path begins, shape (states,)."""
        return self._always(self._all) if self.fair else self._all

    def _always(self, along: Mask) -> Mask:
        """From which states some fair path stays in a set: to its end, or round a fair component."""
        graph = self.graph
        inside = along[graph.sources] & along[graph.targets]
        number, component = self._components(inside)
        turns = inside & (component[graph.sources] == component[graph.targets])
        good = np.zeros(number, np.bool_)
        good[component[graph.sources[turns]]] = True
        for constraint in self.fair:
            met = np.zeros(number, np.bool_)
            met[component[self._plain.states(constraint.states) & along]] = True
            met[component[graph.sources[turns & np.isin(graph.labels, constraint.transitions)]]] = True
            good &= met
        return graph.reaching(along & (good[component] | graph.dead), inside)

    def _components(self, edges: Mask) -> tuple[int, np.ndarray[tuple[int], np.dtype[np.int32]]]:
        graph = self.graph
        ends = graph.sources[edges], graph.targets[edges]
        matrix = coo_matrix((np.ones(len(ends[0]), np.int8), ends), (graph.states, graph.states))
        number, component = connected_components(matrix.tocsr(), directed=True, connection="strong")
        return int(number), component


def _every(masks: Sequence[Mask]) -> Mask:
    return np.asarray(np.all(masks, axis=0), np.bool_)
