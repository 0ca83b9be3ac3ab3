"""Checks of elements of any kind: names declared or listed twice, and cycles of references."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from mcpn.errors import Problem, Source
from mcpn.mission.language.forms import form_of
from mcpn.mission.robot import Element


def unseen(mission: Element, before: Element | None = None) -> Iterator[Element]:
    """The named elements of a mission that ``before`` does not have, itself first, in document order.

    Args:
        mission: The mission.
        before: What it was before an edit; elements of it that were kept are passed over.
    """
    stack: list[tuple[Any, Any]] = [(mission, before)]
    while stack:
        element, old = stack.pop()
        if isinstance(element, Element):
            yield element
        for content in reversed(form_of(type(element)).contents):
            members, others = getattr(element, content.name), getattr(old, content.name, ())
            known = set(map(id, others))
            alike = others if len(others) == len(members) else (None,) * len(members)
            pairs = zip(reversed(members), reversed(alike), strict=True)
            stack.extend(pair for pair in pairs if id(pair[0]) not in known)


def duplicates(kind: str, elements: Iterable[Element]) -> Iterator[Problem]:
    """Elements of one kind that have the name of an earlier one."""
    first: dict[str, Element] = {}
    for element in elements:
        earlier = first.get(element.name)
        if earlier is not None:
            where = f", first declared at {earlier.source}" if earlier.source else ""
            yield Problem(element.source, f"{kind} {element.name} is declared twice{where}")
        first.setdefault(element.name, element)


def repeats(source: Source | None, what: str, names: tuple[str, ...]) -> Iterator[Problem]:
    """Names that an attribute says more than once."""
    for name, count in Counter(names).items():
        if count > 1:
            yield Problem(source, f"{what} names {name} {count} times")


def cycles(
    what: str, elements: Mapping[str, Element], after: Callable[[str], list[str]]
) -> Iterator[Problem]:
    """One problem for each edge that closes a cycle in a depth-first walk of the references ``after``."""
    finished: set[str] = set()
    for start in elements:
        path: dict[str, None] = {}
        stack = [(start, iter(after(start)))] if start not in finished else []
        if stack:
            path[start] = None
        while stack:
            name, left = stack[-1]
            following = next(left, None)
            if following is None:
                finished.add(name)
                stack.pop()
                del path[name]
            elif following in path:
                names = list(path)
                cycle = [*names[names.index(following) :], following]
                yield Problem(elements[following].source, f"{what}: {' -> '.join(cycle)}")
            elif following in elements and following not in finished:
                path[following] = None
                stack.append((following, iter(after(following))))
