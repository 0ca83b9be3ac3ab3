#!/usr/bin/env bash
# Guess: A graphical function of an XMILE model is read by its type wherever it stands: "extrapolate" goes on beyond its ends,
#   "discrete" keeps a value until the next point.
# Package: PyPI pysd 3.14.3
# Seen: So it is in a <gf> of its own. Inside of an <aux>, where Stella writes most of them, the type is dropped: values are
#   interpolated and clamped at the ends, without a word.
# Source: OASIS XMILE 1.0 (graphical functions); pysd/translators/xmile/xmile_element.py (_interp_methods) and the np.interp of the
#   model that is written; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pysd==3.14.3 2>pip.log || { cat pip.log; exit 1; }
cat > model.xmile <<'XML'
<?xml version="1.0" encoding="utf-8"?>
<xmile version="1.0" xmlns="http://docs.oasis-open.org/xmile/ns/XMILE/v1.0">
  <header><vendor>none</vendor><product version="1">none</product><name>model</name></header>
  <sim_specs method="euler" time_units="h"><start>0</start><stop>4</stop><dt>1</dt></sim_specs>
  <model><variables>
    <gf name="curve" type="extrapolate"><xscale min="1" max="3"/><ypts>10,20,30</ypts></gf>
    <aux name="alone"><eqn>curve(TIME)</eqn></aux>
    <aux name="inside"><eqn>TIME</eqn><gf type="extrapolate"><xscale min="1" max="3"/><ypts>10,20,30</ypts></gf></aux>
    <gf name="steps" type="discrete"><xpts>0,2,4</xpts><ypts>10,20,30</ypts></gf>
    <aux name="steps alone"><eqn>steps(TIME)</eqn></aux>
    <aux name="steps inside"><eqn>TIME</eqn><gf type="discrete"><xpts>0,2,4</xpts><ypts>10,20,30</ypts></gf></aux>
  </variables></model>
</xmile>
XML
venv/bin/python -W ignore - <<'PYTHON'
import pysd

expected = {
    "alone": [0, 10, 20, 30, 40],
    "inside": [10, 10, 20, 30, 30],
    "steps alone": [10, 10, 20, 20, 30],
    "steps inside": [10, 15, 20, 25, 30],
}
run = pysd.read_xmile("model.xmile").run()
found = {name: [round(value) for value in run[name]] for name in expected}
print(found)
assert found == expected, "the behaviour has changed"
PYTHON
