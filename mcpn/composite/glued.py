"""Sections glued at their interface: sets of states of the composite, steps and closures.

A state of the whole is a section, a state of its local net, and the status of the hardware beside it; before
and after the mission there is the status of the hardware alone. What one section hands to the next is its
exit and the status of all hardware.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from heapq import heappop, heappush
from itertools import chain

from mcpn._kernel import Zdd
from mcpn.composite.filters import Filter, Filters
from mcpn.composite.layout import Layout
from mcpn.composite.section_type import Allowed
from mcpn.composite.sections import BEGIN, NOWHERE, Moved, Stage, WholeNet, ends_of, outside
from mcpn.drawing.templates.stencil import Kind
from mcpn.spaces.algebra import Guards, Without
from mcpn.spaces.components import strongly_connected
from mcpn.spaces.memoized import ByKey, memoized

Member = tuple[str, tuple[int, ...]]
"""A state: its section, and its marked levels with the section's own slots unmarked."""


class SectionSets(dict[str, Zdd]):
    """A set of states in the making: by section, a diagram that is not empty."""

    def add(self, name: str, part: Zdd) -> bool:
        """Adds states of a section; whether some are new."""
        known = self.get(name)
        wider = part if known is None else known | part
        if not wider or wider == known:
            return False
        self[name] = wider
        return True


class CompositeSet:
    """A set of states of a composite.

    Args:
        space: The composite.
        parts: By section, a diagram with the section's own slots open; those that are empty are left out.
    """

    __slots__ = ("parts", "space")

    def __init__(self, space: Glued, parts: Mapping[str, Zdd]) -> None:
        self.space = space
        self.parts: Mapping[str, Zdd] = {name: part for name, part in parts.items() if part}

    @classmethod
    def of_parts(cls, space: Glued, parts: Mapping[str, Zdd]) -> CompositeSet:
        """The set of some parts, none of which is empty."""
        made = cls.__new__(cls)
        made.space, made.parts = space, parts
        return made

    def _by_size(self, other: CompositeSet) -> tuple[Mapping[str, Zdd], Mapping[str, Zdd]]:
        """The parts of both sets, first those of which there are fewer."""
        few, many = self.parts, other.parts
        return (few, many) if len(few) <= len(many) else (many, few)

    def __and__(self, other: CompositeSet) -> CompositeSet:
        few, many = self._by_size(other)
        both = {n: met for n, part in few.items() if n in many and (met := part & many[n])}
        return self.of_parts(self.space, both)

    def __or__(self, other: CompositeSet) -> CompositeSet:
        few, many = self._by_size(other)
        if not few:
            return self.of_parts(self.space, many)
        return self.of_parts(
            self.space, {**many, **{n: p | many[n] if n in many else p for n, p in few.items()}}
        )

    def __sub__(self, other: CompositeSet) -> CompositeSet:
        theirs = other.parts
        if len(theirs) < len(self.parts):
            rest = dict(self.parts)
            for name in [name for name in theirs if name in rest]:
                if left := rest[name] - theirs[name]:
                    rest[name] = left
                else:
                    del rest[name]
            return self.of_parts(self.space, rest)
        parts = self.parts.items()
        return self.of_parts(
            self.space, {n: left for n, part in parts if (left := part - theirs[n] if n in theirs else part)}
        )

    def __bool__(self) -> bool:
        return bool(self.parts)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, CompositeSet) and self.parts == other.parts

    def __hash__(self) -> int:
        return hash(frozenset(self.parts.items()))

    def of(self, name: str) -> Zdd:
        """The states of one section."""
        return self.parts.get(name, self.space.empty)

    def count(self) -> int:
        """How many states the set has."""
        return sum(self.space.stages[name].closed(part).count() for name, part in self.parts.items())

    def pick(self) -> Member | None:
        """A state of the first section in the mission's order, with little hardware out of service."""
        if not self.parts:
            return None
        name = min(self.parts, key=self.space.order.__getitem__)
        return name, tuple(self.space.stages[name].closed(self.parts[name]).pick() or ())


