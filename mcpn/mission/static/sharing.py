"""Who shares what: which resources several activities may use at a time, and by which interfaces.

Software carries data, so any number of activities may use it at a time, unless it is declared exclusive;
hardware is exclusive, unless it is declared shared. Where no two activities can want a resource at the same
moment, nor one of them ask for it again as soon as it has given it back, there is nothing to share, and the
resource has the one interface of the paper. Elsewhere each activity that consumes it has an interface of its
own.

Activities that may want what serves one at a time at the same moment are rivals, of which the mission is
warned.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from mcpn.errors import Problem, Source
from mcpn.mission.conditions import FACTS, cause
from mcpn.mission.expansion.copies import grouped
from mcpn.mission.flatten import ParallelSection
from mcpn.mission.graph import ObjectivesGraph
from mcpn.mission.model import Mission

if TYPE_CHECKING:
    from mcpn.mission.static.usage import Usage


class Contention(NamedTuple):
    """Two rivals that may run together and both need one resource or activity that serves one at a time.

    Args:
        wanted: An exclusive resource, or ``activity NAME``.
        rivals: Two activities that consume the resource, or two branches that start the activity; sorted.
        context: Where they run together, in words ("parallel block census").
        source: The line of that context.
    """

    wanted: str
    rivals: tuple[str, str]
    context: str
    source: Source | None = None

    def __str__(self) -> str:
        first, second = self.rivals
        return f"{first} and {second}, both in {self.context}, both need {self.wanted}"

    @property
    def where(self) -> tuple[str, str]:
        """What sort of thing the context is, and its name."""
        kind, _, name = self.context.rpartition(" ")
        return kind, name

    @property
    def of_branches(self) -> bool:
        """Whether the rivals are branches, not activities."""
        return self.wanted.startswith("activity ")


def contention_warnings(
    contentions: Iterable[Contention], mission: Mission, graph: ObjectivesGraph
) -> Iterator[Problem]:
    """One warning for each pair of rivals, however many copies of a block are their context.

    Args:
        contentions: Those of the mission.
        mission: A valid mission.
        graph: Its objectives graph.
    """
    copies = graph.copies

    def alike(one: Contention) -> object:
        kind, name = one.where
        rivals = tuple(map(copies.written, one.rivals)) if one.of_branches else one.rivals
        return one.wanted, rivals, kind, name if kind == "activity" else copies.written(name)

    for one, *others in grouped(contentions, alike).values():
        if others:
            (kind, _), names = one.where, [each.where[1] for each in (one, *others)]
            context, _ = copies.subject(kind, names, [section.name for section in graph.all_sections()])
            rivals = one.rivals
            if one.of_branches:
                rivals = copies.written(rivals[0])[1], copies.written(rivals[1])[1]
            one = one._replace(rivals=rivals, context=context)
        yield Problem(one.source, str(one))


Occasion: TypeAlias = tuple[str, str]
"""A hardware resource and ``fails`` or ``returns``; or :data:`FACTS` and ``change``."""


def occasions(fails: Iterable[str], returns: Iterable[str]) -> frozenset[Occasion]:
    """The occasions at which some hardware fails and some returns.

    :data:`FACTS` among them has one occasion: one change of facts may end and allow alternatives at once.
    """
    both = (*((h, "fails") for h in fails), *((h, "returns") for h in returns))
    return frozenset((FACTS, "change") if h == FACTS else (h, what) for h, what in both)


class Sharing:
    """The static analysis of sharing.

    Args:
        usage: The static analysis of the mission.
    """

    def __init__(self, usage: Usage) -> None:
        self.usage = usage
        self._under: dict[tuple[str, str], frozenset[str]] = {}

    @cached_property
    def consumers(self) -> Mapping[str, tuple[str, ...]]:
        """By resource that is shared, the activities that consume it, in document order."""
        usage = self.usage
        wanted = {r for r in usage.wanted_together | usage.wanted_again if not usage.is_exclusive(r)}
        return {
            resource: tuple(a for a in usage.started if resource in usage.resources_of({a}))
            for resource in wanted
        }

    def owners(self, resource: str) -> tuple[str | None, ...]:
        """Whose interfaces a resource has: its consumers', or one of nobody in particular."""
        return self.consumers.get(resource, (None,))

    def owner(self, resource: str, consumer: str) -> str | None:
        """The owner of the interface by which an activity uses a resource."""
        return consumer if resource in self.consumers else None

    def serves(self, activity: str) -> bool:
        """Whether a producer goes on while somebody needs one of its products at the end of a reaction.

        So it does where it has several products, or one that several ask for, or one again and again, or one
        that may be given back while the producer evaluates.
        """
        usage, produces = self.usage, self.usage.activities[activity].produces
        if len(produces) > 1 or not usage.wanted_again.isdisjoint(produces):
            return True
        return any(usage.released_unasked(s) for s in produces)

    @cached_property
    def anything(self) -> bool:
        """Whether any producer serves; the internal transitions of the net then have several ranks."""
        return any(self.serves(a) for a in self.usage.started)

    def kept(self, activity: str) -> bool:
        """Whether the end of an objective may make a branch give a producer up that another begins to use.

        The end of an objective may change facts, or show that hardware is lost. So a branch beside it may
        give up what it uses in the same reaction in which the next objective begins; a producer that serves
        both must await what begins before it stops.
        """
        return activity in self._kept

    @cached_property
    def anything_kept(self) -> bool:
        """Whether any producer is kept."""
        return bool(self._kept)

    @cached_property
    def _kept(self) -> frozenset[str]:
        usage = self.usage
        sensitive = self._sensitive if self.anything else frozenset[str]()
        found = set[str]()
        for graph in usage.graphs() if sensitive else ():
            for block in graph.sections:
                if not isinstance(block, ParallelSection):
                    continue
                started = [
                    {a for o in branch.graph.walk() for a in o.activities} for branch in block.branches
                ]
                reached = [frozenset[str]().union(*map(usage.closure, producers)) for producers in started]
                for producer in filter(self.serves, usage.started):
                    using = [closure for closure in reached if producer in closure]
                    above = (a for a in frozenset[str]().union(*using) if producer in usage.closure(a))
                    if len(using) > 1 and any((usage.closure(a) - {producer}) & sensitive for a in above):
                        found.add(producer)
        # What it serves for must have stopped before it can: at the same moment.
        return frozenset(
            p for p in usage.started if self.serves(p) and not usage.closure(p).isdisjoint(found)
        )

    @cached_property
    def _sensitive(self) -> frozenset[str]:
        """Activities that the end of an objective may make change their alternative."""
        usage = self.usage
        changed = {change.fact for objective in usage.graph.walk() for change in objective.sets}
        late = {h.name for h in usage.mission.late}
        return frozenset(
            a
            for a in usage.started
            if not changed.isdisjoint(usage.world.read_by(a)) or usage.resources_of({a}) & late
        )

    def affecting(self, consumers: Collection[str], producer: str) -> frozenset[Occasion]:
        """What may make some activities ask or release, errors of the producer aside.

        A failure reaches them from below, by an error of something else that they consume, and from above,
        where it makes their own consumers release. A return makes them, or their consumers, switch back.
        """
        usage = self.usage
        above = [a for a in usage.started if not usage.closure(a).isdisjoint(consumers)]
        return frozenset[Occasion]().union(
            *(occasions(self._under_all(a, producer), usage.switching.returns(a)) for a in above)
        )

    def ending(self, activity: str, alternative: int, producer: str) -> frozenset[Occasion]:
        """What may end an alternative, errors of the products of one producer aside."""
        usage = self.usage
        consumed = usage.activities[activity].alternatives[alternative].consumes
        declared = usage.activities[activity].switch_back
        better = usage.switching.higher(activity, alternative) if declared else ()
        facts = {FACTS} if usage.world.requires(activity, alternative) else set[str]()
        under = self._under_resources(consumed, producer) | facts
        return occasions(under, map(cause, frozenset[str]().union(*better)))

    def _under_all(self, activity: str, without: str) -> frozenset[str]:
        key = (activity, without)
        if key not in self._under:
            facts = {FACTS} if activity in self.usage.world.requiring else set[str]()
            resources = self.usage.resources_of({activity})
            self._under[key] = self._under_resources(resources, without) | facts
        return self._under[key]

    def _under_resources(self, resources: Iterable[str], without: str) -> frozenset[str]:
        usage = self.usage
        hardware = frozenset[str]()
        for k in resources:
            if k in usage.hardware:
                hardware |= usage.hardware_under(k)
            elif usage.producer[k] != without and usage.can_fail(k):
                hardware |= self._under_all(usage.producer[k], without)
        return hardware
