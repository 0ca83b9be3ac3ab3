#!/usr/bin/env bash
# Guess: SequenceWithMemory of children that succeed at once succeeds in one tick, as Sequence does.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: It says RUNNING after each child, as Sequence did before 4.2 and AsyncSequence does: three children take three ticks.
# Source: controls/sequence_with_memory_node.cpp (no flag before it yields); sequence_node.cpp has one
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q behaviortreepy==0.1.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from behaviortreepy import BehaviorTreeFactory, NodeStatus

begun = []


def run(body, ticks, answers):
    # A leaf gives its answers in turn, one a tick, the last one ever after.
    factory = BehaviorTreeFactory()
    left = {name: list(own) for name, own in answers.items()}

    def begins(node):
        begun.append(node.name())
        return answer(node)

    def answer(node):
        own = left[node.name()]
        return getattr(NodeStatus, own.pop(0) if len(own) > 1 else own[0])

    for name in answers:
        factory.register_simple_stateful_action(name, begins, answer)
    text = f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">{body}</BehaviorTree></root>'
    factory.register_behavior_tree_from_text(text)
    tree = factory.create_tree("M")
    return [str(tree.tick_exactly_once()).removeprefix("NodeStatus.") for _ in range(ticks)]


three = "<AlwaysSuccess/>" * 3
found = {node: run(f"<{node}>{three}</{node}>", 3, {}) for node in ("Sequence", "AsyncSequence", "SequenceWithMemory")}
print(found)
assert found["Sequence"] == ["SUCCESS"] * 3, "the behaviour has changed"
for node in ("AsyncSequence", "SequenceWithMemory"):
    assert found[node] == ["RUNNING", "RUNNING", "SUCCESS"], "the behaviour has changed"
PYTHON
