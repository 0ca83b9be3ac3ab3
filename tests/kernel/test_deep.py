"""Operations on stores of many levels: on the caller's stack where it has room, else on another thread."""

from __future__ import annotations

import multiprocessing
import os
import resource
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
"""More levels than operations recurse through on a stack of :data:`STACK`."""
STACK = 8 << 20
"""Bytes of the first thread's stack, as most systems have them."""


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


@pytest.mark.parametrize("size", [30, 50], ids=["on the caller's stack", "on a thread"])
def test_progress_of_one_operation_may_begin_another(size: int) -> None:
    store, start, events = permutations(size, memory_limit=1 << 36)
    inner: list[int] = []

    class Enough(Exception):
        pass

    def progress(_: int) -> None:
        inner.extend(log2_of_everything(levels) for levels in (1000, DEEP))
        raise Enough

    store.progress = progress
    with pytest.raises(Enough):
        start.saturate(events)
    assert inner == [1000, DEEP]
    assert log2_of_everything(DEEP) == DEEP


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_processes_made_after_the_first_operation(method: str) -> None:
    assert log2_of_everything(DEEP) == DEEP
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map_async(log2_of_everything, [DEEP, 401, 1000]).get(120) == [DEEP, 401, 1000]
    assert log2_of_everything(DEEP) == DEEP


HEAD = (
    f"import os, resource, sys, threading, time\nsys.path.append({str(ROOT)!r})\n"
    "from tests.kernel.test_deep import everything, log2_of_everything, threads\n"
    "from tests.kernel.test_store import permutations\n"
)


def usual_stack() -> None:
    """For ``preexec_fn``: a child whose first thread has the stack that most systems give it."""
    interruptible()
    resource.setrlimit(resource.RLIMIT_STACK, (STACK, resource.getrlimit(resource.RLIMIT_STACK)[1]))


def alone(script: str) -> subprocess.CompletedProcess[str]:
    """What a script does in a process of its own, which has no thread yet."""
    return subprocess.run(
        [sys.executable, "-c", HEAD + script],
        check=False,
        capture_output=True,
        text=True,
        timeout=120,
        preexec_fn=usual_stack,
    )


WHERE = (
    "def work():\n"
    "    before = threads()\n"
    "    assert log2_of_everything({levels}) == {levels}\n"
    "    print(threads() - before)\n"
)
FIRST = WHERE + "work()\n"
ANOTHER = WHERE + (
    "threading.stack_size({stack})\nworker = threading.Thread(target=work)\nworker.start()\nworker.join()\n"
)


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc")
@pytest.mark.parametrize(
    ("script", "levels", "stack", "made"),
    [
        (FIRST, 300, STACK, 0),
        (FIRST, 3000, STACK, 0),
        (FIRST, DEEP, STACK, 1),
        (ANOTHER, 3000, STACK, 0),
        (ANOTHER, DEEP, STACK, 1),
        (ANOTHER, 300, 256 << 10, 1),
        (ANOTHER, 1000, 2 << 20, 1),
    ],
)
def test_another_thread_serves_where_the_stack_has_no_room(
    script: str, levels: int, stack: int, made: int
) -> None:
    run = alone(script.format(levels=levels, stack=stack))
    assert (run.returncode, run.stdout) == (0, f"{made}\n"), run.stderr


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc")
def test_a_stack_whose_limit_is_lowered_has_less_room() -> None:
    run = alone(
        "assert log2_of_everything(3000) == 3000\n"
        "before = threads()\n"
        "hard = resource.getrlimit(resource.RLIMIT_STACK)[1]\n"
        "resource.setrlimit(resource.RLIMIT_STACK, (2 << 20, hard))\n"
        "assert log2_of_everything(3000) == 3000\n"
        "print(threads() - before)\n"
    )
    assert (run.returncode, run.stdout) == (0, "1\n"), run.stderr


