"""Timers: how long each objective that runs may still run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from mcpn.runtime.tables import Action


class Timers:
    """The timers of a controller; actions arm and disarm them.

    Args:
        clock: Gives the time in seconds; it never goes back.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._ends: dict[str, float] = {}

    def follow(self, actions: Iterable[Action]) -> None:
        """Arms and disarms as some actions say."""
        for action in actions:
            if action.objective is not None:
                if action.verb == "disarm":
                    self._ends.pop(action.objective, None)
                elif action.verb == "arm" and action.seconds is not None:
                    self._ends[action.objective] = self._clock() + action.seconds

    @property
    def left(self) -> dict[str, float]:
        """By objective whose time runs, the seconds that are left, the shortest first."""
        now = self._clock()
        return {name: max(0.0, end - now) for name, end in sorted(self._ends.items(), key=lambda of: of[1])}

    def refused(self, event: object) -> None:
        """Removes the timer whose timeout event was refused, so that the event does not come again."""
        for name, left in self.left.items():
            if not left and event == f"OBJ_{name}_EV_TIMEOUT":
                del self._ends[name]

    def restore(self, left: Mapping[str, float]) -> None:
        """Replaces all timers: by objective, the seconds that are left."""
        now = self._clock()
        self._ends = {name: now + seconds for name, seconds in left.items()}
