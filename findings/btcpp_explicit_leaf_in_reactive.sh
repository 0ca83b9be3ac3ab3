#!/usr/bin/env bash
# Guess: <Action ID="Go"/> and <Go/> mean the same wherever a leaf may stand.
# Package: PyPI behaviortreepy 0.1.4 (BehaviorTree.CPP 4.8.2; the code of 4.10.0 is the same)
# Seen: In a Sequence both are taken; in a ReactiveSequence the explicit form is 'Unknown node type: Action'.
# Source: xml_parsing.cpp (VerifyXML looks the element's own name up where it counts asynchronous children)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q behaviortreepy==0.1.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from behaviortreepy import BehaviorTreeFactory, NodeStatus


def read(body):
    factory = BehaviorTreeFactory()
    factory.register_simple_action("Go", lambda node: NodeStatus.SUCCESS)
    try:
        factory.register_behavior_tree_from_text(
            f'<root BTCPP_format="4"><BehaviorTree ID="M">{body}</BehaviorTree></root>'
        )
    except RuntimeError as error:
        return str(error)
    return str(factory.create_tree("M").tick_once())


for node in ("Sequence", "ReactiveSequence"):
    short, explicit = read(f"<{node}><Go/></{node}>"), read(f'<{node}><Action ID="Go"/></{node}>')
    print(node, short, "/", explicit)
    assert "SUCCESS" in short, "the behaviour has changed"
    assert ("Unknown node type: Action" in explicit) == (node == "ReactiveSequence"), "the behaviour has changed"
PYTHON
