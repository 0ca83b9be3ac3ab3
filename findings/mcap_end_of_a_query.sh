#!/usr/bin/env bash
# Guess: the two readers of MCAP that its authors publish give the same messages for the same start and end of a query.
# Package: npm @mcap/core 2.2.2 and PyPI mcap 1.6.0
# Seen: startTime 10 and endTime 30 give the messages of 10, 20 and 30 ns in JavaScript; start_time 10 and end_time 30 give those
#   of 10 and 20 in Python, where the end does not belong. A recording that is cut at a message loses that one, or has it twice.
# Source: the docstring of iter_messages in mcap/reader.py; McapIndexedReader.readMessages of @mcap/core; found by running both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent --no-audit --no-fund @mcap/core@2.2.2 >npm.log 2>&1 || { cat npm.log; exit 1; }
python3 -m venv venv
venv/bin/pip install -q mcap==1.6.0 2>pip.log || { cat pip.log; exit 1; }
cat > both.js <<'JS'
const { McapIndexedReader, McapWriter } = require("@mcap/core");
const fs = require("fs");

async function main() {
  const parts = [];
  let position = 0n;
  const writable = {
    async write(data) { parts.push(Buffer.from(data)); position += BigInt(data.length); },
    position: () => position,
  };
  const writer = new McapWriter({ writable });
  await writer.start({ profile: "", library: "" });
  const channelId = await writer.registerChannel({ topic: "depth", messageEncoding: "json", schemaId: 0, metadata: new Map() });
  for (const time of [10n, 20n, 30n]) {
    await writer.addMessage({ channelId, sequence: 0, logTime: time, publishTime: time, data: Buffer.from("{}") });
  }
  await writer.end();
  const bytes = Buffer.concat(parts);
  fs.writeFileSync("dive.mcap", bytes);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + length))),
  };
  const reader = await McapIndexedReader.Initialize({ readable });
  const times = [];
  for await (const message of reader.readMessages({ startTime: 10n, endTime: 30n })) times.push(Number(message.logTime));
  console.log("JavaScript:", times.join(" "));
}
main();
JS
node both.js | tee script.txt
grep -qx "JavaScript: 10 20 30" script.txt || { echo "the behaviour has changed"; exit 1; }
venv/bin/python -W ignore - <<'PYTHON'
from mcap.reader import make_reader

with open("dive.mcap", "rb") as file:
    times = [message.log_time for _, _, message in make_reader(file).iter_messages(start_time=10, end_time=30)]
print("Python:", times)
assert times == [10, 20], "the behaviour has changed"
PYTHON
