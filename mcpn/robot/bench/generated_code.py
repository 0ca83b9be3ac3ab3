"""Generated code beside the runtime: the runs of a bench as lines that its program reads."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from mcpn.errors import LimitError
from mcpn.robot.bench.controller_places import ControllerPlace, Places
from mcpn.robot.runtime.actions import Action
from mcpn.robot.targets import files


class Generated(Protocol):
    """Generated code that runs."""

    def answers(self, runs: list[list[str]]) -> list[str]:
        """What it says on the events of some runs, a line for each."""

    def expected(self, status: str, actions: Sequence[Action], place: ControllerPlace) -> str:
        """What it is to say.

        Args:
            status: Of the event: ``taken``, ``refused`` or ``unknown``.
            actions: What the runtime does.
            place: Where it is then.
        """


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
    """A program made of generated code in C or Python, its lines with modes and events in order.

    Args:
        document: The controller's.
        target: ``c`` or ``python``.
        folder: Where its files go.

    Raises:
        LimitError: There is no compiler.
    """

    def __init__(self, document: Mapping[str, Any], target: str, folder: Path) -> None:
        texts = files(document, target)
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
        return [_in_order(line) for line in done.stdout.splitlines()]

    def expected(self, status: str, actions: Sequence[Action], place: ControllerPlace) -> str:
        """The status with the actions, the functioning mode, the events possible next, the outcome."""
        said = f"{status}: {'; '.join(map(str, actions))}"
        mode = " ".join(f"{activity}.{way}" for activity, way in place.inside.mode.items())
        return _in_order(f"{said} | {mode} | {' '.join(place.possible)} | {place.outcome or '-'}")


def _in_order(line: str) -> str:
    said, *parts = line.split("|")
    return " | ".join([" ".join(said.split()), *(" ".join(sorted(part.split())) for part in parts)])


def compare(program: Generated, places: Places, runs: Iterable[list[str]]) -> Difference | None:
    """Gives the events of runs to generated code; the first difference to the runtime, if there is one.

    Args:
        program: What runs the code.
        places: The runtime's places.
        runs: The events of each run.
    """
    every = list(runs)
    said = iter(program.answers(every))
    for run in every:
        place = places.start
        for number, event in enumerate(run, 1):
            found = next(said, "nothing")
            step = places.after(place, event)
            status = "refused" if event in places.tables.known else "unknown"
            actions: tuple[Action, ...] = ()
            if step is not None:
                status, (place, actions) = "taken", step
            expected = program.expected(status, actions, place)
            if found != expected:
                return Difference(tuple(run[:number]), expected, found)
    return None
