#!/usr/bin/env bash
# Guess: robot/** is what stands below robot, and not robot itself.
# Package: PyPI eclipse-zenoh 1.10.2
# Seen: It includes robot (** is any number of chunks, none too), but no chunk that begins with @, at any depth.
# Source: https://zenoh.io/docs/manual/abstractions/; Zenoh RFC on key expressions
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q eclipse-zenoh==1.10.2 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from zenoh import KeyExpr

below = KeyExpr("robot/**")
found = {text: below.includes(KeyExpr(text)) for text in ("robot", "robot/arm", "robot/@arm", "robot/a/@arm/b")}
print(found)
assert found == {"robot": True, "robot/arm": True, "robot/@arm": False, "robot/a/@arm/b": False}, (
    "the behaviour has changed"
)
PYTHON
