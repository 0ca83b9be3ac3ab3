#!/usr/bin/env bash
# Guess: A macro's value stands in the robot description as it was written, so that wheel_${i} with i = 1 is wheel_1; definitions are
#   taken out of what is made; and a block whose condition is "false", as XML writes it, is left out.
# Package: PyPI xmacro 1.2.1
# Seen: A value that is a number becomes a float: wheel_1.0, and 007 is 7.0. Of two definitions that stand side by side, without a space
#   or a line between them, the second is left in the result; condition="false" puts the block in, for only False and 0 leave it out.
# Source: xmacro/xmacro.py (try2number; nodes are removed from the list that is walked); its README: "True, False, 1, 0"
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q xmacro==1.2.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from xmacro.xmacro import XMLMacro


def made(*lines, between="\n"):
    with open("m.xml", "w") as file:
        file.write(f"<robot>{between.join(('', *lines, ''))}</robot>")
    macro = XMLMacro()
    macro.set_xml_file("m.xml")
    macro.generate()
    return "".join(macro.to_string().split("-->")[-1].split())


def value(name, text):
    return f'<xmacro_define_value name="{name}" value="{text}"/>'


block = '<xmacro_define_block name="b" params="a"><link name="${a}"/></xmacro_define_block>'
found = [
    made(value("i", "1"), '<link name="wheel_${i}"/>'),
    made(value("i", "007"), '<link name="${i}"/>'),
    made(value("i", "1"), value("j", "2"), "<link/>"),
    made(value("i", "1"), value("j", "2"), "<link/>", between=""),
    made(block, '<xmacro_block name="b" a="x" condition="False"/>'),
    made(block, '<xmacro_block name="b" a="x" condition="false"/>'),
]
print(*found, sep="\n")
assert found == [
    '<robot><linkname="wheel_1.0"/></robot>', '<robot><linkname="7.0"/></robot>', "<robot><link/></robot>",
    '<robot><xmacro_define_valuename="j"value="2"/><link/></robot>', "<robot/>", '<robot><linkname="x"/></robot>',
], "the behaviour has changed"
PYTHON
