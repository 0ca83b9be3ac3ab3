#!/usr/bin/env bash
# Guess: py_trees' Sequence with memory and BehaviorTree.CPP's SequenceWithMemory are one node: interrupted, it goes on where it was.
# Package: PyPI py_trees 2.6.0 and behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: In BehaviorTree.CPP it goes on at the second child. In py_trees the memory is over with the interruption: it
#   begins again with the first child, which here acts twice.
# Source: py_trees/composites.py (Sequence.tick sets current_child anew where its status is not RUNNING);
#   controls/sequence_with_memory_node.cpp (halt leaves the index)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q py_trees==2.6.0 behaviortreepy==0.1.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import py_trees
from behaviortreepy import BehaviorTreeFactory, NodeStatus
from py_trees.common import Status

HIGHER = [Status.FAILURE, Status.SUCCESS, Status.FAILURE, Status.FAILURE]
begun = []


class Acts(py_trees.behaviour.Behaviour):
    def __init__(self, name, status):
        super().__init__(name)
        self.answer = status

    def initialise(self):
        begun.append(self.name)

    def update(self):
        return self.answer.pop(0) if isinstance(self.answer, list) else self.answer


sequence = py_trees.composites.Sequence("sequence", memory=True)
sequence.add_children([Acts("first", Status.SUCCESS), Acts("second", Status.RUNNING)])
top = py_trees.composites.Selector("top", memory=False)
top.add_children([Acts("higher", list(HIGHER)), sequence])
for _ in HIGHER:
    top.tick_once()
theirs = [name for name in begun if name != "higher"]
print("py_trees", theirs)
assert theirs == ["first", "second", "first", "second"], "the behaviour has changed"

begun.clear()
answers = [NodeStatus.FAILURE, NodeStatus.FAILURE, NodeStatus.SUCCESS, NodeStatus.FAILURE, NodeStatus.FAILURE]


def begins(node):
    begun.append("second")
    return NodeStatus.RUNNING


def acts(node):
    begun.append("first")
    return NodeStatus.SUCCESS


factory = BehaviorTreeFactory()
factory.register_simple_condition("Higher", lambda node: answers.pop(0))
factory.register_simple_action("First", acts)
factory.register_simple_stateful_action("Second", begins, lambda node: NodeStatus.RUNNING)
factory.register_behavior_tree_from_text("""<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">
<ReactiveFallback><Higher/><SequenceWithMemory><First/><Second/></SequenceWithMemory></ReactiveFallback>
</BehaviorTree></root>""")
tree = factory.create_tree("M")
while answers:
    tree.tick_exactly_once()
print("BehaviorTree.CPP", begun)
assert begun == ["first", "second", "second"], "the behaviour has changed"
PYTHON
