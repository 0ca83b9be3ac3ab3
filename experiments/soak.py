"""Runs a robot of processes while everything around it fails, and looks whether somebody is always in charge.

    python experiments/soak.py --minutes 10 --drivers 16 --lines 1000

Each round is a mission among drivers of which most only talk, and one fault in its middle: a driver is
killed, ``mcpn run``, the process that watches over its drivers, both, the broker; the disk is full; mcpn is
suspended; the clock of the day jumps by an hour (in mcpn's own process, for no program may set that of the
machine). Where mcpn was ended the run is gone on with. After each round the journal is replayed on a new
controller, which is to be where the snapshot says, monitors are to agree with what the run has said of them,
and no process is to be left.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import resource
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

from mcpn.controller.monitors.writing import files, monitors_of
from mcpn.controller.targets.json import document
from mcpn.opening import open_study
from mcpn.runtime import Controller, Monitors
from mcpn.runtime.journal import read_journal
from mcpn.runtime.monitors import watch
from mcpn.runtime.restoring import read_snapshot
from mcpn.runtime.tables import Tables

MISSION = """<mission name="soak" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <hardware name="lidar"/><hardware name="wheels"/><software name="scan"/>
    <activity name="look" produces="scan"><alternative name="by_lidar" consumes="lidar"/>
      <alternative name="by_map"/></activity>
    <activity name="drive" consumes="scan wheels"/>
  </robot>
  <requirement name="sees" severity="advice" formula="G !oos(lidar)"/>
  <requirement name="once" severity="advice" formula="G (objective(go_5) -> X G !objective(go_0))"/>
  <each name="i" in="0 1 2 3 4 5 6 7 8 9">
    <objective name="go" activities="drive" timeout="60" failure="succeed"/>
  </each>
</mission>
"""
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
LONGEST = 180.0


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
        )
    return f"""never = ["lidar_EV_RD", "wheels_EV_*"]
[activities.look]
nothing = true
[activities.look.alternatives.by_lidar]
process = ["sleep", "1000"]
ends.other = "lidar_EV_OOS"
[activities.drive]
process = ["sleep", "0.4"]
ends = {{ 0 = "success", other = "failure" }}
repeat = "safe"
{sources}{broker}"""


class Round:
    """One mission with one fault in it."""

    def __init__(self, fault: str, folder: Path, said: argparse.Namespace, rng: random.Random) -> None:
        self.fault, self.folder, self.said, self.rng = fault, folder, said, rng
        self.broker: subprocess.Popen[bytes] | None = None
        self.port: int | None = None
        self.runs = 0
        (folder / "mission.xml").write_text(MISSION)
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
        code = run.wait(LONGEST)
        if self.fault in ("mcpn", "both", "signal"):
            assert code not in (0, 1, 2), code
            until(lambda: self.fault == "both" or not left(self.folder))
            code = self.start("--resume", "at.json").wait(LONGEST)
        assert code == {"disk": 2, "driver": code}.get(self.fault, 0), (self.fault, code)

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
        study = open_study(self.folder / "mission.xml")
        tables = Tables(document(study.controller("auto"), study.mission_net))
        monitors = Monitors(json.loads(files(monitors_of(study.spaces))["monitors.json"]))
        saved = read_snapshot((self.folder / "at.json").read_text(), tables)
        told = json.loads((self.folder / f"out{self.runs}").read_text())
        lines = (self.folder / "log.jsonl").read_text().splitlines(keepends=True)
        if self.fault == "disk":  # which is told: the journal ends in the middle, the snapshot is small
            assert "journal" in told["lost"], told
            assert told["outcome"] == "success", told
            return int(told["events"])
        controller = Controller(tables, on_refused=lambda refused: None)
        for line in read_journal(lines):
            controller.handle(line.event)
        watch(monitors, lines)
        assert controller.count == saved.count
        assert (controller.outcome, controller.out_of_service) == (saved.phase, saved.out_of_service)
        assert saved.beside["monitors"]["state"] == monitors.state | {
            "": saved.beside["monitors"]["state"][""]
        }
        assert list(monitors.violated) == told["violated"]
        assert told["outcome"] == "success", told
        return controller.count

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
    parser.add_argument("--drivers", type=int, default=16)
    parser.add_argument("--lines", type=float, default=1000.0, help="of all drivers, a second")
    parser.add_argument("--suspended", type=float, default=60.0, help="seconds of SIGSTOP")
    parser.add_argument("--faults", nargs="+", choices=FAULTS, default=FAULTS)
    parser.add_argument("--seed", type=int, default=0)
    said = parser.parse_args()
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
