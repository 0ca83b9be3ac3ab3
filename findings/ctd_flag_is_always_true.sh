#!/usr/bin/env bash
# Guess: from_cnv of the package ctd gives what Sea-Bird's software has marked as bad as missing values, and the flag of a
#   scan says whether it is good.
# Package: PyPI ctd 1.5.0
# Seen: The number that the header names as bad_flag stays: a salinity of -9.99e-29, which is 0 in any mean. The flag is True
#   in all scans, good or bad, for texts become bool, and any text is true.
# Source: SBE Data Processing manual (Loop Edit, Wild Edit: bad_flag); ctd/read.py (astype(bool) of texts); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q ctd==1.5.0 2>pip.log || { cat pip.log; exit 1; }
cat > cast.cnv <<'CNV'
* Sea-Bird SBE 9 Data File:
* System UpLoad Time = Mar 03 2026 12:00:00
# nquan = 4
# nvalues = 3
# name 0 = prDM: Pressure, Digiquartz [db]
# name 1 = t090C: Temperature [ITS-90, deg C]
# name 2 = sal00: Salinity, Practical [PSU]
# name 3 = flag:  0.000e+00
# bad_flag = -9.990e-29
# start_time = Mar 03 2026 12:00:00
*END*
      1.000    10.0000    35.0000  0.0000e+00
      2.000    10.1000 -9.990e-29  0.0000e+00
      3.000    10.2000    35.2000 -9.990e-29
CNV
venv/bin/python - <<'PYTHON'
import ctd

cast = ctd.from_cnv("cast.cnv")
print(cast)
assert list(cast["sal00"]) == [35.0, -9.99e-29, 35.2], "the behaviour has changed"
assert list(cast["flag"]) == [True, True, True], "the behaviour has changed"
PYTHON
