#!/usr/bin/env bash
# Guess: what a tree of waits and timeouts answers is the same in ticks of 0.5 s and in one tick of 5 s, since a tick takes the
#   time that has passed: a Timeout of 1 s around a Wait of 2 s fails, and of a Race the child that ends first counts.
# Package: PyPI bonsai-bt 0.14.0
# Seen: In one tick of 5 s the Timeout succeeds: its child is asked first, with all 5 s. In the Race the child that stands first
#   in the list counts, a Wait of 2 s that succeeds before one of 1 s that fails. In ticks of 0.5 s both are as guessed, so a tick
#   that comes late, as when a robot computes, changes the answer.
# Source: found by running it; the package describes dt as the "remaining delta time"
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q bonsai-bt==0.14.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import bonsai_bt as bt

TREES = {
    "Timeout of 1 s, Wait of 2 s": bt.Timeout(1.0, bt.Wait(2.0)),
    "Race, success after 2 s, failure after 1 s": bt.Race([bt.Wait(2.0), bt.Invert(bt.Wait(1.0))]),
}
for name, tree in TREES.items():
    ends = []
    for seconds in (0.5, 5.0):
        runner = bt.BT(tree, None)
        status = bt.Status.Running
        while status == bt.Status.Running:
            status = runner.tick(seconds, lambda args, _: bt.RUNNING)[0]
        ends.append(status)
    print(name, *ends)
    assert ends == [bt.Status.Failure, bt.Status.Success], "the behaviour has changed"
PYTHON