def recursing(levels: int) -> None:
    """Operations that recurse through all levels, those with the largest frames among them."""
    store, all_ = everything(levels)
    evens = store.singleton(list(range(0, levels, 2)))
    moves = [store.event([at], [at + 1]) for at in range(levels - 1)]
    across = store.event([0, levels - 2], [1, levels - 1])
    assert (store.singleton([]) | evens).count() == 2
    one = store.singleton([0])
    assert one.saturate(moves, within=all_).count() == levels
    assert one.saturate(moves[::-1]) == one.saturate(moves)
    assert (all_ - evens).count() == 2**levels - 1
    assert all_.images([*moves, across], within=all_)
    assert all_.beyond(evens, [*moves, across])
    assert all_.without([store.condition([0, levels - 1])]).count() == 3 * 2 ** (levels - 2)
    assert all_.onto(range(0, levels, 2)).count() == 2 ** ((levels + 1) // 2)
    assert evens.weighing([1] * levels, 0, levels) == evens
    assert all_.largest([1] * levels) == levels
    assert store.from_bytes(all_.to_bytes()) == all_


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc")
@pytest.mark.parametrize("stack", [2 << 20, 4 << 20, 16 << 20])
def test_what_has_room_fits(stack: int) -> None:
    """More and more levels, until there is no room: all before run on the caller's stack, and fit."""
    run = alone(
        "from tests.kernel.test_deep import recursing\n"
        "def work():\n"
        "    before, levels = threads(), 300\n"
        "    while threads() == before:\n"
        "        recursing(levels)\n"
        "        levels = levels * 21 // 20\n"
        "    print(levels)\n"
        f"threading.stack_size({stack})\nworker = threading.Thread(target=work)\n"
        "worker.start()\nworker.join()\n"
    )
    assert run.returncode == 0, run.stderr
    assert int(run.stdout) > 300


@pytest.mark.skipif(not Path("/proc/self/statm").is_file(), reason="needs /proc")
@pytest.mark.parametrize("more", [16 << 10, 1 << 20, 4 << 20])
def test_where_addresses_are_limited_the_stack_is_not_relied_on(more: int) -> None:
    """The first thread's stack is mapped as it grows: where it could not, the process would end."""
    run = alone(
        "from mcpn._kernel import Store\n"
        "store = Store(3000)\n"
        "used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
        f"resource.setrlimit(resource.RLIMIT_AS, (used + {more}, used + {more}))\n"
        "try:\n    store.singleton([])\n"
        "except MemoryError:\n    print('refused')\n"
    )
    assert (run.returncode, run.stdout) == (0, "refused\n"), run.stderr


@pytest.mark.skipif(not Path("/proc/self/statm").is_file(), reason="needs /proc")
@pytest.mark.parametrize("levels", [1000, 3000])
def test_where_addresses_are_limited_the_stack_is_mapped_first(levels: int) -> None:
    run = alone(
        "used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
        "resource.setrlimit(resource.RLIMIT_AS, (used + (1 << 30), used + (1 << 30)))\n"
        + FIRST.format(levels=levels)
    )
    assert (run.returncode, run.stdout) == (0, "0\n"), run.stderr


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
    "a child of fork in the middle of an operation on a thread": (
        "store, start, events = permutations(50, memory_limit=1 << 36)\n"
        "class Enough(Exception): pass\n"
        "child = None\n"
        "def progress(_):\n"
        "    global child\n"
        "    child = os.fork()\n"
        "    if child: raise Enough\n"
        "store.progress = progress\n"
        "try:\n    start.saturate(events)\n"
        "except Enough:\n"
        "    store.progress = None\n"
        "    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7\n"
        "    assert start.count() == 1\n"
        "except RuntimeError as error:\n"
        "    assert child == 0 and 'forked' in str(error), error\n"
        "    assert log2_of_everything(1000) == 1000\n"
        "    sys.exit(7)\n"
        "else:\n    raise AssertionError\n"
    ),
    # Both have the stack that the operation is at work on.
    "a child of fork in the middle of an operation on the caller's stack": (
        "store, start, events = permutations(30, memory_limit=1 << 36)\n"
        "class Enough(Exception): pass\n"
        "children = []\n"
        "def progress(_):\n"
        "    if not children: children.append(os.fork())\n"
        "    else: raise Enough\n"
        "store.progress = progress\n"
        "try:\n    start.saturate(events)\n"
        "except Enough:\n"
        "    store.progress = None\n"
        "    assert start.count() == 1 and log2_of_everything(5000) == 5000\n"
        "    if children == [0]: sys.exit(7)\n"
        "    assert os.waitstatus_to_exitcode(os.waitpid(*children, 0)[1]) == 7\n"
        "else:\n    raise AssertionError\n"
    ),
}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("script", SCRIPTS.values(), ids=SCRIPTS.keys())
def test_processes_end(script: str) -> None:
    run = alone(script + "print('end')\n")
    assert (run.returncode, run.stdout) == (0, "end\n"), run.stderr


def stopped(script: str) -> str:
    """What a script prints that is interrupted once it is ready."""
    command = [sys.executable, "-c", HEAD + script]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, preexec_fn=usual_stack) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)
    return out


def test_signals_reach_the_interpreter() -> None:
    """The thread that stands ready takes no signal: a waiting interpreter would not wake."""
    assert (
        stopped(
            "log2_of_everything(5000)\n"
            "try:\n    print('ready', flush=True)\n"
            "    time.sleep(100)\nexcept KeyboardInterrupt:\n    print('stopped')\n"
        )
        == "stopped\n"
    )


@pytest.mark.parametrize("size", [30, 50], ids=["on the caller's stack", "on a thread"])
def test_a_signal_ends_an_operation(size: int) -> None:
    assert (
        stopped(
            f"store, start, events = permutations({size}, memory_limit=1 << 36)\n"
            "told = []\n"
            "def tell(_):\n"
            "    if not told:\n"
            "        told.append(1)\n"
            "        print('ready', flush=True)\n"
            "store.progress = tell\n"
            "try:\n    start.saturate(events)\n"
            "except KeyboardInterrupt:\n"
            "    assert start.count() == 1 and log2_of_everything(5000) == 5000\n"
            "    print('stopped')\n"
        )
        == "stopped\n"
    )
