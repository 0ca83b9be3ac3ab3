"""Operations on stores of many levels, which run on a thread with a deep stack."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from mcpn._kernel import BudgetExceeded, MemoryLimit, Store, Zdd
from tests.conftest import ROOT, interruptible
from tests.kernel.test_store import permutations, switches

DEEP = 5000
"""More levels than operations on the calling thread recurse through."""


def everything(levels: int) -> tuple[Store, Zdd]:
    store = Store(levels)
    return store, store.singleton([]).saturate(switches(store))


def log2_of_everything(levels: int) -> int:
    return everything(levels)[1].count().bit_length() - 1


def test_calls_of_all_depths_follow_each_other() -> None:
    for levels in (401, 20_000, 401, 40_000, 1000):
        assert log2_of_everything(levels) == levels


def test_errors_travel_and_the_next_call_is_right() -> None:
    store = Store(DEEP, memory_limit=8 << 20)
    start, events = store.singleton([]), switches(store)
    for _ in range(3):
        with pytest.raises(BudgetExceeded):
            start.saturate(events, 10)
        with pytest.raises(MemoryLimit):
            Store(DEEP, memory_limit=1 << 10).singleton([0])
        assert (start | store.singleton([0])).count() == 2


def threads() -> int:
    return len(os.listdir("/proc/self/task"))


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc")
def test_one_thread_serves_them_all() -> None:
    store = Store(DEEP)
    sets = [store.singleton([level]) for level in range(100)]
    before = threads()
    union = store.empty()
    for each in sets:
        union |= each
    assert union.count() == 100
    assert threads() == before


def test_operations_at_the_same_time_have_a_thread_each() -> None:
    found: list[int] = []

    def work() -> None:
        for _ in range(5):
            found.append(log2_of_everything(DEEP))

    workers = [threading.Thread(target=work) for _ in range(6)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert found == [DEEP] * 30


def test_progress_of_one_operation_may_begin_another() -> None:
    store, start, events = permutations(30, memory_limit=1 << 36)
    assert store.levels > 400
    inner: list[int] = []

    class Enough(Exception):
        pass

    def progress(_: int) -> None:
        inner.append(log2_of_everything(DEEP))
        raise Enough

    store.progress = progress
    with pytest.raises(Enough):
        start.saturate(events)
    assert inner == [DEEP]
    assert log2_of_everything(DEEP) == DEEP


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_processes_made_after_the_first_operation(method: str) -> None:
    assert log2_of_everything(DEEP) == DEEP
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map_async(log2_of_everything, [DEEP, 401, 1000]).get(120) == [DEEP, 401, 1000]
    assert log2_of_everything(DEEP) == DEEP


SCRIPTS = {
    # What is done at the end of a process does not wait for a thread that it never had.
    "a child of fork that ends as any process": (
        "assert log2_of_everything(5000) == 5000\n"
        "child = os.fork()\n"
        "if not child:\n    assert log2_of_everything(1000) == 1000\n    sys.exit(7)\n"
        "assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7\n"
    ),
    "a child of fork that does nothing": (
        "assert log2_of_everything(5000) == 5000\n"
        "child = os.fork()\n"
        "if not child:\n    sys.exit(7)\n"
        "assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7\n"
    ),
    # The operation is at work on a thread that only the parent has.
    "a child of fork in the middle of an operation": (
        "store, start, events = permutations(30, memory_limit=1 << 36)\n"
        "class Enough(Exception): pass\n"
        "child = None\n"
        "def progress(_):\n"
        "    global child\n"
        "    child = os.fork()\n"
        "    if child: raise Enough\n"
        "store.progress = progress\n"
        "try:\n    start.saturate(events)\n"
        "except Enough:\n"
        "    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7\n"
        "    assert start.count() == 1\n"
        "except RuntimeError as error:\n"
        "    assert child == 0 and 'forked' in str(error), error\n"
        "    assert log2_of_everything(1000) == 1000\n"
        "    sys.exit(7)\n"
        "else:\n    raise AssertionError\n"
    ),
}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("script", SCRIPTS.values(), ids=SCRIPTS.keys())
def test_processes_end(script: str) -> None:
    head = (
        f"import os, sys, threading, time\nsys.path.append({str(ROOT)!r})\n"
        "from tests.kernel.test_deep import log2_of_everything\n"
        "from tests.kernel.test_store import permutations\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", head + script + "print('end')\n"],
        check=False,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert (run.returncode, run.stdout) == (0, "end\n"), run.stderr


def test_signals_reach_the_interpreter() -> None:
    """The thread that stands ready takes no signal: a waiting interpreter would not wake."""
    script = (
        f"import sys, time\nsys.path.append({str(ROOT)!r})\n"
        "from tests.kernel.test_deep import log2_of_everything\n"
        "log2_of_everything(5000)\n"
        "try:\n    print('ready', flush=True)\n"
        "    time.sleep(100)\nexcept KeyboardInterrupt:\n    print('stopped')\n"
    )
    command = [sys.executable, "-c", script]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, preexec_fn=interruptible) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)
    assert out == "stopped\n"
