#!/usr/bin/env bash
# Guess: num_attempts="-2" and num_cycles="-2" are for ever, as -1 is, or refused.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: RetryUntilSuccessful fails and Repeat succeeds without asking the child.
# Source: decorators/retry_node.cpp, repeat_node.cpp (count < max or max == -1)
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


asked = '<AlwaysFailure/>'
found = [run(f'<RetryUntilSuccessful num_attempts="-2">{asked}</RetryUntilSuccessful>')[0],
         run(f'<Repeat num_cycles="-2">{asked}</Repeat>')[0], run(f'<Repeat num_cycles="2">{asked}</Repeat>')[0]]
print(found)
assert found == ["FAILURE", "SUCCESS", "FAILURE"], "the behaviour has changed"
PYTHON
