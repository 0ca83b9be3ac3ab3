#!/usr/bin/env bash
# Guess: once[0:0] {a} is a, as historically[0:0] {a} is: the window is the present moment.
# Package: PyPI reelay 25.0.0
# Seen: An upper bound of 0 is none. Of a true at the first moment alone once[0:0] {a} is true for ever, and historically[0:0]
#   {a} is false from the first a that is false on; once[0:1] {a} is right.
# Source: reelay's own page (once[a:b]: within the time bound); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q reelay==25.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import reelay

A = [True, False, False, True, False]


def values(pattern):
    monitor = reelay.discrete_timed_monitor(pattern=pattern, semantics="boolean", condense=False)
    return [monitor.update({"a": a})["value"] for a in A]


found = {pattern: values(pattern) for pattern in ("once[0:0] {a}", "historically[0:0] {a}", "once[0:1] {a}")}
for pattern, told in found.items():
    print(pattern, told)
assert found["once[0:0] {a}"] == [True] * 5, "the behaviour has changed"
assert found["historically[0:0] {a}"] == [True, False, False, False, False], "the behaviour has changed"
assert found["once[0:1] {a}"] == [True, True, False, True, True], "the behaviour has changed"
PYTHON
