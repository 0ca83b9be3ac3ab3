#!/usr/bin/env bash
# Guess: 2^3^2 of an XMILE model is 512 and -2^2 is -4, as the format's table of operators has it and PySD computes.
# Package: PyPI asdm 0.7.2 and pysd 3.14.3
# Seen: asdm computes 64 and 4: powers from the left, and the sign before the power. PySD gives 512 and -4.
# Source: OASIS XMILE 1.0, 3.3.1 (all but exponentiation and the unary ones bind to the left); found by running both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q asdm==0.7.2 pysd==3.14.3 2>pip.log || { cat pip.log; exit 1; }
cat > model.xmile <<'XML'
<?xml version="1.0" encoding="utf-8"?>
<xmile version="1.0" xmlns="http://docs.oasis-open.org/xmile/ns/XMILE/v1.0">
  <header><vendor>none</vendor><product version="1">none</product><name>model</name></header>
  <sim_specs method="euler" time_units="h"><start>0</start><stop>1</stop><dt>1</dt></sim_specs>
  <model><variables>
    <aux name="powers"><eqn>2^3^2</eqn></aux>
    <aux name="sign"><eqn>-2^2</eqn></aux>
  </variables></model>
</xmile>
XML
venv/bin/python -W ignore - <<'PYTHON'
import pysd
from asdm import sdmodel

model = sdmodel(from_xmile="model.xmile")
model.simulate()
tables = {"asdm": model.export_simulation_result(format="df"), "pysd": pysd.read_xmile("model.xmile").run()}
found = {name: [round(float(table[column].iloc[0])) for column in ("powers", "sign")] for name, table in tables.items()}
print(found)
assert found == {"asdm": [64, 4], "pysd": [512, -4]}, "the behaviour has changed"
PYTHON
