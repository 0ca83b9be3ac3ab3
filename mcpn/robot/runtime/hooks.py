"""Hooks: functions that are called with actions, and what happens when they raise errors."""

from __future__ import annotations

import inspect
import logging
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from mcpn.robot.runtime.actions import Action

Hook = Callable[[Action], object]
"""Called with an action; :class:`mcpn.robot.runtime.AsyncController` awaits what it returns, if it can be."""

_log = logging.getLogger("mcpn.robot.runtime")

if sys.version_info < (3, 11):  # what ROS 2 Humble has

    class ExceptionGroup(Exception):
        """Several errors as one: what Python 3.11 has, as far as it is used here."""

        message: str
        exceptions: tuple[Exception, ...]

        def __new__(cls, message: str, exceptions: Sequence[Exception]) -> ExceptionGroup:
            """The errors, with what they have in common."""
            made = super().__new__(cls, message, exceptions)
            made.message, made.exceptions = message, tuple(exceptions)
            return made

        def __str__(self) -> str:
            several = "s" * (len(self.exceptions) != 1)
            return f"{self.message} ({len(self.exceptions)} sub-exception{several})"


@dataclass(frozen=True, slots=True)
class HookError:
    """A failed call of a hook, or of an observer (``Controller.observe``).

    Args:
        event: The event that was handled.
        action: The action that the hook was called with; ``None`` for an observer.
        error: What the hook or observer raised.
    """

    event: str
    action: Action | None
    error: Exception

    def __str__(self) -> str:
        return f"on {self.event}, at {self.action or 'no action'}: {self.error!r}"


class HookErrors(ExceptionGroup):
    """Hooks have failed; the event has been taken, and all other hooks were called.

    Attributes:
        failed: Each failure with its event and action.
    """

    failed: tuple[HookError, ...]

    def __new__(cls, failed: tuple[HookError, ...]) -> HookErrors:
        """An exception that holds those of the hooks."""
        made = super().__new__(
            cls, "hooks have failed; the event has been taken", [each.error for each in failed]
        )
        made.failed = failed
        return made


OnError = Literal["log", "stop"] | Callable[[HookError], object]
"""What a loop that handles events does when hooks fail: ``log`` logs each failure and goes on, ``stop`` ends
the loop by :class:`HookErrors`, a function is called with each failure."""


def settle(failed: HookErrors, on_error: OnError) -> None:
    """Logs failures, then does with them what ``on_error`` says.

    Raises:
        HookErrors: It was ``stop``.
    """
    for each in failed.failed:
        _log.error("a hook has failed %s", each, exc_info=each.error)
        if callable(on_error):
            on_error(each)
    if on_error == "stop":
        raise failed


class Hooks:
    """Functions that are called with actions."""

    def __init__(self) -> None:
        self._by_activity: dict[str | None, list[Hook]] = {}

    def add(self, activity: str | None, hook: Hook) -> None:
        """Adds a hook of one activity, or of all actions."""
        self._by_activity.setdefault(activity, []).append(hook)

    def of(self, action: Action) -> Iterator[Hook]:
        """The hooks of an action: its activity's in the order of their coming, then those of all actions."""
        if action.activity is not None:
            yield from self._by_activity.get(action.activity, ())
        yield from self._by_activity.get(None, ())

    def call(self, event: str, actions: tuple[Action, ...], failed: list[HookError]) -> None:
        """Calls each hook of each action, whether others fail or not.

        Args:
            event: The event that was handled.
            actions: The actions.
            failed: Failures so far, to which those of hooks are added.

        Raises:
            HookErrors: Some have failed.
        """
        for action in actions if self._by_activity else ():
            for hook in self.of(action):
                try:
                    result = hook(action)
                    if inspect.iscoroutine(result):
                        result.close()
                        raise TypeError("the hook is a coroutine, which AsyncController alone awaits")
                except Exception as error:
                    failed.append(HookError(event, action, error))
        if failed:
            raise HookErrors(tuple(failed))

    async def await_each(self, event: str, actions: tuple[Action, ...], failed: list[HookError]) -> None:
        """Calls the hooks of each action in turn, and awaits what a hook returns before it calls the next."""
        for action in actions if self._by_activity else ():
            for hook in self.of(action):
                try:
                    result = hook(action)
                    if inspect.isawaitable(result):
                        await result
                except Exception as error:
                    failed.append(HookError(event, action, error))
        if failed:
            raise HookErrors(tuple(failed))
