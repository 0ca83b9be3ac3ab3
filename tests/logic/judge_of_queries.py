"""Another reader of PNML and of TAPAAL's queries, and another evaluator: they share no code with mcpn.

Formulas are sets of listed markings, by their definitions; inhibitor arcs are what they say.
"""

from __future__ import annotations

import operator
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from lxml import etree

Marking = tuple[int, ...]
RELATIONS: Mapping[str, Callable[[int, int], bool]] = {
    "integer-eq": operator.eq,
    "integer-ne": operator.ne,
    "integer-lt": operator.lt,
    "integer-le": operator.le,
    "integer-gt": operator.gt,
    "integer-ge": operator.ge,
}


class Graph(NamedTuple):
    """The markings graph: the first marking, the firings of each, the index of each place."""

    first: Marking
    edges: dict[Marking, list[tuple[str, Marking]]]
    places: dict[str, int]


def tag(element: etree._Element) -> str:
    return etree.QName(element).localname


def _number(element: etree._Element, label: str, missing: int) -> int:
    found = element.find(f"{{*}}{label}/{{*}}text")
    return missing if found is None else int(found.text or "")


def graph(path: Path, most: int) -> Graph | None:
    """The markings graph of a net; ``None`` where it has more markings than that."""
    root = etree.parse(path).getroot()
    initial = {place.get("id", ""): _number(place, "initialMarking", 0) for place in root.iter("{*}place")}
    index = {name: number for number, name in enumerate(initial)}
    takes, puts = defaultdict[str, Counter[str]](Counter), defaultdict[str, Counter[str]](Counter)
    inhibits = defaultdict[str, list[tuple[str, int]]](list)
    for arc in root.iter("{*}arc"):
        source, target, weight = arc.get("source", ""), arc.get("target", ""), _number(arc, "inscription", 1)
        if arc.get("type") == "inhibitor":
            inhibits[target].append((source, weight))
        elif source in initial:
            takes[target][source] += weight
        else:
            puts[source][target] += weight
    transitions = [transition.get("id", "") for transition in root.iter("{*}transition")]
    first = tuple(initial.values())
    edges: dict[Marking, list[tuple[str, Marking]]] = {first: []}
    todo = [first]
    while todo:
        marking = todo.pop()
        for t in transitions:
            enough = all(marking[index[p]] >= w for p, w in takes[t].items())
            if enough and all(marking[index[p]] < w for p, w in inhibits[t]):
                tokens = dict(zip(index, marking, strict=True))
                after = tuple(tokens[p] - takes[t][p] + puts[t][p] for p in index)
                edges[marking].append((t, after))
                if after not in edges:
                    edges[after] = []
                    todo.append(after)
        if len(edges) > most:
            return None
    return Graph(first, edges, index)


def value(element: etree._Element, marking: Marking, index: Mapping[str, int]) -> int:
    """The value of an integer expression."""
    match tag(element):
        case "integer-constant":
            return int(element.text or "")
        case "tokens-count":
            return sum(marking[index[(place.text or "").strip()]] for place in element)
    first, *rest = (value(part, marking, index) for part in element)
    match tag(element):
        case "integer-sum":
            return first + sum(rest)
        case "integer-difference":
            return first - sum(rest) if rest else -first
        case "integer-product":
            for factor in rest:
                first *= factor
            return first
    raise AssertionError(tag(element))


def satisfying(element: etree._Element, net: Graph) -> set[Marking]:
    """The markings that satisfy a formula."""
    everything, inside = set(net.edges), tag(element)
    if inside in RELATIONS:
        left, right = element
        holds = RELATIONS[inside]
        return {m for m in everything if holds(value(left, m, net.places), value(right, m, net.places))}
    match inside:
        case "property":
            return next(satisfying(part[0], net) for part in element if tag(part) == "formula")
        case "true":
            return everything
        case "false":
            return set()
        case "deadlock":
            return {m for m in everything if not net.edges[m]}
        case "is-fireable":
            asked = {(t.text or "").strip() for t in element}
            return {m for m in everything if any(t in asked for t, _ in net.edges[m])}
        case "negation":
            return everything - satisfying(element[0], net)
        case "conjunction":
            return set.intersection(*(satisfying(part, net) for part in element))
        case "disjunction":
            return set.union(*(satisfying(part, net) for part in element))
        case "exists-path" | "all-paths":
            some, path = inside == "exists-path", element[0]
            inner = satisfying(path[0], net)
            if (tag(path) == "finally") == some:
                reached = _reaching(inner if some else everything - inner, net)
            else:
                reached = _staying(inner if some else everything - inner, net)
            return reached if some else everything - reached
    raise AssertionError(inside)


def _reaching(goal: set[Marking], net: Graph) -> set[Marking]:
    before = defaultdict[Marking, list[Marking]](list)
    for marking, firings in net.edges.items():
        for _, after in firings:
            before[after].append(marking)
    found, todo = set(goal), list(goal)
    while todo:
        for marking in before[todo.pop()]:
            if marking not in found:
                found.add(marking)
                todo.append(marking)
    return found


def _staying(inside: set[Marking], net: Graph) -> set[Marking]:
    found = set(inside)
    while lost := {m for m in found if net.edges[m] and not any(a in found for _, a in net.edges[m])}:
        found -= lost
    return found
