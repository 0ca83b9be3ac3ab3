#!/usr/bin/env bash
# Guess: the times of a GPX track that becomes GeoJSON stand beside its points: the first time is that of the first point, and
#   a point without a time, which GPX allows, has null.
# Package: npm @tmcw/togeojson 7.1.3 (with @xmldom/xmldom 0.9.12)
# Seen: Points without a time are left out of the times: two times for three points, of which the first is that of the second
#   point. What stands in extensions, as heart rates, is filled up with null.
# Source: https://www.topografix.com/GPX/1/1/ (wptType: time is optional); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent --no-fund --no-audit @tmcw/togeojson@7.1.3 @xmldom/xmldom@0.9.12 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat > track.mjs <<'JS'
import { gpx } from "@tmcw/togeojson";
import { DOMParser } from "@xmldom/xmldom";

const inside = ["", "<time>2026-03-01T10:01:00Z</time>", "<time>2026-03-01T10:02:00Z</time>"];
const rate = "<extensions><TrackPointExtension><hr>60</hr></TrackPointExtension></extensions>";
const points = inside.map((time, place) => `<trkpt lat="47.${place}" lon="8">${time}${place > 0 ? rate : ""}</trkpt>`);
const text = `<gpx version="1.1" creator="test" xmlns="http://www.topografix.com/GPX/1/1">
  <trk><trkseg>${points.join("")}</trkseg></trk></gpx>`;
const [track] = gpx(new DOMParser().parseFromString(text, "text/xml")).features;
const { times, TrackPointExtensions: rates } = track.properties.coordinateProperties;
const found = { points: track.geometry.coordinates.length, times: times.map((time) => time.slice(14, 16)), rates };
console.log(found);
const expected = { points: 3, times: ["01", "02"], rates: [null, 60, 60] };
if (JSON.stringify(found) !== JSON.stringify(expected)) {
  console.log("the behaviour has changed");
  process.exit(1);
}
JS
node track.mjs
