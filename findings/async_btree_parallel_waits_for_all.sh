#!/usr/bin/env bash
# Guess: parallele with success_threshold=1 ends with the first child that succeeds, and with all needed with the first that
#   fails, as its description has it; and a sequence without children, or with a threshold of 0, succeeds, as parallele does.
# Package: PyPI async-btree 3.0.1
# Seen: It waits until each child has ended, whatever is decided: an obstacle that is reported at once stops no motion beside it,
#   which goes on to its end. Sequences without children, or with a threshold of 0, fail, and parallele of the same succeeds.
# Source: the docstrings of parallele ("If #failure >= len(children) - success_threshold, return FAILURE") and of sequence ("If
#   #success reaches success_threshold"); async_btree/parallele.py, control.py; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q async-btree==3.0.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import asyncio

from async_btree import parallele, sequence


def run(threshold, answer):
    # The result, and whether the motion was driven to its end although the other child had answered before.
    ends = []

    async def sensor():
        return answer

    async def motion():
        for _ in range(100):
            await asyncio.sleep(0)
        ends.append("driven to its end")
        return True

    return asyncio.run(parallele([sensor, motion], success_threshold=threshold)()), ends


found = run(1, True), run(2, False)
print(*found, sep="\n")
assert found == ((True, ["driven to its end"]), (False, ["driven to its end"])), "the behaviour has changed"


async def yes():
    return True


empty = [asyncio.run(node([])()) for node in (sequence, parallele)]
none_needed = [asyncio.run(node([yes], success_threshold=0)()) for node in (sequence, parallele)]
print(empty, none_needed)
assert [bool(result) for result in empty + none_needed] == [False, True, False, True], "the behaviour has changed"
PYTHON
