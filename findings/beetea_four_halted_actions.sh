#!/usr/bin/env bash
# Guess: an action begins as it is ticked, also after others have been halted: what is halted does not count any more.
# Package: PyPI beetea 0.1.0
# Seen: A halted action runs on to its own end, in one of four threads that all trees of the process share. Once four of them run on,
#   which here is one drive that was halted four times, nothing that is ticked begins: the action that stops the robot says RUNNING
#   for as long as they last, and its function is not called.
# Source: beetea/bt.py (one ThreadPoolExecutor of four); its page says that callables run asynchronously; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q beetea==0.1.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import threading
import time

from beetea import Action

arrived = threading.Event()
drives, stops = [], []


def drive():
    drives.append(1)
    arrived.wait(30)


driving = Action(drive, label="drive")
stopping = Action(lambda: stops.append(1), label="stop")
for number in range(4):
    driving.tick()
    while len(drives) <= number:
        time.sleep(0.01)
    driving.halt()
answers = []
for _ in range(5):
    answers.append(stopping.tick().name)
    time.sleep(0.1)
begun = len(stops)
arrived.set()
while not stops:
    time.sleep(0.01)
print(len(drives), answers, begun, len(stops))
assert answers == ["RUNNING"] * 5 and begun == 0 and len(stops) == 1, "the behaviour has changed"
PYTHON
