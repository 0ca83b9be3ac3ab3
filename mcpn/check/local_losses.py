"""Loss functions by composition: a graph for each section, glued where one is left for the next.

Between two sections every activity is stopped and every software resource is gone: all that one hands to the
next is which hardware is out of service. So each section is a mission of its own, with the hardware that it
may use; its loss functions for leaving by success and by failure, worked out on its own alternatives graph,
take the place of those read from the text (:mod:`mcpn.check.availability`), and contention inside a section
counts. Hardware that a section does not use is an element that its functions do not depend on, and is never
enumerated. Sections of one type (equal but for names) share one graph.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mcpn.check.availability import Availability
from mcpn.check.cutsets import Losses, Moment
from mcpn.check.families import ALWAYS, NEVER, Families, Family
from mcpn.check.losing import CriticalEvent, Goal, Outlook
from mcpn.mission.flatten import Branch, ElementarySection, ObjectivesGraph, Section
from mcpn.mission.model import FAIL, SUCCEED, Block, Mission, Objective, Parallel, Recursive, Robot
from mcpn.mission.usage import Usage
from mcpn.net.compose import compose
from mcpn.net.templates import TemplateSet
from mcpn.space.alternatives import DEFAULT_MAX_STATES
from mcpn.space.confluence import direct_with_proof
from mcpn.space.graph import Mask

ENDS = ("OK", "FAIL")


@dataclass(frozen=True)
class LocalSection:
    """A section of the mission on its own graph.

    Args:
        section: The section, or one of the same type.
        losses: Loss functions of its own mission.
    """

    section: Section
    losses: Losses

    @property
    def outlook(self) -> Outlook:
        """The section's chances on its own alternatives graph."""
        return self.losses.outlook

    @cached_property
    def _entries(self) -> Mapping[frozenset[int], int]:
        """The state just after the section is entered, by the hardware that is out of service then."""
        graph, outlook = self.outlook.graph, self.outlook
        edges = np.flatnonzero(outlook.fired("MISSION_EV_START"))
        return {self.losses.out(int(graph.sources[e])): int(graph.targets[e]) for e in edges}

    def after_entry(self, out: frozenset[int]) -> Mask:
        """States after forced runs from the entry with some hardware out of service.

        Args:
            out: Elements; those that the section does not know are left aside.
        """
        return self.losses.after_forced(self._entries[out & frozenset(self.losses.elements)])

    def exits(self, out: frozenset[int]) -> tuple[set[frozenset[int]], set[frozenset[int]]]:
        """What is out of service when forced runs from an entry leave by success, and by failure."""
        seen, found = self.after_entry(out), self.outlook.mission_net
        rest = out - frozenset(self.losses.elements)
        well, badly = (
            {self.losses.out(s) | rest for s in np.flatnonzero(seen & self.outlook.graph.marked(p)).tolist()}
            for p in (found.success, found.failure)
        )
        return well, badly

    @cached_property
    def failure(self) -> Goal:
        """The goal of leaving the section by its failure."""
        outlook = self.outlook
        failed = outlook.graph.marked(outlook.mission_net.failure)
        return Goal("mission", "failure", ~failed, failed, outlook.allowed(True))


