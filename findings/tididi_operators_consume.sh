#!/usr/bin/env bash
# Guess: x & y and x | y are made of the same x and y, whose models can be counted before and after.
# Package: PyPI tididi 0.1.1
# Seen: An operator takes its operands away: after x & y neither can be used, not even counted (ConsumedCircuitError), and x ^ x
#   is a ValueError. Each use but the last needs x.copy(). The one example of its page uses each literal once.
# Source: found by running it beside dd, oxidd and PySDD, whose operators leave their operands as they are
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q tididi==0.1.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from tididi import ConsumedCircuitError, Vtree, literal

tree = Vtree.balanced(3)
x, y = literal(tree, 1), literal(tree, 2)
kept = x.copy()
both = x & y
print(both.model_count(), kept.model_count())
assert (both.model_count(), kept.model_count()) == (2, 4), "the behaviour has changed"
consumed, twice = (lambda: x | y, lambda: x.model_count()), lambda: kept ^ kept
for use, kind in (*((use, ConsumedCircuitError) for use in consumed), (twice, ValueError)):
    try:
        use()
    except kind as error:
        print(error)
    else:
        raise AssertionError("the behaviour has changed")
PYTHON
