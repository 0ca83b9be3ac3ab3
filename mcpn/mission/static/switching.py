"""Return to a better alternative: when an alternative is possible again, by which hardware is in service.

The paper's activity leaves its alternative only when it is stopped or a resource fails (6.2). An activity
that is declared to switch back also leaves it when one of higher priority becomes possible, and evaluates all
of them again. An alternative is possible where the hardware that it consumes is in service, and some
alternative of the producer of each software resource that it consumes is possible, and no two of all these
activities need the same hardware for themselves.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from mcpn.errors import LimitError
from mcpn.mission.fact_conditions import cause

if TYPE_CHECKING:
    from mcpn.mission.static.suppliers import Suppliers

_T = TypeVar("_T")

Ways: TypeAlias = frozenset[frozenset[str]]
"""Minimal sets of hardware that can fail, each enough if all of it is in service."""

Held: TypeAlias = frozenset[tuple[str, str]]
"""Hardware with the activity that holds it, empty where it is shared; facts with their values, as
``door=open``."""

MAX_WAYS = 100
"""Sets of hardware that may make one alternative possible."""


class Switching:
    """The static analysis of activities that switch back.

    Args:
        usage: The static analysis of the mission.
    """

    def __init__(self, usage: Suppliers) -> None:
        self.usage = usage
        self._ways: dict[str, frozenset[Held]] = {}

    @cached_property
    def watched(self) -> frozenset[str]:
        """Hardware whose return makes some activity evaluate its alternatives again."""
        return (
            frozenset[str]().union(*(self.returns(a) for a in self.usage.started))
            & self.usage.hardware.keys()
        )

    def returns(self, activity: str) -> frozenset[str]:
        """Hardware whose return may make an activity leave its alternative; ``FACTS`` if facts may."""
        return (
            frozenset(map(cause, self._of_higher(activity))) if self.switches_back(activity) else frozenset()
        )

    def _of_higher(self, activity: str) -> frozenset[str]:
        alternatives = range(len(self.usage.activities[activity].alternatives))
        return frozenset[str]().union(*(way for i in alternatives for way in self.higher(activity, i)))

    def better(self, activity: str, alternative: int) -> list[tuple[str, ...]]:
        """Sets of hardware for which an activity leaves this alternative for one of higher priority.

        Facts with the values that they must have are among it, as ``door=open``. They come in the order in
        which the mission lists its hardware and facts, not in the order of its names.

        Raises:
            LimitError: There are too many.
        """
        if not self.switches_back(activity):
            return []
        facts = (f"{fact.name}={value}" for fact in self.usage.world.facts.values() for value in fact.values)
        place = {h: i for i, h in enumerate((*self.usage.hardware, *facts))}
        ways = (tuple(sorted(way, key=place.__getitem__)) for way in self.higher(activity, alternative))
        return sorted(ways, key=lambda way: [place[h] for h in way])

    def switches_back(self, activity: str) -> bool:
        """Whether an activity returns to a better alternative: where it is declared to, and nowhere else."""
        declared = self.usage.activities[activity]
        return declared.switch_back and len(declared.alternatives) > 1

    def higher(self, activity: str, alternative: int) -> Ways:
        """Sets of hardware that make an alternative of higher priority than this one possible.

        Raises:
            LimitError: There are too many.
        """
        hardware = self.usage.hardware
        found = [held for better in range(alternative) for held in self._all_of(activity, better)]
        ways = _minimal(
            frozenset(h for h, _ in held if h not in hardware or hardware[h].faulty) for held in found
        )
        # A better alternative that is always possible is never passed over, so there is nothing to return to.
        return frozenset() if frozenset() in ways else ways

    def _possible(self, activity: str) -> frozenset[Held]:
        """Sets of hardware with which some alternative of an activity is possible."""
        if activity not in self._ways:
            alternatives = range(len(self.usage.activities[activity].alternatives))
            self._ways[activity] = _minimal(held for i in alternatives for held in self._all_of(activity, i))
        return self._ways[activity]

    def _held(self, activity: str, hardware: str) -> Held:
        """Consumed hardware with its holder; empty where it never fails and nobody else needs it."""
        declared = self.usage.hardware[hardware]
        if not declared.faulty and (declared.shared or self._consumers[hardware] == 1):
            return frozenset()
        return frozenset({(hardware, "" if declared.shared else activity)})

    @cached_property
    def _consumers(self) -> Counter[str]:
        """By resource, how many activities consume it."""
        activities = self.usage.activities.values()
        return Counter(k for a in activities for k in {k for way in a.alternatives for k in way.consumes})

    def _all_of(self, activity: str, alternative: int) -> frozenset[Held]:
        usage = self.usage
        required = (f"{fact}={value}" for fact, value in usage.world.requires(activity, alternative))
        combinations: frozenset[Held] = frozenset({frozenset((condition, "") for condition in required)})
        for k in usage.activities[activity].alternatives[alternative].consumes:
            each = (
                frozenset({self._held(activity, k)})
                if k in usage.hardware
                else self._possible(usage.producer[k])
            )
            together = (one | other for one in combinations for other in each)
            combinations = _minimal(held for held in together if _at_once(held))
            if len(combinations) > MAX_WAYS:
                raise LimitError(
                    f"activity {activity}: more than {MAX_WAYS} sets of hardware make an alternative "
                    "possible: the limit on what it may switch back to was hit"
                )
        return combinations


def _at_once(held: Held) -> bool:
    """Whether no hardware is held by two, and no fact must have two values."""
    return len({h.partition("=")[0] for h, _ in held}) == len(held)


def _minimal(ways: Iterable[frozenset[_T]]) -> frozenset[frozenset[_T]]:
    kept: list[frozenset[_T]] = []
    for way in sorted(set(ways), key=len):
        if not any(other <= way for other in kept):
            kept.append(way)
    return frozenset(kept)
