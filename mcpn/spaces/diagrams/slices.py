"""Ends an operation on diagrams when the slice of CPU time is spent that its caller gives it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from mcpn._kernel import Store


class _SliceSpent(Exception):
    """What is asked has had its slice."""


@contextmanager
def within_seconds(store: Store | None, seconds: float) -> Iterator[None]:
    """Ends what is inside when a diagram has had so much CPU time, whatever else the machine does.

    Args:
        store: That of the diagram; without one nothing is ended.
        seconds: Of CPU time of this process.
    """
    if store is None:
        yield
        return
    before, until = store.progress, time.process_time() + seconds

    def watch(nodes: int) -> None:
        if before is not None:
            before(nodes)
        if time.process_time() > until:
            raise _SliceSpent

    store.progress = watch
    try:
        yield
    except _SliceSpent:
        pass
    finally:
        store.progress = before
