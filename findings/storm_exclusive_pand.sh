#!/usr/bin/env bash
# Guess: pand-excl and pand-incl, the two kinds of an AND with an order that Storm reads in Galileo files, differ where one event
#   fails both inputs at once: the exclusive one does not fail by it.
# Package: PyPI stormpy 2.0.0 (Storm's dynamic fault trees)
# Seen: Both are inclusive. Of OR(A, B) and OR(A, C), all of rate 1, the probability by time 1 is 0.548 for both; the exclusive one's
#   is 0.231: that B fails before A and C, and one of them afterwards. Nothing is said.
# Source: the sum of both orders is 1 - 2/e^2 + 1/e^3, the part in which A is first (1 - 1/e^3)/3; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q stormpy==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import math

import stormpy
import stormpy.dft

(failed,) = stormpy.parse_properties('P=? [F<=1 "failed"]')
both = 1 - 2 * math.exp(-2) + math.exp(-3)
at_once = (1 - math.exp(-3)) / 3
exclusive = (both - at_once) / 2
inclusive = exclusive + at_once
found = {}
for gate in ("pand-incl", "pand-excl", "pand<=", "pand<"):
    with open("tree.dft", "w") as file:
        file.write(f'toplevel "T";\n"T" {gate} "X" "Y";\n"X" or "A" "B";\n"Y" or "A" "C";\n')
        file.writelines(f'"{event}" lambda=1;\n' for event in "ABC")
    (found[gate],) = stormpy.dft.analyze_dft(stormpy.dft.load_dft_galileo_file("tree.dft"), [failed])
print({gate: round(value, 6) for gate, value in found.items()}, "exclusive would be", round(exclusive, 6))
assert all(abs(value - inclusive) < 1e-6 for value in found.values()), "the behaviour has changed"
PYTHON
