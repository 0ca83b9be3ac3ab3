#!/usr/bin/env bash
# Guess: r.S and r["S"] of a model in RoadRunner are the same number, as attributes and keys of a library's object are two ways to
#   one thing.
# Package: PyPI libroadrunner 2.10.0, with antimony 3.3.0
# Seen: r.S is the concentration, r["S"] the amount: 10 and 20 in a compartment of 2 litres. r["[S]"] is the concentration, and so
#   is what simulate() gives by default. In a compartment of 1, which most models have, nobody sees it.
# Source: RoadRunner's documentation of selections (S is an amount, [S] a concentration); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q libroadrunner==2.10.0 antimony==3.3.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import antimony
import roadrunner

antimony.loadAntimonyString("model m\n compartment C = 2; species S in C; S = 10; J: S -> ; 0;\nend")
model = roadrunner.RoadRunner(antimony.getSBMLString("m"))
found = {"r.S": model.S, "r['S']": model["S"], "r['[S]']": model["[S]"], "columns": list(model.simulate(0, 1, 2).colnames)}
print(found)
assert found == {"r.S": 10, "r['S']": 20, "r['[S]']": 10, "columns": ["time", "[S]"]}, "the behaviour has changed"
PYTHON
