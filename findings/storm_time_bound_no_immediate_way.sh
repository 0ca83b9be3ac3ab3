#!/usr/bin/env bash
# Guess: In a Markov automaton whose immediate states all lead away from the goal, the probability to reach the goal
#   by a time is answered as for any other goal.
# Package: PyPI stormpy 2.0.0
# Seen: "Cannot build empty submatrix" for the goal that no immediate state can reach; the same question without the
#   bound, and the bounded question of another goal in the same file, are answered.
# Source: the error itself names SubmatrixBuilder.h, line 154: the states from which immediate choices may still
#   reach the goal are none here
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q stormpy==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import stormpy

with open("m.drn", "w") as file:
    file.write("@type: Markov Automaton\n@parameters\n\n@reward_models\n\n@nr_states\n4\n@nr_choices\n4\n@model\n")
    file.write("state 0 !3 init\n\taction 0\n\t\t1 : 0.5\n\t\t2 : 0.5\n")
    file.write("state 1 !1 success\n\taction 0\n\t\t1 : 1\nstate 2 !0\n\taction 0\n\t\t3 : 1\n")
    file.write("state 3 !1 failure\n\taction 0\n\t\t3 : 1\n")
model = stormpy.build_model_from_drn[float]("m.drn")


def asked(text):
    try:
        (formula,) = stormpy.parse_properties(text)
        return round(stormpy.model_checking(model, formula).get_value(0), 3)
    except RuntimeError as error:
        return str(error).strip()


told = {text: asked(text) for text in (
    'Pmax=? [F<=1 "success"]', 'Pmax=? [F "success"]', 'Pmax=? [F<=1 "failure"]', 'Pmax=? [F "failure"]')}
print(*told.items(), sep="\n")
first, *others = told.values()
assert "empty submatrix" in str(first), "the behaviour has changed"
assert all(isinstance(value, float) for value in others), "the behaviour has changed"
PYTHON
