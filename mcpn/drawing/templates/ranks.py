"""Ranks of internal transitions: the order in which what a mission's net does by itself is done."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeAlias
from weakref import WeakKeyDictionary

from mcpn.mission.core.objectives_graph import ObjectivesGraph, ParallelSection
from mcpn.mission.static.resource_use import Usage


class Ranks:
    """The order in which internal transitions fire, where a net has producers that serve, or gates.

    What is on its way comes first. Then activities are taken in the order of who consumes what, suppliers
    first: what each does on an error, then what it answers to who asks. A producer refuses or stops when
    nobody evaluates any more, so that it goes on if somebody needs it at the end; a gate opens last.

    Where some producer is *kept* (:meth:`mcpn.mission.static.sharing.Sharing.kept`), what nobody needs when
    an objective has ended stops before any activity handles an error, and gates in branches open before a
    kept producer is stopped because its consumers have given it up: what begins there may need it.

    Where a parallel block may abort, or end early, its halting and all other control comes before any of
    that. A block waits for those in it, whose ends may be ends of its branches; of its own ends an abort
    comes first, then success. What is led to, and stopped by a block around, has not begun.
    Then facts are *asked*: all that is left as they have become so is left, in the order of the document, a
    block around before those in it, and only then blocks end by that. What facts have become is forgotten.
    Then what begins changes facts, in the order of the document, before any activity looks at them. Such
    ranks are below 0, down to minus :attr:`below`.

    Args:
        usage: The static analysis of the mission.
    """

    def __init__(self, usage: Usage) -> None:
        self._deciding, self._starting, self._becoming = _numbers_of(usage)
        becoming = 2 + max(self._becoming.values(), default=-2)
        deciding = 1 + max(self._deciding.values(), default=-1)
        watched = len(usage.world.watched)
        facts = watched + 2 if watched else 0
        self.below = 1 + becoming + deciding + facts + 1 + max(self._starting.values(), default=-1)
        if not self._deciding and not self._starting and not self._becoming:
            self.below = 0
        self.control = -self.below
        self._first_becoming = self.control + 1
        self._first_deciding = self._first_becoming + becoming
        self.asked = self._first_deciding - 1
        self.asking = self._first_deciding + deciding
        self.forgetting, self.forgotten = self.asking + watched, self.asking + watched + 1
        self._first_start = self._first_deciding + deciding + facts
        self._several = (
            usage.sharing.anything or bool(usage.handover.gated) or self.below > 0 or bool(usage.requiring)
        )
        self._height = usage.height
        highest = max((usage.height(a) for a in usage.started), default=0)
        kept = usage.sharing.anything_kept
        self.resting, self.rested = 1, 2
        self._errors = self.rested if kept else 0
        self.settling = self._if_several(self._errors + 2 * highest + 3)
        self.entering_branches = self.settling + self._if_several(1)
        self.settling_kept = self.entering_branches + kept
        self.entering = self.settling_kept + kept

    def deciding(self, block: str, outcome: str, branch: str) -> int:
        """How a branch that has ended halts its block: each branch of a section has a rank of its own."""
        return self._first_deciding + self._deciding[block, outcome, branch]

    def becoming(self, section: str, outcome: str, number: int) -> int:
        """How a section is left as facts become so: each word of each condition has a rank of its own."""
        return self._first_becoming + self._becoming[section, outcome, number]

    def starting(self, objective: str) -> int:
        """How an objective changes facts as it is entered: each of a section has a rank of its own."""
        return self._first_start + self._starting[objective]

    def handling(self, activity: str) -> int:
        """What an activity does on an error, and when a better alternative is possible again."""
        return self._if_several(self._errors + 2 * self._height(activity) + 1)

    def answering(self, producer: str) -> int:
        """What a producer that serves answers to who asks."""
        return self._if_several(self._errors + 2 * self._height(producer) + 2)

    def _if_several(self, rank: int) -> int:
        return rank if self._several else 0


_Numbers: TypeAlias = tuple[
    Mapping[tuple[str, str, str], int], Mapping[str, int], Mapping[tuple[str, str, int], int]
]
_KNOWN: WeakKeyDictionary[Usage, _Numbers] = WeakKeyDictionary()


def _numbers_of(usage: Usage) -> _Numbers:
    """What the sections of a mission number, found once for its net and the nets of its parts."""
    if usage not in _KNOWN:
        graph = usage.graph
        _KNOWN[usage] = dict(_deciding(graph)), dict(_starting(graph)), dict(_becoming(graph))
    return _KNOWN[usage]


def _deciding(graph: ObjectivesGraph) -> Iterator[tuple[tuple[str, str, str], int]]:
    """Branches that may end their block, by block, outcome and name, each with its number in its section.

    A block comes after those in it. Of its branches first those count that abort, then by whom it succeeds.
    """
    for section in graph.sections:
        levels, level = list[list[tuple[str, str, str]]](), [section]
        while level:
            blocks = [inner for inner in level if isinstance(inner, ParallelSection)]
            levels += [[(b.name, outcome, branch.name) for b in blocks for outcome, branch in b.deciding]]
            level = [inner for block in blocks for graph in block.graphs for inner in graph.sections]
        every = (branch for level in reversed(levels) for branch in level)
        yield from ((branch, number) for number, branch in enumerate(every))


def _becoming(graph: ObjectivesGraph) -> Iterator[tuple[tuple[str, str, int], int]]:
    """Words of conditions by which sections are left, each with its number in its section of the mission."""
    for section in graph.sections:
        every = (
            (inner.name, outcome, word)
            for inner in ObjectivesGraph((section,), section.name).all_sections()
            for outcome, each in inner.becoming
            for word in range(len(each.when))
        )
        yield from ((word, number) for number, word in enumerate(every))


def _starting(graph: ObjectivesGraph) -> Iterator[tuple[str, int]]:
    """Objectives that change facts as they are entered, each with its number in its section."""
    for section in graph.sections:
        changing = (objective.name for objective in section.walk() if objective.setting("start"))
        yield from ((name, number) for number, name in enumerate(changing))
