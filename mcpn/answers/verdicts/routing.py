"""Where the routes of a mission lead, as far as what really happens takes them.

A route is *taken* if the outcome or the event that it belongs to happens in some state. Objectives to which
no route that is taken leads can never be entered, and the routes that would lead there say why. Where no
route that is taken leads from a success to the success of the mission, though some state in which the
objective runs still reaches that, it leads only to failure. Both look at routes, not at the hardware that is
out of service along them: the analysis is sound, not complete.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import cache, cached_property
from typing import NamedTuple

from mcpn.errors import Problem
from mcpn.events import Event, What
from mcpn.mission.core.copies import Written, grouped
from mcpn.mission.core.objectives_graph import (
    ElementarySection,
    ObjectivesGraph,
    ParallelSection,
    Section,
    failed_for,
)
from mcpn.mission.model import ABORT, FAIL, SUCCEED, TIMED_OUT, Mission
from mcpn.mission.static.warnings import names_of_objectives
from mcpn.sentences import enumeration, shortened

_VERBS = {"success": "succeed", "failure": "fail", "abort": "abort", TIMED_OUT: "time out"}
_EVENTS = {"success": What.SUCCESS, "failure": What.FAILURE, TIMED_OUT: What.TIMEOUT}


class _Route(NamedTuple):
    """A route of a section: by which outcome or declared event, where it leads, whether facts decide it."""

    section: Section
    by: str | Event
    target: str
    by_facts: bool = False


class _Region(NamedTuple):
    """Sections that are never entered, in document order, and the routes that would lead there."""

    sections: list[Section]
    causes: list[_Route]


class _Futile(NamedTuple):
    """A section that leads only to failure by its success.

    Args:
        section: The section.
        ends: The exits that it leads to.
        missing: The routes behind it that would lead to success if they were taken.
    """

    section: Section
    ends: frozenset[str]
    missing: list[_Route]


class Routing:
    """The routes of a mission that are taken.

    Args:
        graph: Its objectives graph.
        entered: The objectives that some state runs.
        happens: The events that some state allows.
        mission: The mission.
        succeeds: Whether the success of the mission is reached from a state that runs one of some objectives.
    """

    def __init__(
        self,
        graph: ObjectivesGraph,
        entered: Collection[str],
        happens: Collection[Event],
        mission: Mission,
        succeeds: Callable[[Collection[str]], bool],
    ) -> None:
        self.graph = graph
        self._mission = mission
        self._copies = graph.copies
        self._entered = entered
        self._happens = happens
        self._happened = {(event.what, event.element, event.reason) for event in happens}
        self._succeeds = succeeds
        self._exits: dict[str, frozenset[str]] = {}
        self._taken: dict[str, frozenset[str]] = {}

    def entered(self, section: Section) -> bool:
        """Whether some state runs the section, or an objective in it."""
        return any(objective.name in self._entered for objective in section.walk())

    def never_entered(self) -> Iterator[Problem]:
        """Objectives, or whole blocks, that routes reach and no run enters, each region with its cause.

        Regions of copies of the same blocks are one.
        """

        def alike(region: _Region) -> object:
            return frozenset(self._copies.written(s.name) for s in region.sections), self._key(region.causes)

        regions = [region for graph in self._graphs(self.graph) for region in self._regions(graph)]
        for same in grouped(regions, alike).values():
            objectives = [o for region in same for section in region.sections for o in section.walk()]
            names = self._whole([objective.name for objective in objectives])
            because = self._because(cause for region in same for cause in region.causes)
            yield Problem(objectives[0].source, f"{names} can never be entered{because}")

    def _regions(self, graph: ObjectivesGraph) -> Iterator[_Region]:
        """Sections that are never entered, with those behind them, and the routes that would lead there."""
        never = {section.name for section in graph.sections if not self.entered(section)}
        into: dict[str, list[_Route]] = {name: [] for name in never}
        for section in graph.sections:
            if section.name not in never:
                for route in _routes(section):
                    if route.target in into:
                        into[route.target].append(route)
        visited = set[str]()
        begins = [s for s in graph.sections if s.name in never and (into[s.name] or s.name == graph.entry)]
        for begin in begins:
            if begin.name in visited:
                continue
            region, queue, causes = list[Section](), [begin.name], list[_Route]()
            while queue:
                name = queue.pop(0)
                if name not in visited:
                    visited.add(name)
                    region.append(graph.section(name))
                    causes += into[name]
                    queue += [target for target in region[-1].routes if target in never]
            yield _Region(_in_text(graph, region), causes)

    def futile(self) -> Iterator[Problem]:
        """Objectives and blocks that may still succeed or fail, and lead only to failure by their success.

        Copies of one are said together.
        """

        def alike(each: _Futile) -> object:
            leads = each.section.success
            to = leads if leads in _ENDS else self._copies.written(leads)
            return (
                _kind(each.section),
                self._copies.written(each.section.name),
                each.ends,
                to,
                self._key(each.missing),
            )

        for same in grouped(self._futile(), alike).values():
            one, missing = same[0], [route for each in same for route in each.missing]
            names = [each.section.name for each in same]
            subject, several = self._copies.subject(_kind(one.section), names, self._every)
            where = " or ".join(word for exit_, word in _ENDS.items() if exit_ in one.ends) or "no end"
            whose = "their" if several else "its"
            if one.section.success in _ENDS:
                cause = f": {whose} success leads to {one.section.success}"
            else:
                successes = shortened(self._copies.told((s.section.success for s in same), self._every))
                cause = self._because(missing) or f": no route leads from {successes} to succeed"
            events = {i.event for each in same for i in each.section.interruptions if i.target not in _ENDS}
            if events and not several:
                cause += f" ({enumeration(sorted(events))} may interrupt it before)"
            leads = "lead" if several else "leads"
            yield Problem(one.section.source, f"{subject} {leads} only to {where} by {whose} success{cause}")

    def _futile(self) -> Iterator[_Futile]:
        hopeful = self._reaching(self.graph, SUCCEED)
        for section in self.graph.sections:
            if section.name not in hopeful or not self.entered(section):
                continue
            led = section.led("success")
            if "success" not in self.taken(section) or hopeful.intersection(led):
                continue
            # Where it cannot succeed in any other way either, its success is not the cause.
            if self._succeeds([objective.name for objective in section.walk()]):
                causes, ends = self._behind(self.graph, led, hopeful)
                yield _Futile(section, frozenset(ends), causes)

    def taken(self, section: Section) -> frozenset[str]:
        """The outcomes of a section that happen."""
        if section.name not in self._taken:
            self._taken[section.name] = self._outcomes_taken(section)
        return self._taken[section.name]

    def _outcomes_taken(self, section: Section) -> frozenset[str]:
        if isinstance(section, ElementarySection):
            known = {outcome: (what, section.name, "") for outcome, what in _EVENTS.items()}
            known |= {to: (What.FAILURE, section.name, why) for why, to in section.failures}
            never = {outcome for outcome, event in known.items() if event not in self._happened}
            return frozenset(outcome for outcome, _ in section.outcomes if outcome not in never)
        ends = [(branch.mandatory, self._ends(branch.name, branch.graph)) for branch in section.branches]
        must = [exits for mandatory, exits in ends if mandatory]
        happen = {
            "success": all(SUCCEED in exits for exits in must) and all({SUCCEED, FAIL} & e for _, e in ends),
            "failure": any(FAIL in exits for exits in must),
            "abort": any(ABORT in exits for _, exits in ends),
            TIMED_OUT: (What.TIMEOUT, section.name, "") in self._happened,
        }
        if section.needed is not None:
            well, badly = (sum(exit_ in exits for _, exits in ends) for exit_ in (SUCCEED, FAIL))
            happen["success"] = well >= section.needed
            happen["failure"] = badly > len(ends) - section.needed or (section.hasty and happen["failure"])
        if section.failing is not None:
            badly, doomed = sum(FAIL in e for _, e in ends), sum(SUCCEED not in e for _, e in ends)
            happen["failure"] |= badly >= section.failing < len(ends)
            happen["success"] &= section.needed is not None or doomed <= section.failing  # the last may fail
        for exit_, _ in section.pause_exits:
            leading = [*_meanwhile(section, exit_)]
            happen[exit_] = not leading or any(map(self._is_taken, leading))
        return frozenset(outcome for outcome, _ in section.outcomes if happen.get(outcome, True))

    def _is_taken(self, route: _Route) -> bool:
        """Whether the outcome or the event of a route happens."""
        return route.by in (self._happens if isinstance(route.by, Event) else self.taken(route.section))

    def _taken_targets(self, section: Section) -> list[str]:
        """The targets of those routes of a section that are taken."""
        targets = list(section.routes)
        taken = self.taken(section)
        for outcome, _ in section.outcomes:
            if outcome not in taken:
                for target in section.led(outcome):
                    targets.remove(target)
        for route in _interrupting(section):
            if not self._is_taken(route):
                targets.remove(route.target)
        return targets

    def _ends(self, branch: str, graph: ObjectivesGraph) -> frozenset[str]:
        """The exits of a branch that routes lead to from its entry."""
        if branch not in self._exits:
            seen = self._reachable(graph, [graph.entry])
            self._exits[branch] = frozenset(seen & {SUCCEED, FAIL, ABORT})
        return self._exits[branch]

    def _reachable(self, graph: ObjectivesGraph, begins: Iterable[str]) -> set[str]:
        """The sections and exits that taken routes lead to from some of them, these included."""
        seen, stack = {*begins}, [*begins]
        inside = {section.name for section in graph.sections}
        while stack:
            if (name := stack.pop()) in inside:
                new = set(self._taken_targets(graph.section(name))) - seen
                seen |= new
                stack.extend(new)
        return seen

    def _reaching(self, graph: ObjectivesGraph, goal: str) -> frozenset[str]:
        """An exit of the graph, and the sections from which routes lead to it."""
        before: dict[str, list[str]] = {}
        for section in graph.sections:
            for target in self._taken_targets(section):
                before.setdefault(target, []).append(section.name)
        seen, stack = {goal}, [goal]
        while stack:
            new = set(before.get(stack.pop(), ())) - seen
            seen |= new
            stack.extend(new)
        return frozenset(seen)

    def _behind(
        self, graph: ObjectivesGraph, begins: Iterable[str], hopeful: Collection[str]
    ) -> tuple[list[_Route], set[str]]:
        """Routes behind sections that would lead to success if they were taken; and the exits reached."""
        seen = self._reachable(graph, begins)
        routes = (r for section in graph.sections if section.name in seen for r in _routes(section))
        missing = [r for r in routes if r.target in hopeful and not isinstance(r.by, Event)]
        return missing, seen & {SUCCEED, FAIL, ABORT}

    @cached_property
    def _every(self) -> list[str]:
        """The names of all sections of the mission, at any depth."""
        return [section.name for section in self.graph.all_sections()]

    def _written(self, route: _Route) -> tuple[str | Event, Written]:
        """A route as it is written, whatever copy it is of."""
        return route.by, self._copies.written(route.section.name)

    def _key(self, routes: Iterable[_Route]) -> frozenset[tuple[str | Event, Written]]:
        """Routes as they are written."""
        return frozenset(map(self._written, routes))

    def _because(self, causes: Iterable[_Route]) -> str:
        """Why routes are not taken; empty where there are none."""
        said = list[str]()

        def alike(route: _Route) -> tuple[object, bool]:
            return self._written(route), route.by_facts and self._is_taken(route)

        for (_, others), same in grouped(causes, alike).items():
            by, kind = same[0].by, _kind(same[0].section)
            subject, several = self._copies.subject(kind, [r.section.name for r in same], self._every)
            if others:
                said.append(f"the facts that {subject} {'ask' if several else 'asks'} for never hold there")
            elif isinstance(by, Event):
                said.append(
                    f"event {by.element} never happens while {subject} {'run' if several else 'runs'}"
                )
            else:
                facts = dict(same[0].section.becoming).get(by)
                verb = _VERBS.get(by) or f"fail for {by.removeprefix(failed_for(''))}"
                if facts is not None:
                    verb = f"be left as {facts.words} becomes true"
                said.append(f"{subject} can never {verb}")
        return f": {shortened(said)}" if said else ""

    def _whole(self, objectives: Sequence[str]) -> str:
        """Objectives by name, those of a whole block by the outermost such block."""
        blocks = self._blocks
        named = {objective: ("objective", objective) for objective in objectives}
        whole = [name for name, held in blocks.items() if len(held) > 1 and named.keys() >= set(held)]
        for block in sorted(whole, key=lambda name: len(blocks[name])):  # the outermost last
            named |= dict.fromkeys(blocks[block], ("block", block))
        every, parts = {"block": [*blocks], "objective": names_of_objectives(self.graph)}, []
        for kind, known in every.items():
            if names := list(dict.fromkeys(name for what, name in named.values() if what == kind)):
                parts.append(self._copies.subject(kind, names, known)[0])
        return " and ".join(parts)

    @cached_property
    def _blocks(self) -> dict[str, tuple[str, ...]]:
        return self._copies.held

    def _graphs(self, graph: ObjectivesGraph) -> Iterator[ObjectivesGraph]:
        """A graph and those of branches that are entered, at any depth."""
        yield graph
        for section in graph.all_sections():
            if isinstance(section, ParallelSection) and self.entered(section):
                yield from section.graphs


_ENDS = {FAIL: "failure", ABORT: "abort"}


def _kind(section: Section) -> str:
    return "objective" if isinstance(section, ElementarySection) else "block"


def _in_text(graph: ObjectivesGraph, sections: Collection[Section]) -> list[Section]:
    """Sections of a graph in document order."""
    wanted = {section.name for section in sections}
    return [section for section in graph.sections if section.name in wanted]


def _routes(section: Section) -> Iterator[_Route]:
    """The routes of a section, those of what runs while it pauses among them."""
    pause_exits = dict(section.pause_exits) if isinstance(section, ParallelSection) else {}
    for outcome, target in section.outcomes:
        if isinstance(section, ParallelSection) and outcome in pause_exits:
            yield from (route._replace(target=target) for route in _meanwhile(section, outcome))
        else:
            yield _Route(section, outcome, target)
        yield from (_Route(section, outcome, case.target, True) for case in section.cases_of(outcome))
    yield from _interrupting(section)


@cache
def _declared(name: str) -> Event:
    """A declared event: one object for all that it interrupts."""
    return Event(What.DECLARED, name)


def _interrupting(section: Section) -> Iterator[_Route]:
    """The routes by which events interrupt a section."""
    for interruption in section.interruptions:
        if interruption.pauses is None:
            event = _declared(interruption.event)
            yield _Route(section, event, interruption.target)
            yield from (_Route(section, event, case.target, True) for case in interruption.cases)


def _meanwhile(section: ParallelSection, exit_: str) -> Iterator[_Route]:
    """The routes by which what runs while a block pauses leads to one of the exits of the block."""
    for pause_graph in section.pause_graphs:
        inside = (route for inner in pause_graph.graph.sections for route in _routes(inner))
        yield from (route for route in inside if route.target == exit_)
        for interruption in pause_graph.interruptions:
            if exit_ in interruption.routes:
                yield _Route(section, Event(What.DECLARED, interruption.event), exit_)
