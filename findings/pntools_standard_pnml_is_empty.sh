#!/usr/bin/env bash
# Guess: A net in the PNML of ISO/IEC 15909-2, with its namespace, is read by a library whose first purpose is PNML; or it
#   is refused.
# Package: PyPI pntools 0.3.1
# Seen: The list of nets is empty, without an error, as of a file that holds none.
# Source: petrinet.py looks for elements by their plain names, which in a file with a namespace are others
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pntools==0.3.1 2>pip.log || { cat pip.log; exit 1; }
cat > net.pnml <<'XML'
<?xml version="1.0"?>
<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml">
  <net id="n" type="http://www.pnml.org/version-2009/grammar/ptnet"><page id="g">
    <place id="p"><name><text>p</text></name><initialMarking><text>3</text></initialMarking></place>
    <transition id="t"><name><text>t</text></name></transition>
    <arc id="a" source="p" target="t"><inscription><text>2</text></inscription></arc>
  </page></net>
</pnml>
XML
venv/bin/python - <<'PYTHON'
from pntools import petrinet

nets = petrinet.parse_pnml_file("net.pnml")
print("nets:", nets)
raise SystemExit("the behaviour has changed" if nets else None)
PYTHON
