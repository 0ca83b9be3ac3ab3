#!/usr/bin/env bash
# Guess: Text of the family sans-serif is drawn with the one font that a machine has.
# Package: PyPI resvg-py 0.5.0
# Seen: Where fontconfig prefers a family that is not there, nothing is drawn, and nothing is said; named as DejaVu
#   Sans the same text is drawn.
# Source: https://github.com/linebender/resvg (fontdb: generic families); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q resvg-py==0.5.0 2>pip.log || { cat pip.log; exit 1; }
apt-get download -qq fonts-dejavu-core >/dev/null 2>&1
dpkg -x fonts-dejavu-core_*.deb root
cat > fonts.conf <<XML
<?xml version="1.0"?><fontconfig><dir>$PWD/root/usr/share/fonts</dir>
<alias><family>sans-serif</family><prefer><family>Noto Sans</family></prefer></alias></fontconfig>
XML
FONTCONFIG_FILE=$PWD/fonts.conf venv/bin/python - <<'PYTHON'
import resvg_py

PAGE = '<svg xmlns="http://www.w3.org/2000/svg" width="60" height="40">{}</svg>'
TEXT = '<text x="4" y="28" font-size="20" font-family="{}">Mm</text>'

def drawn(inside):
    return bytes(resvg_py.svg_to_bytes(svg_string=PAGE.format(inside)))

empty = drawn("")
found = {name: drawn(TEXT.format(name)) != empty for name in ("sans-serif", "DejaVu Sans")}
print(found)
assert found == {"sans-serif": False, "DejaVu Sans": True}, "the behaviour has changed"
PYTHON
