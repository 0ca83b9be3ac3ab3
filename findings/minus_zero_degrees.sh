#!/usr/bin/env bash
# Guess: -0°30'0" is half a degree south of the equator, -0.5, as -1°30'0" is -1.5.
# Package: npm geo-coordinates-parser 1.7.4, coordinate-parser 1.0.7, @openaip/coordinate-parser 0.31.1, dms-conversion 3.1.4,
#   parse-dms 0.0.5; PyPI lat-lon-parser 1.3.1
# Seen: The first four say 0.5, half a degree north: the sign is looked for in a number of degrees, and -0 has none. Of
#   -1°30'0" three of them say -1.5, and dms-conversion says -0.5: it adds the minutes. parse-dms and lat-lon-parser are right.
# Source: ISO 6709, annex D (the sign is of the whole); found by running them
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent --no-fund geo-coordinates-parser@1.7.4 coordinate-parser@1.0.7 @openaip/coordinate-parser@0.31.1 \
  dms-conversion@3.1.4 parse-dms@0.0.5 >npm.log 2>&1 || { cat npm.log; exit 1; }
python3 -m venv venv
venv/bin/pip install -q lat-lon-parser==1.3.1 2>pip.log || { cat pip.log; exit 1; }
cat > read.mjs <<'JS'
import Coordinates from "coordinate-parser";
import { parseDms } from "dms-conversion";
import { convert } from "geo-coordinates-parser";
import { Parser } from "@openaip/coordinate-parser";
import parse from "parse-dms";

const readers = {
  "geo-coordinates-parser": (text) => convert(text).decimalLatitude,
  "coordinate-parser": (text) => new Coordinates(text).getLatitude(),
  "@openaip/coordinate-parser": (text) => new Parser().parse(text).latitude,
  "dms-conversion": (text) => parseDms(text.split(" ")[0]),
  "parse-dms": (text) => parse(text).lat,
};
for (const [name, read] of Object.entries(readers)) {
  console.log(name, ...["-0", "-1"].map((degrees) => read(`${degrees}°30'00" 10°00'00"`)));
}
JS
cat > read.py <<'PYTHON'
from lat_lon_parser import parse

print("lat-lon-parser", *(parse(f"{degrees}°30'00\"") for degrees in ("-0", "-1")))
PYTHON
{ node read.mjs; venv/bin/python read.py; } | tee seen
cat > expected <<'TEXT'
geo-coordinates-parser 0.5 -1.5
coordinate-parser 0.5 -1.5
@openaip/coordinate-parser 0.5 -1.5
dms-conversion 0.5 -0.5
parse-dms -0.5 -1.5
lat-lon-parser -0.5 -1.5
TEXT
diff expected seen || { echo "the behaviour has changed"; exit 1; }
