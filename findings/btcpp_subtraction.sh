#!/usr/bin/env bash
# Guess: In scripts 10 - 2 - 3 is 5.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: 10 - 2 - 3 is 11, and 8 / 4 / 2 is 4: operators of one rank bind to the right, but && and || bind to the left.
# Source: https://www.behaviortree.dev/docs/guides/scripting ; scripting/operators.hpp
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


found = {}
for text in ("10 - 2 - 3 == 5", "10 - 2 - 3 == 11", "10-2-3 == 5", "8 / 4 / 2 == 1", "8 / 4 / 2 == 4"):
    found[text] = run(f'<ScriptCondition code="{text}"/>')[0]
    print(text, found[text])
assert [*found.values()] == ["FAILURE", "SUCCESS", "FAILURE", "FAILURE", "SUCCESS"], "the behaviour has changed"
PYTHON
