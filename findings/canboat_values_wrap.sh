#!/usr/bin/env bash
# Guess: a number that an NMEA 2000 field cannot carry is refused when a message is made, or sent as "not available": a heading
#   of 7 rad, a sum of angles that nobody has brought below a turn; a speed of -1 m/s, going astern; a sea of 1000 K.
# Package: npm @canboat/canboatjs 3.20.0
# Seen: The lowest 16 bits are sent, without a word: the heading comes back as 0.4464 rad, where 0.7168 is meant,
#   the speed as 654.36 m/s, the 1000 K as 344.64 K. A depth that is null is left out, as it should be.
# Source: canboat's pgns.xml (ranges of fields); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent --no-audit --no-fund @canboat/canboatjs@3.20.0 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat > wrap.js <<'JS'
const { FromPgn, pgnToActisenseSerialFormat } = require("@canboat/canboatjs");

const reader = new FromPgn({});
let said = 0;
reader.on("warning", () => said++);
reader.on("error", () => said++);
function back(pgn, fields) {
  return reader.parseString(pgnToActisenseSerialFormat({ pgn, src: 1, dst: 255, prio: 3, fields })).fields;
}
const found = [
  back(127250, { heading: 7 }).heading,
  back(128259, { speedWaterReferenced: -1 }).speedWaterReferenced,
  back(130312, { source: "Sea Temperature", actualTemperature: 1000 }).actualTemperature,
  back(128267, { depth: null, offset: -1.2 }).depth,
  said,
];
console.log(found.map(String).join(" "));
JS
node wrap.js | tee found.txt
grep -qx "0.4464 654.36 344.64 undefined 0" found.txt || { echo "the behaviour has changed"; exit 1; }
