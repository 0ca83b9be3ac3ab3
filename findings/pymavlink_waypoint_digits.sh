#!/usr/bin/env bash
# Guess: a mission of waypoints that is loaded and saved is the same mission.
# Package: PyPI pymavlink 2.4.50
# Seen: Coordinates come back with six decimals (47.2345678 as 47.234568, some 2 cm), and numbers are given anew: item 5 after
#   item 1 becomes 2, so that a DO_JUMP to 5 points elsewhere.
# Source: pymavlink/mavwp.py (save writes %f; add sets seq)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pymavlink==2.4.50 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from pathlib import Path

from pymavlink.mavwp import MAVWPLoader

rows = ["0 1 0 16 0 0 0 0 47.1 8.5 400 1", "1 0 3 16 0 0 0 0 47.2345678 8.5 30 1", "5 0 3 177 5 1 0 0 0 0 0 1"]
Path("a.txt").write_text("\n".join(["QGC WPL 110", *(row.replace(" ", "\t") for row in rows)]) + "\n")
loader = MAVWPLoader()
loader.load("a.txt")
loader.save("b.txt")
saved = [line.split("\t") for line in Path("b.txt").read_text().splitlines()[1:]]
print(saved)
assert saved[1][8] == "47.234568", "the behaviour has changed"
assert (saved[2][0], float(saved[2][4])) == ("2", 5.0), "the behaviour has changed"
PYTHON
