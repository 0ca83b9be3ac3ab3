"""The controller itself: one event at a time, and how long each objective that runs may still run."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Set
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, perf_counter
from typing import Any, Protocol

from mcpn.robot.runtime.actions import Action, Refused, spelled
from mcpn.robot.runtime.controller_tables import Inside, RuntimePosition, Tables, TableSection, read
from mcpn.robot.runtime.documents import BEFORE, RUNNING
from mcpn.robot.runtime.file_schema import ControllerFileError
from mcpn.robot.runtime.hooks import Hook, HookError, Hooks
from mcpn.robot.runtime.restoring import Saved, actions_to, read_snapshot

EARLY = 1e-6
"""Seconds before its end from which a timer is over: sums of seconds are not exact."""


def timeout_event(objective: str) -> str:
    """The event that an objective's time is over."""
    return f"OBJ_{objective}_EV_TIMEOUT"


def timer_order(objective: str, end: float) -> tuple[int, bytes]:
    """By what timers are sorted: their end in milliseconds, then the bytes of their events.

    All controllers have this order, and it needs no memory of which was armed first.

    Args:
        objective: Whose time runs.
        end: When it is over, in seconds.
    """
    return round(1000 * end), timeout_event(objective).encode("utf-8", "surrogatepass")


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
        now, ends = self._clock(), sorted(self._ends.items(), key=lambda item: timer_order(*item))
        return {name: end - now if end - now > EARLY else 0.0 for name, end in ends}

    def refused(self, event: object) -> None:
        """Removes the timer whose timeout event was refused, so that the event does not come again."""
        for name, left in self.left.items():
            if not left and event == timeout_event(name):
                del self._ends[name]

    def restore(self, left: Mapping[str, float]) -> None:
        """Replaces all timers: by objective, the seconds that are left."""
        now = self._clock()
        self._ends = {name: now + seconds for name, seconds in left.items()}


_log = logging.getLogger("mcpn.robot.runtime")


@dataclass(frozen=True, slots=True)
class Where:
    """Where a controller is.

    Args:
        phase: ``before``, ``running``, or the outcome with which the mission has ended.
        section: The section that runs.
        state: The number of its state.
        inside: What runs in it.
    """

    phase: str
    section: str | None
    state: int
    inside: Inside


@dataclass(frozen=True, slots=True)
class Step:
    """One event in the log.

    Args:
        number: Its number, from 1.
        event: Its text.
        taken: Whether the controller could take it.
        actions: What was ordered.
        seconds: How long the controller took, hooks aside.
        before: Where the controller was.
        after: Where it is then.
    """

    number: int
    event: str
    taken: bool
    actions: tuple[Action, ...]
    seconds: float
    before: Where
    after: Where


