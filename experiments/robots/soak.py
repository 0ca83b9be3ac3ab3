"""Runs a robot of processes while everything around it fails, and looks whether somebody is always in charge.

    python experiments/robots/soak.py --minutes 10 --drivers 16 --lines 1000 --hours 1

Each round is a mission among drivers of which most only talk, and one fault in its middle: a driver is
killed, ``mcpn run``, the process that watches over its drivers, both, the broker; the disk is full; mcpn is
suspended; the clock of the day jumps by an hour (in mcpn's own process, for no program may set that of the
machine). Where mcpn was ended the run is gone on with. After each round the journal is replayed on a new
controller, which is to be where the snapshot says, monitors are to agree with what the run has said of them,
and no process is to be left. Where the disk was full the journal is that of the run as far as it goes, and
the snapshot, which has room, is whole.

With ``--hours`` a mission of many timers runs first, in virtual time: the loop that drivers, timers and lines
are on jumps to what comes next. Meanwhile the clock of the day jumps by an hour, ahead and back.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import random
import resource
import selectors
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from mcpn.controller.document import document
from mcpn.controller.monitors.writing import files, monitors_of
from mcpn.robot.drivers.functions import Call
from mcpn.robot.drivers.reading import read_drivers
from mcpn.robot.drivers.running import RobotRun
from mcpn.robot.runtime import Controller, Journal, Monitors
from mcpn.robot.runtime.controller import Step
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.robot.runtime.journal import read_journal
from mcpn.robot.runtime.monitors import watch
from mcpn.robot.runtime.restoring import Saved, read_snapshot
from mcpn.study import open_study

MISSION = """<mission name="soak" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <hardware name="lidar"/><hardware name="wheels"/><software name="scan"/>
    <activity name="look" produces="scan"><alternative name="by_lidar" consumes="lidar"/>
      <alternative name="by_map"/></activity>
    <activity name="drive" consumes="scan wheels"/>
  </robot>
  <requirement name="sees" severity="advice" formula="G !oos(lidar)"/>
  <requirement name="once" severity="advice" formula="G (objective(go_5) -> X G !objective(go_0))"/>
  <each name="i" in="{objectives}">
    <objective name="go" activities="drive" timeout="{seconds}" failure="succeed"/>
  </each>
</mission>
"""
TEN = "0 1 2 3 4 5 6 7 8 9"
TALKS = """
import sys, time
rate, number = float(sys.argv[1]), 0
began = time.monotonic()
while True:
    sys.stdout.write("".join(f"line {number + i}\\n" for i in range(20)))
    sys.stdout.flush()
    number += 20
    time.sleep(max(0.0, began + number / rate - time.monotonic()))
"""
JUMPS = """
import sys, time
real, jump = time.time, {jump}
begun = time.monotonic()
time.time = lambda: real() + (jump if time.monotonic() - begun > 1 else 0)
from mcpn.cli import main
main()
"""
FAULTS = ("driver", "mcpn", "warden", "both", "disk", "suspended", "ahead", "back", "signal", "broker")
LONGEST = 600.0


def drivers_file(drivers: int, lines: float, port: int | None) -> str:
    """Two activities, and sources that talk; where there is a broker one more listens to it."""
    talking = max(1, drivers - 2 - (port is not None))
    sources = "".join(
        f'[sources.s{i}]\nprocess = ["{{python}}", "talks.py", "{lines / talking}"]\n' for i in range(talking)
    )
    broker = ""
    if port is not None:
        broker = (
            f'[mqtt]\nhost = "127.0.0.1"\nport = {port}\n[sources.heard]\nmqtt = {{ says = "robot/x" }}\n'
            'lines = { lost = "lidar_EV_OOS" }\n'
        )
    return f"""never = ["lidar_EV_RD", "wheels_EV_*"]
