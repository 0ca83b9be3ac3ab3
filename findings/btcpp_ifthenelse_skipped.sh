#!/usr/bin/env bash
# Guess: IfThenElse whose condition is skipped is skipped, as Sequence, Inverter and ForceFailure are.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: It throws "Something unexpected happened in IfThenElseNode"; WhileDoElse throws about the status IDLE.
# Source: controls/if_then_else_node.cpp, controls/while_do_else_node.cpp; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q behaviortreepy==0.1.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from behaviortreepy import BehaviorTreeFactory

def run(body, ticks=3):
    factory = BehaviorTreeFactory()
    text = f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">{body}</BehaviorTree></root>'
    factory.register_behavior_tree_from_text(text)
    tree = factory.create_tree("M")
    return [str(tree.tick_once()).removeprefix("NodeStatus.") for _ in range(ticks)]


skipped = '<AlwaysSuccess _skipIf="true"/>'
for node in ("Sequence", "Inverter", "ForceFailure"):
    assert set(run(f"<{node}>{skipped}</{node}>")) == {"SKIPPED"}, "the behaviour has changed"
for node in ("IfThenElse", "WhileDoElse"):
    try:
        found = run(f"<{node}>{skipped}<AlwaysSuccess/><AlwaysFailure/></{node}>")
    except RuntimeError as error:
        print(node, error)
    else:
        raise SystemExit(f"the behaviour has changed: {node} {found}")
PYTHON
