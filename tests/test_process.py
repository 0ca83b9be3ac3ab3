"""The command line as a process: signals, streams that cannot be written, what is left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mcpn.cli.line import run as run_command
from mcpn.report.progress import UnderWay
from mcpn.steps import Doing, WorkStep
from mcpn.workers import executor_of
from tests.conftest import ULYSSE, interruptible

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals and devices")
COMMAND = [sys.executable, "-m", "mcpn.cli"]
ENDS = {signal.SIGINT: (130, "interrupted"), signal.SIGTERM: (143, "terminated")}


@pytest.fixture(scope="module")
def big(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A net of 2^40 markings, which nobody explores to the end."""
    path = tmp_path_factory.mktemp("big") / "big.net"
    lines = ["net big", *(f"pl a{i} (1)\ntr t{i} a{i} -> b{i}\ntr u{i} b{i} -> a{i}" for i in range(40))]
    path.write_text("\n".join(lines) + "\n")
    return path


def ended(arguments: list[str], number: signal.Signals, after: float) -> tuple[int, str, str]:
    """Exit code, output and messages of a command that gets a signal after some seconds."""
    with subprocess.Popen(
        arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=interruptible
    ) as process:
        time.sleep(after)
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    return process.returncode, out, err.strip()


@pytest.mark.parametrize("number", ENDS)
def test_a_signal_ends_an_exploration_cleanly(number: signal.Signals, big: Path) -> None:
    code, said = ENDS[number]
    found = ended([*COMMAND, "states", str(big), "--engine", "explicit"], number, 3)
    assert (*found[:2], found[2].partition("\n")[0]) == (code, "", said)


INTERRUPTED = """
import os, sys
import mcpn.composite.composing as composing
explore = composing.explore_local
def interrupted(*nets):
    os.kill(os.getpid(), {number})
    return explore(*nets)
composing.explore_local = interrupted
sys.argv = ["mcpn", *{arguments!r}]
from mcpn.cli import main
main()
"""


@pytest.mark.parametrize("number", ENDS)
@pytest.mark.parametrize("command", ["check", "causes"])
def test_an_interrupted_command_says_what_it_has(
    number: signal.Signals, command: str, tmp_path: Path
) -> None:
    """The warnings that the text alone gives, the step, and what to try."""
    path = tmp_path / "mission.xml"
    path.write_text(
        """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="h"/><hardware name="unused"/><activity name="a" consumes="h"/></robot>
  <objective name="dive" activities="a"/></mission>"""
    )
    script = INTERRUPTED.format(number=int(number), arguments=[command, str(path), "--engine", "local"])
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, preexec_fn=interruptible
    )
    code, said = ENDS[number]
    assert (run.returncode, run.stdout) == (code, "")
    warning, end, step, hint = run.stderr.splitlines()
    assert warning == f"warning: {path}:2: resource unused is never used"
    assert end == said
    assert step.startswith("while exploring section dive (")
    assert "make section dive smaller" in hint


def test_an_interruption_does_not_wait_for_other_processes() -> None:
    """The processes of --jobs get no signal of their own."""
    started = time.monotonic()

    def interrupted() -> None:
        with executor_of(2, None) as executor:
            assert executor is not None
            for _ in range(2):
                executor.submit(time.sleep, 120)
            time.sleep(2)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert time.monotonic() - started < 60


@pytest.mark.parametrize("number", ENDS)
@pytest.mark.parametrize("module", ["click", "lxml.etree", "numpy"])
def test_a_signal_during_imports_ends_cleanly(number: signal.Signals, module: str) -> None:
    """The signal comes just as a module is looked for."""
    script = f"""
import os, sys
class Late:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), {int(number)})
sys.meta_path.insert(0, Late())
sys.argv = ["mcpn", {"alternatives" if module == "numpy" else "check"!r}, {str(ULYSSE)!r}]
from mcpn.cli import main
main()
"""
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, preexec_fn=interruptible
    )
    code, said = ENDS[number]
    assert (run.returncode, run.stdout, run.stderr.strip()) == (code, "", said)


