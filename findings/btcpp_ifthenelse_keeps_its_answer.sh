#!/usr/bin/env bash
# Guess: a condition of IfThenElse that is an action is asked again when RetryUntilSuccessful tries again.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2; the code of 4.10.0 is the same)
# Seen: With two children it is asked once: it has failed, keeps that status, and the loop runs on the kept answer for
#   ever. With a third child, even one that fails, it is asked each time.
# Source: controls/if_then_else_node.cpp (returns before resetChildren), action_node.cpp (StatefulActionNode begins when idle)
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


retry = '<RetryUntilSuccessful num_attempts="-1"><IfThenElse><A name="a"/>{}</IfThenElse></RetryUntilSuccessful>'
answers = {"a": ["RUNNING", "FAILURE", "RUNNING", "FAILURE", "RUNNING", "FAILURE", "RUNNING"], "b": ["SUCCESS"], "c": ["FAILURE"]}
for children, expected in (("<b/>", 1), ("<b/><c/>", 4)):
    begun.clear()
    run(retry.format(children).replace('<A name="a"/>', "<a/>"), 12, answers)
    print(children, begun.count("a"))
    assert (begun.count("a") == 1) == (expected == 1), "the behaviour has changed"
PYTHON
