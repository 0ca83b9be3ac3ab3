#!/usr/bin/env bash
# Guess: A string constant of a ROS 1 message is all that stands behind the "=", quotes and "#" included, as ROS's page of messages
#   says with an example of its own; and what a library does not read as ROS does, it refuses.
# Package: PyPI ros-parser 0.9.0 and rosbags 0.11.9
# Seen: ros-parser reads a#b as a, and takes the quotes off. The example of ROS's page is an error in both libraries; without what
#   stands behind its quotes ros-parser reads it, and so a text beginning with "#" loses its quotes alone.
# Source: http://wiki.ros.org/msg, "Constants"; genmsg/msg_loader.py reads a constant of type string before it looks for comments
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q ros-parser==0.9.0 rosbags==0.11.9 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from ros_parser import ros1_msg
from rosbags.typesys import get_types_from_msg

EXAMPLE = 'string EXAMPLE="#comments" are ignored, and leading and trailing whitespace removed'


def read(text):
    try:
        (constant,) = ros1_msg.parse_message_string(text).constants
    except Exception as error:
        return type(error).__name__
    return constant.value


def refused_by_rosbags(text):
    try:
        get_types_from_msg(text, "pkg/msg/Type")
    except Exception as error:
        return type(error).__name__
    return None


found = [read("string X=a#b"), read('string X="q"'), read('string X="#c"'), read(EXAMPLE), refused_by_rosbags(EXAMPLE)]
print(found)
assert found == ["a", "q", "#c", "UnexpectedToken", "TypesysError"], "the behaviour has changed"
PYTHON
