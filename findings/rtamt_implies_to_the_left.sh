#!/usr/bin/env bash
# Guess: rtamt reads `a implies b implies c` as `a implies (b implies c)`, as temporal logic is usually written.
# Package: PyPI rtamt 0.4.10
# Seen: It reads `(a implies b) implies c`: where a is false by 2, the formula is false by 2 and not true.
# Source: the package's own StlExpression grammar, where implies is an ordinary binary operator of ANTLR, which is
#   left-associative unless told otherwise
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q rtamt==0.4.10 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python 2>/dev/null - <<'PYTHON'
import rtamt


def asked(formula):
    monitor = rtamt.StlDiscreteTimeSpecification()
    monitor.declare_var("x", "float")
    monitor.declare_var("told", "float")
    monitor.spec = f"told = {formula}"
    monitor.parse()
    return monitor.evaluate({"time": [0, 1], "x": [-2.0, -2.0]})[0][1]


plain = asked("x>=0 implies x>=1 implies x>=7")
left = asked("(x>=0 implies x>=1) implies x>=7")
right = asked("x>=0 implies (x>=1 implies x>=7)")
print("without parentheses", plain, "to the left", left, "to the right", right)
raise SystemExit((plain, left, right) != (-2.0, -2.0, 3.0) and "the behaviour has changed")
PYTHON
