"""One event as the net does it: run to completion.

Where a net is confluent every interleaving of internal transitions ends in the same stable marking. What the
controller must *do* depends on the way there: an activity that runs before and after the event may have gone
on, or may have been stopped and started again; it is *restarted* where it passes through idle. The order in
which internal transitions fire is that of their ranks: what is on its way comes first, and suppliers come
before their consumers. Within a rank the order makes no difference to the actions (tests draw it at random).
This holds for the net of a mission and for that of one of its sections alike, so that machines made of either
give the robot the same orders.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from mcpn.drawing.compose import MissionNet
from mcpn.errors import DivergenceError
from mcpn.events import What
from mcpn.spaces.markings.explicit import KernelNet
from mcpn.spaces.markings.masked import MaskedNet, bits_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from mcpn.spaces.markings.graph import Ints, StateGraph

MAX_FIRINGS = 1_000_000
"""Internal firings after one event beyond which a run is taken for endless."""


@dataclass(frozen=True, slots=True)
class Stopped:
    """What one event does to activities and objectives that run.

    Args:
        activities: Those of which an alternative was left: stopped, or evaluated anew.
        idled: Those of them that became idle: if they run afterwards, they have been restarted.
        ended: Objectives, and blocks with a timeout, that were left: if they run afterwards, they have been
            entered anew.
    """

    activities: frozenset[str]
    idled: frozenset[str]
    ended: frozenset[str]


@dataclass(frozen=True, slots=True)
class Passage(Stopped):
    """What one event does to a stable marking.

    Args:
        marking: The stable marking after it, a bit for each place.
        fired: The internal transitions fired, in order.
    """

    marking: int
    fired: tuple[int, ...]


class Runner:
    """Runs the net of a mission, or of a section, event by event.

    Args:
        mission_net: The net with the meaning of its places.
    """

    def __init__(self, mission_net: MissionNet) -> None:
        self.mission_net = mission_net
        self.masked = MaskedNet(mission_net.net)
        self._covered = lru_cache(1)(self.masked.covered)  # a state's events are fired one after the other

    def stable(self) -> int:
        """The first stable marking."""
        start = self.masked.initial()
        return self._complete(start, self.masked.covered(start), []).marking

    def possible(self, marking: int) -> list[int]:
        """Transitions with an event that a stable marking enables, in the net's order."""
        return list(self.masked.allowed(self.masked.covered(marking)))

    def fire(self, marking: int, transition: int) -> Passage:
        """Fires an event's transition and runs to completion.

        Args:
            marking: A stable marking that enables the transition.
            transition: A transition with an event.

        Raises:
            DivergenceError: The internal run does not end.
        """
        covered = self._covered(marking)
        after, _ = self.masked.fire(marking, transition)
        path = [(transition, after)]
        return self._complete(after, self.masked.covered_after(covered, after, transition), path)

    def _complete(self, marking: int, covered: int, path: list[tuple[int, int]]) -> Passage:
        masked = self.masked
        fired: list[int] = []
        while enabled := masked.first(covered) & masked.internal:
            transition = (enabled & -enabled).bit_length() - 1
            after, _ = masked.fire(marking, transition)
            covered = masked.covered_after(covered, after, transition)
            path.append((transition, after))
            fired.append(transition)
            marking = after
            if len(fired) > MAX_FIRINGS:
                raise DivergenceError(f"an internal run does not end within {MAX_FIRINGS} firings", [])
        left, idled, ended = set[str](), set[str](), set[str]()
        for transition, after in path:
            ended.update(self._ending[transition])
            left.update(self._leaving[transition])
            for activity in left - idled if left else ():
                places, at_rest = self.control[activity]
                if after & places == at_rest:
                    idled.add(activity)
        return Passage(frozenset(left), frozenset(idled), frozenset(ended), marking, tuple(fired))

    def passages(self, graph: StateGraph) -> tuple[Ints, list[Stopped]]:
        """What the events between stable markings of the net do to activities.

        Args:
            graph: The markings, with an edge for each event.

        Returns:
            By edge, a number, and by number, what is done.
        """
        prepared, names = KernelNet(self.mission_net.net), list(self.control)
        number = {name: i for i, name in enumerate(names)}
        # For the kernel an objective with a timeout is an activity without places.
        late = {name: i for i, name in enumerate(self.timed.values(), len(names))}
        every = [*names, *late]
        kernel_number = np.zeros(len(self._leaving), np.uint32)
        kernel_number[prepared.transitions] = np.arange(len(prepared.transitions), dtype=np.uint32)
        found, kinds = prepared.kernel.passages(
            graph.markings,
            graph.offsets,
            graph.targets.astype(np.int64),
            kernel_number[graph.labels],
            [
                [*(number[name] for name in self._leaving[t]), *(late[name] for name in self._ending[t])]
                for t in prepared.transitions
            ],
            [
                (bits_of(places), bits_of(rest))
                for places, rest in [*self.control.values(), *[(0, 0)] * len(late)]
            ],
        )

        def those(numbers: Iterable[int], ended: bool) -> frozenset[str]:
            return frozenset(every[i] for i in numbers if (i >= len(names)) == ended)

        done = [Stopped(those(left, False), those(idled, False), those(left, True)) for left, idled in kinds]
        assert not len(found) or found.max() < len(done), "an edge ends where its run to completion does"
        return found.astype(np.int64), done

    @cached_property
    def _activity(self) -> dict[int, str]:
        """The activity by place that says that one of its alternatives runs."""
        return {place: name.split(".", 1)[0] for place, name in self.mission_net.saying("active").items()}

    @cached_property
    def timed(self) -> dict[int, str]:
        """The objectives and blocks that have a timeout, by the place that says that they run."""
        graph = self.mission_net.graph
        timed = {section.name for section in graph.timed}
        found = {place: name for place, name in self.mission_net.saying("objective").items() if name in timed}
        blocks = {block.name for block in graph.timed_blocks()}
        net = self.mission_net.net
        for t, event in net.events.pairs if blocks else ():
            if event.what is What.TIMEOUT and event.element in blocks:
                ((place, _),) = net.transitions[t].consume
                found[place] = event.element
        return found

    @cached_property
    def _ending(self) -> list[frozenset[str]]:
        """By transition, the objectives and blocks with a timeout of which it takes the place.

        A block that leads to itself may be left and entered again by one transition.
        """
        return [
            frozenset(self.timed[p] for p, _ in t.consume if p in self.timed)
            for t in self.mission_net.net.transitions
        ]

    @cached_property
    def _leaving(self) -> list[frozenset[str]]:
        """By transition, the activities of which it leaves an alternative."""
        return [
            frozenset(self._activity[p] for p in t.consume if p in self._activity and p not in t.produce)
            for t in self.mission_net.net.safe_transitions
        ]

    @cached_property
    def control(self) -> dict[str, tuple[int, int]]:
        """By activity, the places that its own template drew, and those of them marked while it is idle."""
        found: dict[str, tuple[int, int]] = dict.fromkeys(self._activity.values(), (0, 0))
        for number, place in enumerate(self.mission_net.net.places):
            origin = place.provenance
            if origin and origin.kind in ("activity", "alternative"):
                name = origin.name.split(".", 1)[0]
                if name in found:
                    places, at_rest = found[name]
                    found[name] = places | 1 << number, at_rest | (place.initial and 1 << number)
        return found
