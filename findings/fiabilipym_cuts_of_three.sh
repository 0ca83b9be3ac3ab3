#!/usr/bin/env bash
# Guess: minimalcuts(order=3) of three components in parallel is the one set of all three.
# Package: PyPI fiabilipym 2.0.1
# Seen: It is one set of three pairs: from the third order on, what is combined are the pairs of the second, not components. Of
#   the bridge of five components, which has two cuts of three, it gives 54 such sets. Orders 1 and 2 are right.
# Source: fiabilipym/system.py (minimalcuts takes combinations of the former order's pairs); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q fiabilipym==2.0.1 2>pip.log || { cat pip.log; exit 1; }
MPLBACKEND=agg venv/bin/python - <<'PYTHON'
from fiabilipym import Component, System

a, b, c = (Component(name, 1.0) for name in "abc")
system = System()
system["E"] = [a, b, c]
for one in (a, b, c):
    system[one] = "S"
cuts = system.minimalcuts(order=3)
print(cuts)
assert cuts == [frozenset({frozenset({a, b}), frozenset({a, c}), frozenset({b, c})})], "the behaviour has changed"
v, w, x, y, z = (Component(name, 1.0) for name in "vwxyz")
bridge = System()
bridge["E"] = [v, w]
bridge[v], bridge[w], bridge[z] = [x, z], [y, z], [x, y]
bridge[x] = bridge[y] = "S"
assert set(bridge.minimalcuts(order=2)) == {frozenset({v, w}), frozenset({x, y})}, "the behaviour has changed"
found = [cut for cut in bridge.minimalcuts(order=3) if any(isinstance(one, frozenset) for one in cut)]
print(len(found), "sets of pairs of the bridge")
assert len(found) == 54, "the behaviour has changed"
PYTHON
