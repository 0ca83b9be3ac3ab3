#!/usr/bin/env bash
# Guess: the reader of SCXML in hat-stc, a statechart engine without regions, refuses <parallel> and what else it does
#   not have.
# Package: PyPI hat-stc 0.7.4
# Seen: It reads <state> and <final> and passes by everything else without a word: a state that holds a <parallel> has
#   nothing in it, and <raise> raises nothing. Of event="go halt" and event="*" neither word is heard, and error.motor does
#   not match "error", for names are compared whole. A document without initial, which is the first state's, is KeyError.
# Source: https://www.w3.org/TR/scxml/ (3.2, 3.12.1); hat/stc/scxml.py, statechart.py
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q hat-stc==0.7.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from io import StringIO

from hat.stc import Event, Statechart, parse_scxml


def after(body, *events, head='initial="a"'):
    text = f'<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" {head}>{body}</scxml>'
    chart = Statechart(parse_scxml(StringIO(text)), {}, {})
    for name in events:
        chart.step(Event(name))
    return chart.state


def heard(descriptor, event):
    return after(f'<state id="a"><transition event="{descriptor}" target="b"/></state><state id="b"/>', event) == "b"


regions = '<state id="a"><parallel id="p"><state id="x"/><state id="y"/></parallel></state>'
raises = '<state id="a"><onentry><raise event="e"/></onentry><transition event="e" target="b"/></state><state id="b"/>'
found = {"regions": after(regions), "raised": after(raises)}
found |= {text: heard(text, event) for text, event in (("go", "go"), ("go halt", "go"), ("*", "go"), ("error", "error.motor"))}
print(found)
expected = {"regions": "a", "raised": "a", "go": True, "go halt": False, "*": False, "error": False}
assert found == expected, "the behaviour has changed"
try:
    state = after("<state id='a'/>", head="")
except KeyError as error:
    print("without initial:", repr(error))
else:
    raise SystemExit(f"the behaviour has changed: {state}")
PYTHON
