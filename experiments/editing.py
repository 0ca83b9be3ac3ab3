"""What an edit of a long mission costs the server for editors: CPU milliseconds until its problems are known.

Usage: ``python experiments/editing.py [--lines N] [--edits N]`` (needs mcpn[editor])

The mission is N lines long, in one file. Each edit changes an attribute of a line somewhere in it, so that
the mission is right, or names what is not there; then the problems of the whole are found, as the server does
it at each change of the text. Completion is asked for at the same place.
"""

from __future__ import annotations

import argparse
import random
import statistics
import tempfile
import time
from pathlib import Path

from lsprotocol import types as lsp
from pygls.workspace import TextDocument

from mcpn.editor.answers import Answers
from mcpn.editor.project import Project

BAR = 100
"""Milliseconds that nobody notices."""


def mission(lines: int) -> list[str]:
    """A mission of so many lines: a tenth declares activities and hardware, the rest are objectives."""
    declared = lines // 30
    head = ['<mission name="long" xmlns="urn:mcpn:mission:1">', '  <robot name="r">']
    head += [f'    <hardware name="h{i}"/>' for i in range(declared)]
    for i in range(declared):
        other = f'<alternative name="b" consumes="h{(i + 1) % declared}"/>'
        head += [f'    <activity name="a{i}">', f'      <alternative name="a" consumes="h{i}"/>{other}']
        head += ["    </activity>"]
    head += ["  </robot>"]
    legs = (f'  <objective name="o{i}" activities="a{i % declared}"/>' for i in range(lines - len(head) - 1))
    return [*head, *legs, "</mission>"]


def main() -> None:
    """Prints the median and the worst of some edits."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lines", type=int, default=10_000)
    parser.add_argument("--edits", type=int, default=10)
    arguments = parser.parse_args()
    lines, draw = mission(arguments.lines), random.Random(1)
    took: dict[str, list[float]] = {"right": [], "wrong": [], "completion": []}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder).resolve() / "mission.xml"
        file.write_text("\n".join(lines))
        for number in range(2 * arguments.edits):
            wrong = number % 2
            line = draw.randrange(len(lines) // 2, len(lines) - 1)
            typed = list(lines)
            name = "nothing" if wrong else "a"
            typed[line] = typed[line].replace('activities="a', f'activities="{name}')
            text = "\n".join(typed)
            answers = Answers(Project({file: text}), lambda f, text=text: TextDocument(f.as_uri(), text))
            started = time.process_time()
            found = answers.diagnostics(file)
            took["wrong" if wrong else "right"].append(time.process_time() - started)
            errors = [d for d in found[file] if d.severity == lsp.DiagnosticSeverity.Error]
            assert len(errors) == wrong
            at = lsp.Position(line, typed[line].index('"', typed[line].index("activities")) + 1)
            started = time.process_time()
            assert answers.completion(file, at)
            took["completion"].append(time.process_time() - started)
    for name, seconds in took.items():
        middle, worst = (1000 * f(seconds) for f in (statistics.median, max))
        print(f"{arguments.lines} lines, {name}: median {middle:.0f} ms, worst {worst:.0f} ms (bar {BAR} ms)")


if __name__ == "__main__":
    main()
