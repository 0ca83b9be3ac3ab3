"""Generated code beside the runtime: the runs of a bench as lines that its program reads."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from mcpn.bench.places import ControllerPlace, Places
from mcpn.controller.modular import AnyController
from mcpn.controller.targets import files
from mcpn.errors import LimitError
from mcpn.net.compose import MissionNet

Answer = tuple[str, frozenset[str], frozenset[str], str]
"""The status and the actions in order, the functioning mode, the events possible next, the outcome."""


@dataclass(frozen=True)
class Difference:
    """Where generated code does something else.

    Args:
        events: The run, up to the event.
        expected: What the runtime does.
        found: What the program printed.
    """

    events: tuple[str, ...]
    expected: str
    found: str


class Program:
    """A program made of generated code.

    Args:
        controller: The controller.
        mission_net: The mission's net.
        target: ``c`` or ``python``.
        folder: Where its files go.

    Raises:
        LimitError: There is no compiler.
    """

    def __init__(self, controller: AnyController, mission_net: MissionNet, target: str, folder: Path) -> None:
        texts = files(controller, mission_net, target)
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        if target == "python":
            self._command = [sys.executable, "-I", str(folder / next(iter(texts))), "all"]
            return
        compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
        if compiler is None:
            raise LimitError("--against c needs a C compiler on the path: cc, gcc or clang")
        program = folder / "program"
        sources = [str(folder / name) for name in texts if name.endswith(".c")]
        run = subprocess.run(
            [compiler, "-std=c99", "-O1", "-o", str(program), *sources], capture_output=True, text=True
        )
        if run.returncode:
            raise LimitError(f"{compiler} does not compile the controller: {run.stderr[:500]}")
        self._command = [str(program), "all"]

    def answers(self, runs: list[list[str]]) -> list[str]:
        """What it prints on the events of some runs, a line for each."""
        text = "".join(f"{event}\n" for run in runs for event in ("", *run))
        done = subprocess.run(self._command, input=text, capture_output=True, text=True)
        if done.returncode:
            raise LimitError(f"the generated program has ended with {done.returncode}: {done.stderr[:500]}")
        return done.stdout.splitlines()


def compare(program: Program, places: Places, runs: Iterable[list[str]]) -> Difference | None:
    """Gives the events of runs to a program; the first difference to the runtime, if there is one.

    Args:
        program: The program.
        places: The runtime's places.
        runs: The events of each run.
    """
    every = list(runs)
    said = iter(program.answers(every))
    for run in every:
        place = places.start
        for number, event in enumerate(run, 1):
            line = next(said, "nothing")
            step = places.after(place, event)
            status = "refused" if event in places.tables.known else "unknown"
            if step is not None:
                place, status = step[0], "taken"
            actions = "; ".join(map(str, step[1])) if step is not None else ""
            expected = f"{status}: {actions}".strip(), *_of(place)
            if _read(line) != expected:
                words = " | ".join(
                    (expected[0], " ".join(sorted(expected[1])), " ".join(sorted(expected[2])), expected[3])
                )
                return Difference(tuple(run[:number]), words, line)
    return None


def _of(place: ControllerPlace) -> tuple[frozenset[str], frozenset[str], str]:
    mode = frozenset(f"{activity}.{way}" for activity, way in place.inside.mode.items())
    return mode, frozenset(place.possible), place.outcome or "-"


def _read(line: str) -> Answer | None:
    parts = [" ".join(part.split()) for part in line.split("|")]
    if len(parts) != 4:
        return None
    return parts[0], frozenset(parts[1].split()), frozenset(parts[2].split()), parts[3]
