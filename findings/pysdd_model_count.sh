#!/usr/bin/env bash
# Guess: model_count of the function a, in a manager of four variables, is 8.
# Package: PyPI PySDD 1.0.6
# Seen: It is 1: it counts over the part of the vtree that the function uses, a | b has 3, true has 1. global_model_count of
#   the manager says 8.
# Source: sdd library, sdd_model_count and sdd_global_model_count; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q PySDD==1.0.6 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from pysdd.sdd import SddManager

manager = SddManager(var_count=4)
a, b, *_ = manager.vars
found = [(one.model_count(), manager.global_model_count(one)) for one in (a, a | b, manager.true())]
print(found)
assert found == [(1, 8), (3, 12), (1, 16)], "the behaviour has changed"
PYTHON
