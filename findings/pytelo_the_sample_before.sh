#!/usr/bin/env bash
# Guess: The value of a trace at the time of a sample is that sample; between samples a trace made with the default, "nearest", has
#   the nearer one. And an interval of time means all samples in it, and no others.
# Package: PyPI pytelo 1.0.3 (with numpy 2.3.5 and scipy 1.16.3)
# Seen: At the time of a sample (but the first) the value is that of the sample before, and between two it is that of the farther one,
#   so that `F[2,2] x > 0` is false where x is 5 at time 2. "previous" gives the sample before, too, and "next" the one after, at the
#   time of a sample; "linear" is right. F and G look at the times low, low + 1 and so on below high + 1: F[0,0.5] looks at time 1.
# Source: pytelo/_internal/Trace.py (distances are compared with their signs turned round), pytelo/stl/stl.py
#   (np.arange(low, high + 1)); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pytelo==1.0.3 numpy==2.3.5 scipy==1.16.3 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from pytelo.stl import Trace, to_ast

TIMES, VALUES = [0, 1, 2, 3], [-1, -1, 5, -1]


def at(times, **kind):
    trace = Trace(["x"], TIMES, [VALUES], **kind)
    return [float(trace.value("x", time)) for time in times]


nearest = Trace(["x"], TIMES, [VALUES])
found = {
    "samples": at(TIMES),
    "between": at([1.4, 1.6]),
    "previous": at(TIMES, kind="previous"),
    "next": at(TIMES, kind="next"),
    "linear": at(TIMES, kind="linear"),
    "F[2,2]": float(to_ast("F[2,2] x > 0").robustness(nearest, 0)),
    "F[0,0.5]": float(to_ast("F[0,0.5] x > 0").robustness(Trace(["x"], TIMES, [[-1, 5, 5, 5]], kind="linear"), 0)),
}
print(found)
assert found == {
    "samples": [-1, -1, -1, 5], "between": [5, -1], "previous": [-1, -1, -1, 5], "next": [-1, 5, -1, -1],
    "linear": [-1, -1, 5, -1], "F[2,2]": -1, "F[0,0.5]": 5,
}, "the behaviour has changed"
PYTHON
