"""Workers: processes and clusters that do the work, and what is said where they are gone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import process
from contextlib import suppress
from multiprocessing import active_children
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest

from mcpn.composite.composing import composite_space
from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError, WorkersError
from mcpn.workers import executor_of, using
from tests.commands import mcpn, output
from tests.conftest import ROOT, interruptible
from tests.dying import begin_result, die, wait

ULYSSE = ROOT / "experiments" / "ulysse" / "mission.xml"
COMMANDS = (
    ["check"],
    ["causes"],
    ["ask", "EF success"],
    ["report", "-o", "{folder}/r.html"],
    ["controller", "-o", "{folder}/c"],
)


def asking(command: list[str], folder: Path) -> list[object]:
    name, *rest = (part.format(folder=folder) for part in command)
    named = [] if name == "controller" else ["--engine", "local"]
    return [name, ULYSSE, *rest, *named]


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """A dask cluster in processes of its own."""
    distributed = pytest.importorskip("distributed", reason="needs mcpn[distributed]")
    with distributed.LocalCluster(1, threads_per_worker=1, dashboard_address=None) as found:
        yield found


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(command, id=command[0], marks=[pytest.mark.slow] * (command[0] in ("ask", "report")))
        for command in COMMANDS
    ],
)
def test_sections_are_explored_where_the_user_says(command: list[str], tmp_path: Path, cluster: Any) -> None:
    asked = asking(command, tmp_path)
    answers = [
        output(*asked, *where) for where in ((), ("--jobs", 2), ("--scheduler", cluster.scheduler_address))
    ]
    for answer in answers:
        for part in answer if isinstance(answer, list) else [answer]:
            part.pop("seconds", None)
            part.pop("bytes", None)
    assert answers[0] == answers[1] == answers[2]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
def test_a_scheduler_without_workers_says_so(command: list[str], tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed", reason="needs mcpn[distributed]")
    scheduler = {"cls": distributed.Scheduler, "options": {"port": 0, "dashboard": False}}
    with (
        patch("mcpn.cluster.CONNECT_SECONDS", 1),
        distributed.SpecCluster(workers={}, scheduler=scheduler) as empty,
    ):
        run = mcpn(*asking(command, tmp_path), "--scheduler", empty.scheduler_address)
    assert run.returncode == 2
    assert run.stderr.splitlines()[-1] == (
        f"error: the dask scheduler at {empty.scheduler_address} has no workers: "
        f"start some with dask worker {empty.scheduler_address}"
    )
    assert not list(tmp_path.iterdir())


def test_no_scheduler_is_bad_input() -> None:
    pytest.importorskip("distributed", reason="needs mcpn[distributed]")
    with (
        patch("mcpn.cluster.CONNECT_SECONDS", 1),
        pytest.raises(InputError, match="no dask scheduler answers at tcp:"),
        executor_of(scheduler="tcp://127.0.0.1:1"),
    ):
        raise AssertionError("nobody is there")


def test_the_last_worker_that_goes_is_an_error() -> None:
    distributed = pytest.importorskip("distributed", reason="needs mcpn[distributed]")
    with (
        distributed.LocalCluster(1, threads_per_worker=1, processes=False, dashboard_address=None) as found,
        executor_of(scheduler=found.scheduler_address) as executor,
    ):
        assert executor is not None
        assert executor.submit(abs, -3).result() == 3
        begun = threading.Event()
        with patch.dict(_WAITING, {"begun": begun}):
            given = executor.submit(_wait_for_ever)
            begun.wait(20)
            found.scale(0)
            with pytest.raises(WorkersError, match="the last worker of the dask scheduler"):
                given.result(60)
            _WAITING["ended"].set()


_WAITING = {"begun": threading.Event(), "ended": threading.Event()}


def _wait_for_ever() -> None:
    _WAITING["begun"].set()
    _WAITING["ended"].wait(120)


def test_an_error_of_the_work_is_the_work_s(cluster: Any) -> None:
    with executor_of(scheduler=cluster.scheduler_address) as executor:
        assert executor is not None
        with pytest.raises(ZeroDivisionError):
            executor.submit(divmod, 1, 0).result(60)


def test_work_that_kills_each_worker_is_an_error() -> None:
    distributed = pytest.importorskip("distributed", reason="needs mcpn[distributed]")
    import dask

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        distributed.LocalCluster(1, threads_per_worker=1, dashboard_address=None) as found,
        executor_of(scheduler=found.scheduler_address) as executor,
    ):
        assert executor is not None
        with pytest.raises(WorkersError, match=r"died, one after the other|is gone"):
            executor.submit(die).result(60)


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_a_killed_process_is_an_error_that_says_so(ulysse_net: MissionNet) -> None:
    before = set(active_children())
    with executor_of(2) as executor:
        assert executor is not None
        executor.submit(time.sleep, 60)
        while not (children := set(active_children()) - before):
            time.sleep(0.01)
        for child in children:
            child.kill()
        with using(executor), pytest.raises(WorkersError, match="a process that explored sections ended"):
            composite_space(ulysse_net)


def _left_by(work: Callable[[Path], object], begun: Path) -> list[threading.Thread]:
    """Leaves a pool while its work is under way; the threads that are still there then."""
    before = set(threading.enumerate())
    with suppress(ZeroDivisionError), executor_of(2) as executor:
        assert executor is not None
        executor.submit(work, begun)
        while not begun.exists():
            time.sleep(0.01)
        raise ZeroDivisionError
    return [each for each in threading.enumerate() if each not in before and "Manager" in type(each).__name__]


def test_a_pool_that_is_left_has_closed_what_it_opened(tmp_path: Path) -> None:
    """Else its manager and the end of the program close one pipe at once: threading prints a traceback."""
    manager: Any = process._ExecutorManagerThread
    ended = manager.terminate_broken

    def late(self: object, *cause: object) -> None:
        time.sleep(0.5)
        ended(self, *cause)

    with patch.object(manager, "terminate_broken", late):
        assert _left_by(wait, tmp_path / "begun") == []


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_a_signal_that_comes_as_signals_are_blocked_leaves_none_blocked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mask = signal.pthread_sigmask

    def interrupted(how: int, which: set[signal.Signals]) -> object:
        before = mask(how, which)
        if how == signal.SIG_BLOCK and which:
            raise KeyboardInterrupt
        return before

    before = mask(signal.SIG_BLOCK, ())
    monkeypatch.setattr(signal, "pthread_sigmask", interrupted)
    with pytest.raises(KeyboardInterrupt), executor_of(2):
        raise AssertionError("there is no pool yet")
    assert mask(signal.SIG_SETMASK, before) == before


@pytest.mark.skipif(sys.platform == "win32", reason="writes to a pipe of POSIX")
def test_a_process_that_is_killed_in_the_middle_of_a_result_is_not_awaited(tmp_path: Path) -> None:
    assert _left_by(begin_result, tmp_path / "begun") == []


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
@pytest.mark.parametrize(
    ("number", "wait"),
    [(signal.SIGINT, 0.0), (signal.SIGINT, 0.6), (signal.SIGTERM, 0.0), (signal.SIGTERM, 0.6),
     (signal.SIGQUIT, 0.0), (signal.SIGHUP, 0.6)],
)  # fmt: skip
def test_a_signal_to_the_group_ends_all_at_once(number: signal.Signals, wait: float) -> None:
    """As Ctrl-C in a terminal: no process prints a traceback of its own, and nothing hangs."""
    mission = ROOT / "experiments" / "rover" / "mission.xml"
    command = [sys.executable, "-m", "mcpn.cli", "check", str(mission), "--engine", "local", "--jobs", "2"]
    run = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=interruptible,
    )  # fmt: skip
    children = Path(f"/proc/{run.pid}/task/{run.pid}/children")
    if not children.exists():
        run.kill()
        pytest.skip("needs /proc")
    while run.poll() is None and len(children.read_text().split()) < 2:
        time.sleep(0.01)
    time.sleep(wait)
    with suppress(ProcessLookupError):
        os.killpg(run.pid, number)
    _, said = run.communicate(timeout=30)
    assert "Traceback" not in said
    assert "Error" not in said
    assert run.returncode in (0, 1, 128 + number)


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_the_command_line_says_so_too(tmp_path: Path) -> None:
    for command in (COMMANDS[0], COMMANDS[-1]):
        with patch("mcpn.composite.composing.explore_and_prove", die):
            run = mcpn(*asking(command, tmp_path), "--jobs", 2)
        assert run.returncode == 2, run.stderr
        assert "error: a process that explored sections ended before its work was done" in run.stderr
    assert not list(tmp_path.iterdir())
