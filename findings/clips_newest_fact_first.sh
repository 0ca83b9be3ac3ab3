#!/usr/bin/env bash
# Guess: Rules of CLIPS with the same salience fire in the order in which their facts came.
# Package: PyPI clipspy 1.0.6 (CLIPS 6.4)
# Seen: The newest first: three facts asserted as a, b, c are taken as c, b, a. A plan that is written as facts in their order
#   runs backwards. (set-strategy breadth) takes them in order.
# Source: CLIPS Basic Programming Guide, conflict resolution strategies: depth is the default; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q clipspy==1.0.6 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import clips


def order(strategy=""):
    taken = []
    environment = clips.Environment()
    if strategy:
        environment.eval(f"(set-strategy {strategy})")
    environment.define_function(lambda name: taken.append(str(name)), name="take")
    environment.build("(defrule act (goal ?name) => (take ?name))")
    for name in "abc":
        environment.assert_string(f"(goal {name})")
    environment.run()
    return taken


found = order(), order("breadth")
print(*found)
assert found == (["c", "b", "a"], ["a", "b", "c"]), "the behaviour has changed"
PYTHON
