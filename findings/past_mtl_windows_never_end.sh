#!/usr/bin/env bash
# Guess: once(0, 2) of a monitor of past MTL is true where its formula was true in the last 2 s, and hist(0, 2) false where it was
#   false in them; what is older does not count.
# Package: PyPI past-mtl-monitors 0.1.0
# Seen: Nothing is forgotten: 100 s after a single obstacle once(0, 2) is still true, and hist(0, 2) false after a single fault, as
#   without bounds. Only the lower bound counts: hist(1, 2) looks back by 1 s.
# Source: the docstrings of hist and once (the interval from t - end to t - start); past_mtl_monitors/monitors.py (push adds a value
#   to all times to come, and step cuts what is past alone); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q past-mtl-monitors==0.1.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from past_mtl_monitors import atom

x = atom("x")


def values(formula, samples):
    monitor = formula.monitor()
    return [monitor.send((time, {"x": value})) for time, value in samples]


obstacle = [(0, 1), (1, -1), (2, -1), (3, -1), (100, -1)]
fault = [(time, -value) for time, value in obstacle]
found = {
    "once(0, 2), true at 0 alone": values(x.once(0, 2), obstacle),
    "hist(0, 2), false at 0 alone": values(x.hist(0, 2), fault),
    "hist(1, 2), false at 0 alone": values(x.hist(1, 2), fault),
    "hist() without bounds": values(x.hist(), fault),
}
print(*found.items(), sep="\n")
never = float("inf")
expected = [[1] * 5, [-1] * 5, [never, -1, -1, -1, -1], [-1] * 5]
assert list(found.values()) == expected, "the behaviour has changed"
PYTHON