@pytest.mark.parametrize("number", ENDS)
def test_a_signal_in_a_finaliser_is_not_lost(number: signal.Signals) -> None:
    """Python tells what is raised there and goes on."""
    script = f"""
import os, sys
class Finalised:
    def __del__(self):
        os.kill(os.getpid(), {int(number)})
        for _ in range(1000): pass
class Late:
    def find_spec(self, name, path=None, target=None):
        if name == "click":
            Finalised()
            while True: pass
sys.meta_path.insert(0, Late())
sys.argv = ["mcpn", "check", {str(ULYSSE)!r}]
from mcpn.cli import main
main()
"""
    run = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=interruptible,
        timeout=30,
    )
    code, said = ENDS[number]
    assert (run.returncode, run.stdout, run.stderr.strip()) == (code, "", said)


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("arguments", [["check", str(ULYSSE)], ["--help"], ["states", str(ULYSSE), "--json"]])
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_told(arguments: list[str], unbuffered: str) -> None:
    environment = {**os.environ, "PYTHONUNBUFFERED": unbuffered}
    with open("/dev/full", "w") as full:
        run = subprocess.run(
            [*COMMAND, *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            env=environment,
        )
    told = "error: standard output: cannot be written: No space left on device"
    assert (run.returncode, run.stderr.strip()) == (2, told)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_an_error_that_cannot_be_told_keeps_its_code(tmp_path: Path) -> None:
    with open("/dev/full", "w") as full:
        for arguments, code in ((["check", str(tmp_path)], 2), (["fly"], 2), (["--version"], 0)):
            run = subprocess.run([*COMMAND, *arguments], stdout=subprocess.PIPE, stderr=full, check=False)
            assert run.returncode == code


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("arguments", [["check", str(ULYSSE)], ["--help"]])
def test_a_closed_pipe_ends_the_command_without_a_word(arguments: list[str], unbuffered: str) -> None:
    read, write = os.pipe()
    os.close(read)
    environment = {**os.environ, "PYTHONUNBUFFERED": unbuffered}
    run = subprocess.run(
        [*COMMAND, *arguments], stdout=write, stderr=subprocess.PIPE, text=True, check=False, env=environment
    )
    os.close(write)
    assert (run.returncode, run.stderr) == (128 + signal.SIGPIPE, "")


def test_a_terminal_that_knows_no_unicode_gets_escapes(tmp_path: Path) -> None:
    net = tmp_path / "n.net"
    net.write_text("net {\N{ROCKET}}\npl {caf\N{LATIN SMALL LETTER E WITH ACUTE}} (1)\n", encoding="utf-8")
    run = subprocess.run(
        [*COMMAND, "check", str(net)],
        capture_output=True,
        check=False,
        env={**os.environ, "PYTHONIOENCODING": "latin-1"},
    )
    assert (run.returncode, run.stderr) == (0, b"")
    assert b"\\U0001f680" in run.stdout


def test_what_was_registered_for_the_end_runs() -> None:
    """The process ends without taking apart what it holds, but not without its last words."""
    script = """
import atexit, sys
atexit.register(print, "the end")
sys.argv = ["mcpn", "--version"]
from mcpn.cli import main
main()
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "the end"


def test_garbage_is_not_searched_among_less_than_a_million_objects() -> None:
    script = """
import atexit, gc, sys
searches = []
gc.callbacks.append(lambda phase, info: searches.append(phase))
atexit.register(lambda: print(len(searches), "searches"))
import mcpn.cli.line
mcpn.cli.line.run = lambda: len([[i] for i in range(900_000)]) and 0
from mcpn.cli import main
searches.clear()
main()
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "0 searches"


def test_a_profiler_sees_the_end() -> None:
    command = [sys.executable, "-m", "cProfile", *COMMAND[1:], "--version"]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "function calls" in run.stdout


LIMITED = """
import resource
from mcpn.cli import main
resource.setrlimit(resource.RLIMIT_AS, (ROOM, ROOM))
main()
"""


@pytest.mark.skipif(sys.platform != "linux", reason="needs limits on the space of addresses")
@pytest.mark.parametrize(
    "arguments", [["check", str(ULYSSE)], ["causes", str(ULYSSE.parents[1] / "rover/mission.xml"), "--rates"]]
)
def test_too_little_memory_is_told_in_a_sentence(arguments: list[str]) -> None:
    """OpenBLAS, which numpy and scipy load, ends a process with code 1 where it has no room."""
    codes = []
    for megabytes in (35, 60, 90, 105, 120, 220, 1_000):
        command = [sys.executable, "-c", LIMITED.replace("ROOM", str(megabytes << 20)), *arguments]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        codes.append(run.returncode)
        assert run.returncode in (0, 2), (megabytes, run.returncode, run.stdout, run.stderr)
        if run.returncode == 2:
            assert run.stderr.splitlines()[-1].startswith("error: out of memory: "), run.stderr
    assert (codes[0], codes[-1]) == (2, 0)


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (FileNotFoundError(2, "No such file or directory", "x.xml"), "x.xml: No such file or directory"),
        (
            BlockingIOError(11, "Resource temporarily unavailable"),
            "the operating system refuses what this command needs: Resource",
        ),
        (
            ConnectionRefusedError(111, "Connection refused"),
            "the operating system refuses what this command needs: Connection",
        ),
        (OSError(12, "Cannot allocate memory", "networkx"), "out of memory: Cannot allocate memory"),
    ],
)
def test_what_the_system_refuses_is_told(
    error: OSError, told: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whatever it was, it was told that standard output could not be written."""

    def refused(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("mcpn.study.open_study", refused)
    assert run_command(["check", str(ULYSSE)]) == 2
    assert capsys.readouterr().err.startswith(f"error: {told}")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGXCPU])
def test_an_interruption_names_the_questions_that_are_open(tmp_path: Path, number: signal.Signals) -> None:
    """Ctrl-C, or the limit on CPU time: and no engine is recommended that was working."""
    path = tmp_path / "big.net"
    path.write_text("net big\npl a (2)\ntr t a -> b\ntr u b -> a\n")
    script = f"""
import os, sys
from mcpn.spaces.registry import Spaces
Spaces.going_on = lambda *_: iter([os.kill(os.getpid(), {int(number)})])
examinations = "ReachabilityDeadlock", "OneSafe", "Liveness"
sys.argv = ["mcpn", "ask", {str(path)!r}, *(f"--examination={{each}}" for each in examinations)]
from mcpn.cli import main
main()
"""
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, preexec_fn=interruptible
    )
    assert run.returncode == 128 + number
    assert run.stdout == "FORMULA big-OneSafe FALSE TECHNIQUES INITIAL_STATE\n"
    _, step = run.stderr.splitlines()
    assert step.startswith("while answering what is open: big-ReachabilityDeadlock, big-Liveness (")


def test_a_limit_on_time_that_kills_is_not_waited_for(tmp_path: Path) -> None:
    """``ulimit -t`` sets the limit that tells and the one that kills alike: nobody named what is open."""
    path = tmp_path / "big.net"
    path.write_text("net big\npl a (2)\ntr t a -> b\ntr u b -> a\n")
    script = f"""
import itertools, sys
from mcpn.spaces.registry import Spaces
Spaces.going_on = lambda *_: itertools.filterfalse(lambda _: True, itertools.count())
sys.argv = ["mcpn", "ask", {str(path)!r}, "--examination=Liveness"]
from mcpn.cli import main
main()
"""

    def limited() -> None:
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (2, 2))

    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, preexec_fn=limited
    )
    assert run.returncode == 128 + signal.SIGXCPU
    assert run.stderr.splitlines()[1].startswith("while answering what is open: big-Liveness (")


def test_a_hint_names_no_engine_that_was_working() -> None:
    heard = UnderWay()
    heard.begins(WorkStep(Doing.MAKING_DIAGRAM))
    heard.begins(WorkStep(Doing.PROVING))
    assert heard.interrupted()[1:] == ["another engine may be quicker: --engine local or explicit"]
