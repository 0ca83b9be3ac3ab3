#!/usr/bin/env bash
# Guess: in py_trees' XML num_failures="-1" tries for ever, as Repeat's -1 repeats for ever; num_success="0" succeeds at once.
# Package: PyPI py_trees 2.6.0
# Seen: Retry with -1 fails with the first failure; Repeat with 0 runs on while its child succeeds.
# Source: py_trees/decorators.py (Retry.update asks failures < num_failures, Repeat.update success == num_success)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q py_trees==2.6.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import py_trees
from py_trees.behaviours import Failure, Success
from py_trees.decorators import Repeat, Retry


def ticked(root, ticks):
    found = []
    for _ in range(ticks):
        root.tick_once()
        found.append(root.status.name)
    return found


found = ticked(Retry("retry", Failure("a"), -1), 1), ticked(Repeat("repeat", Success("a"), 0), 20)
print(found)
assert found == (["FAILURE"], ["RUNNING"] * 20), "the behaviour has changed"
assert ticked(Repeat("repeat", Success("a"), -1), 20) == ["RUNNING"] * 20, "the behaviour has changed"
assert ticked(Retry("retry", Failure("a"), 2), 2) == ["RUNNING", "FAILURE"], "the behaviour has changed"
PYTHON
