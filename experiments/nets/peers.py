"""mcpn beside other model checkers, on the contest's nets: CPU and wall seconds, memory, answers.

Usage: ``python experiments/nets/peers.py FOLDER [NET...] --verifypn PATH --lola PATH --pnmc PATH --ltsmin
PATH`` with a folder that holds ``formulas.tsv`` and ``NAME/model.pnml``. Peers whose path is not given are
left out; how a peer is asked can be changed by ``--command TOOL:QUESTION=COMMAND``, where the command holds
``{tool}``, ``{net}``, ``{lola}`` (the net for LoLA), ``{file}`` (of properties), ``{queries}`` (1,2,...) or
``{deadlock}`` (a file that asks for one). Each run is a process of its own, one after the other, with the
same limits on time and memory for all tools. CPU seconds and the peak of memory are the system's count.
"""

from __future__ import annotations

import argparse
import csv
import os
import platform
import re
import resource
import shlex
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mcpn import __version__
from mcpn.nets.formats import read_net
from mcpn.nets.petri import PetriNet
from mcpn.nets.structure import needs

COUNT, DEADLOCK = "count", "deadlock"
FILES = ("ReachabilityFireability", "ReachabilityCardinality", "CTLFireability", "CTLCardinality")
QUESTIONS = (COUNT, DEADLOCK, *FILES)
COMMANDS = {
    "mcpn": {
        COUNT: "{tool} -m mcpn.cli states {net} --json",
        DEADLOCK: "{tool} -m mcpn.cli ask {net} --examination ReachabilityDeadlock",
        **dict.fromkeys(FILES, "{tool} -m mcpn.cli ask {net} --properties {file}"),
    },
    "verifypn": {
        DEADLOCK: "{tool} -x 1 {net} {deadlock}",
        **dict.fromkeys(FILES, "{tool} -x {queries} {net} {file}"),
    },
    "lola": {DEADLOCK: "{tool} --formula='EF DEADLOCK' {lola}"},
    "pnmc": {COUNT: "{tool} {net}"},
    "ltsmin": {
        COUNT: "{tool} --saturation=sat -rf {net}",
        DEADLOCK: "{tool} --saturation=sat -rf -d {net}",
    },
}
ASKS_DEADLOCK = """<?xml version="1.0"?>
<property-set xmlns="http://mcc.lip6.fr/"><property><id>deadlock</id><description>deadlock</description>
<formula><exists-path><finally><deadlock/></finally></exists-path></formula></property></property-set>
"""


@dataclass(frozen=True)
class Usage:
    """What one run took, and how it ended."""

    wall: float
    cpu: float
    megabytes: float
    ended: str
    output: str

    def __str__(self) -> str:
        return f"{self.cpu:8.2f} {self.wall:8.2f} {self.megabytes:7.0f}  {self.ended}"


def measure(command: list[str], seconds: float, gib: float) -> Usage:
    """Runs a command within limits of wall time and memory."""

    def limit() -> None:
        os.setsid()
        size = int(gib * 2**30)
        resource.setrlimit(resource.RLIMIT_AS, (size, size))

    with tempfile.TemporaryFile("w+", errors="replace") as output:
        started = time.perf_counter()
        try:
            process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT, preexec_fn=limit)
        except OSError as error:
            return Usage(0, 0, 0, f"does not start: {error}", "")
        late = threading.Event()

        def end() -> None:
            late.set()
            os.killpg(process.pid, signal.SIGKILL)

        timer = threading.Timer(seconds, end)
        timer.start()
        _, status, used = os.wait4(process.pid, 0)
        timer.cancel()
        wall = time.perf_counter() - started
        process.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        told = output.read()
    ended = f"more than {seconds:g} s" if late.is_set() else f"exit {process.returncode}"
    return Usage(wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, ended, told)


def lola(net: PetriNet) -> str:
    """A net in LoLA's language; names are numbered, as LoLA forbids some letters."""
    marked = ", ".join(f"p{i}: {p.initial}" for i, p in enumerate(net.places) if p.initial)
    lines = ["PLACE " + ", ".join(f"p{i}" for i in range(len(net.places))) + ";", f"MARKING {marked};"]
    for number, transition in enumerate(net.transitions):
        taken, put, needed = dict(transition.consume), dict(transition.produce), needs(net, number)
        for place, weight in needed.items():  # what is needed and stays is taken and put back
            put[place] = put.get(place, 0) + weight - taken.get(place, 0)
        sides = [", ".join(f"p{p}: {w}" for p, w in side.items() if w) for side in (needed, put)]
        lines += [f"TRANSITION t{number}", f"CONSUME {sides[0]};", f"PRODUCE {sides[1]};"]
    return "\n".join(lines) + "\n"


