#!/usr/bin/env bash
# Guess: satisfy_count of a decision diagram says how many assignments satisfy it, as that of an expression does.
# Package: PyPI pyeda 0.29.0
# Seen: It counts the paths to 1: (a | b) & c has 3 assignments, the expression says 3, its diagram 2; a | b | c has 7,
#   the diagram says 3. Levels that a path skips are not multiplied in.
# Source: pyeda/boolalg/bdd.py (satisfy_all yields a point for each path), boolfunc.py (satisfy_count is its length)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pyeda==0.29.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from itertools import product

from pyeda.inter import expr, expr2bdd

for text, names in (("(a | b) & c", "abc"), ("a | b | c", "abc")):
    values = [dict(zip(names, bits)) for bits in product((False, True), repeat=len(names))]
    true = sum(eval(text, {}, value) for value in values)
    expression = expr(text)
    counted = expression.satisfy_count(), expr2bdd(expression).satisfy_count()
    print(text, "by hand", true, "expression", counted[0], "diagram", counted[1])
    assert counted[0] == true, "the behaviour has changed"
    assert counted[1] < true, "the behaviour has changed"
PYTHON
