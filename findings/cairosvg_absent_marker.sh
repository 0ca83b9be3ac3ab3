#!/usr/bin/env bash
# Guess: A path whose marker-end names a marker that is not there is drawn without it.
# Package: PyPI CairoSVG 2.9.1
# Seen: AttributeError: 'NoneType' object has no attribute 'get'; resvg, librsvg and browsers draw the line.
# Source: SVG 1.1, 11.6.2; cairosvg/path.py (draw_markers)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q cairosvg==2.9.1 resvg-py==0.5.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import cairosvg
import resvg_py

LINE = '''<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9">
<path d="M0 0 8 8" stroke="black" marker-end="url(#absent)"/></svg>'''
print(len(bytes(resvg_py.svg_to_bytes(svg_string=LINE))), "bytes by resvg")
try:
    cairosvg.svg2png(bytestring=LINE.encode())
except AttributeError as error:
    print(error)
else:
    raise SystemExit("the behaviour has changed")
PYTHON
