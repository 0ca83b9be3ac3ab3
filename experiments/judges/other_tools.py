"""The table of docs/other-tools.md: what other tools say of drawn missions, measured and written anew.

Usage: ``python experiments/judges/other_tools.py [--number N] [ROW ...]``

Rows are those of ``tests/other_tools.py``. Tools that are installed are asked for their versions, and judge N
drawn missions (50), or the tests that hold a row are run; of tools that are not here rows stay as they are.
SCION is found where ``NODE_PATH`` names a folder with ``@scion-scxml/scxml``. It takes some four minutes.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from tests.other_tools import ROWS, Row  # noqa: E402

PAGE = ROOT / "docs" / "other-tools.md"
BLOCK = re.compile(r"(<!-- measured: tools -->\n)(.*?)(<!-- end -->)", re.DOTALL)
HEAD = "| tool, version | file | direction | held | measured | what differs |\n|---|---|---|---|---|---|\n"


def figures(row: Row, number: int) -> str:
    """What a row measures, in words."""
    if row.draws is None:
        asked = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", row.test]
        run = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=False)
        passed = re.search(r"(\d+) passed", run.stdout)
        if run.returncode or passed is None:
            raise SystemExit(run.stdout)
        return "1 test passes" if passed[1] == "1" else f"{passed[1]} tests pass"
    found = row.compared(number, strict=False)
    judged, differ = found.pop("judged"), found.pop("differ", 0)
    told = ", ".join(f"{count:,} {what}" for what, count in found.items())
    return f"{judged} {row.of}: {told}; {differ} differ"


def main() -> None:
    """Measures rows and writes the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rows", nargs="*", metavar="ROW", help=f"by default all: {', '.join(ROWS)}")
    parser.add_argument("--number", type=int, default=50, help="missions for each row")
    asked = parser.parse_args()
    page = PAGE.read_text()
    block = BLOCK.search(page)
    assert block is not None
    before = {tuple(line.split(" | ")[1:4]): line for line in block[2].splitlines()[2:]}
    lines = []
    for name, row in ROWS.items():
        line = before.get((row.file, row.direction, row.held), "")
        if row.here and (not asked.rows or name in asked.rows):
            measured = figures(row, asked.number)
            line = f"| {row.names} | {row.file} | {row.direction} | {row.held} | {measured} | {row.differs} |"
            sys.stdout.write(f"{line}\n")
        if line:
            lines.append(line)
    table = HEAD + "".join(f"{line}\n" for line in lines)
    PAGE.write_text(page[: block.start(2)] + table + page[block.end(2) :])


if __name__ == "__main__":
    main()
