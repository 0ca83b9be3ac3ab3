"""What a mission does while nothing fails: whether every such run succeeds, and what all of them leave out.

A run is *nominal* if no hardware is lost, no objective fails, no declared event happens and no time is over:
after the start objectives succeed, in any order, and that is all. Hardware that is out of service at first
has come back before it, where it can be repaired. Nominal runs are the paths of the space along the
transitions of the start and of successes, so every engine decides by one formula: no state in which they end
but success is reached, and no cycle of them but in a block that is meant to be endless.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence, Set
from functools import cached_property
from itertools import chain
from typing import Generic, NamedTuple

from mcpn.answers.verdicts.as_written import helpers_of
from mcpn.answers.verdicts.unreachable import objectives_run
from mcpn.drawing.compose import MissionNet
from mcpn.events import Event, What
from mcpn.mission.core.objectives_graph import ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.model import ABORT, FAIL, SUCCEED, WHOLE
from mcpn.mission.static.warnings import names_of_objectives
from mcpn.nets.petri import Marking
from mcpn.sentences import enumeration, shortened
from mcpn.spaces.algebra import Edge, S, Space
from mcpn.spaces.run import Run, transitions_of

MOST_READ = 200
"""Most objectives of a mission whose nominal run is looked for: nobody reads a longer one."""
LONGEST = 2_000
"""Most events of a loop that are followed one by one."""
MOST_TOLD = 6
"""Objectives of a loop that a sentence names."""

ENDLESS = (
    '; by default success leads to the next block: the block after which all is done says success="succeed"; '
    'where the loop is meant, a block of it says nominal="endless"'
)
HELD = "; it ends where {} happens, and no declared event does while nothing fails"
"""What is said of a loop that goes on until an event changes a fact: it waits."""
UNKNOWN = (
    "; supposed is the success of {}, of which nobody has said how it ends while nothing fails: "
    'write nominal="entered" on it if by success, nominal="fails" if by failure'
)
"""What is said of conditions, whose success may be no good news."""
OPTIONAL = '; where that is meant, write nominal="optional" on the block'
WAITS = '; where the mission is to wait for it, a block of the loop says nominal="endless"'
"""What an author writes who means what a nominal run does."""


class Nominal(NamedTuple):
    """What nominal runs do.

    Args:
        holds: Whether all of them succeed, and enter every objective that they are meant to enter; ``None``
            where that depends on what nobody has said.
        explanation: One sentence.
        run: A run that succeeds; or one that does not, if there is one.
        cycle: Index of the event of the run with which a loop begins, where it goes on for ever.
        left_out: Objectives that no nominal run enters, and that no text says may be left out.
        kind: The kind of claim that says it, where that is not its success.
        given: What it takes besides that nothing fails, in words.
    """

    holds: bool | None
    explanation: str
    run: Run | None = None
    cycle: int | None = None
    left_out: tuple[str, ...] = ()
    kind: str = ""
    given: tuple[str, ...] = ()


def nominal_transitions(mission_net: MissionNet) -> list[int]:
    """The transitions of nominal runs: internal ones, the start, successes, and failures that are meant."""
    failing = mission_net.graph.copies.meant_as("fails")

    def as_meant(event: Event) -> bool:
        end = What.FAILURE if event.element in failing else What.SUCCESS
        return event.what in (What.START, end)

    events = mission_net.net.events
    return sorted((*events.internal, *events.of(*filter(as_meant, events))))


class NominalRuns(Generic[S]):
    """The nominal runs of a mission, as paths of a space.

    Args:
        mission_net: The mission's net.
        space: Its alternatives graph, or its markings graph.
        settles: Whether it is the alternatives graph.

    Attributes:
        transitions: What they fire.
        begin: Where they begin.
        reached: Where they lead.
    """

    def __init__(self, mission_net: MissionNet, space: Space[S], *, settles: bool) -> None:
        self.mission_net, self.space, self.settles = mission_net, space, settles
        self.transitions = frozenset(nominal_transitions(mission_net))
        hardware = mission_net.core.hardware
        self._out = [h.name for h in hardware if h.initial == "oos" and h.repairable]
        self.begin, self._repairs = space.initial, self._repairing(self._out)
        if self._out:
            self.begin = self._with_repaired(self._out)
        self.reached = space.reached(self.begin, transitions=self.transitions)

    def _repairing(self, names: Collection[str]) -> frozenset[int]:
        """The transitions with which some hardware comes back; none where nothing is out of service."""
        events = self.mission_net.net.events
        repairs = (events.of_element(What.REPAIRED, name) for name in names)
        return frozenset(chain(events.internal, *repairs)) if names else frozenset()

    def _with_repaired(self, names: Collection[str]) -> S:
        """The states before the start in which some hardware has come back, and no other."""
        space, out = self.space, [p for name in names for p in self.mission_net.by_role["oos", name]]
        back = space.reached(space.initial, transitions=self._repairing(names)) & space.stable
        return space.restricted(back, (), out)

    def _needed_repairs(self) -> list[str]:
        """The hardware that is out of service at first, and without which these runs are not as meant."""
        if not self._out or not self._goes_wrong(self.space.initial):
            return []
        alone = [
            name
            for name in self._out
            if self._goes_wrong(self._with_repaired([other for other in self._out if other != name]))
        ]
        return alone or self._out

    def _goes_wrong(self, begin: S) -> bool:
        ends, circling = self._unsuccessful(self.space.reached(begin, transitions=self.transitions))
        return bool(ends or circling)

    def _unsuccessful(self, reached: S) -> tuple[S, S]:
        """Of states that these runs reach: the ends that are no success, and those of unmeant loops."""
        unfinished = reached - self.space.marked([self.mission_net.success])
        ends = unfinished - self.space.enabling(self.transitions)
        lasting = unfinished - ends
        within = lasting - self.space.marked(self._endless) if self._endless else lasting
        return ends, self.space.staying(within, transitions=self.transitions)

    @cached_property
    def _endless(self) -> list[int]:
        """The places of what may go on for ever."""
        meant = self.mission_net.graph.copies.meant_as("endless")
        return [place for place, name in self.mission_net.saying("objective").items() if name in meant]

    def succeeding(self, success: S) -> Run | None:
        """A short run to success; ``None`` where there is none, or the mission is long.

        Hardware that is out of service at first comes back on it only where success needs that.

        Args:
            success: The states in which it has succeeded.
        """
        if sum(1 for _ in self.mission_net.graph.walk()) > MOST_READ or not self.reached & success:
            return None
        if self._repairs:
            run = self.space.run(self.space.initial.pick(), success, transitions=self.transitions)
            if run is not None:
                return self._shown(run)
        return self._shown(self._run_to(success))

    def decided(self) -> Nominal:
        """Whether every one succeeds, and all together enter what they are meant to enter."""
        space, copies = self.space, self.mission_net.graph.copies
        success = space.marked([self.mission_net.success])
        ends, circling = self._unsuccessful(self.reached)
        run, cycle, said = None, None, list[str]()
        if ends:
            edges = self._run_to(ends)
            run = self._shown(edges)
            said.append(self._how_it_ends(edges))
        elif circling:
            edges, first = self._lasso(circling)
            run, cycle = self._shown(edges), len(self._events(edges[:first]))
            around = [event.element for event in self._events(edges[first:])]
            said.append(f"goes on for ever: {shortened(around, MOST_TOLD)}, and so on")
        else:
            run = self.succeeding(success)
        left_out, supposed = self._left_out(), self._supposed()
        if left_out:
            told = copies.told(left_out, names_of_objectives(self.mission_net.graph))
            said.append(f"never enters {shortened(told)}")
        if not said:
            lasting = self.reached - success
            lasts = bool(self._endless and space.staying(lasting, transitions=self.transitions))
            explanation = f"while nothing fails every run succeeds, and {self._nothing_left_out()}"
            if lasts:
                explanation = f"{explanation}; it may go on for ever in a block that is meant to be endless"
            explanation += UNKNOWN.format(enumeration(supposed)) if supposed else ""
            given = tuple(self._given(supposed))
            kind = "" if not lasts else "nominal_either" if self.reached & success else "nominal_endless"
            return Nominal(True, explanation, run, kind=kind, given=given)
        explanation = f"while nothing fails the mission {' and '.join(said)}"
        if cycle is not None and (awaited := self._awaited(circling, success)):
            explanation += f"{HELD.format(enumeration(awaited))}{WAITS}"
        elif not ends:
            explanation += ENDLESS if cycle is not None else OPTIONAL
        explanation += UNKNOWN.format(enumeration(supposed)) if supposed else ""
        return Nominal(None if supposed else False, explanation, run, cycle, left_out)

    def _supposed(self) -> list[str]:
        """The objectives that these runs enter, and of which nobody has said how they end then."""
        unknown = self.mission_net.graph.copies.meant_as("unknown")
        if not unknown:
            return []
        entered = objectives_run(self.mission_net, self.space, self.reached) & unknown
        names = (name for name in names_of_objectives(self.mission_net.graph) if name in entered)
        return self.mission_net.graph.copies.told(names, names_of_objectives(self.mission_net.graph))

    def _given(self, supposed: list[str]) -> Iterator[str]:
        """What these runs need besides that nothing fails."""
        if repaired := self._needed_repairs():
            yield f"once {enumeration(repaired)} work{'s' * (len(repaired) == 1)} again"
        if supposed:
            yield f"{shortened(supposed, MOST_TOLD)} succeed{'s' * (len(supposed) == 1)}"

    def _awaited(self, circling: S, success: S) -> list[str]:
        """The declared events that change facts on a way from a loop to success; none where none does."""
        changing = {Event(What.DECLARED, e.name) for e in self.mission_net.core.events if e.changes_facts}
        awaited = self.space.net.events.of(*changing)
        if not awaited:
            return []
        run = self.space.run(circling.pick(), success, transitions=self.transitions.union(awaited))
        happened = (event.element for event in self._events(run or ()) if event in changing)
        return list(dict.fromkeys(happened))

    def _nothing_left_out(self) -> str:
        """That these runs enter what they are meant to; blocks that may be left out, and are, by name."""
        graph = self.mission_net.graph
        optional = graph.copies.meant_as("optional")
        left = [name for name in self._not_entered if name in optional]
        if not left:
            return "nothing is left out"
        told = graph.copies.told(left, names_of_objectives(graph))
        return f"nothing is left out but {shortened(told)}, which may be"

    def _left_out(self) -> tuple[str, ...]:
        """Objectives that none of them enters, and that are meant to be entered."""
        optional = self.mission_net.graph.copies.meant_as("optional")
        return tuple(name for name in self._not_entered if name not in optional)

    @cached_property
    def _not_entered(self) -> list[str]:
        """Those that are meant to be entered, optional ones among them, and that none of them enters."""
        entered = objectives_run(self.mission_net, self.space, self.reached)
        return [name for name in meant_to_be_entered(self.mission_net) if name not in entered]

    def _events(self, edges: Sequence[Edge]) -> list[Event]:
        events = (self.space.net.transitions[edge.transition].event for edge in edges)
        return [event for event in events if event is not None]

    def _shown(self, edges: Sequence[Edge]) -> Run:
        return Run(self.space.net, transitions_of(edges), settles=self.settles)

    def _run_to(self, goal: S) -> list[Edge]:
        """A short run into a goal that some of them reach."""
        first = self.space.initial.pick()
        run = self._path(first, self.begin, self._repairs) if self._repairs else []
        at = run[-1].target if run else first
        return [*run, *self._path(at, goal, self.transitions, along=self.reached)]

    def _path(
        self, start: object, goal: S, transitions: Collection[int], along: S | None = None
    ) -> list[Edge]:
        run = self.space.run(start, goal, along, transitions)
        assert run is not None, "it is reached"
        return run

    def _lasso(self, circling: S) -> tuple[list[Edge], int]:
        """A run that goes on for ever in some states, and after how many edges its loop begins.

        Args:
            circling: States that each have a next one among them.
        """
        run = self._run_to(circling)
        here = run[-1].target if run else self.space.initial.pick()
        seen: dict[Marking, int] = {}
        while (marking := self.space.marking(here)) not in seen and len(seen) < LONGEST:
            seen[marking] = len(run)
            run.append(next(edge for edge in self.space.edges(here) if self._leads(edge, circling)))
            here = run[-1].target
        return run, seen.get(marking, 0)

    def _leads(self, edge: Edge, into: S) -> bool:
        return edge.transition in self.transitions and bool(self.space.single(edge.target) & into)

    def _how_it_ends(self, run: Sequence[Edge]) -> str:
        """How a run ends that does not succeed."""
        marking = self.space.marking(run[-1].target if run else self.space.initial.pick())
        for end, place in self.mission_net.ends.items():
            if marking[place]:
                return f"ends in {end}"
        running = [name for place, name in self.mission_net.saying("objective").items() if marking[place]]
        if not running:
            return "reaches a state in which nothing can succeed"
        return f"reaches a state in which {enumeration(running)} cannot succeed"


def meant_to_be_entered(mission_net: MissionNet) -> Iterator[str]:
    """The objectives that routes of success lead to, and those that no route leads to.

    What a failure, an abort, a timeout, an event or a fact leads to is a helper, which may be left out. So
    may what successes of helpers alone lead to.
    """
    graph, copies = mission_net.graph, mission_net.graph.copies
    helpers, failing = frozenset(helpers_of(mission_net.mission)), copies.meant_as("fails")

    def helps(section: Section) -> bool:
        return all(copies.around(leaf.name) & helpers for leaf in section.walk())

    def meant(graph: ObjectivesGraph) -> Iterator[str]:
        left = (section for section in _unled(graph) if not helps(section))
        for section in (*_on_the_way(graph, failing), *left):
            if isinstance(section, ElementarySection):
                yield section.name
            else:
                for branch in section.branches:
                    yield from meant(branch.graph)

    return meant(graph)


def _series(section: Section) -> ObjectivesGraph | None:
    """What stands one after the other in a section that is stopped as a whole, and is no level of its own."""
    if isinstance(section, ParallelSection) and len(section.branches) == 1:
        branch = section.branches[0]
        return branch.graph if branch.name.endswith(WHOLE) else None
    return None


def _on_the_way(graph: ObjectivesGraph, failing: Set[str]) -> Iterator[Section]:
    """The objectives and parallel blocks of a level that successes lead to from its first one."""
    wanted = _way_of_successes(graph, failing)
    for section in graph.sections:
        if section.name in wanted:
            series = _series(section)
            yield from [section] if series is None else _on_the_way(series, failing)


def _unled(graph: ObjectivesGraph, *, led: bool = True) -> Iterator[Section]:
    """The objectives and parallel blocks of a level that no route leads to.

    Args:
        graph: The level.
        led: Whether some route leads to its first one.
    """
    reached = _led_to(graph) if led else ()
    for section in (*graph.sections, *graph.unreached):
        led_to, series = section.name in reached, _series(section)
        if series is not None:
            yield from _unled(series, led=led_to)
        elif not led_to:
            yield section


def _led_to(graph: ObjectivesGraph) -> set[str]:
    """The sections that routes lead to from the first one, and the exits, as they are written.

    A series fails, say, only where a route in it leads to its failure.
    """
    sections = {section.name: section for section in graph.sections}
    reached, stack = set[str](), [graph.entry]
    while stack:
        name = stack.pop()
        if name not in reached:
            reached.add(name)
            stack += _leads_to(sections[name]) if name in sections else ()
    return reached


def _leads_to(section: Section) -> Iterator[str]:
    """Where a section may lead: by its ends, and on events."""
    series, ways = _series(section), {"success": SUCCEED, "failure": FAIL, "abort": ABORT}
    exits = {*ways.values()} if series is None else _led_to(series)
    for end, _ in section.outcomes:
        if end not in ways or ways[end] in exits:
            yield from section.led(end)
    for interruption in section.interruptions:
        yield from interruption.routes


def _way_of_successes(graph: ObjectivesGraph, failing: Set[str]) -> set[str]:
    """The sections that successes lead to, and the exits; what facts choose after one is a helper."""
    sections = {section.name: section for section in graph.sections}
    wanted, stack = set[str](), [graph.entry]
    while stack:
        name = stack.pop()
        if name not in wanted:
            wanted.add(name)
            stack += _led_as_meant(sections[name], failing) if name in sections else ()
    return wanted


def _led_as_meant(section: Section, failing: Set[str]) -> Iterator[str]:
    """Where a section leads while all in it ends as it is meant to."""
    if isinstance(section, ElementarySection):
        ends = {"failure" if section.name in failing else "success"}
    elif (series := _series(section)) is not None:
        # Routes inside may lead out by a failure that is meant.
        said = {SUCCEED: "success", FAIL: "failure", ABORT: "abort"}
        ends = {said[exit_] for exit_ in _way_of_successes(series, failing) & {*said}}
    else:
        ends = {"success"}
    for end, target in section.outcomes:
        if end in ends and not section.cases_of(end):
            yield target
