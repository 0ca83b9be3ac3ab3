#!/usr/bin/env bash
# Guess: GTPyhop tries the next method of a task where the first leads to an action that cannot be done, as Pyhop and SHOP do.
# Package: PyPI gtpyhop 2.0.2
# Seen: find_plan() says False: by default it takes the first method that gives subtasks and never comes back to another.
#   With set_recursive_planning(True) the same domain has the plan, so that False is no proof that there is none.
#   And an action that leaves the state as it is, such as a picture that is taken, is left out of the plan.
# Source: gtpyhop/main.py, three planning strategies (iterative greedy is the default); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q gtpyhop==2.0.2 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import contextlib
import io

import gtpyhop

gtpyhop.Domain("doors")


def open_door(state, door):
    if door not in state.unlocked:
        return None
    state.opened = door
    return state


def through_front(state):
    return [("open_door", "front")]


def through_back(state):
    return [("open_door", "back")]


def take_picture(state):
    return state


gtpyhop.declare_actions(open_door, take_picture)
gtpyhop.declare_task_methods("enter", through_front, through_back)
house = gtpyhop.State("house")
house.unlocked, house.opened = ["back"], None


def plan(*tasks):
    with contextlib.redirect_stdout(io.StringIO()):
        return gtpyhop.find_plan(house, [(task,) for task in tasks])


greedy = plan("enter")
gtpyhop.set_recursive_planning(True)
found = greedy, plan("enter", "take_picture")
print(*found)
assert found == (False, [("open_door", "back")]), "the behaviour has changed"
PYTHON
