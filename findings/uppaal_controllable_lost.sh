#!/usr/bin/env bash
# Guess: a network of timed automata that a library reads and writes again is the same one for UPPAAL; what is dropped are
#   places of labels at most.
# Package: PyPI uppaal-py 0.0.4 and pyuppaal 1.2.0
# Seen: controllable="false" of a transition is gone in both, so that the environment's moves of a game (Tiga, Stratego)
#   become the controller's, and a strategy may be found where there is none; options and expected results of queries are
#   gone, too. Rates, weights of branches, guards and invariants stay. pyuppaal writes the file that it reads anew, so
#   that the original is changed by opening it.
# Source: https://www.it.uu.se/research/group/darts/uppaal/flat-1_6.dtd (transition, query); uppaalpy/classes/transitions.py
#   and pyuppaal/nta.py (from_xml); found by running them
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q uppaal-py==0.0.4 pyuppaal==1.2.0 2>pip.log || { cat pip.log; exit 1; }
cat > game.xml <<'XML'
<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE nta PUBLIC '-//Uppaal Team//DTD Flat System 1.6//EN' 'http://www.it.uu.se/research/group/darts/uppaal/flat-1_6.dtd'>
<nta>
  <declaration>clock x;</declaration>
  <template>
    <name x="0" y="0">Dive</name>
    <location id="id0" x="0" y="0"><name x="0" y="0">Down</name>
      <label kind="invariant" x="0" y="0">x &lt;= 9</label><label kind="exponentialrate" x="0" y="0">2</label></location>
    <location id="id1" x="9" y="0"><name x="9" y="0">Up</name><urgent/></location>
    <branchpoint id="id2" x="5" y="0"/>
    <init ref="id0"/>
    <transition controllable="false"><source ref="id0"/><target ref="id2"/>
      <label kind="guard" x="0" y="0">x &gt;= 3</label></transition>
    <transition><source ref="id2"/><target ref="id1"/><label kind="probability" x="0" y="0">3</label></transition>
    <transition><source ref="id2"/><target ref="id0"/><label kind="probability" x="0" y="0">1</label></transition>
  </template>
  <system>dive = Dive(); system dive;</system>
  <queries><query><formula>A&lt;&gt; dive.Up</formula><comment/><option key="--diagnostic" value="0"/>
    <expect outcome="failure" type="quality"/></query></queries>
</nta>
XML
venv/bin/python - <<'PYTHON'
import shutil
import xml.etree.ElementTree as xml

import uppaalpy
from pyuppaal import UModel

shutil.copy("game.xml", "pyuppaal.xml")
uppaalpy.NTA.from_xml("game.xml").to_file("uppaal-py.xml")
UModel("pyuppaal.xml")


def content(name):
    root = xml.parse(name).getroot()
    return {
        "uncontrollable": len(root.findall(".//transition[@controllable='false']")),
        "labels": sorted(label.get("kind") for label in root.iter("label")),
        "of queries": sorted(child.tag for child in root.iterfind(".//query/*") if child.tag in ("option", "expect")),
    }


labels = ["exponentialrate", "guard", "invariant", "probability", "probability"]
expected = {"game.xml": {"uncontrollable": 1, "labels": labels, "of queries": ["expect", "option"]}}
for name in ("uppaal-py.xml", "pyuppaal.xml"):
    expected[name] = {"uncontrollable": 0, "labels": labels, "of queries": []}
found = {name: content(name) for name in expected}
print(found)
assert found == expected, "the behaviour has changed"
PYTHON
