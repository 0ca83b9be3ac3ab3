#!/usr/bin/env bash
# Guess: a transition has one number: fire(0) fires the first of a net, so isTransitionDead(0) asks whether that one can ever fire.
# Package: PyPI petritub 1.1.1
# Seen: fire counts from 0 and isTransitionDead from 1. Asked with the numbers of fire, the first transition is dead in each net,
#   without an error, and each other answer is that of the transition before. The example in its description says True for
#   transitions that are live; what it returns is the reverse. With the right numbers its answers were right in 400 drawn nets.
# Source: the docstrings of both calls (fire: "starting from 0"); found by drawing nets and asking a second program
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q petritub==1.1.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import numpy as np
from petritub.untimed_pn import PetriNet

# the first transition moves the token, the second needs two where there is never more than one
produced = np.array([[0, 0], [1, 0]])
consumed = np.array([[1, 0], [0, 2]])
net = PetriNet(produced, consumed, np.array([[1], [0]]))
dead = {number: net.isTransitionDead(number) for number in (0, 1, 2)}
net.fire(0)
print("dead", dead, "after fire(0)", net.x0.ravel().tolist())
assert dead == {0: True, 1: False, 2: True}, "the behaviour has changed"
assert net.x0.ravel().tolist() == [0, 1], "the behaviour has changed"
PYTHON
