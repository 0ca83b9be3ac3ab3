#!/usr/bin/env bash
# Guess: Storm, which reads models of PRISM, reads PRISM's operators: <=> between two conditions, and !x=1, where ! binds more loosely
#   than =.
# Package: PyPI stormpy 2.0.0
# Seen: Both are refused as syntax errors: <=> is read as <= and a stray >, and ! binds to x alone. y = z says the same as y <=> z, and
#   !(x=1) is taken; so is => between conditions, which binds to the left.
# Source: PRISM's manual, The PRISM language, Expressions (order of operators, ! after = and !=); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q stormpy==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import stormpy


def holds(condition):
    with open("model.prism", "w", encoding="utf-8") as file:
        file.write(
            "dtmc\nmodule m\n x: [0..3] init 1;\n y: bool init false;\n z: bool init true;\n [] true -> true;\nendmodule\n"
            f'label "asked" = {condition};\n'
        )
    try:
        model = stormpy.build_model(stormpy.parse_prism_program("model.prism"))
    except Exception as error:
        return "refused" if "Parsing error" in str(error) else repr(error)
    return 0 in model.labeling.get_states("asked")


found = {text: holds(text) for text in ("y <=> z", "y = z", "!x=1", "!(x=1)", "y => z => y", "(y => z) => y", "y => (z => y)")}
print(found)
assert found == {
    "y <=> z": "refused",
    "y = z": False,
    "!x=1": "refused",
    "!(x=1)": False,
    "y => z => y": False,
    "(y => z) => y": False,
    "y => (z => y)": True,
}, "the behaviour has changed"
PYTHON
