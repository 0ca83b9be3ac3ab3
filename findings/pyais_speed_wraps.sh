#!/usr/bin/env bash
# Guess: A speed that AIS cannot tell (its field has ten bits of 0.1 knots) is refused when a message is encoded, or
#   cut to the most; and what is "not available" by the standard is None when it is decoded.
# Package: PyPI pyais 3.3.1
# Seen: 150 knots are encoded as 47.6, without a word. Not available speed, course, position are the numbers 102.3,
#   360.0, 91.0 and 181.0; of the same message the rate of turn is a member of an enumeration that says so.
# Source: ITU-R M.1371, message 1; the package's fields of messages, which convert and do not compare with limits
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pyais==3.3.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import pyais
from pyais.encode import encode_dict


def there_and_back(**fields):
    return pyais.decode(*encode_dict({"type": 1, "mmsi": "244000000", **fields}))


fast = there_and_back(speed=150.0)
nothing = there_and_back(speed=102.3, course=360.0, lat=91.0, lon=181.0, turn=-128)
print(fast.speed, nothing.speed, nothing.course, nothing.lat, nothing.lon, repr(nothing.turn))
seen = fast.speed == 47.6 and (nothing.speed, nothing.course, nothing.lat, nothing.lon) == (102.3, 360.0, 91.0, 181.0)
raise SystemExit(None if seen and not isinstance(nothing.turn, int) else "the behaviour has changed")
PYTHON
