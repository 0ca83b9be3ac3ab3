#!/usr/bin/env bash
# Guess: Two arcs from one place to one transition add up to weight 2, or are refused.
# Package: PyPI pm4py 2.7.23.11
# Seen: Each is looked at by itself: with one token the transition is enabled, and firing leaves -1 tokens.
# Source: ISO/IEC 15909-2; pm4py/objects/petri_net/semantics.py
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pm4py==2.7.23.11 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import warnings

warnings.simplefilter("ignore")
import pm4py

URI = "http://www.pnml.org/version-2009/grammar"
START = "<initialMarking><text>1</text></initialMarking>"

def read(arcs):
    with open("n.pnml", "w") as file:
        file.write(f'<pnml xmlns="{URI}/pnml"><net id="n" type="{URI}/ptnet"><page id="g"><place id="p">{START}</place>')
        file.write(f'<place id="q"/><transition id="t"/>{arcs}</page></net></pnml>')
    return pm4py.read_pnml("n.pnml")[:2]


from pm4py.objects.petri_net import semantics

net, start = read('<arc id="a" source="p" target="t"/><arc id="b" source="p" target="t"/><arc id="c" source="t" target="q"/>')
(t,) = semantics.enabled_transitions(net, start)
after = semantics.execute(t, net, start)
print(after)
assert {place.name: count for place, count in after.items()}.get("p") == -1, "the behaviour has changed"
PYTHON
