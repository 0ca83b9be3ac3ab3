#!/usr/bin/env bash
# Guess: return_home_on_signal_loss() makes a DJI mission return home when the link to the remote control is lost, and
#   with False go on.
# Package: PyPI djikmz 0.1.0
# Seen: Called with True, as by default, it writes exitOnRCLost goContinue: the aircraft flies on. With False it writes
#   executeLostAction with the action "handover", which is none of WPML's goBack, landing and hover. No call of the
#   builder writes goBack.
# Source: djikmz/task_builder.py (return_home_on_signal_loss), model/mission_config.py (RCLostAction); DJI's WPML
#   reference, template.kml: exitOnRCLost, executeRCLostAction
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q djikmz==0.1.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import re
from zipfile import ZipFile

from djikmz import DroneTask


def on_signal_loss(*asked):
    task = DroneTask("M350", "pilot").name("survey").payload("P1").speed(8.0).altitude(75.0)
    for home in asked:
        task.return_home_on_signal_loss(home)
    task.fly_to(47.1, 8.5)
    task.fly_to(47.2, 8.6)
    task.to_kmz("mission.kmz")
    with ZipFile("mission.kmz") as kmz:
        return re.findall(r"<wpml:(?:exitOn|execute)RCLost\w*>(\w+)<", kmz.read("wpmz/template.kml").decode())


found = {"unasked": on_signal_loss(), "True": on_signal_loss(True), "False": on_signal_loss(False)}
print(found)
expected = {"unasked": ["goContinue"], "True": ["goContinue"], "False": ["executeLostAction", "handover"]}
assert found == expected, "the behaviour has changed"
PYTHON
