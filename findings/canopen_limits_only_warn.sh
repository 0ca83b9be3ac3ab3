#!/usr/bin/env bash
# Guess: A value above the maximum that the object dictionary of a device states is refused before it is sent.
# Package: PyPI canopen 2.4.1
# Seen: "Value 50 is greater than max value 10" is a line of the log, and the bytes of 50 are returned for sending. A value
#   that does not fit its type, 200 for INTEGER8, is refused with ValueError.
# Source: ODVariable.encode_raw in objectdictionary: logger.warning for min and max
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q canopen==2.4.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from canopen.objectdictionary import ODVariable, datatypes

speed = ODVariable("speed", 0x2000)
speed.data_type, speed.min, speed.max = datatypes.INTEGER8, 0, 10
sent = speed.encode_raw(50)
try:
    too_large = speed.encode_raw(200)
except ValueError as error:
    too_large = error
print(sent, repr(too_large))
raise SystemExit(None if sent == b"2" and isinstance(too_large, ValueError) else "the behaviour has changed")
PYTHON
