"""Automata of formulas: their language against other translators; components of graphs."""

from __future__ import annotations

import networkx as nx
from hypothesis import given
from hypothesis import strategies as st

from mcpn.space.components import strongly_connected

GRAPHS = st.integers(1, 9).flatmap(
    lambda n: st.lists(st.lists(st.integers(0, n - 1), max_size=4), min_size=n, max_size=n)
)


@given(GRAPHS)
def test_components_are_those_of_the_graph(targets: list[list[int]]) -> None:
    found = strongly_connected(targets)
    graph = nx.DiGraph((q, t) for q, of in enumerate(targets) for t in of)
    graph.add_nodes_from(range(len(targets)))
    assert {frozenset(c) for c in found} == set(map(frozenset, nx.strongly_connected_components(graph)))
    place = {q: i for i, component in enumerate(found) for q in component}
    assert all(place[t] <= place[q] for q, of in enumerate(targets) for t in of)
