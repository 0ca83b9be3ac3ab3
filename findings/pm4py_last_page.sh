#!/usr/bin/env bash
# Guess: pm4py reads all pages of a PNML net into one net.
# Package: PyPI pm4py 2.7.23.11
# Seen: Of two pages only the last is there: one place and one transition, and the token of the first page is lost.
# Source: ISO/IEC 15909-2 (pages only structure a net); pm4py/objects/petri_net/importer/variants/pnml.py
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
with open("two.pnml", "w") as file:
    file.write(f'''<?xml version="1.0"?><pnml xmlns="{URI}/pnml"><net id="n" type="{URI}/ptnet">
<page id="one"><place id="p"><initialMarking><text>1</text></initialMarking></place><transition id="t"/>
<arc id="a" source="p" target="t"/></page>
<page id="two"><place id="q"/><transition id="u"/><arc id="b" source="q" target="u"/></page></net></pnml>''')
net, start, end = pm4py.read_pnml("two.pnml")
print([place.name for place in net.places], [t.name for t in net.transitions], start)
assert [place.name for place in net.places] == ["q"], "the behaviour has changed"
assert not start, "the behaviour has changed"
PYTHON
