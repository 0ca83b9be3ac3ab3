#!/usr/bin/env bash
# Guess: what decode of a CAN frame has given, encode takes: 10 m/s of a signal with a factor of 0.5 are sent as 20; and a number
#   beyond the signal's bits or its maximum, or a name that the frame has not, is refused.
# Package: PyPI canmatrix 1.3.3 (with cantools 45.1.0, which does all this, beside it)
# Seen: A number is sent as it is, without factor and offset, and a text is not: encode(speed=10) is 5 m/s, encode(speed="10") is
#   10. What does not fit is cut to the lowest bits: -1 is 127.5 m/s, 300 in eight bits 22. An unknown name is passed by. So a frame
#   that is decoded and encoded again is another one.
# Source: canmatrix/Frame.py (signals_to_bytes calls phys2raw for texts alone; encode's description says "values"); found by
#   running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q canmatrix==1.3.3 cantools==45.1.0 2>pip.log || { cat pip.log; exit 1; }
cat > motor.dbc <<'DBC'
VERSION ""
BU_: motor
BO_ 100 Drive: 8 motor
 SG_ speed : 0|8@1+ (0.5,0) [0|100] "m/s" motor
DBC
venv/bin/python - <<'PYTHON'
import canmatrix.formats
import cantools

(matrix,) = canmatrix.formats.loadp("motor.dbc").values()
(frame,) = matrix.frames
other = cantools.database.load_file("motor.dbc").get_message_by_name("Drive")


def sent(**values):
    return float(frame.decode(frame.encode(values))["speed"].phys_value)


def refused_by_the_other(**values):
    try:
        return other.decode(other.encode(values))["speed"]
    except Exception:
        return "refused"


found = {
    "10": (sent(speed=10), refused_by_the_other(speed=10)),
    "'10'": (sent(speed="10"), None),
    "-1": (sent(speed=-1), refused_by_the_other(speed=-1)),
    "300": (sent(speed=300), refused_by_the_other(speed=300)),
    "sped=10": (sent(sped=10), refused_by_the_other(sped=10)),
}
decoded = frame.decode(bytes([20, 0, 0, 0, 0, 0, 0, 0]))["speed"].phys_value
found["again"] = float(decoded), frame.encode({"speed": decoded})[0]
print(*found.items(), sep="\n")
expected = [(5, 10), (10, None), (127.5, "refused"), (22, "refused"), (0, "refused"), (10, 10)]
assert list(found.values()) == expected, "the behaviour has changed"
PYTHON
