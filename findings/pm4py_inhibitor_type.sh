#!/usr/bin/env bash
# Guess: <type value="inhibitor"/> inside an arc, as GreatSPN and PIPE write, is read as an inhibitor arc, or refused.
# Package: PyPI pm4py 2.7.23.11
# Seen: It is read as an ordinary arc: the transition is enabled with a token in the place. Only
#   <arctype><text>inhibitor</text></arctype> counts.
# Source: pm4py/objects/petri_net/importer/variants/pnml.py
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


net, start = read('<arc id="a" source="p" target="t"><type value="inhibitor"/></arc><arc id="c" source="t" target="q"/>')
print(sorted(type(arc).__name__ for arc in net.arcs))
assert {type(arc).__name__ for arc in net.arcs} == {"Arc"}, "the behaviour has changed"
PYTHON
