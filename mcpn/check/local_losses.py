"""Loss functions by composition: those of each section, glued where one is left for the next.

Between two sections every activity is stopped and every software resource is gone: all that one hands to the
next is which hardware is out of service (:mod:`mcpn.space.local` checks it). So the functions of each section
for leaving by success and by failure, worked out on its local graph, take the place of those read from the
mission's text (:mod:`mcpn.check.availability`), and contention inside a section counts.

Where nothing contends, a set that stays out of service may be taken to be all that is out when the next
section is entered: whatever else is out could have been repaired before. Where something does, an activity
may even need a resource to be out of service, so that functions go by the hardware out at each entry.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np

from mcpn.check.availability import Availability, entered
from mcpn.check.cutsets import Moment
from mcpn.check.families import ALWAYS, NEVER, Family
from mcpn.check.large_sections import BlockSection, critical_in_diagram, section_by_text
from mcpn.check.local_sections import Behind, GraphSection, Out, SectionLosses
from mcpn.check.losing import CriticalEvent
from mcpn.errors import LimitError
from mcpn.mission.flatten import ElementarySection, ObjectivesGraph, Section
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.mission.usage import Usage
from mcpn.net.sections import section_part
from mcpn.net.templates import TemplateSet
from mcpn.space.local.composite import ENDS, Composite
from mcpn.space.local.diagram import LocalDiagram
from mcpn.space.local.gluing import glue, judged_everywhere
from mcpn.space.local.interface import HardwareStates
from mcpn.space.local.placing import MOST_LISTED, Making, PlacedSection
from mcpn.space.local.protocol import OUTCOMES, Outcome

DEFAULT_LOCAL_STATES = 1_000_000
TEXT_BEYOND = 10
"""Hardware of an objective beyond which its text is asked, where nothing contends, and no graph is made."""
MAX_FAULTY = 16
"""Hardware of a section beyond which no graph is made: it would list two to this power of entries."""
MAX_CONTENDED = 10
"""Hardware up to which sets are gone through one by one where resources contend."""


class LocalLosses(Availability):
    """Loss functions of a mission from its sections.

    Args:
        usage: The mission's static facts.
        templates: The set of templates; the paper's by default.
        max_states: How many stable states a local graph may have.
        executor: Where local graphs are made; in this process by default.

    Raises:
        PremiseError: A section hands on more than the state of its hardware.
        ConfluenceError: The outcome of a section depends on the interleaving.
        LimitError: A local graph has too many states, or a section too much hardware and contention besides.
    """

    def __init__(
        self,
        usage: Usage,
        templates: TemplateSet | None = None,
        max_states: int = DEFAULT_LOCAL_STATES,
        executor: Executor | None = None,
    ) -> None:
        super().__init__(usage)
        graph = usage.graph
        faulty = {s.name: len(section_part(usage, s).faulty) for s in graph.sections}
        small = [s for s in graph.sections if faulty[s.name] <= self._most_faulty(s)]
        text = Availability(usage, self.families)
        self._all: dict[str, SectionLosses] = {
            s.name: section_by_text(s, text) for s in graph.sections if s not in small
        }
        making = Making(templates, executor, max_states)
        placed = judged_everywhere(usage, ObjectivesGraph(tuple(small), graph.entry), making)
        for p in placed:
            self._all[p.section.name] = GraphSection(p, self, templates)
        self.templates = templates
        self.by_graphs = len(placed) == len(self._all)
        """Whether every section has a local graph."""
        if self.by_graphs:
            self.composite = Composite(usage, graph, tuple(placed))
            for name, reached in self.composite.reached.items():
                local = self._graph_section(name)
                local.reached = reached.mask | ~local.placed.listed.inside.mask
        else:
            large = min(faulty[s.name] for s in graph.sections if s not in small)
            # What has no graph here has a diagram there.
            diagrams = replace(making, most_listed=min(MOST_LISTED, large - 1))
            self.composite = glue(usage, graph, diagrams)
        names = {section.name for section in entered(graph, self._ways)}
        self.locals = {name: local for name, local in self._all.items() if name in names}
        """The sections that some run enters, by name."""

    def _most_faulty(self, section: Section) -> int:
        """Hardware up to which a section has a local graph: less where its text says the same."""
        told = self.exact and isinstance(section, ElementarySection)
        return TEXT_BEYOND if told else MAX_FAULTY

    def _ways(self, section: Section) -> tuple[Family, Family]:
        local = self._all[section.name]
        return local.succeeding, local.failing

    def succeeding(self, section: Section) -> Family:
        """When a section cannot be left by its success; always where no run enters it."""
        return self.locals[section.name].succeeding if section.name in self.locals else ALWAYS

    def failing(self, section: Section) -> Family:
        """When a section cannot be left by its failure; always where no run enters it."""
        return self.locals[section.name].failing if section.name in self.locals else ALWAYS

    @property
    def entered(self) -> list[Section]:
        """The sections that some run enters, in the mission's order."""
        return [section for section in self.usage.graph.sections if section.name in self.locals]

    # --- moments ---------------------------------------------------------------------------------------

    def objective_at(self, moment: Moment) -> Mapping[str, Family]:
        """Cut sets of each elementary objective in its present run, by its name.

        Args:
            moment: ``ENTRY``, ``WHENEVER`` or ``SOMETIME``.

        Returns:
            Functions of the objectives of sections that some run enters.
        """
        found: dict[str, Family] = {}
        for section in self.entered:
            found |= self.locals[section.name].objectives(moment, self._entries(section.name, moment))
        return found

    def mission_at(self, moment: Moment) -> Family:
        """Cut sets of the mission.

        Args:
            moment: ``START``, ``WHENEVER`` or ``SOMETIME``.
        """
        if moment is Moment.START:
            return self.mission
        found = [self._beyond(section.name, moment) for section in self.entered]
        return self.both(found) if moment is Moment.WHENEVER else self.either(found)

    def mission_entering(self, section: str) -> Family:
        """Cut sets of the mission at the entry of a section of the mission's graph, or at once after it."""
        return self._beyond(section, Moment.ENTRY)

    def _beyond(self, name: str, moment: Moment) -> Family:
        return self.locals[name].beyond(moment, self._behind(name), self._entries(name, moment))

    def _entries(self, name: str, moment: Moment) -> list[Out]:
        return self.forced_entries[name] if moment is Moment.SOMETIME else []

    def _behind(self, name: str) -> Behind:
        """What the mission loses behind the two ends of a section."""
        section = self.usage.graph.section(name)
        if not self.exact:
            return self._behind_masks(name, self._entering)
        lost = {SUCCEED: NEVER, FAIL: ALWAYS, **self.mission_from}
        return Behind(lost[section.success], lost[section.failure])

    # --- where resources contend -----------------------------------------------------------------------

    @property
    def mission(self) -> Family:
        """When the mission cannot succeed from its start."""
        if self.exact:
            return super().mission
        entry = self.usage.graph.entry
        return self._graph_section(entry).at_start(self._behind(entry))

    def _graph_section(self, name: str) -> GraphSection:
        local = self._all[name]
        assert isinstance(local, GraphSection), "asked for where each section has a graph"
        return local

    @cached_property
    def _entering(self) -> dict[str, list[Family]]:
        """When the mission is lost just after each section is entered, by the mask of its hardware then.

        Where resources contend, an activity may need a resource to be out of service, so that it counts with
        which hardware the section before can end.
        """
        found = {n: [ALWAYS] * (1 << len(self._graph_section(n).placed.faulty)) for n in self.locals}
        changed = True
        while changed:
            changed = False
            for name in reversed(list(found)):
                now = self._graph_section(name).entering(self._behind_masks(name, found))
                changed |= now != found[name]
                found[name] = now
        return found

    def _behind_masks(self, name: str, entering: Mapping[str, list[Family]]) -> Behind:
        placed, section = self._graph_section(name).placed, self.usage.graph.section(name)
        by_mask: dict[Outcome, list[Family]] = {}
        for outcome, route in zip(OUTCOMES, (section.success, section.failure), strict=True):
            masks = range(1 << len(placed.faulty))
            if route in entering:
                by_mask[outcome] = [self._passed_on(placed, mask, route, entering[route]) for mask in masks]
            else:
                by_mask[outcome] = [NEVER if route == SUCCEED else ALWAYS for _ in masks]
        return Behind(ALWAYS, ALWAYS, by_mask)

    def _passed_on(self, placed: PlacedSection, mask: int, route: str, entering: list[Family]) -> Family:
        """What is lost behind an end: all ways to enter the next section, its own hardware in any state."""
        target = self._graph_section(route).placed
        found = ALWAYS
        for other, lost in enumerate(entering):
            free, fits = [], True
            for bit, name in enumerate(target.faulty):
                out = bool(other >> bit & 1)
                if name in placed.faulty:
                    fits &= out == bool(mask >> placed.faulty.index(name) & 1)
                elif not out:
                    free.append(self.hardware.index(name))
            if fits:
                found = self.families.both(found, self.families.either(self.families.any_of(free), lost))
        return found

    @property
    def worst_known(self) -> bool:
        """Whether the worst moment can be told: nothing contends, or there is little hardware."""
        if any(isinstance(section, BlockSection) for section in self._all.values()):
            return False
        return self.exact or len(self.hardware) <= MAX_CONTENDED

    @cached_property
    def forced_entries(self) -> Mapping[str, list[Out]]:
        """What is out of service when forced runs enter each section.

        Where nothing contends, minimal sets: to fail at the entry or at once after it is the same. Where
        something does, hardware that fails before an activity wants it may leave another one in use than
        hardware that fails after, so that every set counts.

        Raises:
            LimitError: Something contends, and there is more than :data:`MAX_CONTENDED` hardware.
        """
        if not self.worst_known:
            raise LimitError(
                f"resources contend, and {len(self.hardware)} hardware resources may fail: the limit for the "
                f"worst moment is {MAX_CONTENDED}"
            )
        found: dict[str, list[Out]] = {name: [] for name in self.locals}
        entry = self.usage.graph.entry
        todo = self._arrivals(entry, [frozenset()], frozenset())
        while todo:
            name, out = todo.pop()
            if out in found[name] or (self.exact and any(known <= out for known in found[name])):
                continue
            found[name] = [known for known in found[name] if not (self.exact and out < known)] + [out]
            section = self.usage.graph.section(name)
            well, badly = self.locals[name].exits(out)
            for after, sets in ((section.success, well), (section.failure, badly)):
                if after in found:
                    todo += self._arrivals(after, sets, self.locals[name].here)
        return found

    def _arrivals(self, name: str, sets: Collection[Out], before: Out) -> list[tuple[str, Out]]:
        """Entries of a section from what is out when the one before ends, whose own hardware is given."""
        if self.exact:
            return [(name, s) for s in sets if not any(t < s for t in sets)]
        free = sorted(self.locals[name].here - before)
        subsets = [frozenset(c) for size in range(len(free) + 1) for c in combinations(free, size)]
        return [(name, s | more) for s in sets for more in subsets]

    # --- critical events -------------------------------------------------------------------------------

    def critical_of(self, objective: str, repairs: bool) -> list[CriticalEvent]:
        """Critical events of an elementary objective, with or without repairs."""
        for section in self.entered:
            if objective in (inner.name for inner in ObjectivesGraph((section,), section.name).walk()):
                return self.locals[section.name].critical_of(objective, repairs)
        return []

    def critical(self) -> list[CriticalEvent] | None:
        """Critical events of the mission without repairs, section by section.

        Returns:
            ``None`` where resources contend, or where a parallel block has no local graph.
        """
        if not self.exact or any(isinstance(self._all[s.name], BlockSection) for s in self.entered):
            return None
        first = self.usage.graph.entry
        return [
            critical
            for section in self.entered
            for critical in self.locals[section.name].critical(
                self._behind(section.name), first=section.name == first
            )
        ]

    def critical_with_repairs(self) -> list[CriticalEvent]:
        """Critical events of the mission with repairs, section by section."""
        composite = self.composite
        good = composite.leading_to(["success"])
        found: list[CriticalEvent] = []
        for name, states in good.items():
            placed, first = composite.by_name[name], name == self.usage.graph.entry
            traps = {outcome: self._traps(name, outcome, good) for outcome in OUTCOMES}
            if isinstance(placed.local, LocalDiagram):
                found += critical_in_diagram(placed, states, traps, self.templates, first=first)
            else:
                masks = {outcome: trap.masks() for outcome, trap in traps.items()}
                known = self._all[name]
                listed = (
                    known if isinstance(known, GraphSection) else GraphSection(placed, self, self.templates)
                )
                found += listed.critical_with_repairs(states.mask, masks, first)
        return found

    def _traps(self, name: str, outcome: Outcome, good: Mapping[str, Any]) -> HardwareStates:
        """With which states of its hardware a section's end may lose the mission."""
        placed, route = self.composite.by_name[name], self.composite.route(name, outcome)
        if route in ENDS:
            return placed.frame.everything if ENDS[route] == "failure" else placed.frame.nothing
        if route not in good:  # the mission never ends the section so
            return placed.frame.nothing
        target = self.composite.by_name[route]
        return target.entries(target.local.inside - good[route]).seen_by(placed.frame)

    # --- the losing region -----------------------------------------------------------------------------

    def losing_states(self, repairs: bool, objective: str | None = None) -> int | None:
        """The size of a losing region of the whole mission, exact, without listing its states.

        Args:
            repairs: Whether hardware may be repaired.
            objective: An elementary objective; the mission by default.

        Returns:
            Number of stable states, or ``None`` where that takes a local graph that a section has not.
        """
        composite = self.composite
        if not self.by_graphs and (objective is not None or not repairs):
            return None
        total = 0 if objective is not None else self._losing_outside(composite, repairs)
        good = composite.leading_to(["success"])
        for name, reached in composite.reached.items():
            free = len(self.hardware) - len(composite.by_name[name].faulty)
            if repairs and objective is None:
                total += (reached - good[name]).count() << free
                continue
            local = self._graph_section(name)
            if objective is not None:
                goal = local.outlook.objectives.get(objective)
                if goal is not None:
                    total += int((local.outlook.losing(goal, repairs) & reached.mask).sum()) << free
            else:
                lost = local.lost_behind(self._behind(name))
                others = frozenset(range(len(self.hardware))) - local.here
                states = np.flatnonzero(reached.mask).tolist()
                total += sum(self.families.models(lost[s], others) for s in states)
        return total

    def _losing_outside(self, composite: Composite, repairs: bool) -> int:
        """Losing states before the mission begins and after it has failed."""
        count = len(self.hardware)
        failed = 1 << count if "failure" in composite.ends else 0
        if repairs:
            hopeful = composite.hopeful(["success"])[self.usage.graph.entry]
            return failed + (0 if hopeful else 1 << count)
        return failed + self.families.models(self.mission, frozenset(range(count)))
