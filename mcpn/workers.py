"""Where sections are explored side by side: processes of this machine, or the workers of a dask cluster.

What goes to workers and comes back is pickled, and dask runs what it is sent: a scheduler is trusted like a
program that one starts.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future
    from multiprocessing.process import BaseProcess

# Both kinds are loaded when they are asked for.

_WORKERS: ContextVar[Executor | None] = ContextVar("workers", default=None)


def workers() -> Executor | None:
    """Where what can be explored in parts is; ``None`` for this process, which is the default."""
    return _WORKERS.get()


@contextmanager
def using(executor: Executor | None) -> Iterator[None]:
    """Has an executor explore what is explored in parts meanwhile.

    Args:
        executor: Any executor whose calls are pickled; ``None`` for this process.
    """
    before = _WORKERS.set(executor)
    try:
        yield
    finally:
        _WORKERS.reset(before)


@contextmanager
def workers_of(jobs: int = 1, scheduler: str | None = None) -> Iterator[None]:
    """Uses what :func:`executor_of` gives."""
    with executor_of(jobs, scheduler) as executor, using(executor):
        yield


@contextmanager
def executor_of(jobs: int = 1, scheduler: str | None = None) -> Iterator[Executor | None]:
    """Where local graphs are made: a cluster, processes, or this process.

    Args:
        jobs: How many processes; one for this process alone.
        scheduler: The address of a dask scheduler.

    Yields:
        An executor, or ``None`` for this process. What it is asked for ends in a WorkersError where the
        workers are gone.

    Raises:
        InputError: No scheduler answers at the address.
        LimitError: dask is not installed.
        WorkersError: The scheduler has no workers.
    """
    if scheduler is not None:
        from mcpn.cluster import cluster

        with cluster(scheduler) as executor:
            yield executor
    elif jobs > 1:
        from multiprocessing import active_children

        before = set(active_children())
        pool = _pool(jobs)
        try:
            yield pool
        finally:
            with _signals_wait():
                _end(pool, set(active_children()) - before)
    else:
        yield None


_SECONDS = 5.0
"""For the thread that manages a pool to end, which takes milliseconds."""


def _end(pool: Executor, processes: Iterable[BaseProcess]) -> None:
    """Ends a pool whose work is done or needed no more; leaving it would wait for all that it was given.

    Its manager is awaited: it closes a pipe which multiprocessing closes, too, as the program ends, and of
    two at once the second prints a traceback.
    """
    calls, results, manager = (
        getattr(pool, name, None) for name in ("_call_queue", "_result_queue", "_executor_manager_thread")
    )
    for process in processes:
        process.kill()
    # The manager would wait for ever where work that nobody reads fills a pipe, and for the rest of a result.
    if calls is not None:
        calls.cancel_join_thread()
    if results is not None:
        results._writer.close()
    pool.shutdown(wait=False, cancel_futures=True)
    if manager is not None:
        manager.join(_SECONDS)


def _pool(jobs: int) -> Executor:
    """Processes that no signal to their group ends: who asks them does.

    So none prints a traceback of its own, and multiprocessing's tracker of resources outlives them.
    """
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    class QuietPool(ProcessPoolExecutor):
        def submit(self, *call: Any, **named: Any) -> Future[Any]:
            with _signals_wait():  # a process that this starts has them blocked from the first
                return super().submit(*call, **named)

    with _signals_wait():
        return QuietPool(jobs, mp_context=get_context("spawn"), initializer=_end_with_parent)


@contextmanager
def _signals_wait() -> Iterator[None]:
    """Blocks the signals that end a process, for this thread and what it starts."""
    import signal

    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    ending = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    try:
        signal.pthread_sigmask(signal.SIG_BLOCK, ending)  # which may still raise what came before
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_with_parent() -> None:
    """Has this process end when its parent does, however that ends: else it waits for work for ever."""
    import os
    import threading
    from multiprocessing import connection, parent_process

    parent = parent_process()

    def watch() -> None:
        if parent is not None:
            connection.wait([parent.sentinel])
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
