#!/usr/bin/env bash
# Guess: In a parallel of btreeny a child that has finished rests until the others have.
# Package: PyPI btreeny 0.2.3
# Seen: It is ticked again with each tick of the parallel: an action of one step acts once more each time, and a sequence, a
#   fallback or a repeat that has finished raises BehaviourCompleteError. So a parallel of a short sequence and a long action
#   never succeeds.
# Source: btreeny/__init__.py, parallel (all functions are called in each tick); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q btreeny==0.2.3 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import btreeny
from btreeny import TreeStatus, parallel, sequential, simple_action

began = []


def leaf(name, ticks):
    left = [ticks]

    @simple_action
    def act(_):
        began.append(name)
        left[0] -= 1
        return TreeStatus.RUNNING if left[0] > 0 else TreeStatus.SUCCESS

    return act()


@btreeny.runner
def run(tree):
    seen = []
    with tree as tick:
        while not seen or seen[-1] == "RUNNING":
            try:
                seen.append(tick(None).name)
            except btreeny.BehaviourCompleteError as error:
                seen.append(type(error).__name__)
    return seen


plain = run(parallel(leaf("short", 1), leaf("long", 3)))
print(plain, began)
inner = run(parallel(sequential(leaf("short", 1)), leaf("long", 3)))
print(inner)
assert plain == ["RUNNING", "RUNNING", "SUCCESS"], "the behaviour has changed"
assert began[:6].count("short") == 3, "the behaviour has changed"
assert inner == ["RUNNING", "BehaviourCompleteError"], "the behaviour has changed"
PYTHON
