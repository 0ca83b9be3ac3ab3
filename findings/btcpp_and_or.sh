#!/usr/bin/env bash
# Guess: In scripts of BehaviorTree.CPP && binds more tightly than ||, as in C++: true || true && false is true.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: They bind alike, from the left: the condition fails, as (true || true) && false does.
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
for text in ("true || true && false", "(true || true) && false", "true || (true && false)"):
    found[text] = run(f'<ScriptCondition code="{text.replace("&", "&amp;")}"/>')[0]
    print(text, found[text])
assert [*found.values()] == ["FAILURE", "FAILURE", "SUCCESS"], "the behaviour has changed"
PYTHON
