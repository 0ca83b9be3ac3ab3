#!/usr/bin/env bash
# Guess: putting a value on a key expression with a wildcard raises: a value has one key.
# Package: PyPI eclipse-zenoh 1.10.2
# Seen: It is delivered to each subscriber that the expression meets, with the wildcard as its key: who subscribed robot/arm
#   is told a sample of robot/*.
# Source: https://zenoh.io/docs/manual/abstractions/ (key expressions); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q eclipse-zenoh==1.10.2 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import time

import zenoh

config = zenoh.Config()
config.insert_json5("scouting/multicast/enabled", "false")
config.insert_json5("listen/endpoints", "[]")
heard = []
with zenoh.open(config) as session:
    kept = session.declare_subscriber("robot/arm", lambda sample: heard.append(str(sample.key_expr)))
    session.put("robot/*", "stop")
    time.sleep(0.5)
print(heard)
assert heard == ["robot/*"], "the behaviour has changed"
PYTHON
