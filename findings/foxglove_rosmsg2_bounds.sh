#!/usr/bin/env bash
# Guess: A writer of ROS 2 messages refuses what their definition does not allow: a text longer than string<=4, three numbers in
#   int32[<=2], 200 in an int8, a field that the message does not have.
# Package: npm @foxglove/rosmsg2-serialization 3.1.0, @foxglove/rosmsg 5.0.5
# Seen: The bounds are not looked at, 200 becomes -56, 2.7 becomes 2, a text becomes 0, and a misspelled field leaves its
#   own at 0. Only arrays of a fixed length are held to it.
# Source: the package's README, MessageWriter; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent @foxglove/rosmsg2-serialization@3.1.0 @foxglove/rosmsg@5.0.5 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat > run.js <<'JAVASCRIPT'
const { parse } = require("@foxglove/rosmsg");
const { MessageReader, MessageWriter } = require("@foxglove/rosmsg2-serialization");

function written(definition, message) {
  const parsed = parse(definition, { ros2: true });
  try {
    const [value] = Object.values(new MessageReader(parsed).readMessage(new MessageWriter(parsed).writeMessage(message)));
    return typeof value === "object" ? [...value].join(" ") : String(value);
  } catch (error) {
    return error.message;
  }
}

const found = [
  written("string<=4 name", { name: "gripper" }),
  written("int32[<=2] joints", { joints: [1, 2, 3] }),
  written("int8 speed", { speed: 200 }),
  written("int32 speed", { speed: 2.7 }),
  written("int32 speed", { speed: "fast" }),
  written("int32 speed", { sped: 5 }),
  written("int32[3] joints", { joints: [1, 2] }),
].join("; ");
console.log(found);
const expected = "gripper; 1 2 3; -56; 2; 0; 0; Expected 3 items for fixed-length array field joints but received 2";
if (found !== expected) {
  console.log("the behaviour has changed");
  process.exit(1);
}
JAVASCRIPT
node run.js
