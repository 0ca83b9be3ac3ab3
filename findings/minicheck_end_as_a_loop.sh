#!/usr/bin/env bash
# Guess: a chain of two ends, one a missed deadline, has the probability that by hand is 2/3; ends are states that lead to
#   themselves with probability 1, since the outgoing probabilities of a state add up to 1.
# Package: PyPI minicheck 0.4.0
# Seen: There is no verdict: "the chain's linear system has no unique solution", also where the end is named in success_states.
#   Only an end without a way out is solved, a list of probabilities that adds up to 0; then it is 2/3.
# Source: the docstring of check_probabilistic (rows add up to 1; every other absorbing state has probability 0); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q minicheck==0.4.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from minicheck import check_probabilistic

chain = {0: [(0.5, 1), (0.5, "late")], 1: [(0.5, 0), (0.5, "done")], "late": [(1.0, "late")]}
loop = check_probabilistic(chain | {"done": [(1.0, "done")]}, 0, {"late"}, 0.9)
none = check_probabilistic(chain | {"done": []}, 0, {"late"}, 0.9)
named = check_probabilistic(chain | {"done": [(1.0, "done")]}, 0, {"late"}, 0.9, success_states={"done"})
print(loop["p_miss"], none["p_miss"], named["p_miss"], loop["reason"])
assert loop["p_miss"] is None and loop["holds"] is None, "the behaviour has changed"
assert named["p_miss"] is None, "the behaviour has changed"
assert abs(none["p_miss"] - 2 / 3) < 1e-12, "the behaviour has changed"
PYTHON
