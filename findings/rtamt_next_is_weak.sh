#!/usr/bin/env bash
# Guess: At the last sample of a trace `next a` and `eventually[1,1] a` are the same, both false, since there is no
#   next sample; and `prev a` is false at the first sample, as yesterday is in LTL with past.
# Package: PyPI rtamt 0.4.10
# Seen: `next` and `prev` are true with robustness inf where there is no such sample, `eventually[1,1]` and
#   `once[1,1]` are false with -inf.
# Source: visitNext and visitPrevious of the offline visitor of discrete time; the words snext and sprev are the strong ones
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q rtamt==0.4.10 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python 2>/dev/null - <<'PYTHON'
import rtamt

INF = float("inf")


def asked(formula):
    monitor = rtamt.StlDiscreteTimeSpecification()
    monitor.declare_var("x", "float")
    monitor.declare_var("told", "float")
    monitor.spec = f"told = {formula}"
    monitor.parse()
    return [value for _, value in monitor.evaluate({"time": [0, 1], "x": [1.0, 2.0]})]


told = {f: asked(f) for f in ("next(x>=0)", "eventually[1,1](x>=0)", "prev(x>=0)", "once[1,1](x>=0)")}
print(*told.items(), sep="\n")
seen = list(told.values()) == [[2.0, INF], [2.0, -INF], [INF, 1.0], [-INF, 1.0]]
raise SystemExit(None if seen else "the behaviour has changed")
PYTHON
