#!/usr/bin/env bash
# Guess: mocus() of a fault tree lists its minimal cut sets, and first of all an event that is one by itself.
# Package: PyPI cutsets 1.4
# Seen: A cut set that is found three times or more is gone: of gates OR(A, B0), OR(A, B1), OR(A, B2) under an OR, A is
#   listed with two of them and not with three. The single point of failure that most gates share is the one left out.
# Source: cutsets.py (mocus removes one more copy for each pair of equal sets); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q cutsets==1.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from cutsets import mocus

found = {}
for gates in (1, 2, 3, 4):
    tree = [("TOP", "Or", [f"G{number}" for number in range(gates)])]
    tree += [(f"G{number}", "Or", ["A", f"B{number}"]) for number in range(gates)]
    found[gates] = sorted(cut_set for (cut_set,) in mocus(tree))
print(found)
expected = {1: ["A", "B0"], 2: ["A", "B0", "B1"], 3: ["B0", "B1", "B2"], 4: ["B0", "B1", "B2", "B3"]}
assert found == expected, "the behaviour has changed"
PYTHON