[activities.look]
nothing = true
[activities.look.alternatives.by_lidar]
process = ["sleep", "1000"]
ends.other = "lidar_EV_OOS"
[activities.drive]
process = ["sleep", "{0.4 if port is None else 2}"]
ends = {{ 0 = "success", other = "failure" }}
repeat = "safe"
{sources}{broker}"""


def agree(folder: Path, whole: bool = True) -> tuple[Saved, Monitors, list[str]]:
    """Holds the journal and the snapshot of a run in a folder against each other, and against its mission.

    Args:
        folder: Where they are.
        whole: Whether the journal is to have all events; else it is replayed as far as it goes.

    Returns:
        What the snapshot says, monitors that have seen the journal, and its events.
    """
    study = open_study(folder / "mission.xml")
    tables = Tables(document(study.controller("auto"), study.mission_net))
    monitors = Monitors(json.loads(files(monitors_of(study.mission_spaces()))["monitors.json"]))
    saved = read_snapshot((folder / "at.json").read_text(), tables)
    data = (folder / "log.jsonl").read_bytes()
    lines = data[: data.rfind(b"\n") + 1].decode().splitlines(keepends=True)
    controller = Controller(tables, on_refused=lambda refused: None)
    told = [*read_journal(lines)]
    for number, line in enumerate(told, 1):
        assert line.number == number, line
        controller.handle(line.event)
    watch(monitors, lines)
    if whole:
        assert controller.count == saved.count
        assert (controller.outcome, controller.out_of_service) == (saved.phase, saved.out_of_service)
        if "monitors" in saved.beside:
            state = saved.beside["monitors"]["state"]
            assert state == monitors.state | {"": state[""]}
    return saved, monitors, [line.event for line in told]


class Steady(selectors.SelectSelector):
    """A selector in virtual time: where nothing is ready it is at once as late as it would have waited."""

    now = 0.0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        """What is ready; a thread is waited for in real time."""
        ready = super().select(timeout if timeout is None else 0)
        if not ready and timeout is not None:
            self.now += max(0.0, timeout)
        return ready


VIRTUAL = """never = ["wheels_EV_*"]
[activities.look]
nothing = true
[activities.drive]
python = "{name}:drive"
ends = {{ true = "success", other = "failure" }}
{sources}[sources.s0.lines]
lost = "lidar_EV_OOS"
back = "lidar_EV_RD"
"""
SOURCE = """[sources.s{number}]
python = "{name}:talk"
"""
TIMEOUT = 40.0
HOURS: dict[str, float] = {"lines": 0.0, "told": 0.0, "jump": 0.0}
DICE = random.Random(0)


async def drive(_call: Call) -> bool:
    """Takes less than its time, or for ever."""
    await asyncio.sleep(DICE.uniform(1.0, 36.0) if DICE.random() < 0.9 else 1e9)
    return DICE.random() < 0.8


async def talk(call: Call) -> None:
    """Says its lines of each second; one source also tells of the lidar, and sets the clock of the day."""
    seconds = 0
    while True:
        for number in range(int(HOURS["lines"])):
            call.say(f"line {number}")
        if call.activity == "s0":
            seconds += 1
            HOURS["jump"] = (0.0, 3600.0, -3600.0)[seconds // 100 % 3]
            if seconds % 150 == 0:
                call.say("lost" if seconds % 300 else "back")
        await asyncio.sleep(1.0)


def virtual(folder: Path, said: argparse.Namespace) -> None:
    """Runs an hour, or more, of virtual time, and prints what came of it."""
    DICE.seed(said.seed)
    HOURS["lines"] = said.lines // (said.drivers - 1)
    name = Path(__file__).stem
    shutil.copy(__file__, folder / f"{name}.py")
    sys.modules[name] = sys.modules[__name__]
    count = int(said.hours * 3600 / 18)  # a drive takes some 20 seconds
    (folder / "mission.xml").write_text(
        MISSION.format(objectives=" ".join(map(str, range(count))), seconds=TIMEOUT)
    )
    sources = "".join(SOURCE.format(number=number, name=name) for number in range(said.drivers - 1))
    (folder / "drivers.toml").write_text(VIRTUAL.format(name=name, sources=sources))
    study = open_study(folder / "mission.xml")
    tables = Tables(document(study.controller("auto"), study.mission_net))
    selector = Steady()
    loop = asyncio.SelectorEventLoop(selector)
    loop.time = lambda: selector.now  # type: ignore[method-assign]
    controller = Controller(tables, on_refused=lambda refused: None, clock=loop.time)
    begun, off = dict[str, float](), list[float]()

    def look(step: Step) -> None:
        """Notes when objectives are entered, and how late timers are."""
        for action in step.actions:
            if action.verb == "arm":
                begun[str(action.objective)] = selector.now
        event = step.event.removeprefix("OBJ_")
        if step.taken and event.endswith("_EV_TIMEOUT"):
            off.append(abs(selector.now - begun[event.removesuffix("_EV_TIMEOUT")] - TIMEOUT))

    def told(_name: str, _line: str) -> None:
        HOURS["told"] += 1

    with (folder / "log.jsonl").open("w") as stream:
        controller.observe(look)
        controller.observe(Journal(stream, lambda: time.time() + HOURS["jump"]))
        runner = RobotRun(controller, tables, read_drivers(folder / "drivers.toml"), told=told)
        used = time.process_time()
        asyncio.set_event_loop(loop)
        loop.run_until_complete(runner.run())
        used = time.process_time() - used
    (folder / "at.json").write_text(controller.snapshot())
    saved, monitors, events = agree(folder)
    timeouts = sum(event.endswith("_EV_TIMEOUT") for event in events)
    assert timeouts == len(off)
    print(
        f"virtual: {selector.now / 3600:.2f} h in {used:.0f} s of CPU, {saved.count} events, "
        f"{HOURS['told']:,.0f} lines of {said.drivers} drivers, {controller.outcome}; {timeouts} timers, "
        f"at most {max(off, default=0.0):.1e} s off; violated: {', '.join(monitors.violated) or 'none'}",
        flush=True,
    )


class Round:
    """One mission with one fault in it."""

    def __init__(self, fault: str, folder: Path, said: argparse.Namespace, rng: random.Random) -> None:
        self.fault, self.folder, self.said, self.rng = fault, folder, said, rng
        self.broker: subprocess.Popen[bytes] | None = None
        self.port: int | None = None
        self.runs = 0
        (folder / "mission.xml").write_text(MISSION.format(objectives=TEN, seconds=60))
        (folder / "talks.py").write_text(TALKS)
        if fault == "broker":
            with socket.socket() as found:
                found.bind(("127.0.0.1", 0))
                self.port = found.getsockname()[1]
            self.listen()
        (folder / "drivers.toml").write_text(drivers_file(said.drivers, said.lines, self.port))

    def listen(self) -> None:
        """Starts the broker."""
        program = shutil.which("mosquitto", path=f"{os.environ['PATH']}:/usr/sbin")
        assert program is not None
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.broker = subprocess.Popen([program, "-p", str(self.port)], cwd="/", **quiet)  # type: ignore[call-overload]
        until(lambda: answers(self.port or 0))

    def start(self, *options: str) -> subprocess.Popen[bytes]:
        """Starts mcpn run, with the fault that it is born with."""
        self.runs += 1
        jump = {"ahead": 3600, "back": -3600}.get(self.fault)
        program = ["-m", "mcpn.cli"] if jump is None else ["-c", JUMPS.replace("{jump}", str(jump))]
        arguments = ["run", "mission.xml", "--drivers", "drivers.toml", "--monitors", "--json"]
        arguments += ["--journal", "log.jsonl", "--snapshot", "at.json", *options]

        def before() -> None:
            for number in (signal.SIGINT, signal.SIGQUIT, signal.SIGHUP):  # which background jobs ignore
                signal.signal(number, signal.SIG_DFL)
            if self.fault == "disk":
                resource.setrlimit(resource.RLIMIT_FSIZE, (6144, resource.RLIM_INFINITY))

        with (self.folder / f"out{self.runs}").open("wb") as out, (self.folder / "err").open("ab") as err:
            return subprocess.Popen(
                [sys.executable, *program, *arguments],
                cwd=self.folder,
                stdout=out,
                stderr=err,
                preexec_fn=before,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            )

    def play(self) -> None:
        """Plays it, with its fault, to the end of the mission."""
        run = self.start()
        log = self.folder / "log.jsonl"
        at = self.rng.randrange(1, 6)
        until(lambda: run.poll() is not None or (log.exists() and log.read_bytes().count(b"\n") > at))
        if self.fault in ("mcpn", "both"):
            if self.fault == "both":
                os.kill(self.processes()["warden"][0], signal.SIGKILL)
            run.kill()
        elif self.fault == "warden":
            os.kill(self.processes()["warden"][0], signal.SIGKILL)
        elif self.fault == "driver":
            os.kill(self.rng.choice(self.processes()["drivers"])[0], signal.SIGKILL)
        elif self.fault == "suspended":
            run.send_signal(signal.SIGSTOP)
            time.sleep(self.said.suspended)
            run.send_signal(signal.SIGCONT)
        elif self.fault == "signal":
            run.send_signal(self.rng.choice([signal.SIGHUP, signal.SIGQUIT, signal.SIGTERM, signal.SIGUSR1]))
        elif self.fault == "broker" and self.broker is not None:
            self.broker.kill()
            self.broker.wait()
            self.listen()
            until(lambda: self.heard(log) or run.poll() is not None)  # mcpn hears it again
            assert self.heard(log)
        code = run.wait(LONGEST)
        if self.fault in ("mcpn", "both", "signal"):
            assert code not in (0, 1, 2), code
            until(lambda: self.fault == "both" or not left(self.folder))
            code = self.start("--resume", "at.json").wait(LONGEST)
        # 1: by the broker the lidar is lost, so that a monitor finds its requirement violated.
        assert code == {"disk": 2, "driver": code, "broker": 1}.get(self.fault, 0), (self.fault, code)

    def heard(self, log: Path) -> bool:
        """Says by the broker that the lidar is lost; whether that is in the journal."""
        from paho.mqtt import publish

        publish.single("robot/x", "lost", 1, hostname="127.0.0.1", port=self.port or 0)
        time.sleep(0.2)
        return b"lidar_EV_OOS" in log.read_bytes()

    def processes(self) -> dict[str, list]:  # type: ignore[type-arg]
        """What the snapshot says of processes, once all of them have begun."""
        at = self.folder / "at.json"

        def said() -> dict[str, list]:  # type: ignore[type-arg]
            found: dict[str, list] = json.loads(at.read_text()).get("beside", {}).get("processes", {})  # type: ignore[type-arg]
            return found

        until(lambda: at.exists() and len(said().get("drivers", ())) >= self.said.drivers - 3)
        return said()

    def check(self) -> int:
        """Looks whether all files agree and nothing is left; returns the number of events."""
        assert not left(self.folder), left(self.folder)
        told = json.loads((self.folder / f"out{self.runs}").read_text())
        assert told["outcome"] == "success", told
        assert told["lost"] == (["journal"] if self.fault == "disk" else []), told
        saved, monitors, events = agree(self.folder, whole=self.fault != "disk")
        if self.fault == "disk":  # the journal of 6,144 bytes is cut in its middle
            assert 0 < len(events) < saved.count == told["events"], (len(events), told)
        else:
            assert list(monitors.violated) == told["violated"]
        if self.fault != "suspended":  # no clock but the steady one counts for timers
            assert not any(event.endswith("_EV_TIMEOUT") for event in events), events
        return saved.count

    def close(self) -> None:
        """Ends what is left of it, and tells what that was."""
        if self.broker is not None:
            self.broker.kill()
            self.broker.wait()
        for number in left(self.folder):
            os.kill(number, signal.SIGKILL)


def answers(port: int) -> bool:
    """Whether somebody listens."""
    try:
        socket.create_connection(("127.0.0.1", port), 1).close()
    except OSError:
        return False
    return True


def left(folder: Path) -> list[int]:
    """Processes that run in a folder."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if (process / "cwd").resolve() == folder.resolve():
                found.append(int(process.name))
        except OSError:
            continue
    return found