class Glued:
    """The sections of a mission, glued.

    Args:
        whole: The net of the whole mission; it is not explored.
        layout: The diagram store.
        sections: Every section with its type, in document order.
    """

    def __init__(self, whole: WholeNet, layout: Layout, sections: Sequence[Stage]) -> None:
        self.whole = whole
        self.mission_net = whole.mission_net
        self.net = self.mission_net.net
        self.layout = layout
        self.sections = {stage.name: stage for stage in sections}
        around = (BEGIN, *ends_of(self.mission_net))
        begin, *ends = (outside(name, self.mission_net, layout) for name in around)
        self.stages: dict[str, Stage] = {s.name: s for s in (begin, *sections, *ends)}
        self.empty = layout.store.empty()
        self.nothing = CompositeSet(self, {})
        self.order = {name: i for i, name in enumerate(self.stages)}
        self.into: dict[str, dict[str, None]] = {name: {} for name in self.stages}  # whose routes lead there
        for stage in self.stages.values():
            for route in stage.routes.values():
                self.into[route][stage.name] = None

    @cached_property
    def initial(self) -> CompositeSet:
        """The state before the mission: all hardware is in service that is so at the start."""
        true = chain.from_iterable(status.values[status.initial] for status in self.mission_net.statuses)
        slots = self.layout.slots_of(true)
        return CompositeSet(self, {BEGIN: self.stages[BEGIN].entered(self.layout.store.singleton(slots))})

    @cached_property
    def everything(self) -> CompositeSet:
        """All reachable states."""
        local = {name: stage.type.inside for name, stage in self.stages.items()}
        return self.reached(self.initial, CompositeSet(self, local))

    @cached_property
    def stable(self) -> CompositeSet:
        """All states: each is stable."""
        return self.everything

    def filtered(self, transitions: Collection[int] | None, guards: Guards[CompositeSet] = None) -> Filter:
        """What edges may carry, as each section sees it; guards are of sections' events."""
        limits = guards or {}
        known = self._filters.unguarded(transitions)
        if not limits:
            return known

        taken = self._filters.guarded(limits)

        def of(name: str) -> Allowed:
            own, (local, beside, _) = self.stages[name].transitions, known(name)
            return Allowed(local, beside, tuple([(i, limits[own[i]].of(name)) for i in taken(name)]))

        return ByKey(of).__getitem__

    @cached_property
    def _filters(self) -> Filters:
        return Filters(self.stages, self.carrying, self.layout.toggles)

    @memoized
    def _holding(self, kind: Kind) -> tuple[Mapping[int, Sequence[str]], Mapping[int, list[list[str]]]]:
        """By place, or transition, of no copy: stages with it in their control, and groups using it."""
        lying: dict[int, tuple[Stage, list[str]]] = {}  # copies of one lie alike
        for name, stage in self.stages.items():
            row = getattr(stage, kind)
            lying.setdefault(id(row.other if isinstance(row, Moved) else row), (stage, []))[1].append(name)
        control: dict[int, list[str]] = {}
        alike: dict[int, tuple[Sequence[int], list[str]]] = {}
        for stage, names in lying.values():
            row, used = getattr(stage, kind), stage.used[kind]
            alike.setdefault(id(used), (used, []))[1].extend(names)
            for where, other in zip(row.kept if isinstance(row, Moved) else row, used, strict=True):
                if where not in (other, NOWHERE):
                    control.setdefault(where, []).extend(names)
        using: dict[int, list[list[str]]] = {}
        for used, names in alike.values():
            for where in {*used} - {NOWHERE}:
                using.setdefault(where, []).append(names)
        for names in (*control.values(), *(names for _, names in alike.values())):
            names.sort(key=self.order.__getitem__)
        return control, using

    def holders(self, kind: Kind, where: int) -> Sequence[str]:
        """The stages whose local nets have a place, or a transition, in the mission's order."""
        if (name := self.whole.section_of(kind, where)) is not None:
            return (name,) if where in getattr(self.stages[name], kind) else ()
        control, using = self._holding(kind)
        groups = using.get(where, ())
        if not groups:
            return control.get(where, ())
        names = {*control.get(where, ()), *chain.from_iterable(groups)}
        return groups[0] if len(names) == len(groups[0]) else sorted(names, key=self.order.__getitem__)

    def having(self, transitions: Collection[int] | None) -> Collection[str] | None:
        """The sections that have some of these transitions; ``None`` where any section may."""
        if transitions is None or isinstance(transitions, Without) or len(transitions) > len(self.stages):
            return None
        if not self.layout.toggles.keys().isdisjoint(transitions):
            return None
        return dict.fromkeys(name for t in transitions for name in self.holders("transitions", t))

    def ends_into(self, stage: Stage, parts: Mapping[str, Zdd]) -> Zdd:
        """States after the exits of a section from which a set is entered."""
        return stage.ends({r: self.stages[r].entries(parts[r]) for r in stage.routes.values() if r in parts})

    def leaving(
        self,
        into: Mapping[str, Zdd],
        within: CompositeSet,
        allowed: Filter,
        having: Collection[str] | None = None,
    ) -> SectionSets:
        """States of a set with an event that leads out of their section, of some, into another set."""
        sources = SectionSets()
        if len(within.parts) == 1 or having is not None:  # a region of one section, which is most of them
            few = within.parts if having is None else [name for name in having if name in within.parts]
            names = [n for n in few if not into.keys().isdisjoint(self.stages[n].routes.values())]
        else:
            names = [n for n in dict.fromkeys(s for r in into for s in self.into[r]) if n in within.parts]
        entered = ByKey[str, Zdd](lambda route: self.stages[route].entries(into[route]))
        for name in names:
            stage = self.stages[name]
            after = tuple([(exit_, entered[route]) for exit_, route in stage.routes.items() if route in into])
            if part := stage.type.ending(after, stage.slots, allowed(name)) & within.parts[name]:
                sources[name] = part
        return sources

    def entering(self, states: Mapping[str, Zdd], within: CompositeSet, allowed: Filter) -> SectionSets:
        """States of a set just after an event that leads into their section, out of another set."""
        targets = SectionSets()
        for name, part in states.items():
            for route, hardware in self.stages[name].leave(part, allowed(name)):
                if route in within.parts:
                    targets.add(route, self.stages[route].entered(hardware) & within.of(route))
        return targets

    def before(
        self,
        states: CompositeSet,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
        among: CompositeSet | None = None,
    ) -> CompositeSet:
        """States with an edge into some states."""
        allowed = self.filtered(transitions, guards)
        within, having = self.everything if among is None else among, self.having(transitions)
        sources = self.leaving(states.parts, within, allowed, having)
        for name in states.parts if having is None else having:
            if name in within.parts and name in states.parts:
                sources.add(name, self.stages[name].back(states.of(name), allowed(name), within.of(name)))
        return CompositeSet.of_parts(self, sources)

    def after(
        self,
        states: CompositeSet,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> CompositeSet:
        """States that an edge leads to from some states."""
        allowed, having = self.filtered(transitions, guards), self.having(transitions)
        names = states.parts if having is None else having
        parts = {name: states.of(name) for name in names if name in states.parts}
        targets = self.entering(parts, self.everything, allowed)
        for name, part in parts.items():
            targets.add(name, self.stages[name].forth(part, allowed(name)))
        return CompositeSet.of_parts(self, targets)

    @cached_property
    def dead(self) -> CompositeSet:
        """States in which neither the section nor hardware beside it can do anything."""
        parts = self.everything.parts.items()
        return CompositeSet(self, {name: self.stages[name].stuck(part) for name, part in parts})

    def _stuck(self, states: Mapping[str, Zdd], allowed: Filter) -> CompositeSet:
        """Those of some states in which nothing happens that edges may carry."""
        parts = ((self.stages[name], part) for name, part in states.items())
        idle = {s.name: part - s.type.enabling(part, allowed(s.name), s.carried) for s, part in parts}
        return CompositeSet(self, idle)

    def worked(
        self, names: Iterable[str], work: Callable[[str], Iterable[str]], *, back: bool = False
    ) -> None:
        """A worklist of sections, in their order or against it; work on a section names those to do again."""
        queued = set(names)
        heap = sorted((-self.order[name] if back else self.order[name], name) for name in queued)
        while heap:
            _, name = heappop(heap)
            queued.discard(name)
            for changed in work(name):
                if changed not in queued:
                    queued.add(changed)
                    heappush(heap, (-self.order[changed] if back else self.order[changed], changed))

    def reaching(
        self,
        goal: CompositeSet,
        along: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> CompositeSet:
        """States from which some run through ``along`` leads into a goal, the goal's own included."""
        # A run may end where it first comes to the goal, so that it need not leave it again.
        anywhere = along is None or (along | goal).parts == self.everything.parts
        if anywhere and not guards and self._are_all(transitions):
            return self._leading_to(goal)
        return self._reaching(goal, along, transitions, guards)

    @memoized
    def _leading_to(self, goal: CompositeSet) -> CompositeSet:
        """States from which some run of any events leads into a goal: several questions ask for them."""
        return self._reaching(goal)

    def _are_all(self, transitions: Collection[int] | None) -> bool:
        """Whether some transitions are all that carry an event."""
        if transitions is None:
            return True
        many, few = transitions, frozenset[int]()
        if isinstance(transitions, Without):
            many, few = transitions.many, transitions.few
        return not few and len(many) >= len(self.carrying) and self.carrying.issubset(many)

    @cached_property
    def carrying(self) -> frozenset[int]:
        """All transitions that carry an event."""
        return frozenset(t for t, _ in self.net.events.pairs)

    def _reaching(
        self,
        goal: CompositeSet,
        along: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> CompositeSet:
        within = (self.everything if along is None else along).parts
        allowed, sources = self.filtered(transitions, guards), dict(goal.parts)
        entries = dict[str, Zdd]()  # by section, with which status it is entered in its sources

        def work(name: str) -> Iterable[str]:
            stage, there = self.stages[name], sources.get(name, self.empty)
            if (along := within.get(name)) is not None:
                own, routes = allowed(name), stage.routes.items()
                after = tuple([(exit_, entries[route]) for exit_, route in routes if route in entries])
                if after:
                    there |= stage.type.ending(after, stage.slots, own) & along
                there = stage.type.reaching(there, along, own)
            if not there:
                return ()
            sources[name], entered = there, stage.entries(there)
            if not entered or entered == entries.get(name):
                return ()
            entries[name] = entered
            return self._leading_into(name, within)

        self.worked(sources, work, back=True)
        return CompositeSet.of_parts(self, sources)

    def _leading_into(self, name: str, within: Mapping[str, Zdd]) -> Iterable[str]:
        """The sections, of some, with a route into another."""
        before = self.into[name]
        if len(before) > len(within):  # of one section often, and many lead to the last
            return [n for n in within if n in before]
        return [n for n in before if n in within]

    def reached(
        self,
        begin: CompositeSet,
        along: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> CompositeSet:
        """States of ``along`` to which some run through it leads, those it begins from included."""
        within = self.everything if along is None else along
        allowed, targets = self.filtered(transitions, guards), SectionSets((begin & within).parts)

        def work(name: str) -> Iterator[str]:
            targets[name] = self.stages[name].type.reached(targets[name], within.of(name), allowed(name))
            entering = self.entering({name: targets[name]}, within, allowed)
            return (route for route, states in entering.items() if targets.add(route, states))

        self.worked(targets, work)
        return CompositeSet(self, targets)

    def staying(
        self,
        along: CompositeSet,
        asked: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
    ) -> CompositeSet:
        """States from which a maximal run stays in a set; see :meth:`mcpn.spaces.algebra.Space.staying`."""
        remaining, allowed = dict((along & self.everything).parts), self.filtered(transitions)
        ends = self.dead if transitions is None else self._stuck(remaining, allowed)

        def work(name: str) -> Iterator[str]:
            stage, part, before, own = self.stages[name], remaining[name], None, allowed(name)
            onward = ends.of(name) | stage.type.before_step(self.ends_into(stage, remaining), own)
            while before != part:
                before = part
                part = stage.back(part, own, part) | (part & onward)
            if part != remaining[name]:
                remaining[name] = part
                yield from (earlier for earlier in self.into[name] if earlier in remaining)

        self.worked(remaining, work, back=True)
        return CompositeSet(self, remaining)

    @cached_property
    def regions(self) -> Sequence[CompositeSet]:
        """Sections that lead to each other, and each other section alone: no cycle leaves a region."""
        parts = self.everything.parts
        names = list(parts)
        number = {name: i for i, name in enumerate(names)}
        routes = [[number[r] for r in self.stages[n].routes.values() if r in parts] for n in names]
        regions = ([names[i] for i in region] for region in strongly_connected(routes))
        ordered = (sorted(region, key=self.order.__getitem__) for region in regions)
        return [CompositeSet(self, {name: parts[name] for name in region}) for region in ordered]
