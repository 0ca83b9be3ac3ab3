#!/usr/bin/env bash
# Guess: A label that Storm reads from a DRN file can be asked for in a property, in quotes.
# Package: PyPI stormpy 2.0.0
# Seen: done.well is listed among the labels of the model; in a property it is a syntax error, in quotes, too.
# Source: https://www.stormchecker.org/documentation/background/properties.html ; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q stormpy==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import stormpy

with open("m.drn", "w") as file:
    file.write("@type: DTMC\n@parameters\n\n@reward_models\n\n@nr_states\n1\n@nr_choices\n1\n@model\n")
    file.write("state 0 init done.well\n\taction 0\n\t\t0 : 1\n")
model = stormpy.build_model_from_drn[float]("m.drn")
print(sorted(model.labeling.get_labels()))
assert "done.well" in model.labeling.get_labels(), "the behaviour has changed"
try:
    stormpy.parse_properties('P=? [F "done.well"]')
except RuntimeError as error:
    print(str(error).splitlines()[0])
else:
    raise SystemExit("the behaviour has changed")
PYTHON
