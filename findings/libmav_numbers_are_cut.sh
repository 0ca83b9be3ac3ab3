#!/usr/bin/env bash
# Guess: a number that does not fit a field of a MAVLink message is refused, as a text that is too long is; and a latitude in
#   1e-7 degrees, computed as latitude * 1e7, arrives in its int32 field to the last unit or two.
# Package: PyPI libmav 0.1.1
# Seen: 300 in a uint8 is 44, 2147483648 in an int32 is -2147483648. A float goes through 32 bits on its way into an
#   integer: 179.9999001 degrees arrive as 179.9998976, 0.3 m further west, while the same number as an int arrives whole.
# Source: MAVLink, GLOBAL_POSITION_INT; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q libmav==0.1.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from libmav import MessageSet

fields = {"small": "uint8_t", "lon": "int32_t", "text": "char[5]"}
xml = "".join(f'<field type="{kind}" name="{name}">of the test</field>' for name, kind in fields.items())
message_set = MessageSet()
message_set.add_from_xml_string(
    f'<mavlink><messages><message id="9915" name="TEST"><description>a test</description>{xml}</message></messages></mavlink>'
)
message = message_set.create("TEST")


def kept(field, value):
    message[field] = value
    return message[field]


units = 179.9999001 * 1e7
found = [kept("small", 300), kept("lon", 2**31), kept("lon", units), kept("lon", round(units))]
print(found)
assert found == [44, -(2**31), 1799998976, 1799999001], "the behaviour has changed"
try:
    raise SystemExit(f"the behaviour has changed: {kept('text', 'too long')}")
except IndexError as error:
    print(error)
PYTHON
