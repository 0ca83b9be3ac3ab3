#!/usr/bin/env bash
# Guess: a parameter's name of more than 16 characters, or a text of more than 50, is refused when a message is packed.
# Package: PyPI pymavlink 2.4.50
# Seen: Both are cut without a word. PARAM_SET of a name that is one character too long is then one of another parameter, if
#   the short name exists.
# Source: MAVLink common.xml (char[16], char[50]); pymavlink packs with struct, whose s cuts
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


def arrives(message):
    return dialect.MAVLink(None).parse_buffer(message.pack(mav))[0]


name, text = b"BATT_FAILSAFE_LOW", b"Battery 2 is low and the way home is longer than it lasts"
found = arrives(mav.param_set_encode(1, 1, name, 1, 9)).param_id, arrives(mav.statustext_encode(4, text)).text
print(found)
assert found == ("BATT_FAILSAFE_LO", text[:50].decode()), "the behaviour has changed"
PYTHON
