#!/usr/bin/env bash
# Guess: With samples at 0, 1, 5 and 6 s, `always[0,2](x>=0)` at 1 s asks for the samples up to 3 s, and is true; or a
#   trace whose samples are not a period apart is refused.
# Package: PyPI rtamt 0.4.10
# Seen: In discrete time it asks for the next two samples, whenever they were: at 1 s it is false for what happens
#   at 5 s. Nothing is raised; the dense-time monitor of the same data answers by time.
# Source: the package's README, "discrete-time": the sampling period converts bounds to numbers of samples
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q rtamt==0.4.10 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python 2>/dev/null - <<'PYTHON'
import rtamt

TIMES, VALUES = [0, 1, 5, 6], [1.0, 2.0, -3.0, 4.0]


def made(kind):
    monitor = kind()
    monitor.declare_var("x", "float")
    monitor.declare_var("told", "float")
    monitor.spec = "told = always[0,2](x>=0)"
    monitor.parse()
    return monitor


counted = made(rtamt.StlDiscreteTimeSpecification).evaluate({"time": TIMES, "x": VALUES})
timed = made(rtamt.StlDenseTimeSpecification).evaluate(["x", [list(map(float, p)) for p in zip(TIMES, VALUES)]])
print("discrete", counted, "dense", timed)
at_one = [value for time, value in timed if time <= 1][-1]
raise SystemExit(None if (dict(map(tuple, counted))[1], at_one > 0) == (-3.0, True) else "the behaviour has changed")
PYTHON
