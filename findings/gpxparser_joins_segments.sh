#!/usr/bin/env bash
# Guess: the length of a track of two segments is the sum of theirs: between segments there was no fix, as under water; the
#   first point stands at 0 m; and the GeoJSON that is made of it is valid where a point has no elevation.
# Package: npm gpxparser 3.0.8
# Seen: The segments are joined: two of 111 m, a degree apart, are 111,306 m. The lengths so far are those of the next point:
#   the first point has 111 m, the last two are equal. A point without an elevation gets null as its third number.
# Source: https://www.topografix.com/GPX/1/1/ (trksegType); RFC 7946, 3.1.1 (positions are numbers); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent --no-fund gpxparser@3.0.8 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat > track.cjs <<'JS'
const Parser = require("gpxparser");
const point = (lat, inside) => `<trkpt lat="${lat}" lon="8">${inside}</trkpt>`;
const deep = "<ele>-12.5</ele>";
const gpx = new Parser();
gpx.parse(`<?xml version="1.0"?><gpx version="1.1" creator="test" xmlns="http://www.topografix.com/GPX/1/1"><trk>
  <trkseg>${point(47, deep)}${point(47.001, "")}</trkseg><trkseg>${point(48, deep)}${point(48.001, deep)}</trkseg></trk></gpx>`);
const { total, cumul } = gpx.tracks[0].distance;
const found = {
  total: Math.round(total),
  lengths: cumul.map(Math.round),
  second: gpx.toGeoJSON().features[0].geometry.coordinates[1],
};
console.log(found);
const expected = { total: 111306, lengths: [111, 111195, 111306, 111306], second: [8, 47.001, null] };
if (JSON.stringify(found) !== JSON.stringify(expected)) {
  console.log("the behaviour has changed");
  process.exit(1);
}
JS
node track.cjs
