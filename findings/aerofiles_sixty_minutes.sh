#!/usr/bin/env bash
# Guess: Degrees and minutes that a library writes are below 60 minutes: 51.9999999° rounds to 52° 00.000'.
# Package: PyPI aerofiles 1.5.6 (which needs python-dateutil and does not say so) and pynmeagps 1.1.8
# Seen: Writers of SeeYou's waypoint files, of FLARM's configuration and of IGC flight recordings write 51° 60.000', and so does an
#   NMEA sentence that pynmeagps makes.
# Source: Naviter's CUP format, FLARM's configuration (FTD-14), FAI's IGC format, NMEA 0183: minutes below 60;
#   writer.py in aerofiles/seeyou, flarmcfg and igc, pynmeagps/nmeahelpers.py: degrees are split off before minutes are rounded
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q aerofiles==1.5.6 python-dateutil==2.9.0.post0 pynmeagps==1.1.8 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import datetime
import io

from aerofiles import flarmcfg, igc, seeyou
from pynmeagps import GET, NMEAMessage

NORTH, WEST = 51.9999999, -7.9999999
written = {name: io.BytesIO() for name in ("seeyou", "flarm", "igc")}
seeyou.Writer(written["seeyou"]).write_waypoint("a", "A", "DE", NORTH, WEST, "5", 1, 0)
flarmcfg.Writer(written["flarm"]).write_waypoint(NORTH, WEST, "a")
igc.Writer(written["igc"]).write_fix(
    datetime.time(1, 2, 3), latitude=NORTH, longitude=WEST, valid=True, pressure_alt=1, gps_alt=1
)
found = {name: file.getvalue().decode() for name, file in written.items()}
found["nmea"] = NMEAMessage("GP", "GLL", GET, lat=51.99999999999, lon=WEST).serialize().decode()
print(*found.values(), sep="")
seen = "5160.000N,00760.000W" in found["seeyou"] and "5160000N,00760000W" in found["flarm"]
seen = seen and "5160000N00760000W" in found["igc"] and "5160.00000,N" in found["nmea"]
raise SystemExit(None if seen else "the behaviour has changed")
PYTHON
