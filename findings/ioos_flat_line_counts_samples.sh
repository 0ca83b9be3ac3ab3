#!/usr/bin/env bash
# Guess: flat_line_test with a threshold of 30 s flags a sensor that gave one value for three minutes, whatever the rate of its
#   samples: the thresholds are in seconds, and the times are handed over.
# Package: PyPI ioos-qc 3.0.0
# Seen: It counts samples of the median interval. A sensor with a sample a minute while it is stuck and one a second
#   afterwards, as gliders have by depth, passes: 30 s are 30 samples then. With a sample a minute throughout, 30 s are none,
#   and values that change are flagged as well.
# Source: QARTOD manuals (flat line test); ioos_qc/qartod.py (flat_line_test, time_interval); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q ioos-qc==3.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import numpy as np
from ioos_qc.qartod import flat_line_test

stuck, after = [7.0] * 4, [8.0, 9.0, 10.0, 11.0, 12.0]


def flags(seconds):
    found = flat_line_test(
        stuck + after, np.array(seconds, "datetime64[s]"), suspect_threshold=30, fail_threshold=120, tolerance=0.01
    )
    return [int(flag) for flag in found]


even = flags([60 * number for number in range(9)])
uneven = flags([0, 60, 120, 180, 181, 182, 183, 184, 185])
print("a sample a minute", even)
print("a minute, then a second", uneven)
assert even == [3, 3, 4, 4, 3, 3, 3, 3, 3], "the behaviour has changed"
assert uneven == [1] * 9, "the behaviour has changed"
PYTHON
