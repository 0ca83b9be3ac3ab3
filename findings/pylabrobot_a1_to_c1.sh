#!/usr/bin/env bash
# Guess: plate["A1":"C1"] and plate["A1:C1"] are the same three wells, for both name the first and the last; and "A1":"A3" the row.
# Package: PyPI PyLabRobot 0.2.2
# Seen: In one text the last well belongs to it, and the rectangle between both is meant. As a slice the wells are counted down the
#   columns, and the last is left out: "A1":"C1" is A1 and B1, and "A1":"A3" of a plate of 24 is the first two columns.
# Source: PyLabRobot's page on resources (indexing by text and by slices); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q PyLabRobot==0.2.2 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from pylabrobot.resources import celltreat_24_wellplate_3300uL_Fb

plate = celltreat_24_wellplate_3300uL_Fb(name="plate")


def names(wells):
    return [well.name[-2:] for well in wells]


found = [names(wells) for wells in (plate["A1:C1"], plate["A1":"C1"], plate["A1:A3"], plate["A1":"A3"])]
print(*found, sep="\n")
columns = ["A1", "B1", "C1", "D1", "A2", "B2", "C2", "D2"]
assert found == [["A1", "B1", "C1"], ["A1", "B1"], ["A1", "A2", "A3"], columns], "the behaviour has changed"
PYTHON
