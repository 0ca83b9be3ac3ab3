#!/usr/bin/env bash
# Guess: Sequence with memory=False asks its condition at each tick and goes on with the child that runs, as ReactiveSequence of
#   BehaviorTree.CPP does: a Wait of 1 s behind the condition is over after 1 s.
# Package: PyPI bonsai-bt 0.14.0
# Seen: The child that runs begins anew, too. The Wait is never over in ticks of 0.5 s, and over at once in a tick of 1 s; a
#   Sequence with memory inside of one without runs its first action at each tick. Select with memory=False does the same.
# Source: bonsai_bt/__init__.pyi ("restarts from the first child every tick"), which does not say what becomes of the state of
#   the child that runs; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q bonsai-bt==0.14.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import bonsai_bt as bt


def run(tree, seconds, ticks=20):
    # The ticks until the tree ends, None if it does not, and the actions in their order.
    asked = []

    def act(args, _):
        asked.append(args.action)
        if args.action == "runs":
            return bt.RUNNING
        return bt.Status.Failure if args.action == "fails" else bt.Status.Success, args.dt

    runner = bt.BT(tree, None)
    for tick in range(1, ticks + 1):
        if runner.tick(seconds, act)[0] != bt.Status.Running:
            return tick, asked
    return None, asked


wait = bt.Wait(1.0)
found = {
    "without memory, 0.5 s": run(bt.Sequence([bt.Action("check"), wait], memory=False), 0.5)[0],
    "without memory, 1 s": run(bt.Sequence([bt.Action("check"), wait], memory=False), 1.0)[0],
    "with memory, 0.5 s": run(bt.Sequence([bt.Action("check"), wait]), 0.5)[0],
    "Select without memory": run(bt.Select([bt.Action("fails"), wait], memory=False), 0.5)[0],
}
inner = bt.Sequence([bt.Action("first"), bt.Action("runs")])
found["first of the inner one"] = run(bt.Sequence([bt.Action("check"), inner], memory=False), 0.5, 4)[1].count("first")
print(*found.items(), sep="\n")
assert list(found.values()) == [None, 1, 2, None, 4], "the behaviour has changed"
PYTHON
