#!/usr/bin/env bash
# Guess: In scripts 2 == 2 == 1 is (2 == 2) == 1, as in C++: true, since true is 1.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: Comparisons are chained as in Python: 2 == 2 and 2 == 1, which is false; 5 > 4 == true is false, since 4 is
#   not true.
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
for text in ("2 == 2 == 2", "2 == 2 == 1", "5 &gt; 4 == true", "(5 &gt; 4) == true"):
    found[text] = run(f'<ScriptCondition code="{text}"/>')[0]
    print(text, found[text])
assert [*found.values()] == ["SUCCESS", "FAILURE", "FAILURE", "SUCCESS"], "the behaviour has changed"
PYTHON
