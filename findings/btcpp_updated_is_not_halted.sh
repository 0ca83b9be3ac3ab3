#!/usr/bin/env bash
# Guess: WhileDoElse runs one of its two branches, never both: when the condition turns false, the action of the first is
#   halted, also where SkipUnlessUpdated or WaitValueUpdate stands around it.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2)
# Seen: Behind these two decorators the action is not halted: onHalted is not called, its status stays RUNNING while the
#   other branch runs. Two motions at once. Without a decorator, or with Inverter, it is halted.
# Source: decorators/updated_decorator.cpp (halt() does not call that of DecoratorNode); found by playing random trees against
#   the library
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q behaviortreepy==0.1.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from behaviortreepy import BehaviorTreeFactory, NodeStatus


def run(decorated):
    # What happens to the two actions while the condition is true for two ticks, then false.
    happened, answers = [], [NodeStatus.SUCCESS, NodeStatus.SUCCESS, NodeStatus.FAILURE, NodeStatus.FAILURE]

    def begins(node):
        happened.append(f"{node.name()} begins")
        return NodeStatus.RUNNING

    def halted(node):
        happened.append(f"{node.name()} halted")

    factory = BehaviorTreeFactory()
    factory.register_simple_condition("deep", lambda node: answers.pop(0))
    for name in ("rise", "stay"):
        factory.register_simple_stateful_action(name, begins, lambda node: NodeStatus.RUNNING, halted)
    body = f'<Sequence><Script code="goal:=1"/><WhileDoElse><deep/>{decorated}<stay/></WhileDoElse></Sequence>'
    text = f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">{body}</BehaviorTree></root>'
    factory.register_behavior_tree_from_text(text)
    tree = factory.create_tree("M")
    while answers:
        tree.tick_exactly_once()
    return list(happened)


halted, goes_on = ["rise begins", "rise halted", "stay begins"], ["rise begins", "stay begins"]
expected = {
    "<rise/>": halted,
    "<Inverter><rise/></Inverter>": halted,
    '<SkipUnlessUpdated entry="{goal}"><rise/></SkipUnlessUpdated>': goes_on,
    '<WaitValueUpdate entry="{goal}"><rise/></WaitValueUpdate>': goes_on,
}
found = {body: run(body) for body in expected}
print(found)
assert found == expected, "the behaviour has changed"
PYTHON
