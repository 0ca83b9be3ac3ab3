#!/usr/bin/env bash
# Guess: In a Concurrent of misbehave a child that has succeeded rests until the others have.
# Package: PyPI misbehave 0.1.4
# Seen: It begins anew with each tick: beside an action of three ticks a sequence of grasp and lift is done three times, and
#   it is the last answer that counts, so that a child which has succeeded can still make the Concurrent fail.
# Source: misbehave/selector.py, Concurrent (all children are called in each tick); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q misbehave==0.1.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from types import SimpleNamespace

from misbehave.common import State
from misbehave.selector import Concurrent, Sequence

began = []


def leaf(name, *answers):
    rest = iter(answers)

    def act(_actor, _context):
        began.append(name)
        return next(rest)

    return act


def ticks(tree):
    actor, seen = SimpleNamespace(), []
    while not seen or seen[-1] == "RUNNING":
        seen.append(tree(actor, None).name)
    return seen


done, busy, failed = State.SUCCESS, State.RUNNING, State.FAILED
move = leaf("move", busy, busy, done)
pick = ticks(Concurrent(Sequence(leaf("grasp", *[done] * 3), leaf("lift", *[done] * 3)), move))
print(pick, began)
late = ticks(Concurrent(leaf("a", done, failed), leaf("b", busy, busy)))
print(late)
assert pick == ["RUNNING", "RUNNING", "SUCCESS"], "the behaviour has changed"
assert began[:9] == ["grasp", "lift", "move"] * 3, "the behaviour has changed"
assert late == ["RUNNING", "FAILED"], "the behaviour has changed"
PYTHON
