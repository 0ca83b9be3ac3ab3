#!/usr/bin/env bash
# Guess: a file of Groot, with trees of BehaviorTree.CPP 3, becomes the same tree in py_trees: the one that main_tree_to_execute names;
#   what the reader does not know, a leaf that was not registered or another node, it refuses.
# Package: PyPI py_trees_meet_groot 0.2 (with py_trees 2.6.0, of which it asks for no version)
# Seen: The last tree of the file is the root, whichever is named. A leaf that is not registered succeeds; a RetryUntilSuccessful or
#   a SubTree is left out with all that is in it. Both are a printed line. A Parallel with success_threshold 2 of 3 children asks all
#   three. A Sequence or a Fallback cannot be read at all: the answer is None, and the line says "main_tree_to_execute not found".
# Source: BehaviorTree.CPP 3.8, main_tree_to_execute and Parallel; py_trees_meet_groot/groot_xml.py (py_trees asks for
#   memory, and the error is caught); found by reading it and running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q py-trees-meet-groot==0.2 py_trees==2.6.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import contextlib
import io

import py_trees
from py_trees_meet_groot import groot_xml


def read(trees, registered=()):
    with open("trees.xml", "w") as file:
        file.write(f'<root main_tree_to_execute="Main">{trees}</root>')
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        tree = groot_xml.load("trees.xml", list(registered), {})
    if tree is None:
        return printed.getvalue().splitlines()[-1]
    tree.tick_once()
    return [child.name for child in tree.children], tree.status.name


main = '<BehaviorTree ID="Main"><ReactiveSequence>{}</ReactiveSequence></BehaviorTree>'
other = '<BehaviorTree ID="Part"><ReactiveSequence><Action ID="Dock"/></ReactiveSequence></BehaviorTree>'
retry = '<RetryUntilSuccessful num_attempts="3"><Action ID="Dock"/></RetryUntilSuccessful><SubTree ID="Part"/>'
leaves = "".join(f'<Action ID="{name}"/>' for name in ("One", "Two", "Three"))
parallel = f'<Parallel success_threshold="2" failure_threshold="2">{leaves}</Parallel>'
found = {
    "last": read(main.format('<Action ID="Go"/>') + other),
    "left out": read(main.format('<Action ID="Go"/>' + retry)),
    "parallel": read(f'<BehaviorTree ID="Main">{parallel}</BehaviorTree>', [py_trees.behaviours.Running(name="Three")]),
    "sequence": read('<BehaviorTree ID="Main"><Sequence><Action ID="Go"/></Sequence></BehaviorTree>'),
}
for name, answer in found.items():
    print(name, answer)
assert found == {
    "last": (["Dock"], "SUCCESS"),
    "left out": (["Go"], "SUCCESS"),
    "parallel": (["One", "Two", "Three"], "RUNNING"),
    "sequence": "main_tree_to_execute not found",
}, "the behaviour has changed"
PYTHON
