"""What makes an activity ask, release, or leave its alternative: occasions of failure, return and facts."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TypeAlias

from mcpn.mission.fact_conditions import FACTS, cause
from mcpn.mission.static.suppliers import Suppliers
from mcpn.mission.static.switching import Switching

Occasion: TypeAlias = tuple[str, str]
"""A hardware resource and ``fails`` or ``returns``; or :data:`FACTS` and ``change``."""


def occasions(fails: Iterable[str], returns: Iterable[str]) -> frozenset[Occasion]:
    """The occasions at which some hardware fails and some returns.

    :data:`FACTS` among them has one occasion: one change of facts may end and allow alternatives at once.
    """
    both = (*((h, "fails") for h in fails), *((h, "returns") for h in returns))
    return frozenset((FACTS, "change") if h == FACTS else (h, what) for h, what in both)


class Occasions:
    """By activity, the occasions that reach it from below and from above.

    Args:
        usage: What activities stand on.
        switching: Which of them return to a better alternative.
    """

    def __init__(self, usage: Suppliers, switching: Switching) -> None:
        self.usage = usage
        self.switching = switching
        self._under: dict[tuple[str, str], frozenset[str]] = {}

    def affecting(self, consumers: Collection[str], producer: str) -> frozenset[Occasion]:
        """What may make some activities ask or release, errors of the producer aside.

        A failure reaches them from below, by an error of something else that they consume, and from above,
        where it makes their own consumers release. A return makes them, or their consumers, switch back.
        """
        usage = self.usage
        above = [a for a in usage.started if not usage.closure(a).isdisjoint(consumers)]
        return frozenset[Occasion]().union(
            *(occasions(self._under_all(a, producer), self.switching.returns(a)) for a in above)
        )

    def ending(self, activity: str, alternative: int, producer: str) -> frozenset[Occasion]:
        """What may end an alternative, errors of the products of one producer aside."""
        usage = self.usage
        consumed = usage.activities[activity].alternatives[alternative].consumes
        declared = usage.activities[activity].switch_back
        better = self.switching.higher(activity, alternative) if declared else ()
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
