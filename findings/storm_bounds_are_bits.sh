#!/usr/bin/env bash
# Guess: A variable of a PRISM or JANI model that an update takes out of its bounds is an error, as in PRISM: a model is not checked
#   whose variables leave the values that they are declared to have.
# Package: PyPI stormpy 2.0.0
# Seen: By default the model is built and answered. Of the bounds there are only as many bits as they need: [0..2] holds 3 as well, so
#   that P=? [F y=3] is 1, and one more is 0; [0..3] goes from 3 to 0, and [1..2] from 1 up to 2 by y-1.
# Source: the PRISM manual, "Commands" (an update that leaves the range is an error); https://jani-spec.org (BoundedType);
#   Storm's option --explchecks, which is off by default; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q stormpy==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import json

import stormpy


def answered(model, goal):
    (asked,) = stormpy.parse_properties(f"P=? [F {goal}]", model)
    built = stormpy.build_model(model, [asked])
    return stormpy.model_checking(built, asked).get_value(built.initial_states[0]), int(built.nr_states)


def prism(low, high, start, step, goal):
    with open("m.pm", "w") as file:
        file.write(f"dtmc\nmodule m\n y : [{low}..{high}] init {start};\n [] true -> (y'=y{step});\nendmodule\n")
    return answered(stormpy.parse_prism_program("m.pm"), goal)


def jani(goal):
    kind = {"kind": "bounded", "base": "int", "lower-bound": 0, "upper-bound": 2}
    more = {"ref": "y", "value": {"op": "+", "left": "y", "right": 1}}
    edge = {"location": "l", "destinations": [{"location": "l", "assignments": [more]}]}
    automaton = {"name": "a", "locations": [{"name": "l"}], "initial-locations": ["l"], "edges": [edge]}
    document = {
        "jani-version": 1, "name": "m", "type": "dtmc", "actions": [], "properties": [],
        "variables": [{"name": "y", "type": kind, "initial-value": 0}],
        "automata": [automaton], "system": {"elements": [{"automaton": "a"}]},
    }
    with open("m.jani", "w") as file:
        json.dump(document, file)
    return answered(stormpy.parse_jani_model("m.jani")[0], goal)


found = {
    "[0..2] comes to 3": prism(0, 2, 0, "+1", "(y=3)"),
    "[0..2] in JANI": jani("(y=3)"),
    "[0..3] comes to 4": prism(0, 3, 0, "+1", "(y=4)"),
    "[0..3] comes from 3 to 0": prism(0, 3, 3, "+1", "(y=0)"),
    "[1..2] comes from 1 down to 0": prism(1, 2, 1, "-1", "(y=0)"),
    "[1..2] comes from 1 down to 2": prism(1, 2, 1, "-1", "(y=2)"),
}
print(found)
assert found == {
    "[0..2] comes to 3": (1.0, 4), "[0..2] in JANI": (1.0, 4), "[0..3] comes to 4": (0.0, 4),
    "[0..3] comes from 3 to 0": (1.0, 2), "[1..2] comes from 1 down to 0": (0.0, 2),
    "[1..2] comes from 1 down to 2": (1.0, 2),
}, "the behaviour has changed"
PYTHON