def until(condition: Callable[[], object]) -> None:
    """Waits until something is so."""
    end = time.monotonic() + LONGEST
    while not condition():
        assert time.monotonic() < end, "not so in time"
        time.sleep(0.05)


def main() -> None:
    """Plays rounds until the time is over, and prints what became of each fault."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--hours", type=float, default=0.0, help="of virtual time, before")
    parser.add_argument("--drivers", type=int, default=16)
    parser.add_argument("--lines", type=float, default=1000.0, help="of all drivers, a second")
    parser.add_argument("--suspended", type=float, default=60.0, help="seconds of SIGSTOP")
    parser.add_argument("--faults", nargs="+", choices=FAULTS, default=FAULTS)
    parser.add_argument("--seed", type=int, default=0)
    said = parser.parse_args()
    if said.hours:
        with tempfile.TemporaryDirectory() as name:
            virtual(Path(name), said)
    rng, end = random.Random(said.seed), time.monotonic() + 60 * said.minutes
    broker = shutil.which("mosquitto", path=f"{os.environ['PATH']}:/usr/sbin")
    faults = [fault for fault in said.faults if fault != "broker" or broker is not None]
    rounds, events, wrong = Counter[str](), Counter[str](), Counter[str]()
    number = 0
    while time.monotonic() < end:
        fault = faults[number % len(faults)]
        number += 1
        with tempfile.TemporaryDirectory() as name:
            played = Round(fault, Path(name), said, rng)
            try:
                played.play()
                events[fault] += played.check()
            except (AssertionError, subprocess.TimeoutExpired) as error:
                wrong[fault] += 1
                sys.stderr.write(f"{fault}: {error!r}\n{(Path(name) / 'err').read_text()[-2000:]}\n")
            finally:
                played.close()
        rounds[fault] += 1
    print("| fault | rounds | events | wrong |\n|---|---|---|---|")
    for fault in faults:
        print(f"| {fault} | {rounds[fault]} | {events[fault]} | {wrong[fault]} |")


if __name__ == "__main__":
    main()
