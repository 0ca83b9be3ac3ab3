#!/usr/bin/env bash
# Guess: a latch of an AIGER file that begins with either value, which is written by its own number in the place of the reset
#   value, is refused by a library that has only one value for it, or is free.
# Package: PyPI py-aiger 8.1.0
# Seen: It begins with 1, without a word: runs from 0 are not there. Latch 2 of the file below is an output, so "the output is
#   always 1" holds in the library and does not by the format.
# Source: Biere, Heljanko, Wieringa, AIGER 1.9 and beyond (2011), reset values; aiger/parser.py (bool of the number)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q py-aiger==8.1.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import aiger

found = {}
for reset in ("0", "1", "2"):
    circuit = aiger.parse(f"aag 1 0 1 1 0\n2 2 {reset}\n2\n")
    run = circuit.simulator()
    next(run)
    ((value,), _) = [list(part.values()) for part in run.send({})]
    found[reset] = value
print(found)
assert found == {"0": False, "1": True, "2": True}, "the behaviour has changed"
PYTHON
