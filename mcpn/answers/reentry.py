"""Blocks that a single event may end and enter again: runs of their objectives end, and new runs begin.

No state lies between the end and the new entry, and one transition may stay inside the block from one state
and end the block from another. The target state tells the two apart: where the block has been entered again,
every branch is at its first section.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, reduce
from operator import and_
from typing import Generic, NamedTuple, TypeAlias

from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError
from mcpn.events import What
from mcpn.mission.core.objectives_graph import (
    Branch,
    ElementarySection,
    ObjectivesGraph,
    ParallelSection,
    Section,
    failed_for,
    names_in,
)
from mcpn.mission.core.routes import GO_ON
from mcpn.mission.model import ABORT, FAIL, SUCCEED, TIMED_OUT
from mcpn.mission.static.handover import entries
from mcpn.spaces.algebra import S, Space


class _Level(NamedTuple):
    """An objectives graph, and the block and branch that it belongs to; ``None`` for the mission's own.

    What runs while a block pauses belongs to no branch of it.
    """

    graph: ObjectivesGraph
    block: ParallelSection | None = None
    branch: Branch | None = None


_Ancestors: TypeAlias = tuple[_Level, ...]
"""The level in which a section stands, and those around it, the innermost first."""

_Move: TypeAlias = tuple[int, str]
"""The number of levels from the mission inwards, and the section that is entered there."""

_OUTCOMES = {What.SUCCESS: "success", What.FAILURE: "failure", What.TIMEOUT: TIMED_OUT}


def blocks_entered_again(graph: ObjectivesGraph) -> list[ParallelSection]:
    """Blocks that one event may end while they run, and enter again.

    Args:
        graph: The objectives graph of a mission, or of a section alone.
    """
    return list({block.name: block for block in _entered_again(graph, ())}.values())


def _entered_again(graph: ObjectivesGraph, around: tuple[ParallelSection, ...]) -> Iterator[ParallelSection]:
    """Such blocks in a graph, and such blocks around it, which are given from the innermost outwards."""
    for block in graph.sections:
        if not isinstance(block, ParallelSection):
            continue
        early = {outcome for outcome, _ in (*block.deciding, *block.pause_exits, *block.becoming)}
        routes = {route for outcome in early for route in block.led(outcome)}
        for outer, further in zip((block, *around), (*around, None), strict=True):
            if outer.name in routes:
                yield outer
            left = further is not None and not routes.isdisjoint((SUCCEED, FAIL, ABORT))
            routes = set() if further is None or not left else _targets(further)
        for inner in block.graphs:
            yield from _entered_again(inner, (block, *around))


def _targets(block: ParallelSection) -> set[str]:
    """The sections and exits that the outcomes of a block lead to."""
    return {route for outcome, _ in block.outcomes for route in block.led(outcome)}


def _levels(graph: ObjectivesGraph, around: _Ancestors = ()) -> Iterator[tuple[Section, _Ancestors]]:
    """Every section of a graph at any depth, with the levels around it."""
    levels = around or (_Level(graph),)
    for section in graph.sections:
        yield section, levels
        if isinstance(section, ParallelSection):
            for branch in section.branches:
                yield from _levels(branch.graph, (_Level(branch.graph, section, branch), *levels))
            for pause_graph in section.pause_graphs:
                yield from _levels(pause_graph.graph, (_Level(pause_graph.graph, section), *levels))


def _moves(levels: _Ancestors, routes: Iterable[str]) -> Iterator[_Move]:
    """The sections that may be entered when a section is left by routes, which may end blocks around it."""
    (graph, block, branch), *outer = levels
    inside = {section.name for section in graph.sections}
    for route in dict.fromkeys(routes):
        if route in inside:
            yield len(levels), route
        elif block is not None and branch is None:
            if route == GO_ON:
                yield len(outer), GO_ON
            else:
                yield from _moves(tuple(outer), block.led(route))
        elif block is not None and branch is not None:
            ended = _ended(block, branch, route)
            yield from _moves(tuple(outer), (to for outcome in ended for to in block.led(outcome)))


def _ended(block: ParallelSection, branch: Branch, route: str) -> tuple[str, ...]:
    """The outcomes that a block may have when a branch ends it by one of its exits."""
    if route == ABORT:
        return ("abort",)
    if route == SUCCEED:
        return ("success",) if block.needed == 1 else ("success", "failure")
    return ("failure",) if block.needed is not None or branch.mandatory else ("success", "failure")


def _stays_at_entry(levels: _Ancestors, moves: Collection[_Move], block: ParallelSection) -> bool:
    """Whether some move within a block may lead to where its branches begin."""
    inside = levels[
        : next(i for i, level in enumerate(levels) if level.block and level.block.name == block.name) + 1
    ]
    if any(name == GO_ON for _, name in moves):
        return True
    for number, level in enumerate(inside):
        begins = (len(levels) - number, level.graph.entry) in moves
        above = zip(inside[number:], inside[number + 1 :], strict=False)
        if begins and all(
            inner.block is not None and inner.block.name == outer.graph.entry for inner, outer in above
        ):
            return True
    return False


class Reentry(Generic[S]):
    """Edges of a space with which blocks are entered again that have run before.

    Args:
        mission_net: The mission's net, that of the space.
        space: Its alternatives graph.
    """

    def __init__(self, mission_net: MissionNet, space: Space[S]) -> None:
        self.mission_net = mission_net
        self.space = space
        self.blocks = {block.name: block for block in blocks_entered_again(mission_net.graph)}
        self._before_reentry = self._states_before_reentry() if self.blocks else {}

    def ending(self, objective: str, running: S) -> Mapping[int, S]:
        """By transition, the states before edges that end a run of an objective and begin another.

        Args:
            objective: Its name.
            running: The states in which it runs.
        """
        found: dict[int, S] = {}
        for section in self._left_by_facts:
            if any(inner.name == objective for inner in section.walk()):
                for t, so in self._becoming[section.name]:
                    if states := so & running:
                        found[t] = found[t] | states if t in found else states
        for name, block in self.blocks.items():
            if any(inner.name == objective for inner in block.walk()):
                for t, before in self._before_reentry[name].items():
                    if states := before & running:
                        found[t] = found[t] | states if t in found else states
        return found

    def entered(self, section: Section, running: S) -> S:
        """The states at the entry of a section that are entered by ending its former run.

        Args:
            section: An objective in a block, or a block.
            running: The states in which it runs.
        """
        found = self.space.nothing
        leading = self.ending(section.name, running)
        if section.name in self.blocks:
            leading = {t: before & running for t, before in self._before_reentry[section.name].items()}
        for t, before in leading.items():
            found = found | self.space.after(before, [t])
        for block in self._left_by_facts:
            if section.name in names_in(block) and not isinstance(section, ElementarySection):
                for t, so in self._becoming[block.name]:
                    found = found | self.space.after(so & running, [t])
        return found

    @cached_property
    def _left_by_facts(self) -> list[Section]:
        """Sections that are left when facts become so."""
        return [section for section in self.mission_net.graph.all_sections() if section.becomes]

    @cached_property
    def _becoming(self) -> Mapping[str, Sequence[tuple[int, S]]]:
        """By section, transitions by which facts become so that it is left, each with the states before.

        Facts that a condition asks for are changed by events alone, so that the transition of the event says
        what they become.
        """
        found: dict[str, list[tuple[int, S]]] = {section.name: [] for section in self._left_by_facts}
        for t, _ in self.mission_net.net.events.pairs if found else ():
            for section, _, places, begun in self._beginning(t):
                found[section.name].append((t, self._holding(places - begun)))
        return found

    def _beginning(self, t: int) -> Iterator[tuple[Section, str, set[int], set[int]]]:
        """Sections that a transition may leave as it changes facts.

        Yields:
            A section, the outcome that this is, the places of all that its condition asks for, and those of
            them that the transition marks.
        """
        by_role = self.mission_net.by_role
        marked = {place for place, _ in self.mission_net.net.transitions[t].produce}
        for section in self._left_by_facts:
            for outcome, each in section.becoming:
                places = {by_role["fact", f"{fact}={value}"][0] for fact, value in each.when}
                if begun := places & marked:
                    yield section, outcome, places, begun

    def _holding(self, places: Iterable[int]) -> S:
        """States in which some places are all marked."""
        return reduce(and_, (self.space.marked([place]) for place in places), self.space.everything)

    def _states_before_reentry(self) -> dict[str, dict[int, S]]:
        """By block and transition, the states before edges that enter the block again."""
        levels = {section.name: (section, around) for section, around in _levels(self.mission_net.graph)}
        leading = defaultdict[str, dict[int, S]](dict)
        begun = {name: self._begun(block) for name, block in self.blocks.items()}
        for t, left in self._left(levels):
            for name, block in self.blocks.items():
                inside = [(around, moves) for around, moves in left if _is_in(around, block)]
                depth = len(levels[name][1])
                if not any((depth, name) in moves for _, moves in inside):
                    continue
                if any(_stays_at_entry(around, moves, block) for around, moves in inside):
                    event = self.mission_net.net.transitions[t].event
                    at = f"{block.source}: " if block.source else ""
                    raise LimitError(
                        f"{at}{event} may lead back into {name} at once, or to the beginning of a branch in "
                        "it: causes and numbers of risk cannot tell one run of its objectives from the next; "
                        "put an objective between"
                    )
                leading[name][t] = self.space.before(begun[name], [t])
        return leading

    def _begun(self, block: ParallelSection) -> S:
        """States in which every branch of a block is where it begins."""
        by_role, found = self.mission_net.by_role, self.space.everything
        for first in entries(block):
            places = [p for kind in ("objective", "pending") for p in by_role.get((kind, first.name), ())]
            found = found & self.space.marked(places)
        return found

    def _left(
        self, levels: Mapping[str, tuple[Section, _Ancestors]]
    ) -> Iterator[tuple[int, list[tuple[_Ancestors, set[_Move]]]]]:
        """By transition, the sections that it may leave: the levels around each, and its moves."""
        net = self.mission_net.net
        for t, event in net.events.pairs:
            by_facts = list[tuple[_Ancestors, set[_Move]]]()
            for section, outcome, *_ in self._beginning(t):
                around = levels[section.name][1]
                by_facts.append((around, set(_moves(around, section.led(outcome)))))
            if event.what in _OUTCOMES and event.element in levels:
                section, around = levels[event.element]
                outcome = failed_for(event.reason) if event.reason else _OUTCOMES[event.what]
                yield t, [(around, set(_moves(around, section.led(outcome)))), *by_facts]
            elif event.what is What.DECLARED:
                origins = (net.places[place].provenance for place, _ in net.transitions[t].consume)
                names = {o.name for o in origins if o is not None and o.kind in ("objective", "parallel")}
                left = list[tuple[_Ancestors, set[_Move]]]()
                for section, around in (levels[name] for name in names if name in levels):
                    handled = (i for i in section.every_interruption if i.event == event.element)
                    pause_exits = dict(section.pause_exits) if isinstance(section, ParallelSection) else {}
                    routes = (pause_exits.get(to, to) for i in handled for to in i.routes)
                    left.append((around, set(_moves(around, routes))))
                yield t, [*left, *by_facts]


def _is_in(around: _Ancestors, block: ParallelSection) -> bool:
    """Whether a section with some levels around it stands in a block."""
    return any(level.block is not None and level.block.name == block.name for level in around)
