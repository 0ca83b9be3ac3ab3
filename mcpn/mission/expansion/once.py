"""Handlers that happen once: the objectives graph is written out once more for what comes after them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TypeAlias

from mcpn.errors import LimitError
from mcpn.mission.graph import Branch, ElementarySection, Interruption, ObjectivesGraph, Section

Used: TypeAlias = frozenset[int]
"""Handlers that have happened and can be met again."""


def reachable(graph: ObjectivesGraph) -> ObjectivesGraph:
    """The graph with what no route reaches put aside."""
    seen, stack = {graph.entry}, [graph.entry]
    while stack:
        section = graph.section(stack.pop())
        for target in (*graph.targets(section), *graph.interrupted(section)):
            if target.name not in seen:
                seen.add(target.name)
                stack.append(target.name)
    reached = tuple(s for s in graph.sections if s.name in seen)
    return ObjectivesGraph(reached, graph.entry, tuple(s for s in graph.sections if s.name not in seen))


def unfold_once(graph: ObjectivesGraph, limit: int, within: str = "") -> ObjectivesGraph:
    """The graph with handlers that happen once as handlers like any other.

    What may come after such a handler has happened is a copy of its own of the sections, in which it is not;
    a handler is forgotten as soon as nothing that follows can meet it. A section that the mission meets in
    one such history only keeps its name; copies are qualified by the events that have happened
    (``after_leak.diving``).

    Args:
        graph: A graph whose sections may have several interruptions for one event, innermost first.
        limit: How many sections there may be.
        within: Stands before the names of copies: the branch of a parallel block that the graph is of.

    Returns:
        The graph with at most one interruption of a section for each event.

    Raises:
        LimitError: There would be more sections.
    """
    if not any(i.once is not None for section in graph.sections for i in section.interruptions):
        return graph
    unfolding = _Unfolding(graph, limit, within)
    return ObjectivesGraph(tuple(unfolding.sections()), graph.entry, graph.unreached)


class _Unfolding:
    def __init__(self, graph: ObjectivesGraph, limit: int, within: str) -> None:
        self.graph = graph
        self.within = within
        self.names = {section.name for section in graph.sections}
        self.ahead = _ahead(graph)
        # By history, in the order of discovery, the sections met in it.
        self.met: dict[Used, set[str]] = {}
        self.walk(limit)
        histories: dict[str, list[Used]] = {}
        for used, names in self.met.items():
            for name in names:
                histories.setdefault(name, []).append(used)
        self.histories = histories
        self.tags = self.tagged()

    def walk(self, limit: int) -> None:
        stack, count = [self.after(self.graph.entry, frozenset())], 0
        while stack:
            name, used = stack.pop()
            met = self.met.setdefault(used, set())
            if name in met:
                continue
            met.add(name)
            count += 1
            if count > limit:
                message = f"more than {limit} sections with handlers that happen once: the limit was hit"
                raise LimitError(message)
            section = self.graph.section(name)
            following = [self.after(route, used) for route in (section.success, section.failure)]
            for interruption in _effective(section, used):
                following.append(self.after(interruption.target, _with(used, interruption)))
            stack.extend(after for after in reversed(following) if after[0] in self.names)

    def after(self, route: str, used: Used) -> tuple[str, Used]:
        """A section to come with the history that still matters there."""
        return route, used & self.ahead.get(route, frozenset())

    def tagged(self) -> dict[Used, str]:
        """By history the qualifier of copies that stand in it."""
        events = {i.once: i.event for s in self.graph.sections for i in s.interruptions if i.once is not None}
        words = (section.name.split(".") for section in self.graph.all_sections())
        taken = {".".join(parts[:end]) for parts in words for end in range(1, len(parts))}
        tags: dict[Used, str] = {}
        for used in self.met:
            tag = whole = f"{self.within}after_" + "_and_".join(sorted(events[handler] for handler in used))
            number = 2
            while tag in taken:
                tag, number = f"{whole}_{number}", number + 1
            taken.add(tag)
            tags[used] = tag
        return tags

    def prefix(self, name: str, used: Used) -> str:
        return f"{self.tags[used]}." if used and len(self.histories[name]) > 1 else ""

    def sections(self) -> Iterator[Section]:
        for used, met in self.met.items():
            for section in self.graph.sections:
                if section.name in met:
                    yield self.copy(section, used)

    def copy(self, section: Section, used: Used) -> Section:
        def route(target: str, history: Used) -> str:
            name, left = self.after(target, history)
            return self.prefix(name, left) + name if name in self.names else name

        interruptions = tuple(
            replace(i, target=route(i.target, _with(used, i)), once=None) for i in _effective(section, used)
        )
        named = _qualified(section, self.prefix(section.name, used))
        return replace(
            named,
            success=route(section.success, used),
            failure=route(section.failure, used),
            interruptions=interruptions,
        )


def _with(used: Used, interruption: Interruption) -> Used:
    return used if interruption.once is None else used | {interruption.once}


def _effective(section: Section, used: Used) -> list[Interruption]:
    """By event the innermost interruption that can still happen."""
    found: dict[str, Interruption] = {}
    for interruption in section.interruptions:
        if interruption.once not in used:
            found.setdefault(interruption.event, interruption)
    return list(found.values())


def _ahead(graph: ObjectivesGraph) -> dict[str, Used]:
    """By section the handlers that happen once of it and of all that may follow."""
    before: dict[str, list[str]] = {}
    ahead: dict[str, Used] = {}
    for section in graph.sections:
        own = frozenset(i.once for i in section.interruptions if i.once is not None)
        ahead[section.name] = own
        for target in (*graph.targets(section), *graph.interrupted(section)):
            before.setdefault(target.name, []).append(section.name)
    waiting = [name for name, own in ahead.items() if own]
    while waiting:
        name = waiting.pop()
        for earlier in before.get(name, ()):
            if not ahead[name] <= ahead[earlier]:
                ahead[earlier] |= ahead[name]
                waiting.append(earlier)
    return ahead


def _qualified(section: Section, prefix: str) -> Section:
    """The section with its name, and the names in it, behind a prefix; its own routes stay."""
    if not prefix:
        return section
    if isinstance(section, ElementarySection):
        return replace(section, name=prefix + section.name)
    branches = tuple(
        Branch(prefix + branch.name, branch.mandatory, _all_qualified(branch.graph, prefix), branch.source)
        for branch in section.branches
    )
    return replace(section, name=prefix + section.name, branches=branches)


def _all_qualified(graph: ObjectivesGraph, prefix: str) -> ObjectivesGraph:
    names = {section.name for section in (*graph.sections, *graph.unreached)}

    def route(target: str) -> str:
        return prefix + target if target in names else target

    def moved(section: Section) -> Section:
        return replace(
            _qualified(section, prefix),
            success=route(section.success),
            failure=route(section.failure),
            interruptions=tuple(replace(i, target=route(i.target)) for i in section.interruptions),
        )

    sections, unreached = (tuple(map(moved, part)) for part in (graph.sections, graph.unreached))
    return ObjectivesGraph(sections, prefix + graph.entry, unreached)
