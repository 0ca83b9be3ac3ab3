#!/usr/bin/env bash
# Guess: a parameter of type INT32 arrives with the number that was set.
# Package: PyPI pymavlink 2.4.50
# Seen: param_value is a float: 16,777,217 arrives as 16,777,216. MAVLink has two ways to carry integers (cast and bytewise), and
#   the encoder uses the first whatever the type says.
# Source: https://mavlink.io/en/services/parameter.html (parameter encoding)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pymavlink==2.4.50 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import io

from pymavlink.dialects.v20 import ardupilotmega as dialect

mav = dialect.MAVLink(io.BytesIO(), 1, 1)
for number, expected in ((16_777_216, 16_777_216), (16_777_217, 16_777_216)):
    message = mav.param_set_encode(1, 1, b"ID", number, dialect.MAV_PARAM_TYPE_INT32)
    found = dialect.MAVLink(None).parse_buffer(message.pack(mav))[0].param_value
    print(number, found)
    assert found == expected, "the behaviour has changed"
PYTHON
