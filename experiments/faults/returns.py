"""How often a mission comes back to a file of mcpn that it has left, command by command.

Usage: ``python experiments/faults/returns.py [MISSION] [--stays]``. Followed are the calls of functions and
methods that are handed the mission, methods of the mission itself left out. Calls in one file, one after the
other, are a *stay* of the mission in that file; a stay in a file where it has stayed before is a *return*.
Reading and printing count, importing does not. It takes about 2 seconds.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import sys
import tempfile
from itertools import groupby
from pathlib import Path
from types import FrameType
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

import mcpn  # noqa: E402
from mcpn.cli.line import run  # noqa: E402
from mcpn.mission.model import Mission  # noqa: E402

PACKAGE = Path(mcpn.__file__).parent
COMMANDS = (("check",), ("causes",), ("controller", "-o", "{out}/controller"))
"""``{out}`` is a folder that is removed afterwards."""


def stays(words: list[str]) -> list[str]:
    """The files in which the mission stays while a command runs, in this order."""
    called: list[str] = []

    def follow(frame: FrameType, event: str, argument: Any) -> None:
        code = frame.f_code
        if event != "call" or code.co_name.startswith("<") or str(PACKAGE) not in code.co_filename:
            return
        names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
        if any(name != "self" and isinstance(frame.f_locals.get(name), Mission) for name in names):
            called.append(str(Path(code.co_filename).relative_to(PACKAGE)))

    with contextlib.redirect_stdout(io.StringIO()):
        sys.setprofile(follow)
        try:
            run(words)
        finally:
            sys.setprofile(None)
    return [file for file, _ in groupby(called)]


def main() -> None:
    """Prints a line for each command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    default = ROOT / "experiments" / "ulysse" / "mission.xml"
    parser.add_argument("mission", nargs="?", default=default, type=Path, help="default: Ulysse")
    parser.add_argument("--stays", action="store_true", help="list them")
    given = parser.parse_args()
    for name, *options in COMMANDS:
        with tempfile.TemporaryDirectory() as out:
            found = stays([name, str(given.mission), *(option.format(out=out) for option in options)])
        files = len({*found})
        print(f"{name}: {len(found)} stays in {files} files, {len(found) - files} returns")
        if given.stays:
            print(*(f"  {file}" for file in found), sep="\n")


if __name__ == "__main__":
    main()
