"""One start of a driver: what it is called with, and what it tells while it runs."""

from __future__ import annotations

import asyncio
import json
import logging
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Protocol

from mcpn.robot.drivers.functions import Call, FunctionDriver, function_of
from mcpn.robot.drivers.inbox import Inbox
from mcpn.robot.drivers.mapping import DriverSpec, Topics, filled
from mcpn.robot.drivers.processes import NOT_STARTED, ProcessDriver, Warden
from mcpn.robot.drivers.topics import Bus, StopMessage, TopicDriver

_log = logging.getLogger("mcpn.robot.drivers")


class _Driver(Protocol):
    async def start(self) -> None: ...

    def kill(self) -> None: ...

    async def stop(self, grace: float) -> bool: ...


class Started:
    """A driver from its start to its stop; what it reports after that no longer counts.

    Args:
        spec: What it is.
        name: The activity, the source or the hardware.
        alternative: The alternative.
        objective: The objective that the activity is started for.
        parameters: Their texts, by name.
        number: How many drivers were started before.
        told: Called on the loop's thread with each text that ``lines`` or ``ends`` map to, and with ``None``
            and the line where they do not.
        ready: Whether what it tells can be taken now; until then it waits.
        keeper: Hears of the process that it is.
    """

    def __init__(
        self,
        spec: DriverSpec,
        name: str,
        alternative: str | None,
        objective: str | None,
        parameters: Mapping[str, str],
        number: int,
        told: Callable[[Started, str | None, str], None],
        ready: Callable[[], bool],
        keeper: Warden,
    ) -> None:
        self.spec, self.name, self.alternative, self.objective = spec, name, alternative, objective
        self.parameters, self.number, self._told = parameters, number, told
        self.over = False
        """Whether it has been stopped, or is to be."""
        self._driver: _Driver | None = None
        self._ended = asyncio.Event()
        self._inbox = Inbox(self._line, ready)
        self._warden = keeper

    async def start(self, folder: Path, buses: Mapping[str, Bus]) -> None:
        """Starts it; a driver that cannot be started has ended."""
        try:
            self._driver = self._made(folder, buses)
            if self._driver is not None:
                await self._driver.start()
        except Exception as error:  # whatever starting raises: a missing program, a callable's own error
            self._driver = None
            self._has_ended(NOT_STARTED, error)

    def _made(self, folder: Path, buses: Mapping[str, Bus]) -> _Driver | None:
        spec, say = self.spec, self._inbox.put

        def ended(how: str, error: Exception | None) -> None:
            self._inbox.put(lambda: self._has_ended(how, error))  # behind what it told before

        if spec.kind == "process":
            command = [filled(text, self._values) for text in spec.command]
            return ProcessDriver(
                str(self), command, folder, self._inbox, self._has_ended, spec.stop, spec.grace, self._warden
            )
        if spec.kind == "python":
            call = Call(self.name, self.alternative, self.objective, self.parameters, say)
            return FunctionDriver(function_of(spec.function, folder), call, ended)
        if self.topics is not None:
            return TopicDriver(buses[spec.kind], self.topics, self._message, say)
        return None

    @property
    def _own(self) -> dict[str, str | None]:
        return {"activity": self.name, "alternative": self.alternative, "objective": self.objective}

    @property
    def _values(self) -> dict[str, str]:
        """What fills the holes of its texts."""
        said = {key: value for key, value in self._own.items() if value is not None}
        return {**self.parameters, **said, "run": str(self.number), "python": sys.executable}

    @property
    def _message(self) -> str:
        return json.dumps({**self._own, "run": self.number, "parameters": dict(self.parameters)})

    @property
    def topics(self) -> Topics | None:
        """Where it is reached by messages, if it is."""
        if self.spec.kind not in ("mqtt", "zenoh"):
            return None
        given, values = self.spec.topics, self._values
        start, stop, says = (
            None if text is None else filled(text, values) for text in (given.start, given.stop, given.says)
        )
        return Topics(start, stop, says)

    @property
    def to_stop(self) -> StopMessage | None:
        """The message that tells it to stop, if one does."""
        if self.topics is None or self.topics.stop is None:
            return None
        return StopMessage(self.spec.kind, self.topics.stop, self._message)

    def _line(self, line: str) -> None:
        if not self.over:
            self._told(self, self.spec.of_line(line), line)

    def _has_ended(self, how: str, error: Exception | None) -> None:
        self._ended.set()
        if error is not None:
            _log.error("%s: %r", self, error, exc_info=error if how != NOT_STARTED else None)
        if not self.over:
            self._told(self, self.spec.of_end(how), f"ended: {how}")

    async def ended(self) -> None:
        """Waits until it has ended by itself, which what is reached by messages never does."""
        if self.spec.kind in ("process", "python"):
            await self._ended.wait()

    def leave(self) -> None:
        """What it reports from now on no longer counts."""
        self.over = True
        self._inbox.close()

    async def stop(self, hurry: bool = False) -> None:
        """Stops it.

        Args:
            hurry: Whether it has no time to end by itself.
        """
        self.leave()
        if self._driver is None:
            return
        try:
            in_time = await self._driver.stop(0.0 if hurry else self.spec.grace)
        except Exception as error:  # of what carries messages; the others are to be stopped all the same
            _log.error("%s cannot be stopped: %r", self, error, exc_info=error)
            return
        if not in_time:
            _log.warning("%s has not ended within %g seconds", self, self.spec.grace)

    def kill(self) -> None:
        """Ends it at once, or waits no longer for its end."""
        if self._driver is not None:
            self._driver.kill()

    def __str__(self) -> str:
        return self.name if self.alternative in (None, self.name) else f"{self.name} ({self.alternative})"
