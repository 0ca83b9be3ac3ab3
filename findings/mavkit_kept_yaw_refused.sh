#!/usr/bin/env bash
# Guess: a waypoint whose param4 is NaN, which in MAVLink means "keep the yaw" and is what ground stations write, is a
#   valid item, and a plan is equivalent to itself.
# Package: PyPI mavkit 0.3.0
# Seen: validate_plan gives an error, "param4 must be finite", and plans_equivalent of two such plans is False: numbers are
#   compared with a tolerance, and NaN is near nothing. Who compares what was downloaded with what was uploaded is told
#   that it is another mission. A DO_JUMP to an item that is not there passes.
# Source: MAVLink, MAV_CMD_NAV_WAYPOINT (param4: NaN to use the current yaw mode); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q mavkit==0.3.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from math import nan

from mavkit import MissionFrame, MissionItem, MissionPlan, MissionType, plans_equivalent, validate_plan


def plan(yaw, *more):
    frame = MissionFrame.GlobalRelativeAltInt
    point = MissionItem(seq=0, command=16, frame=frame, x=473977420, y=85455940, z=50.0, param4=yaw)
    return MissionPlan(mission_type=MissionType.Mission, items=[point, *more])


jump = MissionItem(seq=1, command=177, frame=MissionFrame.Mission, param1=9.0, param2=3.0)
found = {
    "equivalent": [plans_equivalent(plan(yaw), plan(yaw)) for yaw in (90.0, nan)],
    "issues": [[issue.message for issue in validate_plan(of)] for of in (plan(90.0), plan(nan), plan(90.0, jump))],
}
print(found)
expected = {"equivalent": [True, False], "issues": [[], ["param4 must be finite"], []]}
assert found == expected, "the behaviour has changed"
PYTHON
