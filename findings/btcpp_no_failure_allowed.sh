#!/usr/bin/env bash
# Guess: A Parallel with failure_count="0" fails at once whatever its children do, or is refused.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: It fails once its first child runs or has succeeded, and goes on where that has failed: with AlwaysFailure first it
#   succeeds with its second child. Failures are compared with the count for equality, after each child. With
#   success_count="0" it succeeds once its first child has begun, which is halted.
# Source: controls/parallel_node.cpp (failure_count_ == failureThreshold()); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q behaviortreepy==0.1.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from behaviortreepy import BehaviorTreeFactory, NodeStatus


def run(body):
    factory, seen = BehaviorTreeFactory(), []
    for name in "ab":
        factory.register_simple_stateful_action(
            name,
            lambda node, name=name: seen.append(f"{name} begins") or NodeStatus.RUNNING,
            lambda node, name=name: seen.append(f"{name} ends") or NodeStatus.SUCCESS,
            lambda node, name=name: seen.append(f"{name} is halted"),
        )
    text = f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">{body}</BehaviorTree></root>'
    tree = factory.create_tree_from_text(text)
    while (status := tree.tick_once()) == NodeStatus.RUNNING:
        pass
    return str(status).removeprefix("NodeStatus."), seen


found = {
    "a, b; no failure": run('<Parallel success_count="1" failure_count="0"><a/><b/></Parallel>'),
    "AlwaysFailure, a; no failure": run(
        '<Parallel success_count="1" failure_count="0"><AlwaysFailure/><a/></Parallel>'
    ),
    "a, b; no success": run('<Parallel success_count="0"><a/><b/></Parallel>'),
}
for name, told in found.items():
    print(name, *told)
assert found == {
    "a, b; no failure": ("FAILURE", ["a begins", "a is halted"]),
    "AlwaysFailure, a; no failure": ("SUCCESS", ["a begins", "a ends"]),
    "a, b; no success": ("SUCCESS", ["a begins", "a is halted"]),
}, "the behaviour has changed"
PYTHON
