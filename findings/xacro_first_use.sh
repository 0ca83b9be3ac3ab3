#!/usr/bin/env bash
# Guess: a property b = ${a/2} that is made while a is 1 is 0.5, also after a has become 10.
# Package: PyPI xacro 2.1.1
# Seen: It is worked out where it is used first: 5.0 behind the change, but 0.5 there if b has been used once before it. A
#   line that only prints b changes what all lines after it get. (A number in a text is written anew, too: 1e3 becomes 1000.0.)
# Source: https://wiki.ros.org/xacro (properties); xacro/__init__.py (Table keeps what it has resolved); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q xacro==2.1.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import re

import xacro

found = {}
for used in ("<u b='${b}'/>", ""):
    with open("robot.xacro", "w") as file:
        file.write(
            "<robot xmlns:xacro='http://www.ros.org/wiki/xacro' name='r'>"
            "<xacro:property name='a' value='1'/><xacro:property name='b' value='${a/2}'/>"
            f"{used}<xacro:property name='a' value='10'/><xacro:property name='d' value='1e3'/><m b='${{b}}' d='${{d}}'/></robot>"
        )
    text = xacro.process_file("robot.xacro").toxml()
    found[bool(used)] = re.search(r"<m b=\"(.*?)\" d=\"(.*?)\"", text).groups()
print("used before:", found[True], "not used before:", found[False])
assert found == {True: ("0.5", "1000.0"), False: ("5.0", "1000.0")}, "the behaviour has changed"
PYTHON