class Listener(Protocol):
    """What watches the events that happen: :class:`mcpn.robot.runtime.Monitors`."""

    def take(self, event: str) -> object:
        """Takes an event that has happened."""


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
        self._timers = Timers(clock)
        self.hooks = Hooks()
        self._observers: list[Callable[[Step], object]] = []
        self.log: deque[Step] = deque(maxlen=log)
        self.count = 0
        self.refusals = 0
        self.slowest = 0.0
        self.seconds = 0.0
        self._phase = BEFORE
        self._section: TableSection | None = None
        self._state = 0
        self._out_of_service: Set[str] = {*tables.out_of_service}
        self._true: Set[str] = {*tables.true_at_first}

    @classmethod
    def load(cls, path: str | Path, *, monitors: Listener | None = None, **options: Any) -> Controller:
        """Reads a controller from its JSON file.

        Args:
            path: The file.
            monitors: Take each event that the controller takes, before any hook is called.
            **options: As for the class.

        Raises:
            ControllerFileError: The file is no controller.
        """
        controller = cls(read(Path(path)), **options)
        if monitors is not None:
            controller.observe(lambda step: monitors.take(step.event) if step.taken else None)
        return controller

    @classmethod
    def from_document(cls, document: Mapping[str, Any], **options: Any) -> Controller:
        """A controller from the JSON object of a controller file."""
        return cls(Tables(document), **options)

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
    def unnoticed(self) -> frozenset[str]:
        """Hardware out of service of which the robot does not know it: detected late, and not yet."""
        with self._lock:
            late = self._tables.late.items()
            return frozenset(h for h, known in late if h in self._out_of_service and known not in self._true)

    @property
    def happened(self) -> frozenset[str]:
        """Handlers that happen once and have; a flat controller has this in its state alone."""
        with self._lock:
            return frozenset(self._true - self._tables.of_facts)

    @property
    def facts(self) -> Mapping[str, str]:
        """The value of each fact, as far as the events say it."""
        with self._lock:
            return self._tables.values(self._true)

    @property
    def outcome(self) -> str | None:
        """``success``, ``failure``, ``abort``, or ``None`` before the mission has ended."""
        with self._lock:
            return None if self._phase in (BEFORE, RUNNING) else self._phase

    @property
    def possible(self) -> tuple[str, ...]:
        """The events that can be taken now, sorted."""
        with self._lock:
            return tuple(sorted(self._tables.possible(self._position)))

    @property
    def _position(self) -> RuntimePosition:
        return RuntimePosition(self._phase, self._section, self._state, self._out_of_service, self._true)

    @property
    def where(self) -> Where:
        """Phase, section, state and what runs: all that an event may change, but for hardware and facts."""
        with self._lock:
            name = self._section.name if self._section else None
            return Where(self._phase, name, self._state, self.state)

    @property
    def timers(self) -> Mapping[str, float]:
        """By objective that ends when its time is over, the seconds that it has left, the fewest first."""
        with self._lock:
            return self._timers.left

    @property
    def overdue(self) -> str | None:
        """The event of the timer that was over first, to be handled now."""
        with self._lock:
            over = next((name for name, left in self._timers.left.items() if not left), None)
            return None if over is None else timeout_event(over)

    def tick(self) -> tuple[tuple[str, tuple[Action, ...]], ...]:
        """Takes the events of the timers that are over, the first one first; call it from time to time.

        Returns:
            Each event with its actions, as of :meth:`handle`.

        Raises:
            HookErrors: As of :meth:`handle`; later timers are left for the next time.
        """
        with self._lock:
            taken = []
            for _ in range(len(self._timers.left)):  # timers armed meanwhile are not over yet
                event = self.overdue
                if event is None:
                    break
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
            HookErrors: Hooks have failed; the event has been taken all the same.
        """
        with self._lock:
            actions, failed = self.react(event)
            self.hooks.call(event, actions, failed)
            return actions

    def react(self, event: str) -> tuple[tuple[Action, ...], list[HookError]]:
        """Takes an event without calling hooks, for those who carry out the actions themselves.

        Returns:
            The actions, and the failures of observers.

        Raises:
            Refused: As :meth:`handle`.
        """
        with self._lock:
            before, started = self.where, perf_counter()
            if isinstance(event, str):
                event = spelled(event, self._tables.known)
            actions = self._take(event)
            seconds = perf_counter() - started
            self.count += 1
            self.seconds += seconds
            self.slowest = max(self.slowest, seconds)
            taken = actions is not None
            after = self.where if taken else before
            step = Step(self.count, str(event), taken, actions or (), seconds, before, after)
            self.log.append(step)
            failed = self._call_observers(step)
            if actions is None:
                for each in failed:
                    _log.error("an observer has failed %s", each, exc_info=each.error)
                return self._refuse(event), []
            self._timers.follow(actions)
            if _log.isEnabledFor(logging.INFO):
                _log.info("%s: %s", event, "; ".join(map(str, actions)) or "nothing to do")
            return actions, failed

    def _call_observers(self, step: Step) -> list[HookError]:
        failed: list[HookError] = []
        for observer in self._observers:
            try:
                observer(step)
            except Exception as error:
                failed.append(HookError(step.event, None, error))
        return failed

    def _refuse(self, event: object) -> tuple[Action, ...]:
        self.refusals += 1
        self._timers.refused(event)
        known = isinstance(event, str) and event in self._tables.known
        refused = Refused(event, known, self.possible)
        _log.warning("refused: %s", refused)
        if self._on_refused is None:
            raise refused
        self._on_refused(refused)
        return ()

    def _take(self, event: str) -> tuple[Action, ...] | None:
        """Takes an event: changes the state and returns the actions; ``None`` where it cannot be taken."""
        if not isinstance(event, str):
            return None
        step = self._tables.after(self._position, event)
        if step is None:
            return None
        self._phase, self._section, self._state, self._out_of_service, self._true = step[0]
        return step[1]

    def on(self, activity: str | None, hook: Hook) -> None:
        """Has a function called with each action of one activity, after the state has changed.

        Args:
            activity: The activity; ``None`` for every action, those of hardware included.
            hook: What to call. Hooks are called in the order of the actions, then of their coming.
        """
        with self._lock:
            self.hooks.add(activity, hook)

    def observe(self, observer: Callable[[Step], object]) -> None:
        """Has a function called with each step, refused ones too, before any hook: a log, a monitor.

        What it raises does not keep the hooks from being called, and is raised with what they raise; at a
        refused event it is logged.
        """
        with self._lock:
            self._observers.append(observer)

    def snapshot(self, beside: Mapping[str, Any] | None = None) -> str:
        """Where the controller is, as a text to be given to :meth:`restore`.

        Args:
            beside: What is to stand in it besides, of JSON: where monitors are, which processes run.
        """
        return self.saved(beside).text(self._tables.digest)

    def saved(self, beside: Mapping[str, Any] | None = None) -> Saved:
        """What :meth:`snapshot` says, not as a text: for who goes back within one process."""
        with self._lock:
            return Saved(
                self._phase,
                self._section,
                self._state,
                set(self._out_of_service),
                set(self._true),
                self.count,
                self._timers.left,
                beside or {},
            )

    def beside(self, snapshot: str) -> Mapping[str, Any]:
        """What stands beside in a snapshot of this very controller.

        Raises:
            SnapshotError: As of :meth:`restore`.
        """
        return read_snapshot(snapshot, self._tables).beside

    def restore(self, snapshot: str) -> tuple[Action, ...]:
        """Goes back to where a snapshot was taken; the log and the times stay. No hook is called.

        Args:
            snapshot: What :meth:`snapshot` gave, of this very controller.

        Returns:
            The actions that bring the robot there, whatever it does now: every activity is stopped, all
            hardware released, and what runs selected and started.

        Raises:
            SnapshotError: It is truncated, changed, or of another controller; nothing has changed.
        """
        saved = read_snapshot(snapshot, self._tables)
        with self._lock:
            self.resume(saved)
            return tuple(actions_to(self.state, self._tables.laws))

    def resume(self, saved: Saved) -> None:
        """Goes back to where :meth:`saved` was asked of this very controller."""
        with self._lock:
            self._phase, self._section, self._state = saved.phase, saved.section, saved.state
            self._out_of_service, self._true = set(saved.out_of_service), set(saved.true)
            self.count = saved.count
            self._timers.restore(saved.timers)


__all__ = ["Controller", "ControllerFileError", "Hook", "Step", "Where"]
