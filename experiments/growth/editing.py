"""What an edit of a long mission costs the server for editors: CPU milliseconds until its problems are known.

Usage: ``python experiments/growth/editing.py [--lines N] [--edits N]`` (needs mcpn[editor])

The mission is N lines long, in one file. Each edit changes a line somewhere in it, or adds one, so that the
mission is right or wrong; then the problems of the whole are found, as the server does it at each change of
the text. Completion and hover are asked for at the same place.
"""

from __future__ import annotations

import argparse
import random
import statistics
import tempfile
import time
from collections import defaultdict
from pathlib import Path

from lsprotocol import types as lsp
from pygls.workspace import TextDocument

from mcpn.editor.answers import Answers
from mcpn.editor.project import Memory, Project

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
    took: dict[str, list[float]] = defaultdict(list)
    with tempfile.TemporaryDirectory() as folder:
        file, memory = Path(folder).resolve() / "mission.xml", Memory()
        file.write_text("\n".join(lines))

        def typed(kind: str, wrong: int) -> Answers:
            """Finds the problems of the lines as they are now; what it takes is counted."""
            text = "\n".join(lines)
            answers = Answers(Project({file: text}, memory), lambda f: TextDocument(f.as_uri(), text))
            started = time.process_time()
            found = answers.diagnostics(file, at_once=True)
            took[kind].append(time.process_time() - started)
            assert sum(d.severity == lsp.DiagnosticSeverity.Error for d in found[file]) == wrong, found
            if not wrong:
                started = time.process_time()
                answers.diagnostics(file)
                took["what is suspicious, after a pause"].append(time.process_time() - started)
            return answers

        typed("opened", 0)
        for _ in range(arguments.edits):
            line = draw.randrange(len(lines) // 2, len(lines) - 1)
            right = lines[line]
            lines[line] = right.replace('activities="a', 'activities="nothing')
            answers = typed("a name that nothing has", 1)
            at = lsp.Position(line, lines[line].index('"', lines[line].index("activities")) + 1)
            started = time.process_time()
            assert answers.completion(file, at)
            took["completion"].append(time.process_time() - started)
            started = time.process_time()
            assert answers.hover(file, at, lambda name: "")
            took["hover"].append(time.process_time() - started)
            lines[line] = right.replace("activities", "activites")
            typed("an attribute that there is not", 1)
            lines[line] = right.replace("/>", "")
            typed("no XML", 1)
            lines[line] = right
            typed("right again", 0)
            lines.insert(line, "")
            typed("a line more", 0)
            lines[line] = f'  <objective name="new{line}" activities="a1"/>'
            typed("an objective more", 0)
    for name, seconds in took.items():
        middle, worst = (1000 * f(seconds) for f in (statistics.median, max))
        print(f"{arguments.lines} lines, {name}: median {middle:.0f} ms, worst {worst:.0f} ms (bar {BAR} ms)")


if __name__ == "__main__":
    main()
