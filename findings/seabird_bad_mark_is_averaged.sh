#!/usr/bin/env bash
# Guess: what wild_edit has marked as bad (-9.99e-29) stays marked when the channel is shifted or filtered, and is in no mean;
#   align_ctd gives as many scans as it gets, whatever their number.
# Package: PyPI seabirdscientific 3.1.1 (Sea-Bird's own toolkit)
# Seen: The mark is read as a number, 0. Shifted by half a scan, one bad scan among temperatures of 10 degrees becomes two of
#   5, and no mark is left; a low-pass filter takes 2 degrees from scans a second away. At 10 scans a second align_ctd ends in a
#   ValueError for one in ten numbers of scans, 3, 6 and 12 among them: 3 * 0.1 is more than 0.3.
# Source: SBE Data Processing manual (Wild Edit: marks are badflag; Align CTD); processing.py (np.interp over all values,
#   np.arange(0, n * interval, interval)); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q seabirdscientific==3.1.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python -W ignore - <<'PYTHON'
import numpy as np
from seabirdscientific.processing import align_ctd, low_pass_filter, wild_edit

BAD = -9.99e-29
read = np.full(40, 10.0)
read[20] = 35.0
marked = wild_edit(read, np.zeros(40), 2, 2, 40, 0.5, False)
assert [i for i, value in enumerate(marked) if value == BAD] == [20]
shifted = align_ctd(marked, offset=0.125, sample_interval=0.25)
filtered = low_pass_filter(marked, time_constant=0.5, sample_interval=0.25)
print("shifted ", shifted[17:24].round(2))
print("filtered", filtered[15:26].round(2))


def refused(scans: int) -> bool:
    try:
        return len(align_ctd(np.zeros(scans), 0.0, 0.1)) != scans
    except ValueError:
        return True


numbers = [scans for scans in range(1, 101) if refused(scans)]
print("numbers of scans that are refused at 10 a second:", numbers)
assert shifted[19:21].round(3).tolist() == [5.0, 5.0], "the behaviour has changed"
assert BAD not in shifted[:-1], "the behaviour has changed"
assert filtered[20].round(0) == 8.0 and filtered[16] < 10 > filtered[24], "the behaviour has changed"
assert numbers[:3] == [3, 6, 12], "the behaviour has changed"
PYTHON
