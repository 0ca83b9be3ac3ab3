#!/usr/bin/env bash
# Guess: after set_universe, sets made before keep their elements, or using them raises.
# Package: PyPI graphillion 2.1
# Seen: They keep numbers, not elements: with the same three names in another order a set that held a holds c, and the
#   union with a set made afterwards is of other elements than either's author wrote. Nothing warns.
# Source: graphillion/setset.py, universe.py (one table of objects for the process)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q graphillion==2.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from graphillion import setset

setset.set_universe(["a", "b", "c"])
before = setset([["a"], ["b", "c"]])
setset.set_universe(["c", "a", "b"])
found = sorted(sorted(one) for one in before)
print(found)
assert found == [["a", "b"], ["c"]], "the behaviour has changed"
PYTHON
