#!/usr/bin/env bash
# Guess: a robot's description in xacro is the same robot for ROS's own xacro and for the parser that browsers use.
# Package: npm xacro-parser 0.3.11 (with @xmldom/xmldom 0.9.12), PyPI xacro 2.1.1 beside it
# Seen: "False", which is how Python writes it and what an argument of a launch file often is, is true in xacro-parser: the other
#   half of the robot is built, without a word. ${2^3} is 8, where xacro has 1, Python's exclusive or; ${1 < 2 < 2} is true, where
#   xacro chains; ${007} of a property stays 007, where xacro has 7; and an element of a list, ${p[0]}, is the text "$".
# Source: https://wiki.ros.org/xacro (conditional blocks: 0, 1, true and false; expressions are Python's); found by running both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q xacro==2.1.1 2>pip.log || { cat pip.log; exit 1; }
npm init -y >npm.log
npm install --silent --ignore-scripts xacro-parser@0.3.11 @xmldom/xmldom@0.9.12 >>npm.log 2>&1 || { cat npm.log; exit 1; }
cat >robot.xacro <<'XML'
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="sim" default="False"/>
  <xacro:if value="$(arg sim)"><simulated/></xacro:if>
  <xacro:unless value="$(arg sim)"><real/></xacro:unless>
  <xacro:property name="number" value="007"/>
  <xacro:property name="joints" value="${[1, 2]}"/>
  <link caret="${2^3}" chain="${1 &lt; 2 &lt; 2}" number="${number}" first="${joints[0]}"/>
</robot>
XML
cat >parse.mjs <<'JS'
import { readFileSync } from "node:fs";
import { DOMParser, XMLSerializer } from "@xmldom/xmldom";
import { XacroParser } from "xacro-parser";
globalThis.DOMParser = DOMParser;
const parser = new XacroParser();
parser.requirePrefix = parser.inOrder = parser.localProperties = true;
const robot = await parser.parse(readFileSync("robot.xacro", "utf8"));
console.log(new XMLSerializer().serializeToString(robot));
JS
venv/bin/xacro robot.xacro >ros.xml
node parse.mjs >browser.xml
python3 - <<'PYTHON'
import xml.etree.ElementTree as ET

found = {}
for name in ("ros", "browser"):
    built, link = ET.parse(f"{name}.xml").getroot()
    found[name] = (built.tag, link.attrib)
    print(name, *found[name])
ros = ("real", {"caret": "1", "chain": "False", "number": "7", "first": "1"})
browser = ("simulated", {"caret": "8", "chain": "true", "number": "007", "first": "$"})
assert found == {"ros": ros, "browser": browser}, "the behaviour has changed"
PYTHON
