"""Strongly connected components, without networkx: it takes longer to load than most questions to answer."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def strongly_connected(successors: Sequence[Iterable[int]]) -> list[list[int]]:
    """The strongly connected components of a graph, those that others lead to first (Tarjan 1972).

    The walk keeps its own stack.

    >>> strongly_connected([[1], [2], [1]])
    [[1, 2], [0]]

    Args:
        successors: By node, the nodes that its edges lead to.
    """
    components: list[list[int]] = []
    number: dict[int, int] = {}
    lowest: dict[int, int] = {}
    waiting: list[int] = []
    assigned = set[int]()
    for start in range(len(successors)):
        stack = [] if start in number else [(start, iter(successors[start]))]
        while stack:
            node, left = stack[-1]
            if node not in number:
                number[node] = lowest[node] = len(number)
                waiting.append(node)
            following = next(left, None)
            if following is not None:
                if following not in number:
                    stack.append((following, iter(successors[following])))
                elif following not in assigned:
                    lowest[node] = min(lowest[node], number[following])
                continue
            stack.pop()
            if stack:
                around = stack[-1][0]
                lowest[around] = min(lowest[around], lowest[node])
            if lowest[node] == number[node]:
                component = [waiting.pop()]
                while component[-1] != node:
                    component.append(waiting.pop())
                components.append(sorted(component))
                assigned.update(component)
    return components
