#!/usr/bin/env bash
# Guess: p until[0,2] q is true at a moment at which q holds, whatever p does, as eventually[0,2] q is; and the two kinds of time of
#   one package answer alike where a signal never changes.
# Package: PyPI rtamt 0.4.10 and mstlo-python 0.2.2
# Seen: In discrete time rtamt says so (0.5), in dense time it says false (-1.5) where p is false throughout and q true: there p has
#   to hold at the moment of q, too. mstlo says false as well, at the first moment and at the moment at which p ends and q begins.
# Source: Maler, Nickovic, Monitoring temporal properties of continuous signals (2004), whose until asks for p at the moment of q;
#   LTL's does not; found by running them
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q rtamt==0.4.10 mstlo-python==0.2.2 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import mstlo_python
import rtamt

formula = "x>=0.5 until[0,2] y>=0.5"
specs = []
for kind in (rtamt.StlDiscreteTimeSpecification, rtamt.StlDenseTimeSpecification):
    spec = kind()
    spec.declare_var("x", "float")
    spec.declare_var("y", "float")
    spec.spec = formula
    spec.parse()
    specs.append(spec)
discrete = specs[0].evaluate({"time": [0, 1, 2, 3], "x": [-1, -1, -1, -1], "y": [1, 1, 1, 1]})[0][1]
dense = specs[1].evaluate(["x", [[0, -1], [5, -1]]], ["y", [[0, 1], [5, 1]]])[0][1]


def first(text, samples):
    monitor = mstlo_python.Monitor(mstlo_python.parse_formula(text), semantics="DelayedQualitative")
    return [value for sample in samples for _, value in monitor.update(*sample).verdicts()][0]


held = [("x", -1, 0), ("y", 1, 0), ("x", -1, 5), ("y", 1, 5)]
handed = [("x", 1, 0), ("y", -1, 0), ("x", -1, 1), ("y", 1, 1), ("x", -1, 5), ("y", 1, 5)]
until = "x > 0 U[0,2] y > 0"
found = (discrete, dense, first(until, held), first(until, handed), first("F[0,2](y > 0)", held))
print(found)
assert found == (0.5, -1.5, False, False, True), "the behaviour has changed"
PYTHON
