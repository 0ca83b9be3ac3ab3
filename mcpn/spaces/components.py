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
    size = len(successors)
    components: list[list[int]] = []
    number = [0] * size  # in the order of the walk, from 1 on; beyond all where the component is known
    lowest = [0] * size
    waiting: list[int] = []
    known, count = size + 1, 0
    for start in range(size):
        if number[start]:
            continue
        count += 1
        number[start] = lowest[start] = count
        waiting.append(start)
        stack = [(start, iter(successors[start]))]
        while stack:
            node, left = stack[-1]
            least = lowest[node]
            for following in left:
                if not number[following]:
                    count += 1
                    number[following] = lowest[following] = count
                    waiting.append(following)
                    stack.append((following, iter(successors[following])))
                    break
                if number[following] < least:
                    least = number[following]
            else:
                stack.pop()
                if stack and least < lowest[stack[-1][0]]:
                    lowest[stack[-1][0]] = least
                if least == number[node]:
                    component = [waiting.pop()]
                    while component[-1] != node:
                        component.append(waiting.pop())
                    for member in component:
                        number[member] = known
                    components.append(sorted(component))
                continue
            lowest[node] = least
    return components
