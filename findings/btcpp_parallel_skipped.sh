#!/usr/bin/env bash
# Guess: A Parallel that needs two successes and has one child that is skipped and one that succeeds ends: it can no
#   longer succeed.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: It is RUNNING for ever, though none of its children runs.
# Source: controls/parallel_node.cpp; found by running it
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


children = '<AlwaysSuccess _skipIf="true"/><AlwaysSuccess/>'
found = run(f'<Parallel success_count="2" failure_count="2">{children}</Parallel>', 20)
print(found)
assert set(found) == {"RUNNING"}, "the behaviour has changed"
PYTHON
