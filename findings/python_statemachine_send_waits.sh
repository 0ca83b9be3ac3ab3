#!/usr/bin/env bash
# Guess: send() takes the event and returns; a delayed <send> of the chart is taken when its time has come.
# Package: PyPI python-statemachine 3.2.2
# Seen: send("go") returns after the delay, a second later, in the state that the delayed event leads to; an event
#   that comes meanwhile is never in time.
# Source: W3C SCXML 6.2 (delay); https://python-statemachine.readthedocs.io ; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q python-statemachine==3.2.2 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import time

from statemachine.io.scxml.processor import SCXMLProcessor

CHART = '''<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" initial="a" datamodel="null">
<state id="a"><transition event="go" target="b"/></state>
<state id="b"><onentry><send event="late" delay="1s"/></onentry><transition event="late" target="c"/>
<transition event="other" target="d"/></state><state id="c"/><state id="d"/></scxml>'''
processor = SCXMLProcessor()
processor.parse_scxml("chart", CHART)
machine = processor.start()
began = time.monotonic()
machine.send("go")
seconds = time.monotonic() - began
print(f"send returned after {seconds:.1f} s in {set(machine.configuration_values)}")
assert seconds > 0.9 and set(machine.configuration_values) == {"c"}, "the behaviour has changed"
PYTHON
