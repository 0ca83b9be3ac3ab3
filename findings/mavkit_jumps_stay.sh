#!/usr/bin/env bash
# Guess: a plan of mission items that mavkit prepares for the upload is the same mission: DO_JUMP goes to the item that
#   it went to, and a plan without a home position leaves the vehicle's own.
# Package: PyPI mavkit 0.3.0
# Seen: The home position becomes item 0 and all others are counted one up, but the target of DO_JUMP is not: a jump to
#   the last waypoint goes to the one before it. Without a home position item 0 is at latitude 0, longitude 0.
# Source: MAVLink, MAV_CMD_DO_JUMP (param1 is a sequence number); mavkit's items_for_wire_upload, found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q mavkit==0.3.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from mavkit import HomePosition, MissionFrame, MissionItem, MissionPlan, MissionType, items_for_wire_upload

WAYPOINT, DO_JUMP = 16, 177
frame = MissionFrame.GlobalRelativeAltInt
north = [473977420, 473978420]
items = [
    *(MissionItem(seq=i, command=WAYPOINT, frame=frame, x=x, y=85455940, z=50.0) for i, x in enumerate(north)),
    MissionItem(seq=2, command=DO_JUMP, frame=frame, param1=1.0, param2=3.0),
]


def uploaded(**home):
    return items_for_wire_upload(MissionPlan(mission_type=MissionType.Mission, items=items, **home))


sent = uploaded(home=HomePosition(latitude_deg=47.1, longitude_deg=8.5, altitude_m=400.0))
target = int(sent[-1].param1)
print("jump to", target, "which is", sent[target].x, "and was", items[1].x)
assert [item.seq for item in sent] == [0, 1, 2, 3], "the behaviour has changed"
assert (target, sent[target].x) == (1, north[0]), "the behaviour has changed"
unsaid = uploaded()[0]
print("home, where none is given:", unsaid.x, unsaid.y)
assert (unsaid.command, unsaid.x, unsaid.y) == (WAYPOINT, 0, 0), "the behaviour has changed"
PYTHON
