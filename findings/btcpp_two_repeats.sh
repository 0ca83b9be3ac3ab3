#!/usr/bin/env bash
# Guess: ReactiveSequence of two Repeats of two rounds each, whose children succeed at once, succeeds after a few ticks.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: It never ends. The first Repeat is RUNNING between its rounds, so each time it is asked again it needs two ticks, in
#   the first of which the second Repeat is halted: that one never gets to its second round. With a plain child first, or
#   with Sequence, it succeeds.
# Source: decorators/repeat_node.cpp (RUNNING where the child was idle before), controls/reactive_sequence.cpp; found by
#   playing random trees against the library
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q behaviortreepy==0.1.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from behaviortreepy import BehaviorTreeFactory, NodeStatus


def run(body, ticks=1000):
    # The status after each tick until one is not RUNNING, and how often each leaf was asked.
    asked = {"a": 0, "b": 0}

    def succeeds(node):
        asked[node.name()] += 1
        return NodeStatus.SUCCESS

    factory = BehaviorTreeFactory()
    for name in asked:
        factory.register_simple_action(name, succeeds)
    text = f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">{body}</BehaviorTree></root>'
    factory.register_behavior_tree_from_text(text)
    tree = factory.create_tree("M")
    for tick in range(1, ticks + 1):
        status = str(tree.tick_exactly_once()).removeprefix("NodeStatus.")
        if status != "RUNNING":
            return status, tick, asked
    return status, ticks, asked


twice = '<Repeat num_cycles="2"><{0}/></Repeat>'.format
found = {
    "reactive, two": run(f"<ReactiveSequence>{twice('a')}{twice('b')}</ReactiveSequence>"),
    "reactive, one": run(f"<ReactiveSequence><a/>{twice('b')}</ReactiveSequence>"),
    "sequence, two": run(f"<Sequence>{twice('a')}{twice('b')}</Sequence>"),
}
print(found)
assert found["reactive, two"] == ("RUNNING", 1000, {"a": 1000, "b": 500}), "the behaviour has changed"
assert found["reactive, one"][:2] == ("SUCCESS", 2), "the behaviour has changed"
assert found["sequence, two"][0] == "SUCCESS", "the behaviour has changed"
PYTHON
