#!/usr/bin/env bash
# Guess: In CP-SAT an interval of length 0 may stand inside another one, and a resource of capacity 1 says the same of
#   a set of intervals whether it is written as no-overlap or as cumulative.
# Package: PyPI ortools 9.14.6206
# Seen: add_no_overlap allows it at the ends of the other alone, and makes a plan with an instantaneous action inside a long one
#   infeasible. add_cumulative with demands and a capacity of 1 allows it anywhere, also where its demand exceeds the capacity.
# Source: https://github.com/CPMpy/cpmpy/issues/1084 (the same of its own constraints, after CP-SAT); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q ortools==9.14.6206 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from ortools.sat.python import cp_model


def feasible(at, constraint):
    model = cp_model.CpModel()
    long = model.new_fixed_size_interval_var(0, 10, "drive")
    instant = model.new_fixed_size_interval_var(at, 0, "photo")
    constraint(model, [long, instant])
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    return solver.solve(model) == cp_model.OPTIMAL


no_overlap = [feasible(at, lambda model, both: model.add_no_overlap(both)) for at in (0, 5, 10)]
cumulative = [feasible(at, lambda model, both: model.add_cumulative(both, [1, 1], 1)) for at in (0, 5, 10)]
heavy = feasible(5, lambda model, both: model.add_cumulative(both, [1, 9], 1))
print(no_overlap, cumulative, heavy)
assert no_overlap == [True, False, True], "the behaviour has changed"
assert cumulative == [True, True, True] and heavy, "the behaviour has changed"
PYTHON
