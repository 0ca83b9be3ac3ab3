#!/usr/bin/env bash
# Guess: cooldown(child, 3600) runs its child when it is asked for the first time, and skips it for an hour afterwards.
# Package: PyPI async-btree 3.0.1
# Seen: The last run is taken to have been at 0 of time.monotonic(), which on Linux is the start of the machine: on a robot that
#   has been switched on for less than an hour the child is skipped, and the node succeeds. With a clock of 600 s below nothing
#   is run and True comes back; with one of 7200 s the child runs.
# Source: async_btree/decorator.py (cooldown begins with a last run of 0.0, and returns SUCCESS for what it skips); found by
#   reading it, and by running it with a clock that says what it is told
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q async-btree==3.0.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import asyncio
from unittest import mock

import async_btree


def first_call(seconds_since_boot):
    ran = []

    async def calibrate():
        ran.append("calibrate")
        return True

    node = async_btree.cooldown(calibrate, delay=3600)
    with mock.patch("async_btree.decorator.time.monotonic", return_value=seconds_since_boot):
        return asyncio.run(node()), ran


found = first_call(600.0), first_call(7200.0)
print(*found, sep="\n")
assert found == ((True, []), (True, ["calibrate"])), "the behaviour has changed"
PYTHON
