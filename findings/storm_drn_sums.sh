#!/usr/bin/env bash
# Guess: Storm refuses a chain in the DRN format in which the probabilities of a state add up to 0.6, or scales them.
# Package: PyPI stormpy 2.0.0
# Seen: It reads the chain without a word: one of two ends is reached with 0.3, the other with 0.3, and one or the
#   other with 1, for that is decided on the graph alone.
# Source: https://www.stormchecker.org/documentation/background/languages.html#drn says nothing of a check; found by
#   running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q stormpy==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import stormpy

with open("m.drn", "w") as file:
    file.write("@type: DTMC\n@parameters\n\n@reward_models\n\n@nr_states\n3\n@nr_choices\n3\n@model\n")
    file.write("state 0 init\n\taction 0\n\t\t1 : 0.3\n\t\t2 : 0.3\n")
    file.write("state 1 one\n\taction 0\n\t\t1 : 1\nstate 2 other\n\taction 0\n\t\t2 : 1\n")
model = stormpy.build_model_from_drn[float]("m.drn")
found = []
for text in ('P=? [F "one"]', 'P=? [F "other"]', 'P=? [F ("one" | "other")]'):
    (asked,) = stormpy.parse_properties(text)
    found.append(round(stormpy.model_checking(model, asked).get_value(0), 6))
    print(text, found[-1])
assert found == [0.3, 0.3, 1.0], "the behaviour has changed"
PYTHON