def rows(folder: Path, nets: list[str], questions: list[str]) -> Iterator[tuple[str, str]]:
    """Pairs of net and question for which there is something to ask."""
    for name in nets:
        for question in questions:
            if question not in FILES or (folder / name / f"{question}.xml").exists():
                yield name, question


def known(folder: Path) -> dict[str, str]:
    """The contest's verdicts by formula."""
    with (folder / "formulas.tsv").open(newline="") as file:
        return {row["formula"]: row["verdict"] for row in csv.DictReader(file, delimiter="\t")}


def judged(output: str, verdicts: dict[str, str]) -> str:
    """How many answers in the contest's form agree with its verdicts, and how many do not."""
    answers = dict(re.findall(r"^FORMULA (\S+) (TRUE|FALSE|\d+)\b", output, re.MULTILINE))
    told = {name: value for name, value in answers.items() if verdicts.get(name, "?") != "?"}
    if not told:
        return ""
    wrong = sum(value != verdicts[name] for name, value in told.items())
    return f"{len(told)} answers" + (f", {wrong} WRONG" if wrong else "")


def main() -> None:
    """Prints a row for each net, question and tool."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("nets", nargs="*", help="all that the folder holds by default")
    for tool in COMMANDS:
        given = sys.executable if tool == "mcpn" else None
        what = "the Python that has mcpn" if tool == "mcpn" else f"path of {tool}"
        parser.add_argument(f"--{tool}", default=given, metavar="PATH", help=what)
    parser.add_argument("--command", action="append", default=[], metavar="TOOL:QUESTION=COMMAND")
    parser.add_argument(
        "--question", action="append", choices=QUESTIONS, help="count and deadlock by default"
    )
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--gib", type=float, default=4)
    arguments = parser.parse_args()
    commands = {tool: dict(asked) for tool, asked in COMMANDS.items()}
    for text in arguments.command:
        found = re.fullmatch(r"(\w+):(\w+)=(.+)", text)
        if not found or found[1] not in commands or found[2] not in QUESTIONS:
            parser.error(f"--command {text!r}: expected TOOL:QUESTION=COMMAND with a known tool and question")
        commands[found[1]][found[2]] = found[3]
    folder: Path = arguments.folder
    nets = arguments.nets or sorted(path.parent.name for path in folder.glob("*/model.pnml"))
    verdicts = known(folder)
    print(
        f"{platform.machine()}, {os.cpu_count()} cores, mcpn {__version__}, {arguments.seconds:g} s and ",
        end="",
    )
    print(f"{arguments.gib:g} GiB a run")
    print(f"{'net':30} {'question':24} {'tool':9} {'CPU s':>8} {'wall s':>8} {'MB':>7}")
    with tempfile.TemporaryDirectory() as scratch:
        deadlock, net_of_lola = Path(scratch, "deadlock.xml"), Path(scratch, "net.lola")
        deadlock.write_text(ASKS_DEADLOCK)
        for name, question in rows(folder, nets, arguments.question or [COUNT, DEADLOCK]):
            net, file = folder / name / "model.pnml", folder / name / f"{question}.xml"
            queries = file.read_text().count("<property>") if question in FILES else 1
            for tool, asked in commands.items():
                path = getattr(arguments, tool)
                if path is None or question not in asked:
                    continue
                if "{lola}" in asked[question]:
                    net_of_lola.write_text(lola(read_net(net)))
                places = {
                    "tool": path,
                    "net": str(net),
                    "lola": str(net_of_lola),
                    "file": str(file),
                    "deadlock": str(deadlock),
                    "queries": ",".join(str(i + 1) for i in range(queries)),
                }
                command = [part.format(**places) for part in shlex.split(asked[question])]
                used = measure(command, arguments.seconds, arguments.gib)
                told = judged(used.output, verdicts) if question in FILES else ""
                print(f"{name:30} {question:24} {tool:9} {used}  {told}", flush=True)


if __name__ == "__main__":
    main()
