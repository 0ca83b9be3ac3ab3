#!/usr/bin/env bash
# Guess: In a Markov automaton a state with a rate and two actions is refused, or the first action is taken at that
#   rate and Pmax is 1.
# Package: PyPI stormpy 2.0.0
# Seen: The first, Markovian choice is dropped: Pmax of what it leads to is 0.
# Source: https://www.stormchecker.org/documentation/background/languages.html#drn (maximal progress, applied as the
#   file is read)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q stormpy==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import stormpy

with open("m.drn", "w") as file:
    file.write("@type: Markov Automaton\n@parameters\n\n@reward_models\n\n@nr_states\n3\n@nr_choices\n4\n@model\n")
    file.write("state 0 !3 init\n\taction 0\n\t\t1 : 1\n\taction 1\n\t\t2 : 1\n")
    file.write("state 1 !1 done\n\taction 0\n\t\t1 : 1\nstate 2 !1\n\taction 0\n\t\t2 : 1\n")
model = stormpy.build_model_from_drn[float]("m.drn")
(asked,) = stormpy.parse_properties('Pmax=? [F "done"]')
value = stormpy.model_checking(model, asked).get_value(0)
print(asked, value)
assert value == 0, "the behaviour has changed"
PYTHON
