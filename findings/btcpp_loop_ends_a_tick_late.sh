#!/usr/bin/env bash
# Guess: LoopInt succeeds in the tick in which its child succeeds for the last value, as Repeat does after its last round; so
#   a condition before it in a ReactiveFallback is not asked again once all values are done.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: It is RUNNING after the last value, too, and finds its queue empty in the next tick. In between the condition is asked
#   once more: where it has become true, the loop, whose work is done, is halted.
# Source: decorators/loop_node.h (tick returns RUNNING behind each success); found by playing random trees against the library
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q behaviortreepy==0.1.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from behaviortreepy import BehaviorTreeFactory, NodeStatus


def run(body):
    # The status after each tick and the leaves that were asked, in their order.
    asked = []

    def leaf(status):
        def tick(node):
            asked.append(node.name())
            return status

        return tick

    factory = BehaviorTreeFactory()
    factory.register_simple_condition("higher", leaf(NodeStatus.FAILURE))
    factory.register_simple_action("work", leaf(NodeStatus.SUCCESS))
    text = f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">{body}</BehaviorTree></root>'
    factory.register_behavior_tree_from_text(text)
    tree = factory.create_tree("M")
    statuses = []
    while not statuses or statuses[-1] == "RUNNING":
        statuses.append(str(tree.tick_exactly_once()).removeprefix("NodeStatus."))
    return statuses, asked


under = "<ReactiveFallback><higher/>{}</ReactiveFallback>".format
loop = run(under('<LoopInt queue="1"><work/></LoopInt>'))
repeat = run(under('<Repeat num_cycles="1"><work/></Repeat>'))
print("LoopInt", loop)
print("Repeat", repeat)
assert loop == (["RUNNING", "SUCCESS"], ["higher", "work", "higher"]), "the behaviour has changed"
assert repeat == (["SUCCESS"], ["higher", "work"]), "the behaviour has changed"
PYTHON
