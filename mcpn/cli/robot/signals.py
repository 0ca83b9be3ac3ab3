"""Signals that end a robot's run in order, or would suspend it."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from mcpn.cli import SIGNALS

SUSPENDING = {signal.SIGTSTP}
"""The signal that would suspend mcpn, with nobody in charge of what runs."""
IGNORED = {signal.SIGTTIN, signal.SIGTTOU}
"""Signals of a terminal to what runs in the background: each write that is tried again would raise one."""


@contextmanager
def caught(stop: Callable[[int], None]) -> Iterator[None]:
    """Has a function called on the loop's thread with each signal that would end or suspend this process.

    Signals have a way of their own into the loop: in the one that asyncio shares with calls from threads,
    they can be lost behind these. One that is ignored stays so (SIGHUP under ``nohup``). Where one has come,
    all is stopped in the end, and a further one ends the process with the exit code of the first.
    """
    loop = asyncio.get_running_loop()
    heard, waking = socket.socketpair()
    received: list[int] = []
    codes: list[int] = []

    def leave(_number: int, _frame: FrameType | None) -> None:
        os._exit(codes[0])

    def note(number: int, _frame: FrameType | None) -> None:
        received.append(number)
        codes.append(128 + number)

    def take() -> None:
        with suppress(BlockingIOError):
            heard.recv(4096)
        while received:
            stop(received.pop(0))

    before = {}
    for end in (heard, waking):
        end.setblocking(False)
    loop.add_reader(heard.fileno(), take)
    woken = signal.set_wakeup_fd(waking.fileno(), warn_on_full_buffer=False)
    try:
        for number in SIGNALS | SUSPENDING:
            handler = signal.getsignal(number)
            if handler is not None and handler is not signal.SIG_IGN:
                before[number] = signal.signal(number, note)
        for number in IGNORED:
            before[number] = signal.signal(number, signal.SIG_IGN)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, leave if codes and number not in IGNORED else handler)
        signal.set_wakeup_fd(woken)
        loop.remove_reader(heard.fileno())
        take()
        heard.close()
        waking.close()
