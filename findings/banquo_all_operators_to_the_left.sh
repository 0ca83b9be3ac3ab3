#!/usr/bin/env bash
# Guess: a formula in text binds as logic does: "p or q and r" is p or (q and r), "p -> q and r" is p -> (q and r).
# Package: PyPI pybanquo 0.1.1
# Seen: All operators between two formulas bind alike, from the left, -> among them: "p or q and r" is (p or q) and r, "p -> q and r"
#   is (p -> q) and r, "p -> q -> r" is (p -> q) -> r. Below p is true, q and r are false.
# Source: found by running it; the package's page names no precedence
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pybanquo==0.1.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import banquo
from banquo import stl

trace = banquo.Trace({0.0: {"p": -1.0, "q": 1.0, "r": 1.0}, 1.0: {"p": -1.0, "q": 1.0, "r": 1.0}})
P, Q, R = "p <= 0", "q <= 0", "r <= 0"


def holds(text):
    return banquo.evaluate(stl.parse(text), trace) > 0


found = [
    [holds(text) for text in three]
    for three in (
        (f"{P} or {Q} and {R}", f"({P} or {Q}) and {R}", f"{P} or ({Q} and {R})"),
        (f"{Q} -> {Q} and {R}", f"({Q} -> {Q}) and {R}", f"{Q} -> ({Q} and {R})"),
        (f"{Q} -> {P} -> {R}", f"({Q} -> {P}) -> {R}", f"{Q} -> ({P} -> {R})"),
    )
]
print(found)
assert found == [[False, False, True]] * 3, "the behaviour has changed"
PYTHON
