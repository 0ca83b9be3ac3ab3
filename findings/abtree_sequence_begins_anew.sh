#!/usr/bin/env bash
# Guess: a Sequence whose second child is still running goes on with that child at the next tick; the first, which is done, acts
#   once.
# Package: PyPI abtree 0.3.12
# Seen: Each tick begins with the first child: an action that has succeeded acts again as long as a later one runs, as in
#   BehaviorTree.CPP's ReactiveSequence; and so does Selector. No other Sequence is there. `from abtree import *` is an
#   AttributeError, for the list of names has one that is not there.
# Source: abtree/nodes/composite.py (Sequence, Selector); BehaviorTree.CPP's page on sequences for what Sequence is there
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q abtree==0.3.12 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import asyncio
import logging

logging.disable(logging.CRITICAL)
from abtree import Action, Selector, Sequence
from abtree.core import Status

acted = []


class Scripted(Action):
    def __init__(self, name, *answers):
        super().__init__(name)
        self.answers = list(answers)

    async def execute(self):
        acted.append(self.name)
        return self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]


async def play(kind, first, last):
    acted.clear()
    root = kind("root")
    for child in (Scripted("arm", first), Scripted("drive", Status.RUNNING, Status.RUNNING, last)):
        root.add_child(child)
    return [(await root.tick()).name for _ in range(3)], " ".join(acted)


for kind, first, last in ((Sequence, Status.SUCCESS, Status.SUCCESS), (Selector, Status.FAILURE, Status.FAILURE)):
    answers, names = asyncio.run(play(kind, first, last))
    print(kind.__name__, answers, names)
    assert answers == ["RUNNING", "RUNNING", last.name], "the behaviour has changed"
    assert names == "arm drive arm drive arm drive", "the behaviour has changed"
try:
    exec("from abtree import *")
except AttributeError as error:
    print(error)
else:
    raise AssertionError("the behaviour has changed")
PYTHON
