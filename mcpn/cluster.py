"""Runs calls on the workers of a dask cluster; calls fail with an error when all workers are gone."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future, InvalidStateError
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any

from mcpn.errors import InputError, LimitError, McpnError, WorkersError

CONNECT_SECONDS = 10
"""How long to wait for a scheduler to answer, and then for its first worker."""

LOOK_SECONDS = 1.0
"""The time between two counts of the workers."""

MOST_LOOKS = 3
"""Counts in a row without any worker after which calls fail: a worker that restarts is back sooner."""


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """An executor of the workers of a dask scheduler; see :func:`mcpn.workers.executor_of`."""
    try:
        distributed: Any = import_module("distributed")
    except ImportError as error:
        raise LimitError("--scheduler needs dask: pip install 'mcpn[distributed]'") from error
    try:
        client = distributed.Client(address, timeout=f"{CONNECT_SECONDS}s")
    except (OSError, ValueError) as error:
        raise InputError.at(None, f"no dask scheduler answers at {address}: {error}") from error
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT_SECONDS)
        except TimeoutError as error:
            raise WorkersError(
                f"the dask scheduler at {address} has no workers: start some with dask worker {address}"
            ) from error
        executor = _Cluster(client, address)
        try:
            yield executor
        finally:
            executor.shutdown(wait=False)


class _Cluster(Executor):
    """An executor whose calls fail with a :class:`WorkersError` when all workers of the cluster are gone.

    Args:
        client: A client of the cluster's scheduler.
        address: The scheduler's address.
    """

    def __init__(self, client: Any, address: str) -> None:
        self._client, self._address = client, address
        self._executor = client.get_executor(pure=False)
        self._waiting: set[Future[Any]] = set()
        self._ended = threading.Event()
        self._watch = threading.Thread(target=self._watching, daemon=True)
        self._watch.start()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Sends a call to a worker."""
        promised: Future[Any] = Future()
        self._waiting.add(promised)
        sent = self._executor.submit(fn, *args, **kwargs)
        sent.add_done_callback(lambda done: self._done(promised, done))
        return promised

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Ends the watch of the workers; results of calls under way are not waited for."""
        self._ended.set()

    def _done(self, promised: Future[Any], done: Future[Any]) -> None:
        self._waiting.discard(promised)
        with suppress(InvalidStateError):  # the watch has failed it already
            try:
                promised.set_result(done.result())
            except (McpnError, MemoryError) as error:
                promised.set_exception(error)
            except (Exception, CancelledError) as error:
                promised.set_exception(self._translated(error))

    def _translated(self, error: BaseException) -> BaseException:
        """An error of the cluster itself as a :class:`WorkersError`; any other error as it is."""
        kind = type(error)
        if kind.__name__ == "KilledWorker":
            return WorkersError(
                f"workers of the dask scheduler at {self._address} died, one after the other, over the same "
                "section: they may have too little memory"
            )
        if isinstance(error, CancelledError) or kind.__module__.startswith(
            ("distributed", "dask", "tornado")
        ):
            text = str(error) or kind.__name__
            return WorkersError(f"the dask scheduler at {self._address} gave up the work: {text}")
        return error

    def _watching(self) -> None:
        """Counts the workers again and again; when there are none, fails all calls under way."""
        absent = 0
        while not self._ended.wait(LOOK_SECONDS):
            try:
                absent = 0 if self._client.nthreads() else absent + 1
            except Exception:  # whatever a connection that breaks raises
                absent += 1
            if absent >= MOST_LOOKS:
                error = WorkersError(f"the last worker of the dask scheduler at {self._address} is gone")
                for promised in list(self._waiting):
                    self._waiting.discard(promised)
                    with suppress(InvalidStateError):
                        promised.set_exception(error)
