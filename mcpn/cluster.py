"""Work for the workers of a dask cluster, given up when they are gone."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future, InvalidStateError
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any

from mcpn.errors import InputError, LimitError, McpnError, WorkersError

CONNECT_SECONDS = 10
"""How long a scheduler may take to answer, and until it has a worker."""

LOOK_SECONDS = 1.0
"""How often the workers are counted while they work."""

MOST_LOOKS = 3
"""How often in a row none may be there: one that restarts is soon back."""


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
    """Work for a dask cluster, given up when its workers are gone.

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
        given: Future[Any] = Future()
        self._waiting.add(given)
        self._executor.submit(fn, *args, **kwargs).add_done_callback(lambda done: self._done(given, done))
        return given

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Ends the watch; what is under way is nobody's any more."""
        self._ended.set()

    def _done(self, given: Future[Any], done: Future[Any]) -> None:
        self._waiting.discard(given)
        with suppress(InvalidStateError):  # it was given up
            try:
                given.set_result(done.result())
            except (McpnError, MemoryError) as error:
                given.set_exception(error)
            except (Exception, CancelledError) as error:
                given.set_exception(self._lost(error))

    def _lost(self, error: BaseException) -> BaseException:
        """Says of an error of the cluster itself what has happened."""
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
        """Counts the workers now and then; where there are none, what waits is given up."""
        absent = 0
        while not self._ended.wait(LOOK_SECONDS):
            try:
                absent = 0 if self._client.nthreads() else absent + 1
            except Exception:  # whatever a connection that breaks raises
                absent += 1
            if absent >= MOST_LOOKS:
                error = WorkersError(f"the last worker of the dask scheduler at {self._address} is gone")
                for given in list(self._waiting):
                    self._waiting.discard(given)
                    with suppress(InvalidStateError):
                        given.set_exception(error)
