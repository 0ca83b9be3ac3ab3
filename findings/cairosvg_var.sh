#!/usr/bin/env bash
# Guess: A program that does not know var() drops the declaration and takes the colour of the attribute, or the
#   fallback that var() names.
# Package: PyPI CairoSVG 2.9.1
# Seen: fill: var(--c) is black, though the attribute says red; with a fallback in it, var(--c, #ff0000), a ValueError
#   about base 16.
# Source: CSS 2.1, 4.2 (illegal values are ignored); cairosvg/colors.py
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q cairosvg==2.9.1 pillow==13.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from io import BytesIO

import cairosvg
from PIL import Image

SQUARE = '''<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><style>rect {{ --c: red; fill: {} }}</style>
<rect width="9" height="9" fill="red"/></svg>'''
picture = Image.open(BytesIO(cairosvg.svg2png(bytestring=SQUARE.format("var(--c)").encode()))).convert("RGBA")
print(picture.getpixel((4, 4)))
assert picture.getpixel((4, 4)) == (0, 0, 0, 255), "the behaviour has changed"
try:
    cairosvg.svg2png(bytestring=SQUARE.format("var(--c, #ff0000)").encode())
except ValueError as error:
    print(error)
else:
    raise SystemExit("the behaviour has changed")
PYTHON
