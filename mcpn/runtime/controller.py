"""The controller itself: one event at a time."""

from __future__ import annotations

import json
import logging
import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, perf_counter
from typing import Any

from mcpn.runtime.machines import ControllerFileError
from mcpn.runtime.tables import (
    ENDS,
    START,
    Action,
    Inside,
    Refused,
    SnapshotError,
    Tables,
    TableSection,
    read,
)
from mcpn.runtime.timers import Timers

SNAPSHOT, SNAPSHOT_VERSION = "mcpn-controller-snapshot", 1
BEFORE, RUNNING = "before", "running"

Hook = Callable[[Action], object]

_log = logging.getLogger("mcpn.runtime")


@dataclass(frozen=True, slots=True)
class Step:
    """One event in the log.

    Args:
        number: Its number, from 1.
        event: Its text.
        taken: Whether the controller could take it.
        actions: What was ordered.
        seconds: How long the controller took, hooks aside.
    """

    number: int
    event: str
    taken: bool
    actions: tuple[Action, ...]
    seconds: float


class Controller:
    """A mission controller; all its methods may be called from any thread.

    Args:
        tables: The controller's tables; :meth:`load` and :meth:`from_document` make them.
        on_refused: Called with each event that cannot be taken, in place of an exception.
        log: How many steps are kept.
        clock: Gives the time in seconds, for timers; it never goes back.
    """

    def __init__(
        self,
        tables: Tables,
        *,
        on_refused: Callable[[Refused], object] | None = None,
        log: int = 1000,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self._tables = tables
        self._on_refused = on_refused
        self._lock = threading.RLock()
        self._hooks: dict[str | None, list[Hook]] = {}
        self.log: deque[Step] = deque(maxlen=log)
        self.count = 0
        self.refusals = 0
        self.slowest = 0.0
        self.seconds = 0.0
        self._phase = BEFORE
        self._section: TableSection | None = None
        self._state = 0
        self._out_of_service: set[str] = set()
        self._happened: set[str] = set()
        self._timers = Timers(clock)

    @classmethod
    def load(cls, path: str | Path, **options: Any) -> Controller:
        """Reads a controller from its JSON file.

        Args:
            path: The file.
            **options: As for the class.

        Raises:
            ControllerFileError: The file is no controller.
        """
        return cls(read(Path(path)), **options)

    @classmethod
    def from_document(cls, document: Mapping[str, Any], **options: Any) -> Controller:
        """A controller from the JSON object of a controller file."""
        return cls(Tables(document), **options)

    # --- what it is in ---

    @property
    def mission(self) -> str:
        """The mission's name."""
        return self._tables.mission

    @property
    def section(self) -> str | None:
        """The section that runs, or ``None`` before the start and after the end."""
        with self._lock:
            return self._section.name if self._section else None

    @property
    def state(self) -> Inside:
        """What runs: objectives, mode, what waits and what was refused."""
        with self._lock:
            return self._section.state(self._state) if self._section else Inside()

    @property
    def mode(self) -> Mapping[str, str]:
        """The functioning mode: the selected alternative of each running activity."""
        return self.state.mode

    @property
    def out_of_service(self) -> frozenset[str]:
        """Hardware out of service."""
        with self._lock:
            return frozenset(self._out_of_service)

    @property
    def happened(self) -> frozenset[str]:
        """Handlers that happen once and have; a flat controller has this in its state alone."""
        with self._lock:
            return frozenset(self._happened)

    @property
    def outcome(self) -> str | None:
        """``success``, ``failure``, ``abort``, or ``None`` before the mission has ended."""
        with self._lock:
            return None if self._phase in (BEFORE, RUNNING) else self._phase

    @property
    def possible(self) -> tuple[str, ...]:
        """The events that can be taken now, sorted."""
        with self._lock:
            tables, gone = self._tables, self._out_of_service
            events = set[str]()
            covered = set[str]()
            if self._section:
                events.update(self._section.possible(self._state, self._happened))
                covered.update(self._section.hardware)
            elif self._phase == BEFORE:
                events.add(START)
            for name in tables.hardware:
                if name not in covered:
                    events.add(f"{name}_EV_RD" if name in gone else f"{name}_EV_OOS")
            return tuple(sorted(events))

    @property
    def timers(self) -> Mapping[str, float]:
        """By objective that ends when its time is over, the seconds that it has left, the fewest first."""
        with self._lock:
            return self._timers.left

    # --- events ---

    def tick(self) -> tuple[tuple[str, tuple[Action, ...]], ...]:
        """Takes the events of the timers that are over, the first one first; call it from time to time.

        Returns:
            Each event with its actions, as of :meth:`handle`.

        Raises:
            ExceptionGroup: As of :meth:`handle`; later timers are left for the next time.
        """
        with self._lock:
            taken = []
            for _ in range(len(self._timers.left)):  # what follows has all its time
                name = next((name for name, left in self._timers.left.items() if not left), None)
                if name is None:
                    break
                event = f"OBJ_{name}_EV_TIMEOUT"
                taken.append((event, self.handle(event)))
            return tuple(taken)

    def handle(self, event: str) -> tuple[Action, ...]:
        """Takes one event.

        Args:
            event: Its text.

        Returns:
            The actions, in the order in which they are to be carried out.

        Raises:
            Refused: It cannot be taken now, and no ``on_refused`` was given.
            ExceptionGroup: Hooks have failed; the event has been taken all the same.
        """
        with self._lock:
            started = perf_counter()
            actions = self._take(event)
            seconds = perf_counter() - started
            self.count += 1
            self.seconds += seconds
            self.slowest = max(self.slowest, seconds)
            self.log.append(Step(self.count, str(event), actions is not None, actions or (), seconds))
            if actions is None:
                return self._refuse(event)
            self._timers.follow(actions)
            if _log.isEnabledFor(logging.INFO):
                _log.info("%s: %s", event, "; ".join(map(str, actions)) or "nothing to do")
            if self._hooks:
                self._call_hooks(actions)
            return actions

    def _refuse(self, event: object) -> tuple[Action, ...]:
        self.refusals += 1
        known = isinstance(event, str) and event in self._tables.known
        refused = Refused(event, known, self.possible)
        _log.warning("refused: %s", refused)
        if self._on_refused is None:
            raise refused
        self._on_refused(refused)
        return ()

    def _take(self, event: str) -> tuple[Action, ...] | None:
        """Changes the state, or leaves it and gives ``None``."""
        tables, section = self._tables, self._section
        if not isinstance(event, str):
            return None
        failing, repaired = tables.failures.get(event), tables.repairs.get(event)
        hardware = failing or repaired
        actions: tuple[Action, ...] = ()
        if section is not None and event in section.number:
            step = section.move(self._state, event, self._happened)
            if step is None:
                return None
            target, actions, happening = step
            self._happened |= happening
            self._note(failing, repaired)
            if isinstance(target, str):
                actions += self._enter(section.routes[target])
            else:
                self._state = target
        elif hardware is not None:
            if (hardware in self._out_of_service) == (failing is not None):
                return None
            self._note(failing, repaired)
        elif event == START and self._phase == BEFORE:
            actions = self._enter(tables.initial.name)
        else:
            return None
        return actions

    def _note(self, failing: str | None, repaired: str | None) -> None:
        """Takes note of hardware that fails or is ready again."""
        if failing is not None:
            self._out_of_service.add(failing)
        elif repaired is not None:
            self._out_of_service.discard(repaired)

    def _enter(self, route: str) -> tuple[Action, ...]:
        """Enters a section, or ends the mission."""
        if route in ENDS:
            self._section, self._state, self._phase = None, 0, ENDS[route]
            return ()
        section = self._tables.sections[route]
        state, actions = section.entry(self._out_of_service, self._happened)
        self._section, self._state, self._phase = section, state, RUNNING
        return actions

    # --- hooks ---

    def on(self, activity: str | None, hook: Hook) -> None:
        """Has a function called with each action of one activity, after the state has changed.

        Args:
            activity: The activity; ``None`` for every action, those of hardware included.
            hook: What to call. Hooks are called in the order of the actions, then of their coming.
        """
        with self._lock:
            self._hooks.setdefault(activity, []).append(hook)

    def _call_hooks(self, actions: tuple[Action, ...]) -> None:
        errors: list[Exception] = []
        for action in actions:
            own = self._hooks.get(action.activity, []) if action.activity is not None else []
            for hook in (*own, *self._hooks.get(None, ())):
                try:
                    hook(action)
                except Exception as error:
                    errors.append(error)
        if errors:
            raise ExceptionGroup("hooks have failed; the event has been taken", errors)

    # --- snapshots ---

    def snapshot(self) -> str:
        """Where the controller is, as a text to be given to :meth:`restore`."""
        with self._lock:
            left = self._timers.left
            return json.dumps(
                {
                    "format": SNAPSHOT,
                    "version": SNAPSHOT_VERSION,
                    "controller": self._tables.digest,
                    "phase": self._phase,
                    "section": self._section.name if self._section else None,
                    "state": self._state,
                    "out_of_service": sorted(self._out_of_service),
                    "happened": sorted(self._happened),
                    "count": self.count,
                    **({"timers": left} if left else {}),
                }
            )

    def restore(self, snapshot: str) -> None:
        """Goes back to where a snapshot was taken; the log and the times stay.

        Args:
            snapshot: What :meth:`snapshot` gave, of this very controller.

        Raises:
            SnapshotError: It is truncated, changed, or of another controller; nothing has changed.
        """
        try:
            said = json.loads(snapshot)
            if said["format"] != SNAPSHOT or said["version"] != SNAPSHOT_VERSION:
                raise SnapshotError("no snapshot of a version that is known here")
            if said["controller"] != self._tables.digest:
                raise SnapshotError("the snapshot is of another controller")
            phase, name, state = said["phase"], said["section"], said["state"]
            gone, count = set(said["out_of_service"]), said["count"]
            happened = set(said.get("happened", ()))
            left = {name: float(seconds) for name, seconds in said.get("timers", {}).items()}
            section = None if name is None else self._tables.sections[name]
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            if isinstance(error, SnapshotError):
                raise
            raise SnapshotError(f"the snapshot is not whole: {error!r}") from error
        whole = (
            phase in (BEFORE, RUNNING, *ENDS.values())
            and (section is not None) == (phase == RUNNING)
            and type(state) is int
            and (section is not None or state == 0)
            and gone <= set(self._tables.hardware)
            and happened <= self._tables.once
            and type(count) is int
            and count >= 0
        )
        timeouts = self._tables.laws.timeouts
        running = set[str]()
        if whole and section:
            whole = section.whole(state, gone, happened)
            running = timeouts.keys() & section.state(state).objectives if whole else running
        whole = whole and left.keys() == running
        whole = whole and all(0 <= seconds <= timeouts[name] for name, seconds in left.items())
        if not whole:
            raise SnapshotError("the snapshot says what cannot be")
        with self._lock:
            self._phase, self._section, self._state = phase, section, state
            self._out_of_service, self._happened, self.count = gone, happened, count
            self._timers.restore(left)


__all__ = ["Controller", "ControllerFileError", "Hook", "Step"]
