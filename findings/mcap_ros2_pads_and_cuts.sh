#!/usr/bin/env bash
# Guess: the writers of ROS 2 messages refuse what a message does not hold: two numbers or four where three are due, five where at
#   most two are, a name that the message has not.
# Package: PyPI mcap-ros2-support 0.6.0 (with mcap 1.6.0), and mcap-ros2-support-fast 0.8.0 beside it
# Seen: mcap-ros2-support fills up with zeros and cuts, without a word; the list that it was given has None in it afterwards. A
#   misspelled field is left out, and the right one has its default; 1.7 in an int32 is 1. Only numbers that are too large are
#   refused. The other package refuses the wrong lengths and the 1.7, and leaves out unknown names, too.
# Source: mcap_ros2/_dynamic.py (list_array.append(None)); found by running both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q mcap-ros2-support==0.6.0 mcap==1.6.0 mcap-ros2-support-fast==0.8.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import io
from types import SimpleNamespace

from mcap_ros2.reader import read_ros2_messages
from mcap_ros2.writer import Writer
from mcap_ros2_support_fast import ROS2EncoderFactory

DEFINITION = "float64[3] position\nint16[<=2] few\nint32 speed 5\n"


def written(**fields):
    file = io.BytesIO()
    writer = Writer(file)
    schema = writer.register_msgdef("own_msgs/msg/Pose", DEFINITION)
    writer.write_message("/pose", schema, fields)
    writer.finish()
    file.seek(0)
    message = next(iter(read_ros2_messages(file))).ros_msg
    return message.position, message.few, message.speed


def refused_by_the_other(**fields):
    schema = SimpleNamespace(id=1, name="own_msgs/msg/Pose", encoding="ros2msg", data=DEFINITION.encode())
    whole = {"position": [0.0, 0.0, 0.0], "few": [], "speed": 1} | fields
    try:
        ROS2EncoderFactory().encoder_for(schema)(SimpleNamespace(**whole))
    except Exception:
        return True
    return False


given = [1.0, 2.0]
found = [
    written(position=given),
    written(position=[1.0, 2.0, 3.0, 4.0]),
    written(few=[1, 2, 3, 4, 5]),
    written(sped=9),
    written(speed=1.7),
]
print(*found, given, sep="\n")
zero = [0.0, 0.0, 0.0]
assert found[:2] == [([1.0, 2.0, 0.0], [], 5), ([1.0, 2.0, 3.0], [], 5)], "the behaviour has changed"
assert found[2:] == [(zero, [1, 2], 5), (zero, [], 5), (zero, [], 1)], "the behaviour has changed"
assert given == [1.0, 2.0, None], "the behaviour has changed"
cases = {"position": [1.0, 2.0]}, {"position": [1.0, 2.0, 3.0, 4.0]}, {"few": [1, 2, 3]}, {"speed": 1.7}, {"sped": 9}
refused = [refused_by_the_other(**fields) for fields in cases]
print(refused)
assert refused == [True, True, True, True, False], "the behaviour has changed"
PYTHON