class LocalLosses(Availability):
    """Loss functions of a mission from the graphs of its sections.

    Args:
        usage: The mission's static facts.
        templates: The set of templates; the paper's by default.
        max_states: How many stable states the graph of a section may have.

    Raises:
        ConfluenceError: The outcome of a section depends on the interleaving.
        LimitError: A section has too many states.
    """

    def __init__(
        self, usage: Usage, templates: TemplateSet | None = None, max_states: int = DEFAULT_MAX_STATES
    ) -> None:
        super().__init__(usage, Families(len([h for h in usage.mission.hardware if h.faulty])))
        self._templates = templates
        self._max_states = max_states
        self._types: dict[object, LocalSection] = {}
        self.locals: dict[str, LocalSection] = {}
        """The sections that some run enters, by name."""
        entered = [usage.graph.entry]
        for name in entered:  # grows while it is walked
            section = usage.graph.section(name)
            self.locals[name] = self._local(section)
            ways = ((self.succeeding(section), section.success), (self.failing(section), section.failure))
            entered += {
                after: None
                for lost, after in ways
                if lost != ALWAYS and after not in (SUCCEED, FAIL) and after not in entered
            }

    def _local(self, section: Section) -> LocalSection:
        kind = _kind(section)
        if kind not in self._types:
            mission = local_mission(self.usage, section)
            found = compose(mission, self._templates)
            graph = direct_with_proof(found.net, max_states=self._max_states)
            losses = Losses(Outlook(found, graph), self.families, self.hardware)
            self._types[kind] = LocalSection(section, losses)
        return self._types[kind]

    def succeeding(self, section: Section) -> Family:
        """When a section cannot be left by its success; always where no run enters it."""
        local = self.locals.get(section.name)
        if local is None:
            return ALWAYS
        return local.losses.cut_sets(local.outlook.mission, Moment.START)

    def failing(self, section: Section) -> Family:
        """When a section cannot be left by its failure; always where no run enters it."""
        local = self.locals.get(section.name)
        if local is None:
            return ALWAYS
        return local.losses.cut_sets(local.failure, Moment.START)

    @property
    def entered(self) -> list[Section]:
        """The sections that some run enters, in the mission's order."""
        return [section for section in self.usage.graph.sections if section.name in self.locals]

    # --- objectives and moments ------------------------------------------------------------------------

    def objective_at(self, moment: Moment) -> Mapping[str, Family]:
        """Cut sets of each elementary objective in its present run, by its name.

        Args:
            moment: ``ENTRY``, ``WHENEVER`` or ``SOMETIME``.

        Returns:
            Functions of the objectives of sections that some run enters.
        """
        found = {}
        for section in self.entered:
            local = self.locals[section.name]
            for inner, mine in zip(_elementary(local.section), _elementary(section), strict=True):
                goal = local.outlook.objectives[inner.name]
                if moment is Moment.SOMETIME:
                    found[mine.name] = self._at_worst(section, goal)
                else:
                    found[mine.name] = local.losses.cut_sets(goal, moment, inner.name)
        return found

    def mission_at(self, moment: Moment) -> Family:
        """Cut sets of the mission.

        Args:
            moment: ``START``, ``WHENEVER`` or ``SOMETIME``.
        """
        if moment is Moment.START:
            return self.mission
        if moment is Moment.WHENEVER:
            return self.both(self._beyond(section, moment) for section in self.entered)
        return self.either(self._at_worst(section, self.led_on(section)) for section in self.entered)

    def _at_worst(self, section: Section, goal: Goal) -> Family:
        """Sets that lose a goal at the worst moment of a section, entered as forced runs enter it."""
        local, found = self.locals[section.name], NEVER
        begun = goal.running & local.outlook.begun
        for members in self.families.members(self.forced_entries[section.name]):
            out = frozenset(members)
            lost = local.losses.in_some(goal, begun & local.after_entry(out))
            found = self.families.either(found, self.families.both(self.families.all_of(out), lost))
        return found

    @cached_property
    def forced_entries(self) -> Mapping[str, Family]:
        """The minimal sets that are out of service when forced runs enter each section."""
        families = self.families
        found = dict.fromkeys(self.locals, NEVER)
        todo: list[tuple[str, frozenset[int]]] = [(self.usage.graph.entry, frozenset())]
        while todo:
            name, out = todo.pop()
            if families.holds(found[name], out):
                continue
            found[name] = families.either(found[name], families.all_of(out))
            section = self.usage.graph.section(name)
            well, badly = self.locals[name].exits(out)
            for after, sets in ((section.success, well), (section.failure, badly)):
                if after in found:
                    todo += [(after, s) for s in sets if not any(t < s for t in sets)]
        return found

    def mission_entering(self, section: str) -> Family:
        """Cut sets of the mission at the entry of a section of the mission's graph, or at once after it."""
        return self._beyond(self.usage.graph.section(section), Moment.ENTRY)

    def _beyond(self, section: Section, moment: Moment) -> Family:
        """Cut sets of the mission in all states of one section that a moment asks for."""
        local = self.locals[section.name]
        return local.losses.cut_sets(self.led_on(section), moment, local.section.name)

    # --- critical events -------------------------------------------------------------------------------

    def critical_of(self, objective: str) -> list[CriticalEvent]:
        """Critical events of an elementary objective without repairs, on the graph of its section."""
        for section in self.entered:
            local = self.locals[section.name]
            pairs = zip(_elementary(local.section), _elementary(section), strict=True)
            names = {inner.name: mine.name for inner, mine in pairs}
            for inner, mine in names.items():
                if mine == objective:
                    found = local.outlook.critical(local.outlook.objectives[inner], repairs=False)
                    return [_renamed(critical, names) for critical in found]
        return []

    def critical(self) -> list[CriticalEvent]:
        """Critical events of the mission without repairs, section by section.

        A failure of hardware that a section does not use is critical where the loss behind the section's end
        depends on it.
        """
        found: list[CriticalEvent] = []
        for section in self.entered:
            local, goal = self.locals[section.name], self.led_on(section)
            pairs = zip(_elementary(local.section), _elementary(section), strict=True)
            names = {inner.name: mine.name for inner, mine in pairs}
            first = section.name == self.usage.graph.entry
            crossings = self._crossings(
                local, goal, np.ones_like(goal.running) if first else local.outlook.begun
            )
            found += [_renamed(critical, names) for critical in local.outlook.grouped(crossings)]
        return found

    def _crossings(self, local: LocalSection, goal: Goal, where: Mask) -> Iterator[tuple[str, int]]:
        outlook, graph, families = local.outlook, local.outlook.graph, self.families
        functions, here = local.losses.functions(goal), frozenset(local.losses.elements)
        # What is lost in each state, as a function of the hardware that the section does not know.
        lost = [families.assuming(loss, local.losses.out(s)) for s, loss in enumerate(functions)]
        lost = [families.inside(loss, frozenset(range(families.elements)) - here) for loss in lost]
        chance = [open_ and lost[s] != ALWAYS for s, open_ in enumerate((goal.running & where).tolist())]
        for edge in np.flatnonzero(outlook.allowed(False)).tolist():
            before, after = int(graph.sources[edge]), int(graph.targets[edge])
            if chance[before] and families.either(lost[before], lost[after]) != lost[before]:
                event = graph.net.transitions[int(graph.labels[edge])].event
                assert event is not None, "only events label the alternatives graph"
                yield event, before
        for state in np.flatnonzero(chance).tolist():
            for h in families.support(lost[state]):
                yield f"{self.hardware[h]}_EV_OOS", state

    def led_on(self, section: Section) -> Goal:
        """The mission's success as a goal on the graph of one section, its ends told what comes behind."""
        local = self.locals[section.name]
        outlook = local.outlook
        success, failure = (
            outlook.graph.marked(p) for p in (outlook.mission_net.success, outlook.mission_net.failure)
        )
        ended = success | failure
        # A mission that has failed is lost, as on the whole graph; one that has gone on is told of behind.
        failed = failure if section.failure == FAIL else np.zeros_like(ended)
        failed = failed | success if section.success == FAIL else failed
        goal = Goal("mission", f"beyond {section.name}", ~ended | failed, ended, outlook.allowed(True))
        behind = {SUCCEED: NEVER, FAIL: ALWAYS, **self.mission_from}
        local.losses.lead_on(goal, [(success, behind[section.success]), (failure, behind[section.failure])])
        return goal


