"""Qt's QScxmlStateMachine as a program: events in, one a line; out what is logged, and the active states.

It has a process of its own because two calls of PySide6 6.12 take a reference of ``None`` that they do not
own (seen with CPython 3.11): each is given back here, and the process ends without the interpreter's own end.
"""

from __future__ import annotations

import ctypes
import json
import os
import sys
from typing import Any

from PySide6.QtCore import QCoreApplication
from PySide6.QtScxml import QScxmlStateMachine


def _give_back() -> None:
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(None))


def main(path: str) -> None:
    """Runs the machine of a file until the input ends; an empty line begins again."""
    application = QCoreApplication([])
    logged: list[tuple[str, str]] = []
    stable: list[bool] = []
    machines: list[Any] = []

    def settle() -> None:
        stable.clear()
        while not stable:
            application.processEvents()
            _give_back()
        for _ in range(2):  # what was only scheduled then
            application.processEvents()
            _give_back()

    def restart() -> None:
        machine: Any = QScxmlStateMachine.fromFile(path)
        assert not machine.parseErrors(), machine.parseErrors()
        machine.log.connect(lambda label, data: logged.append((label, data)))
        machine.reachedStableState.connect(lambda: stable.append(True))
        machine.init()
        machine.start()
        settle()
        machines.append(machine)

    restart()
    for line in sys.stdin:
        event = line.rstrip("\n")
        if not event:
            machines[-1].stop()
            restart()
            continue
        logged.clear()
        machines[-1].submitEvent(event)
        _give_back()
        settle()
        labels, told = [label for label, _ in logged], [data for _, data in logged]
        sys.stdout.write(json.dumps([labels, sorted(machines[-1].activeStateNames(True)), told]) + "\n")
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1])
