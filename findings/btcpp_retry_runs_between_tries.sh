#!/usr/bin/env bash
# Guess: ReactiveFallback of RetryUntilSuccessful(2) and an action that takes two ticks: when both tries have failed at once, the action runs to its end.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: RetryUntilSuccessful says RUNNING between its tries, and a child of ReactiveFallback that runs halts those after it:
#   asked again in each tick, the retry halts the action each time, which begins again and again and never ends.
# Source: decorators/retry_node.cpp (RUNNING after a failed try, to be interruptible), controls/reactive_fallback.cpp
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
    def begins_b(node):
        begun.append("b")
        return NodeStatus.RUNNING

    factory.register_simple_stateful_action("b", begins_b, lambda node: NodeStatus.SUCCESS)
    text = f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">{body}</BehaviorTree></root>'
    factory.register_behavior_tree_from_text(text)
    tree = factory.create_tree("M")
    return [str(tree.tick_exactly_once()).removeprefix("NodeStatus.") for _ in range(ticks)]


tree = '<ReactiveFallback><RetryUntilSuccessful num_attempts="{}"><a/></RetryUntilSuccessful><b/></ReactiveFallback>'
for tries, ends in ((1, True), (2, False)):
    begun.clear()
    found = run(tree.format(tries), 9, {"a": ["FAILURE"]})
    print(tries, begun.count("b"), found)
    assert ("SUCCESS" in found) == ends, "the behaviour has changed"
    assert ends or begun.count("b") == 4, "the behaviour has changed"
PYTHON
