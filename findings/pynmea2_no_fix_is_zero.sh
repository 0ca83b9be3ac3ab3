#!/usr/bin/env bash
# Guess: The latitude and longitude of a GGA sentence of a receiver that has no fix, whose fields are empty, are None.
# Package: PyPI pynmea2 1.19.0
# Seen: They are 0.0 and 0.0, a place in the Gulf of Guinea; the altitude of the same sentence is None. Only
#   is_valid, or gps_qual 0, tells.
# Source: LatLonFix.latitude and dm_to_sd in nmea_utils.py, which return 0. for an empty field or direction
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pynmea2==1.19.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import pynmea2

told = pynmea2.parse("$GPGGA,123519,,,,,0,00,,,M,,M,,*6B")
seen = (told.latitude, told.longitude, told.altitude, told.is_valid)
print(seen)
raise SystemExit(None if seen == (0.0, 0.0, None, False) else "the behaviour has changed")
PYTHON