def _renamed(critical: CriticalEvent, names: Mapping[str, str]) -> CriticalEvent:
    """The same for another section of the type."""
    events = {
        f"OBJ_{inner}_EV_{end}": f"OBJ_{mine}_EV_{end}" for inner, mine in names.items() for end in ENDS
    }
    return replace(
        critical,
        event=events.get(critical.event, critical.event),
        objectives=tuple(names[name] for name in critical.objectives),
    )


def _elementary(section: Section) -> Iterator[ElementarySection]:
    yield from ObjectivesGraph((section,), section.name).walk()


def _kind(section: Section) -> object:
    """What sections of one type have in common: everything but names and what lies outside."""
    if isinstance(section, ElementarySection):
        return section.activities
    return tuple((branch.mandatory, _shape(branch.graph)) for branch in section.branches)


def _shape(graph: ObjectivesGraph) -> object:
    numbers: dict[str, object] = {section.name: number for number, section in enumerate(graph.sections)}
    numbers |= {SUCCEED: SUCCEED, FAIL: FAIL}
    inner = tuple((_kind(s), numbers[s.success], numbers[s.failure]) for s in graph.sections)
    return numbers[graph.entry], inner


# --- the mission of a section --------------------------------------------------------------------------


def local_mission(usage: Usage, section: Section) -> Mission:
    """A mission of one section alone, with the resources and activities that it may use.

    Args:
        usage: Static facts of the whole mission.
        section: A section of its objectives graph.

    Returns:
        A mission whose objectives graph is that section, led to success by its success, else to failure.
    """
    activities = [a for inner in _elementary(section) for a in inner.activities]
    closure = frozenset[str]().union(*(usage.closure(a) for a in activities))
    kept = [a for a in usage.mission.activities if a.name in closure]
    consumed = {k for a in kept for alternative in a.alternatives for k in alternative.consumes}
    produced = {k for a in kept for k in a.produces}
    robot = Robot(
        name=usage.mission.name,
        hardware=tuple(h for h in usage.mission.hardware if h.name in consumed),
        software=tuple(s for s in usage.mission.software if s.name in produced),
        activities=tuple(kept),
    )
    return Mission(
        name=usage.mission.name, blocks=(_block(section),), robots=(robot,), source=usage.mission.source
    )


def _block(section: Section) -> Block:
    if isinstance(section, ElementarySection):
        return Objective(
            name=section.name,
            activities=section.activities,
            source=section.source,
            duration=section.duration,
            failure_probability=section.failure_probability,
        )
    return Parallel(
        name=section.name, blocks=tuple(_child(b) for b in section.branches), source=section.source
    )


def _child(branch: Branch) -> Block:
    """A branch as a block again: its entry first, every route said."""
    graph = branch.graph
    (alone,) = graph.sections if len(graph.sections) == 1 else (None,)
    if isinstance(alone, ElementarySection) and alone.name == branch.name:
        routes = (alone.success, alone.failure)
        if routes == (SUCCEED, FAIL):
            return replace(_block(alone), mandatory=branch.mandatory)
    first = sorted(graph.sections, key=lambda s: s.name != graph.entry)
    blocks = tuple(replace(_block(s), success=s.success, failure=s.failure) for s in first)
    return Recursive(name=branch.name, blocks=blocks, mandatory=branch.mandatory, source=branch.source)
