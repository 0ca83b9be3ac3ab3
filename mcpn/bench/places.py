"""The places of a controller, each asked of the runtime once: runs through them look up what is known."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass, field

from mcpn.runtime.controller import Controller
from mcpn.runtime.restoring import Saved
from mcpn.runtime.tables import Action, Inside, Tables


@dataclass(eq=False)
class ControllerPlace:
    """Where a controller is, its timers aside.

    Args:
        saved: What the runtime goes back to.
        section: The section that runs, and the number of its state.
        inside: What runs.
        gone: Hardware out of service.
        happened: Handlers that happen once and have, and what is true of facts.
        outcome: How the mission has ended.
        possible: The events that can be taken.
        edges: Where events lead, and the actions, as far as they have been asked.
    """

    saved: Saved
    section: tuple[str, int] | None
    inside: Inside
    gone: frozenset[str]
    happened: frozenset[str]
    outcome: str | None
    possible: tuple[str, ...]
    edges: dict[str, tuple[ControllerPlace, tuple[Action, ...]]] = field(default_factory=dict)

    @property
    def seen(self) -> tuple[tuple[str, ...], tuple[tuple[str, str], ...]]:
        """Objectives that run, and the functioning mode."""
        return self.inside.objectives, tuple(sorted(self.inside.mode.items()))


class Places:
    """The places of one controller, as far as they have been come to.

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
        controller.count = 0  # the same place is the same one, however a run came to it
        saved = controller.saved()
        name = None if saved.section is None else saved.section.name
        gone, happened = frozenset(saved.out_of_service), frozenset(saved.happened)
        key = saved.phase, name, saved.state, gone, happened, tuple(sorted(saved.timers.items()))
        if key not in self._known:
            where = controller.where
            section = None if where.section is None else (where.section, where.state)
            self._known[key] = ControllerPlace(
                saved,
                section,
                where.inside,
                gone,
                happened,
                controller.outcome,
                controller.possible,
            )
        return self._known[key]
