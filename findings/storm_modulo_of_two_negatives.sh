#!/usr/bin/env bash
# Guess: A remainder is smaller than what one divides by, whatever the signs: mod(-7, -3) is -1, or 2; and two readers of JANI agree on
#   the operator %, which PRISM's mod becomes.
# Package: PyPI stormpy 2.0.0 and momba 0.6.12 (with momba_engine 0.6.12)
# Seen: For Storm it is -4, in PRISM's language and in JANI alike; for momba 2, and so -7 % -3 chooses another way in each. Where at most
#   one of the two is negative they agree: mod(-7, 3) is 2, mod(7, -3) is 1.
# Source: https://jani-spec.org (BinaryExpression, "%": modulo); the PRISM manual, "Expressions" (mod); found by running both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q stormpy==2.0.0 momba==0.6.12 momba_engine==0.6.12 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import json

import stormpy
from momba import engine, jani

PAIRS = [(7, 3), (-7, 3), (7, -3), (-7, -3)]


def document(left, right):
    kind = {"kind": "bounded", "base": "int", "lower-bound": -20, "upper-bound": 20}
    value = {"op": "%", "left": "x", "right": right}
    to_end = {"location": "e", "assignments": [{"ref": "y", "value": value}]}
    edges = [{"location": "s", "destinations": [to_end]}, {"location": "e", "destinations": [{"location": "e"}]}]
    locations = [{"name": "s"}, {"name": "e"}]
    variables = [{"name": name, "type": kind, "initial-value": start} for name, start in (("x", left), ("y", 20))]
    return {
        "jani-version": 1, "name": "m", "type": "dtmc", "actions": [], "properties": [], "variables": variables,
        "automata": [{"name": "a", "locations": locations, "initial-locations": ["s"], "edges": edges}],
        "system": {"elements": [{"automaton": "a"}]},
    }


def values_of(model):
    """Values that y comes to, as Storm says."""
    for value in range(-9, 10):
        (asked,) = stormpy.parse_properties(f"P=? [F (y={value})]", model)
        built = stormpy.build_model(model, [asked])
        if stormpy.model_checking(built, asked).get_value(built.initial_states[0]) == 1:
            yield value


def by_storm_in_jani(left, right):
    with open("m.jani", "w") as file:
        json.dump(document(left, right), file)
    return list(values_of(stormpy.parse_jani_model("m.jani")[0]))


def by_storm_in_prism(left, right):
    with open("m.pm", "w") as file:
        file.write("dtmc\nmodule m\n y : [-20..20] init 20;\n")
        file.write(f" [] y=20 -> (y'=mod({left}, {right}));\n [] y!=20 -> true;\nendmodule\n")
    return list(values_of(stormpy.parse_prism_program("m.pm")))


def by_momba(left, right):
    explorer = engine.Explorer.new_discrete_time(jani.load_model(json.dumps(document(left, right))))
    (state,) = explorer.initial_states
    (transition,) = state.transitions
    (destination,) = transition.destinations.support
    return [destination.state.global_env["y"].as_int]


found = {name: [ask(*pair) for pair in PAIRS] for name, ask in (
    ("Storm, JANI", by_storm_in_jani), ("Storm, PRISM", by_storm_in_prism), ("momba", by_momba),
)}
print(PAIRS, found)
assert found == {
    "Storm, JANI": [[1], [2], [1], [-4]], "Storm, PRISM": [[1], [2], [1], [-4]], "momba": [[1], [2], [1], [2]],
}, "the behaviour has changed"
PYTHON
