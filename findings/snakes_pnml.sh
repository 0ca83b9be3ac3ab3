#!/usr/bin/env bash
# Guess: what SNAKES writes as PNML is a P/T net of the standard, where the net is one.
# Package: PyPI SNAKES 0.9.33
# Seen: The root has no namespace, the net no type and no page; a marking is a multiset element of its own, and pm4py reads
#   the net as empty of tokens, without a word.
# Source: snakes/pnml.py; ISO/IEC 15909-2; pm4py 2.7.23.11 beside it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q SNAKES==0.9.33 pm4py==2.7.23.11 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import re
import warnings
from pathlib import Path

import snakes.nets as nets
from snakes.pnml import dumps

net = nets.PetriNet("n")
net.add_place(nets.Place("p", [nets.dot]))
net.add_transition(nets.Transition("t"))
net.add_input("p", "t", nets.Value(nets.dot))
text = dumps(net)
assert "<pnml>" in text, "the behaviour has changed"
assert not re.search(r"<net[^>]*type=", text), "the behaviour has changed"
assert "<multiset>" in text, "the behaviour has changed"
warnings.simplefilter("ignore")
import pm4py

Path("n.pnml").write_text(text)
found, start, _ = pm4py.read_pnml("n.pnml")
print(found.places, start)
assert not start, "the behaviour has changed"
PYTHON
