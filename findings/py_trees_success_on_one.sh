#!/usr/bin/env bash
# Guess: a Parallel with SuccessOnOne, or SuccessOnSelected, succeeds when that one succeeds, whatever another child does.
# Package: PyPI py_trees 2.6.0
# Seen: It fails in the tick in which any child fails, although the one that counts has succeeded in the same tick.
# Source: py_trees/composites.py (Parallel.tick looks for a failure first, with each policy)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q py_trees==2.6.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import py_trees
from py_trees.behaviours import Failure, Running, Success
from py_trees.common import ParallelPolicy, Status

for other, expected in ((Running, Status.SUCCESS), (Failure, Status.FAILURE)):
    counts = Success("counts")
    for policy in (ParallelPolicy.SuccessOnOne(), ParallelPolicy.SuccessOnSelected([counts])):
        parallel = py_trees.composites.Parallel("parallel", policy, children=[counts, other("other")])
        parallel.tick_once()
        print(type(policy).__name__, other.__name__, parallel.status.name)
        assert parallel.status == expected, "the behaviour has changed"
        parallel.remove_all_children()
PYTHON
