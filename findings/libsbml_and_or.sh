#!/usr/bin/env bash
# Guess: a || b && c in a formula of SBML, where it is the trigger of an event, is a || (b && c), as in C, whose signs they are.
# Package: PyPI python-libsbml 5.21.2, and antimony 3.3.0, whose models are SBML
# Seen: It is (a || b) && c: both signs bind alike, from the left. So it is in a trigger of antimony: "at (x > 0 || y > 0 && z > 0)"
#   waits for z.
# Source: libSBML's documentation of parseL3Formula (table of precedence); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q python-libsbml==5.21.2 antimony==3.3.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import antimony
import libsbml

found = {text: libsbml.formulaToL3String(libsbml.parseL3Formula(text)) for text in ("a || b && c", "a && b || c")}
antimony.loadAntimonyString("model m\n x = 1; y = 0; z = 0; done = 0; at (x > 0 || y > 0 && z > 0): done = 1;\nend")
model = libsbml.readSBMLFromString(antimony.getSBMLString("m")).getModel()
found["trigger"] = libsbml.formulaToL3String(model.getEvent(0).getTrigger().getMath())
print(found)
assert found == {
    "a || b && c": "(a || b) && c",
    "a && b || c": "(a && b) || c",
    "trigger": "((x > 0) || (y > 0)) && (z > 0)",
}, "the behaviour has changed"
PYTHON
