#!/usr/bin/env bash
# Guess: add_vars gives a manager of decision diagrams more variables and leaves the functions made before as they are: x or not x
#   stays true, and x does not ask for the new variable.
# Package: PyPI oxidd 0.13.0
# Seen: With BDDManager it is so. With ZBDDManager, which has the same calls, each function made before becomes false where a new
#   variable is true: x or not x is no longer valid, x differs from var(0), and of x and the new z nothing is left.
# Source: Minato (1993), zero-suppressed diagrams (what a set does not name is not in it); the docstring of add_vars ("can change the
#   semantics"); found by running both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q oxidd==0.13.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from oxidd.bdd import BDDManager
from oxidd.zbdd import ZBDDManager

found = {}
for manager in (BDDManager(1000, 1000, 1), ZBDDManager(1000, 1000, 1)):
    manager.add_vars(2)
    x = manager.var(0)
    certain = x | ~x
    assert certain.valid() and x.eval([(0, True), (1, False)])
    manager.add_vars(1)
    both = (x & manager.var(2)).satisfiable()
    found[type(manager).__name__] = (certain.valid(), x == manager.var(0), both)
print(found)
assert found == {"BDDManager": (True, True, True), "ZBDDManager": (False, False, False)}, "the behaviour has changed"
PYTHON
