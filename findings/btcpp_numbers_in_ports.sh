#!/usr/bin/env bash
# Guess: num_cycles="3abc" is refused; " 3" and "+3" are 3.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: It is the other way round: "3abc" and "3.0" are 3 and "0x3" is 0, without a word; " 3" and "+3" throw.
# Source: basic_types.cpp (std::from_chars, whose end is not looked at)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q behaviortreepy==0.1.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from behaviortreepy import BehaviorTreeFactory, NodeStatus


def rounds(count):
    """How often a child is ticked, or that the tree is refused."""
    ticked = []

    def go(node):
        ticked.append(1)
        return NodeStatus.SUCCESS

    factory = BehaviorTreeFactory()
    factory.register_simple_action("Go", go)
    body = f'<Repeat num_cycles="{count}"><Go/></Repeat>'
    try:
        factory.register_behavior_tree_from_text(
            f'<root BTCPP_format="4"><BehaviorTree ID="M">{body}</BehaviorTree></root>'
        )
        tree = factory.create_tree("M")
        for _ in range(10):
            if "RUNNING" not in str(tree.tick_exactly_once()):
                break
    except RuntimeError:
        return "refused"
    return len(ticked)


found = {count: rounds(count) for count in ("3", "3abc", "3.0", "0x3", " 3", "+3")}
print(found)
assert found == {"3": 3, "3abc": 3, "3.0": 3, "0x3": 0, " 3": "refused", "+3": "refused"}, "the behaviour has changed"
PYTHON
