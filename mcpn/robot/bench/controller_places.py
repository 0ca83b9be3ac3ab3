"""The places of a controller, each asked of the runtime once: runs through them look up what is known.

Hardware that fails on demand is played here too: what starts on an event is asked, one by one. The order is
that of the numbers of risk (:mod:`mcpn.answers.causes.demands`): resources as the activities of the section
come upon them, then activities, then alternatives. What starts is read from the controller's actions.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

from mcpn.events import Event, What
from mcpn.robot.bench.chances import Chances
from mcpn.robot.runtime.actions import Action
from mcpn.robot.runtime.controller import Controller
from mcpn.robot.runtime.controller_tables import Inside, Tables, TableSection
from mcpn.robot.runtime.restoring import Saved


class StartDemand(NamedTuple):
    """Hardware that an alternative consumes which has just started; in the order in which they are asked."""

    rank: tuple[int, int, int]
    activity: str
    alternative: str
    hardware: str

    @property
    def event(self) -> str:
        """The event that it fails."""
        return str(Event(What.OUT_OF_SERVICE, self.hardware))


Move: TypeAlias = tuple[int, frozenset[str]]
"""A state of a section, and what has happened then."""


class Demands:
    """What may fail on demand as alternatives start.

    Args:
        tables: The controller's, which say what alternatives consume.
        chances: How probable that is.
    """

    def __init__(self, tables: Tables, chances: Chances) -> None:
        self.probability = chances.on_demand
        self._orders = chances.orders
        self._ways = {
            (activity, way): (number, [k for k in said["consumes"] if k in self.probability])
            for activity, row in tables.laws.activities.items()
            for number, (way, said) in enumerate(row["alternatives"].items())
        }

    def started(self, inside: Inside, actions: Iterable[Action]) -> tuple[StartDemand, ...]:
        """What is asked after an event, in order.

        Args:
            inside: What runs then.
            actions: What the controller has ordered.
        """
        if not self.probability or not inside.objectives:
            return ()
        order, found = self._orders[inside.objectives[0]], list[StartDemand]()
        for action in actions:
            activity, alternative = action.activity, action.alternative
            if activity is not None and alternative is not None:
                number, consumed = self._ways[activity, alternative]
                task = order.activities[activity]
                found += (
                    StartDemand((order.hardware[k], task, number), activity, alternative, k) for k in consumed
                )
        return tuple(sorted(found))

    def following(
        self, failed: StartDemand, rest: Sequence[StartDemand], inside: Inside, actions: Iterable[Action]
    ) -> tuple[StartDemand, ...]:
        """What is still asked, and what is asked besides, after something has failed on demand.

        Args:
            failed: What has failed.
            rest: What was to be asked after it.
            inside: What runs then.
            actions: What the controller has ordered.
        """
        still = {
            demand
            for demand in rest
            if demand.hardware != failed.hardware and inside.mode.get(demand.activity) == demand.alternative
        }
        return tuple(sorted(still.union(self.started(inside, actions))))

    def ends(self, section: TableSection, at: Move, asked: Sequence[StartDemand]) -> Iterator[Move]:
        """The states of a section that are possible when some hardware has been asked.

        Args:
            section: The section.
            at: Where it is before.
            asked: What is asked, in order.
        """
        if not asked:
            yield at
            return
        first, rest = asked[0], asked[1:]
        if self.probability[first.hardware] < 1:
            yield from self.ends(section, at, rest)
        step = section.move(at[0], first.event, at[1])
        if step is None:  # it is lost already, and that not known yet
            yield from self.ends(section, at, rest) if self.probability[first.hardware] == 1 else ()
            return
        assert not isinstance(step[0], str), "hardware that fails ends no section"
        lost = step[0], (at[1] | step[2]) - step[3]
        yield from self.ends(section, lost, self.following(first, rest, section.state(step[0]), step[1]))


@dataclass(eq=False)
class ControllerPlace:
    """Where a controller is, its timers aside.

    Args:
        saved: What the runtime goes back to.
        section: The section that runs, and the number of its state.
        inside: What runs.
        gone: Hardware out of service.
        true: Handlers that happen once and have, and what is true of facts.
        outcome: How the mission has ended.
        possible: The events that can be taken.
        edges: Where events lead, and the actions, as far as they have been asked.
    """

    saved: Saved
    section: tuple[str, int] | None
    inside: Inside
    gone: frozenset[str]
    true: frozenset[str]
    outcome: str | None
    possible: tuple[str, ...]
    edges: dict[str, tuple[ControllerPlace, tuple[Action, ...]]] = field(default_factory=dict)

    @property
    def seen(self) -> tuple[tuple[str, ...], tuple[tuple[str, str], ...]]:
        """Objectives that run, and the functioning mode."""
        return self.inside.objectives, tuple(sorted(self.inside.mode.items()))


class Places:
    """The places of one controller, as far as they have been reached.

    Args:
        tables: The controller's.
    """

    def __init__(self, tables: Tables) -> None:
        self.tables = tables
        self._controller = Controller(tables, log=1, clock=lambda: 0.0)
        self._known: dict[Hashable, ControllerPlace] = {}
        self.start = self._here()

    def __iter__(self) -> Iterator[ControllerPlace]:
        return iter(list(self._known.values()))

    def after(self, place: ControllerPlace, event: str) -> tuple[ControllerPlace, tuple[Action, ...]] | None:
        """Where an event leads, and the actions; ``None`` where the controller refuses it."""
        if event not in place.edges:
            if event not in place.possible:
                return None
            self._controller.resume(place.saved)
            actions, _ = self._controller.react(event)
            place.edges[event] = self._here(), actions
        return place.edges[event]

    def _here(self) -> ControllerPlace:
        controller = self._controller
        controller.count = 0  # the same place is the same one, however a run reached it
        saved = controller.saved()
        name = None if saved.section is None else saved.section.name
        gone, true = frozenset(saved.out_of_service), frozenset(saved.true)
        key = saved.phase, name, saved.state, gone, true, tuple(sorted(saved.timers.items()))
        if key not in self._known:
            where = controller.where
            section = None if where.section is None else (where.section, where.state)
            self._known[key] = ControllerPlace(
                saved,
                section,
                where.inside,
                gone,
                true,
                controller.outcome,
                controller.possible,
            )
        return self._known[key]
