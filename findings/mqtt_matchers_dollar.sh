#!/usr/bin/env bash
# Guess: Packages that match MQTT topics with filters do it as brokers do: # and + at the beginning are not for topics
#   that begin with $, and + stands for an empty level, too.
# Package: npm mqtt-match 3.0.0, mqtt-pattern 2.1.1, mqtt-wildcard 3.0.9
# Seen: With all three # hears $SYS/uptime, and +/uptime does: a handler of all topics gets the broker's own, of a
#   logger or a bridge that subscribes to both. mqtt-pattern does not match +/x with /x, nor robot/+ with robot/.
# Source: MQTT 5.0, 4.7.1.3 and 4.7.2; found by running them
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm install --silent --no-audit --no-fund mqtt-match@3.0.0 mqtt-pattern@2.1.1 mqtt-wildcard@3.0.9 > npm.log 2>&1 ||
  { cat npm.log; exit 1; }
cat > matches.mjs <<'JS'
import { createRequire } from "node:module";

const require = createRequire(import.meta.url);
const match = require("mqtt-match");
const pattern = require("mqtt-pattern");
const wildcard = require("mqtt-wildcard");
const found = {};
for (const [filter, topic] of [
  ["robot/#", "robot"],
  ["#", "$SYS/uptime"],
  ["+/uptime", "$SYS/uptime"],
  ["+/x", "/x"],
  ["robot/+", "robot/"],
]) {
  const answers = [(match.default ?? match)(filter, topic), pattern.matches(filter, topic), wildcard(topic, filter) !== null];
  found[`${filter} ${topic}`] = answers.map((answer) => (answer ? "yes" : "no")).join(" ");
}
console.log(found);
const expected = {
  "robot/# robot": "yes yes yes",
  "# $SYS/uptime": "yes yes yes",
  "+/uptime $SYS/uptime": "yes yes yes",
  "+/x /x": "yes no yes",
  "robot/+ robot/": "yes no yes",
};
if (JSON.stringify(found) !== JSON.stringify(expected)) {
  console.log("the behaviour has changed");
  process.exit(1);
}
JS
node matches.mjs
