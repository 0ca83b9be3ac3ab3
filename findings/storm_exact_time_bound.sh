#!/usr/bin/env bash
# Guess: A probability by a time of a model with exact numbers is refused with an error, or computed with floats.
# Package: PyPI stormpy 2.0.0
# Seen: stormpy.model_checking returns None, without an error; the same question without a time bound is answered.
# Source: https://www.stormchecker.org/documentation/background/languages.html#drn ; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q stormpy==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import stormpy

with open("m.drn", "w") as file:
    file.write("@type: Markov Automaton\n@parameters\n\n@reward_models\n\n@nr_states\n3\n@nr_choices\n3\n@model\n")
    file.write("state 0 !0 init\n\taction 0\n\t\t1 : 1/2\n\t\t2 : 1/2\n")
    file.write("state 1 !1\n\taction 0\n\t\t2 : 1\nstate 2 !1 done\n\taction 0\n\t\t2 : 1\n")
model = stormpy.build_model_from_drn[stormpy.Rational]("m.drn")
for text, known in (('Pmax=? [F<=1 "done"]', False), ('Pmax=? [F "done"]', True)):
    (asked,) = stormpy.parse_properties(text)
    found = stormpy.model_checking(model, asked)
    print(text, found)
    assert (found is not None) == known, "the behaviour has changed"
PYTHON
